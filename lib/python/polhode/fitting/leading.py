"""A fit that is led along in time, so that no turn is miscounted, and one that finds what does not belong."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .._errors import ComputationError, InputError
from .motions import FreeMotions
from .observations import WIDTH
from .problem import solve

CERTAIN_RAD = np.radians(25)  # an attitude that is known beforehand to this sigma is met by the turn that is meant
UNKNOWN = {"rate": 0.03, "angle": 0.2, "moment": 0.1, "other": 1.0}  # of a first guess, in natural scales
FARTHEST = 25.0  # chi-squared above the best, beyond which another way to count is given up
MOST_PATHS = 8
LIKELY = 1e-3  # a datum is rejected that a right one surpasses with this chance


def guessed_sigma(number):
    if number.sigma > 0:
        return number.sigma
    kind = number.name.split(".")[0]
    if kind in ("components", "P_phi", "P_psi", "period"):
        return UNKNOWN["rate"] * number.scale
    if kind in ("moments", "products", "tensor", "semi_axes"):
        return UNKNOWN["moment"] * number.scale
    return UNKNOWN["angle" if number.unit in ("deg", "rad", "arcmin", "arcsec") else "other"] * number.scale


@dataclass
class Course:
    """How a fit went: which rows were added when, and where a turn may have been miscounted."""

    stages: list = field(default_factory=list)  # (number of rows, seconds of the last)
    gaps: list = field(default_factory=list)  # (seconds of the row, sigma in turns with which it was foreseen)
    aliases: list = field(default_factory=list)  # (values, chi-squared) that count the turns of a gap otherwise


def led_along(problem, progress=None, loss="linear", turns=3):
    """The values of a fit to all rows, and its Course. Rows are added in order of their distance from the epoch, those
    whose attitude the fit to the rows before foresees; where it foresees none, the next one all the same. So many `turns`
    more or fewer are then tried, 0: none."""
    course = Course()
    times = np.unique(np.concatenate(problem.times))
    order = times[np.argsort(np.abs(times), kind="stable")]
    rough = FreeMotions(problem.parameters, problem.motions.frame)
    paths = [(problem.values, 0.0)]  # ways to count, the best first
    taken = 0
    while taken < len(order):
        values = paths[0][0]
        covariance, by_turn = foresight(problem, rough, values, order, [np.isin(t, order[:taken]) for t in problem.times])
        of_turn = by_turn @ covariance @ np.swapaxes(by_turn, 1, 2)
        foreseen = np.sqrt(np.maximum(np.linalg.eigvalsh(of_turn)[:, -1], 0))
        uncertain = np.flatnonzero(foreseen[taken:] > CERTAIN_RAD)
        until = taken + (int(uncertain[0]) if len(uncertain) else len(order) - taken)
        if until == taken:
            until += 1
            if taken:
                course.gaps.append((float(order[taken]), float(foreseen[taken] / (2 * np.pi))))
                if turns:
                    paths = counted_otherwise(problem, paths, covariance, by_turn[taken], of_turn[taken], turns)
        taken = until
        active = [np.isin(t, order[:taken]) for t in problem.times]
        if progress:
            progress(taken, len(order))
        paths = solved(problem, paths, active, loss, rough=taken < len(order))
        course.stages.append((sum(int(a.sum()) for a in active), float(order[taken - 1])))
    course.aliases = paths[1:]
    return paths[0][0], course


def foresight(problem, rough, values, times, active):
    """The covariance of the free numbers by the active rows, a guess's where they say nothing, and the derivatives of the
    small turn at `times` by these numbers."""
    n_body = len(problem.parameters.numbers)
    free = np.flatnonzero(problem.free)
    guess = np.array([guessed_sigma(problem.numbers[k]) for k in free])
    information = np.zeros((len(free), len(free)))
    if any(a.any() for a in active):
        by = problem.residuals(values, active)[1][:, free]
        information = by.T @ by
    covariance = np.linalg.inv(information * np.outer(guess, guess) + np.eye(len(free))) * np.outer(guess, guess)
    whole = np.zeros((len(times), 3, len(problem.numbers)))
    whole[:, :, :n_body] = rough.states(values[:n_body], times).by_turn
    return covariance, whole[:, :, free]


def counted_otherwise(problem, paths, covariance, by_turn, of_turn, turns):
    """The paths, and beside each those that have made up to so many turns more or fewer by the next row."""
    free = np.flatnonzero(problem.free)
    sizes, axes = np.linalg.eigh(of_turn)
    out = list(paths)
    for size, axis in zip(sizes, axes.T):
        sigma_turns = np.sqrt(max(size, 0)) / (2 * np.pi)
        most = min(turns, int(np.ceil(2.5 * sigma_turns)))
        if np.sqrt(max(size, 0)) < CERTAIN_RAD:
            continue
        change = covariance @ by_turn.T @ axis / size * 2 * np.pi
        for n in range(-most, most + 1):
            if n == 0:
                continue
            for values, _ in paths[:MOST_PATHS]:
                moved = values.copy()
                moved[free] += n * change
                out.append((moved, np.inf))
    return out


def solved(problem, paths, active, loss, rough):
    """The paths after a fit each, the best first, without those that end at the same or are much worse."""
    ends = []
    for values, _ in paths:
        try:
            end = solve(problem, values, active, loss, rough)
            ends.append((end, chi_squared(problem, end, active)))
        except (ComputationError, InputError):
            continue
    if not ends:
        raise ComputationError("the fit found no body: no step led to numbers that a body has")
    ends.sort(key=lambda end: end[1])
    kept = []
    free = problem.free
    for values, cost in ends:
        if cost > ends[0][1] + FARTHEST and kept:
            break
        if all(np.abs((values - other)[free] / problem.scales[free]).max() > 1e-4 for other, _ in kept):
            kept.append((values, cost))
    return kept[:MOST_PATHS]


def chi_squared(problem, values, active):
    return float(np.sum(problem.residuals(values, active, derivatives=False) ** 2))


def surprises(problem, values, active):
    """Of every row, active or not: its squared residual in sigmas, and the limit that a right one seldom surpasses."""
    from scipy.stats import chi2

    out = []
    for _, residual, _ in problem.each(values, problem.everything(), derivatives=False):
        squared = np.sum(residual**2, axis=1)
        out.append((squared, chi2.isf(LIKELY, residual.shape[1])))
    return out


def without_outliers(problem, values, most=12):
    """Fits again without the rows that do not belong, until they stay the same: values, the rows that are left. Sigmas that
    are estimated come from the middle of the residuals."""
    from scipy.stats import chi2

    active = problem.everything()
    values = solve(problem, values, active, loss="soft_l1")
    for _ in range(most):
        found = surprises(problem, values, active)
        left = []
        for k, (squared, limit) in enumerate(found):
            if problem.estimated[k]:
                factor = np.sqrt(np.median(squared) / chi2.ppf(0.5, WIDTH[problem.rows[k].kind]))
                problem.sigma[k] = problem.sigma[k] * factor
                squared = squared / factor**2
            left.append(squared <= limit)
        if all(np.array_equal(a, b) for a, b in zip(left, active)):
            break
        active = left
        values = solve(problem, values, active)
    return values, active


def with_estimated_sigmas(problem, values, active):
    """Where sigmas are not stated: the rows' own scatter, and the fit with it."""
    for _ in range(3):
        free = int(problem.free.sum())
        count = sum(int(mask.sum()) * WIDTH[r.kind] for r, mask in zip(problem.rows, active))
        share = max(1 - free / max(count, 1), 1 / max(count, 1))
        changed = False
        for k in range(len(problem.rows)):
            if not problem.estimated[k] or not active[k].any():
                continue
            only = [mask if j == k else np.zeros(len(mask), dtype=bool) for j, mask in enumerate(active)]
            residual = next(problem.each(values, only, derivatives=False))[1]
            factor = np.sqrt(np.mean(residual**2) / share)
            factor = max(factor, 1e-9 / problem.sigma[k][0])
            changed |= not 0.99 < factor < 1.01
            problem.sigma[k] = problem.sigma[k] * factor
        if not changed:
            break
        values = solve(problem, values, active)
    return values
