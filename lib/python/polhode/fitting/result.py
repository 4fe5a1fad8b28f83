"""What a fit found: the body with its uncertainties, residuals, what pulls, what is not determined."""

from __future__ import annotations

import numpy as np

from .. import _files
from .._errors import InputError
from .motions import FreeMotions
from .observations import ATTITUDE, AXIS, MAGNITUDE, RATE
from .problem import Problem
from .words import Determined

NATURAL = {ATTITUDE: (np.degrees(1), "deg"), RATE: (np.degrees(1) * 86400, "deg/day"), AXIS: (np.degrees(1), "deg"), MAGNITUDE: (1.0, "mag")}


class Fit:
    """One solution of a fit. `chi_squared`, `dof`, `rank` (1 is the best of several), `parameters` (name: value), `sigma`
    (name: one sigma of what was free), `covariance` with `names`, `undetermined` and `warnings` (sentences), `rejected`
    (rows by name), `body` and `motion()`, `solutions` (all that fit, the best first, itself among them)."""

    def __init__(self, problem: Problem, values, active, course=None, scene=None, rank=1):
        self._problem, self._values, self._active, self._scene = problem, np.asarray(values), active, scene
        self.rank = rank
        self._residuals = None
        self.solutions: list = [self]
        self.warnings: list = []
        residual, by = problem.residuals(values, active)
        self.chi_squared = float(np.sum(residual**2))
        determined = Determined(problem, self._values, by)
        self.dof = max(len(residual) - int(problem.free.sum()) + len(determined.open_directions), 0)
        self.covariance, self.undetermined = determined.covariance, determined.sentences
        self.names = [p.name for p in problem.numbers]
        self.parameters = {p.name: float(v) for p, v in zip(problem.numbers, self._values)}
        self.units = {p.name: p.unit for p in problem.numbers}
        self.sigma = {p.name: float(np.sqrt(self.covariance[k, k])) for k, p in enumerate(problem.numbers) if p.free}
        self.rejected = [problem.rows[k].name(j) for k, mask in enumerate(active) for j in np.flatnonzero(~mask)]
        self.body = problem.parameters.body_at(self._values[: len(problem.parameters.numbers)])
        self.course = course
        self._warn()
        if isinstance(problem.motions, FreeMotions):
            self._warn_of_curvature()

    def _warn_of_curvature(self):
        """Where chi-squared is no parabola within two sigmas, the sigmas hold roughly only."""
        free = [k for k in range(len(self.names)) if self.covariance[k, k] > 0]
        scale = np.sqrt(np.diag(self.covariance)[free])
        sizes, axes = np.linalg.eigh(self.covariance[np.ix_(free, free)] / np.outer(scale, scale))
        worst, where = 1.0, None
        for size, axis in zip(sizes, axes.T):
            if size < 1e-12:
                continue
            for sign in (2, -2):
                moved = self._values.copy()
                moved[free] += sign * np.sqrt(size) * axis * scale
                try:
                    rise = max(self.chi_squared_of(moved) - self.chi_squared, 0.04) / 4
                except InputError:  # beyond what bodies can be
                    continue
                if max(rise, 1 / rise) > worst:
                    worst, where = max(rise, 1 / rise), axis
        if worst > 4:
            names = [self.names[free[k]] for k in np.argsort(-np.abs(where))[:3]]
            self.warnings.append(f"the sigmas are rough: chi-squared is no parabola along {', '.join(names)}")

    def _warn(self):
        problem = self._problem
        for gap, sigma in self.course.gaps if self.course else ():
            when = (problem.parameters.epoch + gap).text("UTC", 0)
            self.warnings.append(f"the rows before {when} UTC foresee the attitude there to {sigma:.2g} of a turn only: turns may be miscounted")
        if self.dof > 0:
            from scipy.stats import chi2

            if not any(problem.estimated) and chi2.sf(self.chi_squared, self.dof) < 1e-6:
                self.warnings.append(f"chi-squared is {self.chi_squared:.4g} with {self.dof} degrees of freedom: the measurements are not met to their sigmas, and the sigmas of the result are too small")
        for k, p in enumerate(problem.numbers):
            pull = abs(self._values[k] - p.value) / p.sigma if p.free and p.sigma > 0 else 0
            if pull > 3:
                self.warnings.append(f"{p.name} ends {pull:.1f} sigma from what was known of it beforehand: the measurements contradict it")

    def motion(self):
        """The motion of the fitted body: free, or under the scene's torques."""
        if self._scene is None:
            return self.body.motion(frame=self._problem.motions.frame)
        return self.scene().motion()

    def scene(self):
        """The scene with the fitted body."""
        from .._core import Scene

        s = self._scene
        if s is None:
            raise InputError("no scene was fitted")
        return Scene(s.name, self.body, s.torques, frame=s.frame, before=-s.span[0], after=s.span[1], accuracy=s.accuracy_rad)

    def residuals(self):
        """A row for each measurement: a list of dicts with source, line, date_utc, kind, residual (of an attitude the angle),
        unit, sigmas (its size in standard deviations, of all its numbers together), chi_squared and used."""
        if self._residuals is not None:
            return self._residuals
        out = self._residuals = []
        problem = self._problem
        for r, weighted, _ in problem.each(self._values, problem.everything(), derivatives=False):
            k = next(i for i, other in enumerate(problem.rows) if other is r)
            factor, unit = NATURAL[r.kind]
            size = weighted * problem.sigma[k][:, None] * factor
            for j in range(len(r)):
                one = size[j, 0] if size.shape[1] == 1 else np.linalg.norm(size[j])
                out.append(
                    {
                        "date_utc": r.instants[j].text("UTC", 3),
                        "kind": r.kind,
                        "residual": float(one),
                        "unit": unit,
                        "components": [float(x) for x in size[j]],
                        "sigma": float(problem.sigma[k][j] * factor),
                        "chi_squared": float(np.sum(weighted[j] ** 2)),
                        "used": bool(self._active[k][j]),
                        "source": r.source,
                        "line": int(r.lines[j]),
                    }
                )
        return out

    def chi_squared_of(self, values):
        """With other values of all numbers, in the order of `names`."""
        return float(np.sum(self._problem.residuals(np.asarray(values, dtype=float), self._active, derivatives=False) ** 2))

    def rms(self, kind=ATTITUDE):
        """Root of the mean square of the residuals of a kind that were used: of attitudes of the angle, deg."""
        used = [row["residual"] for row in self.residuals() if row["kind"] == kind and row["used"]]
        return float(np.sqrt(np.mean(np.square(used)))) if used else None

    # --- Out --------------------------------------------------------------------------------------------------------

    def text(self):
        """The body file, with uncertainties and correlations."""
        n_body = len(self._problem.parameters.numbers)
        comments = [f"Fitted by polhode: chi-squared {self.chi_squared:.6g}, {self.dof} degrees of freedom, rank {self.rank}."]
        comments += [sentence[0].upper() + sentence[1:] + "." for sentence in self.undetermined + self.warnings]
        comments += [f"Rejected: {name}." for name in self.rejected]
        for k in range(n_body, len(self.names)):
            comments.append(f"{self.names[k]} = {self._values[k]:.6g}" + (f" +- {self.sigma[self.names[k]]:.2g}" if self.names[k] in self.sigma else ""))
        sources = sorted({r.source for r in self._problem.rows})
        return self._problem.parameters.text(
            self._values[:n_body], self.covariance[:n_body, :n_body], source="fitted to " + ", ".join(sources), comments=comments
        )

    def write(self, path):
        """The body file, which appears whole or not at all."""
        with _files.whole_file(path) as file:
            file.write(self.text().encode())

    def write_residuals(self, path):
        """The residuals as CSV."""
        lines = ["date_utc,kind,residual,unit,component_1,component_2,component_3,sigma,chi_squared,used,source,line"]
        for row in self.residuals():
            parts = [f"{x:.6g}" for x in row["components"]] + [""] * (3 - len(row["components"]))
            source = '"' + row["source"].replace('"', '""') + '"' if "," in row["source"] or '"' in row["source"] else row["source"]
            lines.append(
                f"{row['date_utc']},{row['kind']},{row['residual']:.6g},{row['unit']},{','.join(parts)},{row['sigma']:.6g},"
                f"{row['chi_squared']:.6g},{'yes' if row['used'] else 'no'},{source},{row['line']}"
            )
        with _files.whole_file(path) as file:
            file.write(("\n".join(lines) + "\n").encode())

    def figure(self):
        """A matplotlib figure of the residuals over time."""
        from .picture import residual_figure

        return residual_figure(self)

    def summary(self, most=5):
        """What there is to say, as text."""
        lines = [f"chi-squared   {self.chi_squared:.5g}, {self.dof} degrees of freedom"]
        rows = self.residuals()
        for kind in (ATTITUDE, RATE, AXIS, MAGNITUDE):
            used = [row for row in rows if row["kind"] == kind and row["used"]]
            if used:
                k = next(i for i, r in enumerate(self._problem.rows) if r.kind == kind)
                estimated = f"; sigma {used[0]['sigma']:.3g} {used[0]['unit']}, estimated from the residuals" if self._problem.estimated[k] else ""
                lines.append(f"{kind + 's':13} {len(used)}, {self.rms(kind):.4g} {used[0]['unit']} rms{estimated}")
        lines.append("")
        for name, value in self.parameters.items():
            sigma = f"+- {self.sigma[name]:.2g}" if name in self.sigma else "(held)"
            lines.append(f"  {name:18} {value:14.7g} {sigma:12} {self.units[name]}".rstrip())
        pull = sorted((row for row in rows if row["used"]), key=lambda row: -row["chi_squared"])[:most]
        lines += ["", "what pulls most:"]
        for row in pull:
            lines.append(f"  {row['kind']} of {row['date_utc'][:19]}: {row['residual']:.3g} {row['unit']}, chi-squared {row['chi_squared']:.3g} ({row['source']}:{row['line']})")
        lines += [f"rejected: {name}" for name in self.rejected]
        lines += self.undetermined
        lines += [f"caution: {warning}" for warning in self.warnings]
        for other in self.solutions[1:] if self.rank == 1 else ():
            values = ", ".join(f"{name} {other.parameters[name]:.6g}" for name in other.sigma)
            lines.append(f"fits as well (chi-squared {other.chi_squared:.5g}): {values}")
        return "\n".join(lines)

    def __repr__(self):
        return f"<Fit of {self.body.name}: chi-squared {self.chi_squared:.5g}, {self.dof} degrees of freedom, rank {self.rank}>"
