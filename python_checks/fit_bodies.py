"""Bodies in random tumbling motion, their attitudes with noise, and whether a fit ends at the truth.

By hand, for many bodies: python python_checks/fit_bodies.py 0 300
"""

import sys

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import polhode

RATE = np.radians(100) / 86400


def random_body(random):
    """A body in either mode, its axes in any order of moments."""
    while True:
        moments = np.sort(random.uniform(0.2, 1, 3))
        if moments[0] + moments[1] > 1.02 * moments[2]:
            break
    moments = random.permutation(moments / moments[2])
    q = random.normal(size=4)
    omega = random.normal(size=3) / moments
    omega *= RATE / np.linalg.norm(omega)
    inertia = polhode.Inertia(moments)
    return polhode.Body("random", inertia=inertia, epoch="2020-01-01 TDB", q=q / np.linalg.norm(q), omega=omega)


def attitudes(body, random, count=30, turns=10, noise_deg=2.0):
    """An AttitudeHistory at random times over so many turns, with noise about each axis."""
    t = np.sort(random.uniform(0, turns * 2 * np.pi / np.linalg.norm(body.omega), count))
    noise = Rotation.from_rotvec(np.radians(noise_deg) * random.normal(size=(count, 3)))
    q = (body.motion()(t).rotation * noise).as_quat()[:, [3, 0, 1, 2]]
    return polhode.AttitudeHistory(body.name, [body.epoch + float(x) for x in t], q)


def off_by(body, fit, instants):
    """The largest angle between the true attitude and the fitted one, deg."""
    true = body.motion()([i - body.epoch for i in instants]).rotation
    mine = fit.motion()([i - fit.body.epoch for i in instants]).rotation
    return np.degrees((true.inv() * mine).magnitude().max())


def share_of_region(body, fit):
    """The probability of the smallest region that holds the truth, uniform between 0 and 1 if it is right: of regions by
    chi-squared, and by the covariance."""
    state = body.motion()(fit.body.epoch - body.epoch)
    q = fit.body.q[[1, 2, 3, 0]]
    turn = np.degrees((Rotation.from_quat(q).inv() * state.rotation).as_rotvec())
    true = dict(zip(("turn.x", "turn.y", "turn.z"), turn))
    unit = np.radians(1) / (1 if fit.units["components.x"] == "deg/s" else 86400)
    true |= dict(zip(("components.x", "components.y", "components.z"), state.omega / unit))
    moments = np.diag(body.inertia.tensor)
    held = next(k for k, a in enumerate("xyz") if f"moments.{a}" not in fit.sigma)
    true |= dict(zip(("moments.x", "moments.y", "moments.z"), moments / moments[held] * fit.parameters[f"moments.{'xyz'[held]}"]))
    names = list(fit.sigma)
    places = [fit.names.index(name) for name in names]
    error = np.array([true[name] - fit.parameters[name] for name in names])
    covariance = fit.covariance[np.ix_(places, places)]
    if fit.undetermined:
        return None, None
    values = np.array([true.get(name, fit.parameters[name]) for name in fit.names])
    by_likelihood = chi2.cdf(fit.chi_squared_of(values) - fit.chi_squared, len(names))
    return by_likelihood, float(chi2.cdf(error @ np.linalg.solve(covariance, error), len(names)))


def main():
    first, last = map(int, sys.argv[1:3])
    shares, found = [], 0
    for seed in [int(s) for s in sys.argv[3:]] or range(first, last):
        random = np.random.default_rng(seed)
        body = random_body(random)
        history = attitudes(body, random)
        try:
            fit = polhode.fit("random", history, sigma="2 deg")
        except polhode.Error as error:
            print(seed, "failed", error, flush=True)
            continue
        off = off_by(body, fit, [history.epoch + float(t) for t in history.segments[0].t])
        share = share_of_region(body, fit)
        right = off < 10
        found += right
        if right and share[0] is not None:
            shares.append(share)
        print(seed, f"{off:.2f} deg", f"chi2 {fit.chi_squared:.1f}", len(fit.solutions), share, fit.undetermined, flush=True)
    shares = np.array(shares)
    print(f"{found} of {last - first} at the truth")
    for kind, column in zip(("chi-squared", "covariance"), shares.T):
        print(f"in the region by {kind} of 68 %: {np.mean(column < 0.68):.3f}, of 95 %: {np.mean(column < 0.95):.3f}, of {len(shares)}")


if __name__ == "__main__":
    main()
