"""States at the times of measurements, and their derivatives by the free numbers of a body."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from .._core import Body, Inertia, Scene
from .._errors import InputError
from . import rotations
from .parameters import TENSOR

LEAST_SEPARATION = 1e-6  # of moments whose axes a product of inertia turns, as a part of the largest
DIFFERENCE_RAD = 1e-3  # that a step of a difference turns the body by, at the most
ACCURACY_RAD = 1e-6  # of motions that differences are taken of


@dataclass
class States:
    """In the frame and the body's named axes. Derivatives by all numbers, None where they were not asked for: of the
    attitude's small turn in body axes, and of the rate."""

    q: np.ndarray  # (n, 4)
    omega: np.ndarray  # (n, 3)
    by_turn: np.ndarray | None = None  # (n, 3, numbers)
    by_omega: np.ndarray | None = None


def inertia_of(tensor, absolute=False):
    return Inertia(np.diag(tensor), [tensor[0, 1], tensor[0, 2], tensor[1, 2]], absolute=absolute)


def body_of(parameters, at):
    return Body("body", inertia=inertia_of(at.tensor, parameters.body.inertia.absolute), epoch=parameters.epoch, frame=parameters.frame, q=at.q, omega=at.omega)


def apart(tensor):
    """The tensor with moments that are nearly equal taken apart, so that each has its axis."""
    moments, axes = np.linalg.eigh(tensor)
    gap = LEAST_SEPARATION * moments[2]
    if min(np.diff(moments)) >= gap:
        return tensor
    moments = moments + np.maximum(0, gap - np.diff(moments, prepend=moments[0] - gap)).cumsum()
    return axes @ np.diag(moments) @ axes.T


def epoch_partials(motion, at, t):
    """d(small turn, rate at t) / d(small turn, rate, tensor at the epoch), (n, 6, 12), named axes, by the motion's own
    partials, which hold the momentum and know the principal moments."""
    inertia = inertia_of(at.tensor)
    moments, axes = inertia.principal_moments, inertia.named_from_principal
    partials = motion.partials(t)
    state = motion(t)
    momentum_0 = at.tensor @ at.omega
    # By (turn, momentum, principal moments), and by a turn of the principal axes in the named ones.
    by_axes = partials[:, :, :3] - partials[:, :, 3:6] @ -rotations.cross_matrix(momentum_0)
    by_axes[:, :3] -= np.eye(3)
    by_axes[:, 3:] -= rotations.cross_matrix(state.momentum)
    out = np.zeros((len(t), 6, 12))
    out[:, :, :3] = partials[:, :, :3]
    out[:, :, 3:6] = partials[:, :, 3:6] @ at.tensor
    for column, (i, k) in enumerate(TENSOR.values()):
        change = np.zeros((3, 3))
        change[i, k] = change[k, i] = 1
        principal = axes.T @ change @ axes
        turn = np.zeros(3)
        for axis, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
            if abs(principal[a, b]) > 1e-12:
                gap = moments[b] - moments[a]
                turn[axis] = -principal[a, b] / np.copysign(max(abs(gap), LEAST_SEPARATION * moments[2] / 2), gap)
        out[:, :, 6 + column] = (
            partials[:, :, 3:6] @ (change @ at.omega) + partials[:, :, 6:9] @ np.diag(principal) + by_axes @ (axes @ turn)
        )
        out[:, 3:, 6 + column] -= state.omega @ change  # the momentum at t less what of it is not the rate
    out[:, 3:] = np.linalg.solve(at.tensor, out[:, 3:])
    return out


class FreeMotions:
    """The free motion of a body."""

    def __init__(self, parameters, frame=None):
        self.parameters = parameters
        self.frame = frame or parameters.frame

    def states(self, values, t, derivatives=True):
        at = self.parameters.at(values)
        state = body_of(self.parameters, at).motion(frame=self.frame)(t)
        if not derivatives:
            return States(state.q, state.omega)
        if len(self.parameters.numbers) > 9:  # products of inertia
            at.tensor = apart(at.tensor)
        by = epoch_partials(body_of(self.parameters, at).motion(frame=self.frame), at, t) @ self.parameters.derivative(values)
        return States(state.q, state.omega, by[:, :3], by[:, 3:])


class SceneMotions:
    """The motion of a scene's body under its torques: derivatives by those of the motion where it has them, else by
    differences of motions, side by side on all cores."""

    def __init__(self, parameters, scene):
        self.parameters, self.scene, self.frame = parameters, scene, scene.frame
        self.free_motions = FreeMotions(parameters, scene.frame)
        self.accuracy_rad = min(ACCURACY_RAD, scene.accuracy_rad)
        self.last = (None, None, None)  # numbers and times, and the states there

    def motion(self, values, t):
        """Over no more than the times ask for."""
        first, last = min(t.min(), 0.0), max(t.max(), 0.0)
        begin, end = self.scene.span
        if first < begin or last > end:
            raise InputError(f"a measurement lies {max(begin - first, last - end) / 86400:.1f} d outside of the scene's span")
        scene = Scene(
            self.scene.name, body_of(self.parameters, self.parameters.at(values)), self.scene.torques, frame=self.frame,
            before=max(-first, 0.0), after=min(last * (1 + 1e-12) + 1.0, end), accuracy=self.accuracy_rad,
        )  # fmt: skip
        return scene.motion()

    def states(self, values, t, derivatives=True):
        known_values, known_t, states = self.last
        known = states is not None and np.array_equal(values, known_values) and np.array_equal(t, known_t)
        if known and (states.by_turn is not None or not derivatives):
            return states
        states = self._states(values, t, derivatives)
        self.last = (np.array(values), np.array(t), states)
        return states

    def _states(self, values, t, derivatives):
        motion = self.motion(values, t)
        state = motion(t)
        if not derivatives:
            return States(state.q, state.omega)
        try:
            at = self.parameters.at(values)
            by = epoch_partials(motion, at, t) @ self.parameters.derivative(values)
            return States(state.q, state.omega, by[:, :3], by[:, 3:])
        except InputError:  # this motion has none
            return self._differences(values, t, state)

    def _differences(self, values, t, state):
        rough = self.free_motions.states(values, t).by_turn
        out = States(state.q, state.omega, np.zeros(rough.shape), np.zeros(rough.shape))

        def column(k):
            fastest = np.linalg.norm(rough[:, :, k], axis=1).max()
            step = min(DIFFERENCE_RAD / max(fastest, 1e-300), 1e-3 * self.parameters.numbers[k].scale)
            moved = values.copy()
            moved[k] += step
            beside = self.motion(moved, t)(t)
            out.by_turn[:, :, k] = rotations.logarithm(rotations.multiply(rotations.conjugate(state.q), beside.q)) / step
            out.by_omega[:, :, k] = (beside.omega - state.omega) / step

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(column, np.flatnonzero(self.parameters.free)))
        return out
