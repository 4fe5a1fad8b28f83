"""Quaternions as arrays (..., 4), scalar first, and small turns, for what has to be fast without scipy."""

from __future__ import annotations

import numpy as np


def multiply(p, q):
    p, q = np.broadcast_arrays(p, q)
    out = np.empty(p.shape)
    out[..., 0] = p[..., 0] * q[..., 0] - np.sum(p[..., 1:] * q[..., 1:], axis=-1)
    out[..., 1:] = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return out


def conjugate(q):
    return np.asarray(q) * [1.0, -1.0, -1.0, -1.0]


def exponential(turn):
    """The quaternion of a turn vector (..., 3), rad."""
    turn = np.asarray(turn, dtype=float)
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * turn], axis=-1)


def logarithm(q):
    """The turn vector (..., 3) of a quaternion, of at most pi."""
    q = np.asarray(q) * np.where(np.asarray(q)[..., :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)


def matrix(q):
    """(..., 3, 3): components from the body to the frame."""
    q = np.asarray(q) / np.linalg.norm(q, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(rotation):
    """One quaternion of one matrix (3, 3), by the largest of its components."""
    r = np.asarray(rotation)
    four_squares = np.array([1 + np.trace(r), *(1 - np.trace(r) + 2 * np.diag(r))])
    skew = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    k = int(np.argmax(four_squares))
    q = np.empty(4)
    if k == 0:
        q[0], q[1:] = four_squares[0], skew
    else:
        q[0], q[1:] = skew[k - 1], r[k - 1] + r[:, k - 1]
        q[k] = four_squares[k]
    return q / np.linalg.norm(q)


def cross_matrix(v):
    """(..., 3, 3) with cross_matrix(v) @ w = v x w."""
    v = np.asarray(v)
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def turn_residual(model, measured):
    """The turn (n, 3), in body axes, from the model's attitude to the measured one, and its derivative (n, 3, 3) by a
    small turn of the model: the inverse of the exponential's left Jacobian, negative."""
    r = logarithm(multiply(conjugate(model), measured))
    angle = np.linalg.norm(r, axis=-1)
    half = np.maximum(angle, 1e-6) / 2
    factor = np.where(angle < 1e-3, 1 / 12, (1 - half / np.tan(np.minimum(half, 1.5707))) / np.maximum(angle, 1e-6) ** 2)
    skew = cross_matrix(r)
    return r, -(np.eye(3) - skew / 2 + factor[..., None, None] * (skew @ skew))
