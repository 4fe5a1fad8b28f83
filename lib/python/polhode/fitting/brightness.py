"""Brightness of an ellipsoid by its projected lit area, with its derivatives."""

from __future__ import annotations

import numpy as np


def semi_axes_of_moments(moments):
    """Of the homogeneous ellipsoid with these principal moments about its axes; the longest is 1."""
    moments = np.asarray(moments, dtype=float)
    squares = np.maximum(moments.sum() / 2 - moments, 1e-6 * moments.sum())
    return np.sqrt(squares / squares.max())


def ellipsoid_magnitude(semi_axes, observer, sun):
    """-2.5 log10 of the projected lit area (Connelly & Ostro 1984) over that of the sphere of equal volume, of an ellipsoid
    along the body's axes, from the directions to observer and Sun in body axes, (n, 3); and its derivatives by the two
    directions and by the logarithms of the semi-axes, (n, 3) each."""
    a = np.asarray(semi_axes, dtype=float)
    m = 1 / a**2
    m_e, m_s = observer * m, sun * m
    ee, es, ss = np.sum(observer * m_e, -1), np.sum(observer * m_s, -1), np.sum(sun * m_s, -1)
    root_ee, root_ss = np.sqrt(ee), np.sqrt(ss)
    sum_ = root_ee + es / root_ss
    scale = np.prod(a) ** (1 / 3) / 2
    dark = sum_ <= 1e-9 * root_ee  # the lit side is turned away
    sum_ = np.where(dark, 1e-9 * root_ee, sum_)
    magnitude = -2.5 * np.log10(scale * sum_)
    factor = (-2.5 / np.log(10) / sum_ * ~dark)[:, None]
    by_observer = factor * (m_e / root_ee[:, None] + m_s / root_ss[:, None])
    by_sun = factor * (m_e / root_ss[:, None] - (es / ss / root_ss)[:, None] * m_s)
    # m_k = a_k^-2: d m_k / d ln a_k = -2 m_k; and ln(scale) has a third of each.
    by_m = observer**2 / (2 * root_ee[:, None]) + observer * sun / root_ss[:, None] - (es / (2 * ss * root_ss))[:, None] * sun**2
    by_axes = -2 * factor * m * by_m - 2.5 / np.log(10) / 3
    return magnitude, by_observer, by_sun, by_axes
