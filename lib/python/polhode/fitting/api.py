"""polhode.fit."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from .._core import AttitudeHistory, Body, Scene, read
from .._errors import InputError
from .leading import led_along, with_estimated_sigmas, without_outliers
from .motions import FreeMotions, SceneMotions
from .observations import ATTITUDE, AXIS, MAGNITUDE, RATE, read_observations
from .parameters import Parameters, parameters_of
from .problem import Photometry, Problem
from .result import Fit
from .units import angle_rad, rate_rad_s


def fit(
    what,
    observations,
    *,
    free=None,
    fixed=None,
    robust=False,
    sigma=None,
    sigma_rates=None,
    sigma_magnitudes=None,
    shape=None,
    products=False,
    turns=None,
    within=25.0,
    most_solutions=20,
    max_rate=None,
    progress=None,
) -> Fit:
    """A spin state and ratios of inertia from measurements.

    what: a Body, a Scene, the path of one, or a name where nothing is known. A body without a state, or without inertia, is
    fitted from nothing. Numbers that have a `_sigma` in the body's file are known to that beforehand and free, the others of
    such a file are exact; without any `_sigma` state and ratios are free, and the largest moment (or that which is 1) is not.
    observations: paths of tables, histories or messages, AttitudeHistory objects, or a list of these.
    free, fixed: lists of names, as `euler_angles` or `components.z`; `free` frees no others unless a name begins with +.
    robust: leaves out what does not belong, and says what.
    sigma, sigma_rates, sigma_magnitudes: one sigma where the rows have none: of attitudes and directions (rad, or '2 deg'), of
    rates (rad/s, or '1 deg/day'; without it, and without a column, rates are not fitted), of magnitudes (mag; added to the
    rows' own). Where none is stated they are estimated from the residuals.
    shape: semi-axes of the ellipsoid along x, y, z, for magnitudes; without it that of the moments.
    products: products of inertia are free, too, where the body's file has none.
    turns: so many turns more or fewer are tried where a gap leaves them open (3; of scenes 0).
    within: chi-squared above the best up to which other solutions are returned.
    max_rate: from nothing, the fastest rate that is looked for (rad/s, or '30 deg/day').

    Returns the best Fit; `solutions` has the others. Raises InputError, ComputationError.
    """
    rows = with_sigmas(read_observations(observations), sigma, sigma_rates, sigma_magnitudes)
    what = what_is(what)
    body = what.body if isinstance(what, Scene) else what
    if isinstance(body, str) or body.missing:
        from .nothing import from_nothing

        return from_nothing(body, rows, robust=robust, products=products, shape=shape, within=within, most_solutions=most_solutions, max_rate=max_rate, progress=progress, free=free, fixed=fixed)
    scene = what if isinstance(what, Scene) else None
    parameters = parameters_of(body, scene.path if scene else "")
    if products and not any(p.name.startswith(("products", "tensor")) for p in parameters.numbers):
        parameters = with_products(parameters)
    photometry = photometry_of(rows, parameters, shape)
    choose(parameters, photometry, free, fixed)
    motions = SceneMotions(parameters, scene) if scene else FreeMotions(parameters, inertial(parameters.frame))
    problem = Problem(parameters, motions, rows, photometry)
    if turns is None:
        turns = 0 if scene else 3
    values, course = led_along(problem, progress, "soft_l1" if robust else "linear", turns)
    best = finished(problem, values, course, scene, robust)
    for k, (other, chi_squared) in enumerate(course.aliases):
        if chi_squared <= best.chi_squared + within and len(best.solutions) < most_solutions:
            best.solutions.append(Fit(problem, other, best._active, course, scene, rank=k + 2))
    return best


def finished(problem, values, course, scene, robust, rank=1):
    active = problem.everything()
    if robust:
        values, active = without_outliers(problem, values)
    values = with_estimated_sigmas(problem, values, active)
    if not course or not course.aliases:
        values = problem.parameters.anchored(values)
    return Fit(problem, values, active, course, scene, rank)


def what_is(what):
    """A Body or a Scene; a text that is no path is the name of a body of which nothing is known."""
    if isinstance(what, (Body, Scene)):
        return what
    if isinstance(what, AttitudeHistory):
        return what.body
    if isinstance(what, (str, os.PathLike)):
        if Path(what).exists() or "/" in str(what) or str(what).endswith(".toml"):
            return what_is(read(what))
        return str(what)
    raise InputError(f"found {type(what).__name__}; a Body, a Scene, the path of one, or a name is wanted")


def inertial(frame):
    return "ICRF" if frame == "TEME" else frame


def with_sigmas(rows, sigma, sigma_rates, sigma_magnitudes):
    """Rows with a sigma each, where they have one or it is given; rates without one are left out."""
    given = {
        ATTITUDE: None if sigma is None else angle_rad(sigma),
        AXIS: None if sigma is None else angle_rad(sigma),
        RATE: None if sigma_rates is None else rate_rad_s(sigma_rates),
    }
    out = []
    for r in rows:
        if r.kind == MAGNITUDE:
            more = 0.0 if sigma_magnitudes is None else float(sigma_magnitudes)
            if r.sigma is not None:
                unknown = r.sigma <= 0
                usual = np.median(r.sigma[~unknown]) if not unknown.all() else 0.1
                r = replace(r, sigma=np.hypot(np.where(unknown, usual, r.sigma), more))
            elif more > 0:
                r = replace(r, sigma=np.full(len(r), more))
        elif r.sigma is None and given[r.kind] is not None:
            r = replace(r, sigma=np.full(len(r), given[r.kind]))
        if r.kind == RATE and r.sigma is None:
            continue
        out.append(r)
    if not out:
        raise InputError("found rates without a sigma only; a column sigma_omega_deg_day or sigma_rates is wanted")
    return out


def photometry_of(rows, parameters, shape):
    if not any(r.kind == MAGNITUDE for r in rows):
        if shape is not None:
            raise InputError("a shape is for magnitudes, and there are none")
        return None
    if shape is None:
        tensor = parameters.at(parameters.values).tensor
        if np.abs(tensor - np.diag(np.diag(tensor))).max() > 1e-9 * np.trace(tensor):
            raise InputError("magnitudes of a body with products of inertia need a shape: semi-axes along x, y, z")
        return Photometry(None)
    shape = np.asarray(shape, dtype=float)
    if shape.shape != (3,) or not (shape > 0).all():
        raise InputError(f"shape: found {shape}, three positive semi-axes are wanted")
    return Photometry(tuple(shape / shape.max()))


def choose(parameters, photometry, free, fixed):
    """Names of the body's numbers, and of those of the brightness."""
    own = {p.name.split(".")[0] for p in photometry.numbers} if photometry else set()

    def bright(names):
        return [name for name in names or () if name.removeprefix("+").split(".")[0] in own]

    def rest(names):
        return [name for name in names or () if name not in bright(names)]

    if rest(free) or rest(fixed):
        parameters.choose(rest(free), rest(fixed), others=photometry is not None)
    for names, value in ((bright(free), True), (bright(fixed), False)):
        for name in names:
            for p in photometry.numbers:
                if p.name == name.removeprefix("+") or p.name.startswith(name.removeprefix("+") + "."):
                    p.free = value
    if not parameters.free.any() and not (photometry and any(p.free for p in photometry.numbers)):
        raise InputError("no parameter is free: nothing is to be fitted")


def with_products(parameters):
    if "moments" not in parameters.tables["inertia"]:
        raise InputError("products of inertia go with moments; this body's inertia is given otherwise")
    tables = dict(parameters.tables)
    tables["inertia"] = {**tables["inertia"], "products": [0.0, 0.0, 0.0], "products_are": "tensor elements"}
    out = Parameters(tables, parameters.folder)
    for p in parameters.numbers:
        mine = out.named(p.name)
        mine.sigma, mine.free = p.sigma, p.free
    return out
