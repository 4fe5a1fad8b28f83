"""From nothing: a tumbling ellipsoid by its magnitudes alone.

The frequencies of the longest apparition give pairs of precession and polhode. For each pair, both modes and a grid of shapes
the motion is known up to the momentum's direction and two phases: these are tried on a grid, the best are fitted, first to
that apparition and then to all, led along in time."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from .._core import FreeMotion, Inertia, Instant, q_frame_from_momentum, solve_periods
from .._errors import ComputationError, InputError
from . import rotations
from .frequencies import lines, pairs
from .leading import counted_otherwise, foresight, solved
from .motions import FreeMotions
from .observations import MAGNITUDE
from .parameters import Parameters
from .problem import Photometry, Problem
from .units import rate_rad_s

LEAST = 30  # magnitudes
PAIRS = 40  # of frequencies that are tried
SHAPES = [(b, c * b) for b in (0.35, 0.55, 0.75, 0.92) for c in (0.55, 0.75, 0.93)]
DIRECTIONS, PHI, PSI = 60, 12, 6
POINTS = 110  # of the light curve, for the grid
KEPT_OF_PAIR, KEPT = 12, 80
GAP_S = 60 * 86400.0  # that separates apparitions
FRAME = "ECLIPJ2000"


def from_magnitudes(name, rows, *, shape, within, most_solutions, max_rate, progress):
    rows = [r.in_frame(FRAME) for r in rows if r.kind == MAGNITUDE]
    if shape is not None:
        raise InputError("from nothing the shape follows from the fitted moments; none can be given")
    count = sum(map(len, rows))
    if count < LEAST:
        raise InputError(f"of {name} nothing is known, and there are {count} magnitudes: {LEAST} are wanted at least, or a body file with a first guess")
    instants = [i for r in rows for i in r.instants]
    zero = min(instants)
    t = np.array([i - zero for i in instants])
    main = apparitions(t)[0]
    epoch = zero + float(np.median(t[main]))
    t = t - (epoch - zero)
    curve = Curve(
        t[main],
        np.concatenate([r.values - 5 * np.log10(np.prod(r.distances_au, axis=1)) for r in rows])[main],
        np.concatenate([np.full(len(r), 0.05) if r.sigma is None else r.sigma for r in rows])[main],
        np.concatenate([r.towards for r in rows])[main],
    )
    highest = rate_rad_s(max_rate) / (2 * np.pi) if max_rate is not None else curve.highest()
    found = lines(curve.t, curve.y, 1 / curve.sigma, curve.base, highest)
    tried = pairs(curve.t, curve.y, 1 / curve.sigma, curve.base, found, highest, PAIRS)
    if not tried:
        raise ComputationError(f"{name}: the magnitudes show no two frequencies; a body that turns about one axis has one")
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        starts = []
        for k, some in enumerate(pool.map(grid_of_pair, [(curve, pair) for pair in tried])):
            starts += some
            if progress:
                progress(k + 1, len(tried) + KEPT)
        starts.sort(key=lambda start: start[0])
        plain = [replace(r, instants=[i.since_j2000("TT") for i in r.instants]) for r in rows]  # for another process
        half_span = float(np.abs(curve.t).max())
        tasks = [(name, plain, epoch.since_j2000("TT"), start, half_span) for start in starts[:KEPT]]
        ends = []
        for k, end in enumerate(pool.map(fitted, tasks)):
            if end is not None:
                ends.append((end[0], problem_of(name, rows, epoch, starts[k]), end[1]))
            if progress:
                progress(len(tried) + k + 1, len(tried) + KEPT)
    if not ends:
        raise ComputationError(f"{name}: no motion was found that meets the magnitudes")
    from .nothing import ranked

    return ranked(ends, False, within, most_solutions)


def apparitions(t):
    """Indices of rows without long gaps between them, those with most rows first."""
    order = np.argsort(t)
    parts = np.split(order, 1 + np.flatnonzero(np.diff(t[order]) > GAP_S))
    return sorted(parts, key=len, reverse=True)


class Curve:
    """Reduced magnitudes of an apparition."""

    def __init__(self, t, y, sigma, towards):
        self.t, self.y, self.sigma, self.towards = t, y, sigma, towards
        e, s = towards[:, 0], towards[:, 1]
        phase = np.degrees(np.arctan2(np.linalg.norm(np.cross(e, s), axis=1), np.sum(e * s, axis=1)))
        self.base = np.column_stack([np.ones(len(t)), phase / 10])

    def highest(self):
        """The frequency up to which is looked: two turns in the median time between rows, at the most 12 in a day."""
        steps = np.diff(np.sort(self.t))
        return min(2 / np.median(steps[steps > 0]), 12 / 86400)

    def thinned(self, most):
        k = np.unique(np.linspace(0, len(self.t) - 1, min(most, len(self.t))).astype(int))
        order = np.argsort(self.t)[k]
        return Curve(self.t[order], self.y[order], self.sigma[order], self.towards[order])


def sphere(n):
    k = np.arange(n) + 0.5
    z, phi = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    return np.degrees(phi) % 360, np.degrees(np.arcsin(z))


def grid_of_pair(task):
    """Starts for a pair of frequencies: (misfit, q, omega, moments) at the curve's epoch, the best first."""
    curve, (f_phi, twice_f_psi) = task
    curve = curve.thinned(POINTS)
    weight = 1 / curve.sigma
    basis = np.linalg.qr(curve.base * weight[:, None])[0]
    y = curve.y * weight
    y = y - basis @ (basis.T @ y)
    turns = []
    for lon, lat in zip(*sphere(DIRECTIONS)):
        q = q_frame_from_momentum(np.radians(lon), np.radians(lat))
        for phi in np.arange(PHI) * 2 * np.pi / PHI:
            turns.append(rotations.multiply(q, [np.cos(phi / 2), 0, 0, np.sin(phi / 2)]))
    turns = np.array(turns)
    into = np.swapaxes(rotations.matrix(turns), 1, 2).astype(np.float32)  # axes with z along L
    directions = curve.towards.astype(np.float32)
    in_momentum = np.einsum("wij,nkj->wnki", into, directions)  # (turns, n, 2, 3)
    out = []
    for b, c in SHAPES:
        moments = np.array([b * b + c * c, 1 + c * c, 1 + b * b])
        moments /= moments[2]
        try:
            solutions = solve_periods(Inertia(moments), 1 / f_phi, 2 / twice_f_psi, "long axis")
        except InputError:
            continue
        squares = np.array([1, 1 / b**2, 1 / c**2], dtype=np.float32)
        for solution in solutions:
            q, momentum, _ = solution.state(Inertia(moments), 0.0, 0.0)
            motion = FreeMotion(moments, q, momentum)
            for k in range(PSI):
                shift = k / PSI / twice_f_psi
                to_body = np.swapaxes(rotations.matrix(motion(curve.t + shift).q), 1, 2).astype(np.float32)
                seen = np.einsum("nij,wnkj->wnki", to_body, in_momentum)
                e, s = seen[:, :, 0], seen[:, :, 1]
                m_e = e * squares
                ee, es, ss = (m_e * e).sum(-1), (m_e * s).sum(-1), (s * s * squares).sum(-1)
                area = np.sqrt(ee) + es / np.sqrt(ss)
                model = -2.5 * np.log10(np.maximum(area, 1e-6)) * weight.astype(np.float32)
                model -= (model @ basis) @ basis.T
                cost = np.sum((y - model) ** 2, axis=1)
                for w in np.argpartition(cost, 4)[:4]:
                    state = motion(shift)
                    out.append((float(cost[w]), rotations.multiply(turns[w], state.q), state.omega, moments))
    out.sort(key=lambda start: start[0])
    return out[:KEPT_OF_PAIR]


def problem_of(name, rows, epoch, start):
    _, q, omega, moments = start
    parameters = Parameters.of_state(name, epoch, FRAME, q, omega, np.diag(moments))
    return Problem(parameters, FreeMotions(parameters), rows, Photometry(None))


def fitted(task):
    """(chi-squared, values) of a fit from a start: to the main apparition, then to all; None where it fails."""
    name, plain, epoch, start, half_span = task
    rows = [replace(r, instants=[Instant.from_tt_j2000(*i) for i in r.instants]) for r in plain]
    problem = problem_of(name, rows, Instant.from_tt_j2000(*epoch), start)
    main = [np.abs(t) <= half_span * 1.001 for t in problem.times]
    values = problem.values
    try:
        residual = np.concatenate([(r * problem.sigma[k][m][:, None]).ravel() for k, (m, (_, r, _)) in enumerate(zip(main, problem.each(values, main, False)))])
        values[len(problem.parameters.numbers)] += float(np.median(residual))
        values, cost = solved(problem, [(values, np.inf)], main, "linear", rough=True)[0]
        values, cost = solved(problem, [(values, cost)], main, "linear", rough=False)[0]
        if not all(m.all() for m in main):
            if cost > 30 * sum(int(m.sum()) for m in main):
                return None
            values, cost = to_all(problem, values, main)
    except (ComputationError, InputError):
        return None
    return cost, values


def to_all(problem, values, main):
    """On from the main apparition to the others, the nearest first; where a turn may be miscounted, also one more or less."""
    paths = [(values, 0.0)]
    active = list(main)
    times = np.unique(np.concatenate([t[~m] for t, m in zip(problem.times, main)]))
    for part in sorted(apparitions(times), key=lambda part: np.abs(times[part]).min()):
        nearest = times[part][np.argmin(np.abs(times[part]))]
        covariance, by_turn = foresight(problem, problem.motions, paths[0][0], np.array([nearest]), active)
        of_turn = by_turn[0] @ covariance @ by_turn[0].T
        paths = counted_otherwise(problem, paths[:2], covariance, by_turn[0], of_turn, 1)
        active = [a | np.isin(t, times[part]) for a, t in zip(active, problem.times)]
        paths = solved(problem, paths, active, "linear", rough=True)
    return solved(problem, paths[:1], problem.everything(), "linear", rough=False)[0]
