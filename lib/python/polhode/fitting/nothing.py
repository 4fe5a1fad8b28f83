"""From nothing: a body's motion by its attitudes alone.

The angular momentum L stands still in space. For a direction of L, each attitude gives the direction u of L in the body, and
all u lie on one polhode, u K u = constant with K the inverse of the tensor of inertia: linear equations for K, up to a factor
and a multiple of the unit matrix. The direction is found where they fit best. What is left are two frequencies, each found by
itself: du/dt = a u x K u runs along the polhode, and the multiple of the unit matrix, b, turns the body about L alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core import Body, FreeMotion, frame_rotation
from .._errors import ComputationError, InputError
from . import rotations
from .leading import chi_squared, solved, with_estimated_sigmas, without_outliers
from .motions import FreeMotions, inertia_of
from .observations import ATTITUDE, MAGNITUDE
from .parameters import Parameters
from .problem import Problem
from .result import Fit
from .units import rate_rad_s

LEAST = 4  # attitudes
DIRECTIONS = 1500  # of the momentum, on a hemisphere
KEPT_DIRECTIONS = 12
APART_RAD = np.radians(8)  # directions that are kept
PHASES = 720  # along a polhode
FINENESS = 6  # trial frequencies for each turn more over the span
MOST_FREQUENCIES = 20000
KEPT_FREQUENCIES = 3
BASE = 6.0  # of the inverse moments, where only their differences matter
GUESSES, MOST_GUESSES = 8, 60  # that are fitted at least, and at most if none meets the attitudes
SEEN_ASIDE = 0.3  # between momentum and rate, above which a body surely tumbles
ONE_AXIS = 16.0  # chi-squared that tumbling must save, for two ratios and two angles
BASIS = np.zeros((5, 3, 3))  # of symmetric matrices without a trace, the diagonal ones first
BASIS[0] = np.diag([1, -1, 0]) / 2**0.5
BASIS[1] = np.diag([1, 1, -2]) / 6**0.5
for _k, (_i, _j) in enumerate(((0, 1), (0, 2), (1, 2))):
    BASIS[2 + _k, _i, _j] = BASIS[2 + _k, _j, _i] = 0.5**0.5


@dataclass
class Guess:
    """A motion at the first of the attitudes, in body axes."""

    q: np.ndarray
    omega: np.ndarray
    tensor: np.ndarray
    misfit: float


def from_nothing(body, rows, *, robust, products, shape, within, most_solutions, max_rate, progress, free, fixed):
    name = body if isinstance(body, str) else body.name
    attitudes = [r for r in rows if r.kind == ATTITUDE]
    if not attitudes:
        if any(r.kind == MAGNITUDE for r in rows):
            from .lightcurve import from_magnitudes

            return from_magnitudes(name, rows, shape=shape, within=within, most_solutions=most_solutions, max_rate=max_rate, progress=progress)
        raise InputError(f"of {name} nothing is known, and there are no attitudes: attitudes or magnitudes are wanted to begin with")
    frame = attitudes[0].frame
    instants = [instant for r in attitudes for instant in r.instants]
    q = np.concatenate([r.in_frame(frame).values for r in attitudes])
    if len(np.unique([i - instants[0] for i in instants])) < LEAST:
        raise InputError(
            f"of {name} nothing is known, and there are {len(q)} attitudes: {LEAST} at different times are wanted at least, or a body file with a first guess"
        )
    if not any(frame == f for f in ("ICRF", "ECLIPJ2000")):
        q, frame = rotations.multiply(frame_rotation(frame, "ICRF"), q), "ICRF"
    order = np.argsort([i - instants[0] for i in instants], kind="stable")
    first, middle = instants[order[0]], instants[order[len(order) // 2]]  # from its middle the motion is most nearly linear
    t = np.array([instants[k] - first for k in order])
    q = q[order]
    highest = rate_rad_s(max_rate) if max_rate is not None else fastest(t)
    paths = []
    guesses = search(t, rotations.matrix(q), highest, products, progress)
    for k, guess in enumerate(guesses[:MOST_GUESSES]):
        if k >= GUESSES and k % 4 == 0 and paths and is_met(min(paths, key=lambda path: path[0])):
            break
        state = Body(name, inertia=inertia_of(guess.tensor), epoch=first, frame=frame, q=guess.q, omega=guess.omega).motion(frame)(middle - first)
        parameters = Parameters.of_state(name, middle, frame, state.q, state.omega, guess.tensor, products=products)
        if free or fixed:
            parameters.choose(free, fixed)
        mine = Problem(parameters, FreeMotions(parameters), rows)
        try:
            values, cost = solved(mine, [(mine.values, np.inf)], mine.everything(), "soft_l1", rough=True)[0]
            values, cost = solved(mine, [(values, cost)], mine.everything(), "soft_l1" if robust else "linear", rough=False)[0]
        except ComputationError:
            continue
        paths.append((cost, mine, values))
    if not paths:
        raise ComputationError(f"{name}: no motion was found that meets the attitudes")
    return ranked(paths, robust, within, most_solutions)


def is_met(path):
    """Whether most rows are met: to three sigmas, or where these are not stated to 10 deg."""
    _, problem, values = path
    far = [np.sqrt(np.mean(r**2, axis=1)) > (2 if e else 3) for e, (_, r, _) in zip(problem.estimated, problem.each(values, problem.everything(), False))]
    return np.mean(np.concatenate(far)) < 0.2


def ranked(paths, robust, within, most_solutions):
    """Fits of (chi-squared, problem, values), the best first, each motion once."""
    paths.sort(key=lambda path: path[0])
    found = []
    for cost, problem, values in paths:
        if found and cost > paths[0][0] + max(within, 3 * paths[0][0]):
            break
        if any(same_motion(problem, values, *other) for other in found):
            continue
        found.append((problem, values))
    fits = []
    for problem, values in found[: max(most_solutions, 1)]:
        active = problem.everything()
        if robust:
            values, active = without_outliers(problem, values)
        if fits:  # to the same sigmas
            problem.sigma = [s * np.median(o / s) if e else s for s, o, e in zip(problem.sigma, fits[0]._problem.sigma, problem.estimated)]
        else:
            values = with_estimated_sigmas(problem, values, active)
        values, sentences = about_one_axis(problem, values, active)
        fits.append(Fit(problem, problem.parameters.anchored(values), active))
        fits[-1].undetermined += sentences
    fits.sort(key=lambda fit: fit.chi_squared)
    fits = [fit for fit in fits if fit.chi_squared <= fits[0].chi_squared + within]
    for k, one in enumerate(fits):
        one.rank, one.solutions = k + 1, fits
    if len(fits) > 1:
        fits[0].warnings.append(f"{len(fits)} solutions are within {within:g} of the best chi-squared: the measurements do not decide between them")
    return fits[0]


def about_one_axis(problem, values, active):
    """The values, and what is to be said where a rotation about one axis meets the measurements as well: then the moments,
    whatever they came to, are not determined, and are held."""
    parameters = problem.parameters
    at = parameters.at(values[: len(parameters.numbers)])
    momentum = at.tensor @ at.omega
    aside = np.linalg.norm(np.cross(momentum, at.omega)) / np.linalg.norm(momentum) / np.linalg.norm(at.omega)
    moments = [k for k, p in enumerate(parameters.numbers) if p.name.startswith(("moments", "products")) and p.free]
    if aside > SEEN_ASIDE or not moments or problem.photometry:
        return values, []
    steady = values.copy()
    for k, p in enumerate(parameters.numbers):
        if p.name.startswith(("moments", "products")):
            steady[k] = 1.0 if p.name.startswith("moments") else 0.0
            p.free = False
    steady, cost = solved(problem, [(steady, np.inf)], active, "linear", rough=False)[0]
    if cost < chi_squared(problem, values, active) + ONE_AXIS:
        return steady, ["not determined: the moments of inertia; a rotation about one axis meets the measurements as well, and the moments are written as equal ones"]
    for k in moments:
        parameters.numbers[k].free = True
    return values, []


def same_motion(problem, values, other, other_values):
    """Whether two solutions agree at all measurements to a fraction of their sigma."""
    one = np.concatenate([r.ravel() for _, r, _ in problem.each(values, problem.everything(), False)])
    two = np.concatenate([r.ravel() for _, r, _ in other.each(other_values, other.everything(), False)])
    return np.sqrt(np.mean((one - two) ** 2)) < 0.05


def fastest(t):
    """The rate up to which is looked: two turns in the mean time between attitudes."""
    return 2 * np.pi * 2 * (len(t) - 1) / np.ptp(t)


def search(t, to_frame, highest, products=False, progress=None):
    """Guesses of the motion, the best first."""
    directions = hemisphere(DIRECTIONS)
    basis = BASIS if products else BASIS[:2]
    misfit = off_polhode(np.einsum("nji,dj->dni", to_frame, directions), basis)[0]
    kept = []
    for k in np.argsort(misfit):
        if all(abs(directions[k] @ d) < np.cos(APART_RAD) for d in kept):
            kept.append(directions[k])
        if len(kept) == KEPT_DIRECTIONS:
            break
    guesses = []
    for k, direction in enumerate(kept):
        guesses += of_direction(t, to_frame, sharpened(to_frame, direction, basis), basis, highest)
        if progress:
            progress(k + 1, len(kept))
    guesses.sort(key=lambda guess: guess.misfit)
    return guesses


def hemisphere(n):
    k = np.arange(n) + 0.5
    z, phi = k / n, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)


def off_polhode(u, basis):
    """Of directions (..., n, 3) in body axes: by how much, in rad squared, they are off the polhode that fits them best, and
    its K (..., 3, 3), traceless."""
    k_u = np.einsum("kij,...nj->...nki", basis, u)  # (..., n, k, 3)
    energy = np.einsum("...nki,...ni->...nk", k_u, u)
    n = u.shape[-2]
    spread = energy - energy.mean(axis=-2, keepdims=True)
    spread = np.swapaxes(spread, -1, -2) @ spread / n
    # A small error of u moves the energy by twice what of K u is across u.
    slope = np.einsum("...nki,...nli->...kl", k_u, k_u) / n - np.swapaxes(energy, -1, -2) @ energy / n
    root = np.linalg.inv(np.linalg.cholesky(4 * slope + 1e-3 * np.eye(len(basis))))
    size, axes = np.linalg.eigh(root @ spread @ np.swapaxes(root, -1, -2))
    k = np.einsum("...lk,...l->...k", root, axes[..., 0])
    return size[..., 0], np.einsum("...k,kij->...ij", k, basis)


def sharpened(to_frame, direction, basis):
    """The direction near this one where the misfit is least."""
    width = np.radians(4)
    for _ in range(5):
        across = np.linalg.svd(direction[None, :])[2][1:]
        steps = np.linspace(-1, 1, 7) * width
        grid = (direction + steps[:, None, None] * across[0] + steps[None, :, None] * across[1]).reshape(-1, 3)
        grid /= np.linalg.norm(grid, axis=1, keepdims=True)
        direction = grid[np.argmin(off_polhode(np.einsum("nji,dj->dni", to_frame, grid), basis)[0])]
        width /= 2.5
    return direction


def of_direction(t, to_frame, direction, basis, highest):
    """Guesses with this direction of the momentum, of either sign."""
    u = np.einsum("nji,j->ni", to_frame, direction)
    _, k = off_polhode(u, basis)
    sizes, axes = np.linalg.eigh(k)
    if basis is not BASIS and len(basis) == 2:
        axes, sizes = np.eye(3)[:, np.argsort(np.diag(k))], np.sort(np.diag(k))
    axes, inverse = axes[:, ::-1].copy(), BASE + sizes[::-1] / max(np.ptp(sizes), 1e-12)  # moments ascend
    axes[:, 1] *= np.sign(np.linalg.det(axes))
    v = u @ axes
    energy = v**2 @ inverse
    motion = FreeMotion(1 / inverse, [1.0, 0.0, 0.0, 0.0], v[np.argmin(np.abs(energy - np.median(energy)))])
    out = about_momentum(t, to_frame, direction, axes, inverse, motion, 0.0, np.zeros(len(t)), highest)  # all about one axis
    rate = 2 * np.pi / motion.mean_rates()["polhode_period_s"]
    if not 1e-3 < rate < np.inf:  # one axis, or the separatrix
        return out
    tau = 2 * np.pi / rate * np.arange(PHASES) / PHASES
    curve = motion(tau).momentum
    phase = 2 * np.pi / PHASES * np.argmax(v @ curve.T, axis=1)
    speed = np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=1)
    weight = speed[np.argmax(v @ curve.T, axis=1)] / speed.max()  # noise moves the phase less where it runs fast
    for frequency, offset in peaks(t, phase, weight, highest):
        out += about_momentum(t, to_frame, direction, axes, inverse, motion, frequency / rate, (frequency * t + offset) / rate, highest)
    return out


def about_momentum(t, to_frame, direction, axes, inverse, motion, a, tau, highest):
    """Guesses with this frequency along the polhode: those about the momentum that fit best."""
    start = motion(0.0).momentum
    onto = shortest_turn(start / np.linalg.norm(start), direction)
    model = onto @ rotations.matrix(motion(tau).q) @ axes.T
    rest = to_frame @ np.swapaxes(model, 1, 2)
    skew = np.stack([rest[:, 2, 1] - rest[:, 1, 2], rest[:, 0, 2] - rest[:, 2, 0], rest[:, 1, 0] - rest[:, 0, 1]], axis=-1)
    angle = np.arctan2(skew @ direction, np.trace(rest, axis1=1, axis2=2) - np.einsum("i,nij,j->n", direction, rest, direction))
    # The whole rate is (a K + b) u, of which the model has (a K + a BASE) u.
    out = []
    for frequency, offset in peaks(t, angle, np.ones(len(t)), 1.5 * highest):
        whole = a * inverse + frequency
        if whole.min() * whole.max() <= 0:
            continue
        turned = rotations.matrix(rotations.exponential(direction * (frequency * t + offset)[:, None])) @ model
        turn = rotations.matrix(rotations.exponential(direction * offset))
        first = turn @ onto @ rotations.matrix(motion(tau[0]).q) @ axes.T
        moments = np.abs(1 / whole)
        moments = np.minimum(moments, 0.999 * (moments.sum() - moments))  # what noise made impossible
        moments = np.sort(moments) / moments.max()
        misfit = float(np.mean(3 - np.einsum("nij,nij->n", turned, to_frame)))
        at = first.T @ direction
        out.append(Guess(rotations.from_matrix(first), axes @ (whole * (axes.T @ at)), axes @ np.diag(np.abs(moments_along(whole, moments))) @ axes.T, misfit))
    return out


def moments_along(whole, moments):
    """Ascending moments along the axes whose inverse moments are in proportion to `whole`."""
    out = np.empty(3)
    out[np.argsort(1 / np.abs(whole))] = moments
    return out


def peaks(t, phase, weight, highest):
    """Frequencies (rad/s, both signs) with which the phases run, and the phase at t = 0: the best first."""
    span = np.ptp(t)
    count = int(min(2 * highest * span / (2 * np.pi) * FINENESS + 20, MOST_FREQUENCIES))
    frequencies = np.linspace(-highest, highest, count)
    size = np.abs(np.exp(-1j * np.outer(frequencies, t)) @ (weight * np.exp(1j * phase)))
    inner = size[1:-1]
    tops = 1 + np.flatnonzero((inner >= size[:-2]) & (inner > size[2:]))
    out = []
    for k in tops[np.argsort(-size[tops])][:KEPT_FREQUENCIES]:
        fine = np.linspace(frequencies[k - 1], frequencies[k + 1], 21)
        sums = np.exp(-1j * np.outer(fine, t)) @ (weight * np.exp(1j * phase))
        best = np.argmax(np.abs(sums))
        out.append((float(fine[best]), float(np.angle(sums[best]))))
    return out


def shortest_turn(a, b):
    """The rotation that takes one unit vector to another."""
    axis, cosine = np.cross(a, b), a @ b
    if cosine < -1 + 1e-12:
        across = np.linalg.svd(a[None, :])[2][1]
        return 2 * np.outer(across, across) - np.eye(3)
    skew = rotations.cross_matrix(axis)
    return np.eye(3) + skew + skew @ skew / (1 + cosine)
