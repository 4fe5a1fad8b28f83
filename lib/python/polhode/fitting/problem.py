"""What is to be made small: residuals of measurements and of what is known beforehand, with their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .._errors import ComputationError, InputError
from . import rotations
from .brightness import ellipsoid_magnitude, semi_axes_of_moments
from .observations import ATTITUDE, AXIS, MAGNITUDE, RATE, WIDTH
from .parameters import Parameter

GUESSED_SIGMA = {ATTITUDE: np.radians(5), AXIS: np.radians(5), MAGNITUDE: 0.1}  # where none is stated: to begin with


@dataclass
class Photometry:
    """How bright the body is: an ellipsoid along its named axes, H, a line and a parabola in phase angle. Without semi-axes
    it is the ellipsoid of uniform density that has the body's moments, whatever they are."""

    semi_axes: tuple | None
    numbers: list = field(default_factory=list)

    def __post_init__(self):
        self.numbers = [
            Parameter("H", ("H",), 0.0, 1.0, "mag", 1e-4),
            Parameter("phase_slope", ("slope",), 0.035, 0.1, "mag/deg", 1e-6),
            Parameter("phase_curvature", ("curvature",), 0.0, 1e-3, "mag/deg2", 1e-8, free=False),
        ]
        for k, a in enumerate("xyz" if self.semi_axes else ""):
            scale = max(self.semi_axes)
            self.numbers.append(Parameter(f"shape.{a}", ("shape", k), float(self.semi_axes[k]), scale, "", 1e-5, free=False))

    def magnitudes(self, values, q, moments, rows):
        """(n,), and derivatives by a small turn (n, 3), by the numbers, and by the moments (n, 3)."""
        h, slope, curvature, *axes = values
        if not axes:
            axes = semi_axes_of_moments(moments)
        to_body = np.swapaxes(rotations.matrix(q), -1, -2)
        directions = np.einsum("nij,nkj->nki", to_body, rows.towards)
        e, s = directions[:, 0], directions[:, 1]
        magnitude, by_e, by_s, by_axes = ellipsoid_magnitude(axes, e, s)
        phase = np.degrees(np.arctan2(np.linalg.norm(np.cross(e, s), axis=1), np.sum(e * s, axis=1)))
        distance = 5 * np.log10(np.prod(rows.distances_au, axis=1))
        # A small turn of the body takes a direction d in its axes by d x turn.
        by_turn = np.cross(by_e, e) + np.cross(by_s, s)
        by_numbers = np.column_stack([np.ones(len(phase)), phase, phase**2])
        by_moments = np.zeros((len(phase), 3))
        if self.semi_axes:
            by_numbers = np.column_stack([by_numbers, by_axes / np.array(axes)])
        else:
            by_moments = by_axes @ ((0.25 - 0.5 * np.eye(3)) / np.maximum(moments.sum() / 2 - moments, 1e-6 * moments.sum())[:, None])
        return h + slope * phase + curvature * phase**2 + distance + magnitude, by_turn, by_numbers, by_moments


class Problem:
    """Rows in the frame of the motions, with a sigma each, and the numbers that they depend on."""

    def __init__(self, parameters, motions, rows, photometry=None):
        self.parameters, self.motions = parameters, motions
        self.rows = [r.in_frame(motions.frame) for r in rows]
        self.photometry = photometry
        self.numbers = parameters.numbers + (photometry.numbers if photometry else [])
        self.times = [np.array([instant - parameters.epoch for instant in r.instants]) for r in self.rows]
        self.estimated = [r.sigma is None for r in self.rows]
        self.sigma = [np.full(len(r), GUESSED_SIGMA[r.kind]) if r.sigma is None else np.array(r.sigma) for r in self.rows]
        self.start = self.values  # that known sigmas are about
        self._known()

    @property
    def values(self):
        return np.array([p.value for p in self.numbers])

    @property
    def free(self):
        return np.array([p.free for p in self.numbers], dtype=bool)

    @property
    def scales(self):
        return np.array([p.scale for p in self.numbers])

    def everything(self):
        return [np.ones(len(r), dtype=bool) for r in self.rows]

    def _known(self):
        """The root of the inverse covariance of what is known beforehand about free numbers."""
        known = [k for k, p in enumerate(self.numbers) if p.free and p.sigma > 0]
        covariance = np.diag([self.numbers[k].sigma ** 2 for k in known]) if known else np.zeros((0, 0))
        if self.parameters.correlated is not None:
            names, of_names = self.parameters.correlated
            place = {self.numbers[k].name: i for i, k in enumerate(known)}
            for a, name_a in enumerate(names):
                for b, name_b in enumerate(names):
                    if name_a in place and name_b in place:
                        covariance[place[name_a], place[name_b]] = of_names[a, b]
        self.known = known
        self.known_root = np.zeros((0, 0))
        if known:
            sigma = np.sqrt(np.diag(covariance))
            size, axes = np.linalg.eigh(covariance / np.outer(sigma, sigma))
            self.known_root = (axes / np.sqrt(np.maximum(size, 1e-12))).T / sigma  # what is exact stays, within rounding

    def residuals(self, values, active, derivatives=True):
        """Residuals in sigmas, of every active row and of what is known beforehand; with derivatives (rows, numbers)."""
        values = np.asarray(values, dtype=float)
        parts, by_parts = [], []
        for _, residual, by in self.each(values, active, derivatives):
            parts.append(residual.ravel())
            if derivatives:
                by_parts.append(by.reshape(-1, len(self.numbers)))
        if self.known:
            parts.append(self.known_root @ (values - self.start)[self.known])
            by = np.zeros((len(self.known), len(self.numbers)))
            by[:, self.known] = self.known_root
            by_parts.append(by)
        if not derivatives:
            return np.concatenate(parts)
        by = np.concatenate(by_parts)
        by[:, ~self.free] = 0
        return np.concatenate(parts), by

    def each(self, values, active, derivatives=True):
        """Of each set of rows: it, residuals (n, width) in sigmas, derivatives (n, width, numbers)."""
        n_body = len(self.parameters.numbers)
        all_times = np.concatenate([t[a] for t, a in zip(self.times, active)])
        times, where = np.unique(all_times, return_inverse=True)
        states = self.motions.states(values[:n_body], times, derivatives)
        begin = 0
        for r, sigma, mask in zip(self.rows, self.sigma, active):
            n = int(mask.sum())
            at = where[begin : begin + n]
            begin += n
            if n == 0:
                continue
            part = r.part(mask)
            by = np.zeros((n, WIDTH[r.kind], len(self.numbers))) if derivatives else None
            residual = self._of_kind(part, states, at, values, by)
            yield r, residual / sigma[mask][:, None], by / sigma[mask][:, None, None] if derivatives else None

    def _of_kind(self, rows, states, at, values, by):
        n_body = len(self.parameters.numbers)
        q, omega = states.q[at], states.omega[at]
        by_turn = states.by_turn[at] if by is not None else None
        if rows.kind == ATTITUDE:
            residual, by_model = rotations.turn_residual(q, rows.values)
            if by is not None:
                by[:, :, :n_body] = by_model @ by_turn
        elif rows.kind == RATE:
            residual = rows.values - omega
            if by is not None:
                by[:, :, :n_body] = -states.by_omega[at]
        elif rows.kind == AXIS:
            to_body = np.swapaxes(rotations.matrix(q), -1, -2)
            seen = np.einsum("nij,nj->ni", to_body, rows.values)
            across = np.linalg.svd(rows.axis[None, :])[2][1:]  # two directions at a right angle to the axis
            sine, cosine = np.linalg.norm(seen @ across.T, axis=1), seen @ rows.axis
            factor = np.where(sine > 1e-9, np.arctan2(sine, cosine) / np.maximum(sine, 1e-12), 1.0)
            residual = factor[:, None] * (seen @ across.T)
            if by is not None:  # a small turn takes what is seen by seen x turn; the factor's own change is of second order
                by[:, :, :n_body] = factor[:, None, None] * (across @ rotations.cross_matrix(seen)) @ by_turn
        else:
            moments = np.diag(self.parameters.at(values[:n_body]).tensor)
            magnitude, of_turn, of_numbers, of_moments = self.photometry.magnitudes(values[n_body:], q, moments, rows)
            residual = (rows.values - magnitude)[:, None]
            if by is not None:
                by[:, 0, :n_body] = -np.einsum("ni,nik->nk", of_turn, by_turn)
                by[:, 0, n_body:] = -of_numbers
                if not self.photometry.semi_axes:
                    of_tensor = self.parameters.derivative(values[:n_body])[[6, 9, 11]]
                    by[:, 0, :n_body] -= of_moments @ of_tensor
        return residual


def solve(problem, values, active, loss="linear", rough=False, most=60):
    """The free numbers that make the residuals least, from these; `rough`: as good as a next stage needs. Raises
    ComputationError where none are found."""
    from scipy.optimize import least_squares

    free = np.flatnonzero(problem.free)
    scales = problem.scales[free]

    def whole(z):
        out = np.array(values, dtype=float)
        out[free] += z * scales
        return out

    def function(z):
        try:
            return problem.residuals(whole(z), active, derivatives=False)
        except InputError:  # no body has these numbers
            return np.full(rows, np.inf)

    def derivative(z):
        return problem.residuals(whole(z), active)[1][:, free] * scales

    rows = len(problem.residuals(values, active, derivatives=False))
    if rows == 0:
        return np.array(values, dtype=float)
    ftol = 1e-3 if rough else 1e-6
    found = least_squares(
        function, np.zeros(len(free)), derivative, loss=loss, f_scale=2.0, x_scale=1.0, ftol=ftol, xtol=1e-10, gtol=1e-12, max_nfev=most
    )
    if not np.isfinite(found.cost):
        raise ComputationError("the fit found no body: every step led to numbers that no body has")
    return whole(found.x)
