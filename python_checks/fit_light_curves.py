"""Light curves of random tumbling ellipsoids, and whether a fit from nothing finds them.

By hand, for many: python python_checks/fit_light_curves.py 0 50
"""

import sys
import time

import erfa
import numpy as np

import polhode
from polhode.fitting.brightness import ellipsoid_magnitude
from polhode.fitting.observations import Rows
from polhode.fitting.rotations import matrix

DAY = 86400.0


def geometry(random, zero, t):
    """From the body to observer and Sun, unit vectors in ICRF, and both distances: an orbit a little outside the Earth's,
    near opposition at t = 0 and after its synodic period."""
    a, tilt, node = random.uniform(1.6, 2.4), np.radians(random.uniform(2, 15)), random.uniform(0, 2 * np.pi)
    jd = zero.since_j2000("TDB")[0] / DAY + 2451545.0
    earth_0 = np.asarray(erfa.epv00(jd, 0.0)[0]["p"])
    eps = np.radians(23.4392911)
    ecliptic = np.array([[1, 0, 0], [0, np.cos(eps), np.sin(eps)], [0, -np.sin(eps), np.cos(eps)]])
    longitude = np.arctan2(*(ecliptic @ earth_0)[[1, 0]]) + np.radians(random.uniform(-6, 6)) + 2 * np.pi * t / DAY / 365.25 / a**1.5
    along = longitude - node
    place = np.stack([np.cos(node) * np.cos(along) - np.sin(node) * np.sin(along) * np.cos(tilt), np.sin(node) * np.cos(along) + np.cos(node) * np.sin(along) * np.cos(tilt), np.sin(along) * np.sin(tilt)], -1)
    sun = a * place @ ecliptic
    from_earth = sun - np.asarray(erfa.epv00(jd + t / DAY, 0.0)[0]["p"])
    delta = np.linalg.norm(from_earth, axis=1)
    return np.stack([-from_earth / delta[:, None], -sun / a], 1), np.stack([delta, np.full(len(t), a)], 1), 1 / abs(1 - a**-1.5) * 365.25 * DAY


def nights(random, count, days=40, in_night=8):
    """Times within nights of 8 hours, around 0."""
    night = random.choice(days, size=25, replace=False) - days / 2
    return np.sort(DAY * (random.choice(night, size=count) + random.uniform(0, in_night / 24, count)))


def light_curve(random, count=400, noise=0.02):
    """A body and its magnitudes in two apparitions."""
    while True:
        b = random.uniform(0.35, 0.85)
        c = b * random.uniform(0.5, 0.95)
        moments = np.array([b * b + c * c, 1 + c * c, 1 + b * b]) / (1 + b * b)
        q = random.normal(size=4)
        momentum = random.normal(size=3)
        omega = momentum / moments
        omega *= 2 * np.pi / (random.uniform(8, 40) * 3600) / np.linalg.norm(momentum)
        body = polhode.Body("random", inertia=polhode.Inertia(moments), epoch="2020-01-01 TDB", frame="ECLIPJ2000", q=q / np.linalg.norm(q), omega=omega)
        if body.info()["motion"]["separatrix_distance"] > 0.02 and tumbles(body, momentum):
            break
    first = nights(random, count // 2)
    seed = random.integers(1 << 30)
    synodic = geometry(np.random.default_rng(seed), body.epoch, np.zeros(1))[2]
    t = np.concatenate([first, np.sort(nights(random, count - count // 2) + np.floor(synodic / DAY) * DAY)])
    towards, distances, _ = geometry(np.random.default_rng(seed), body.epoch, t)
    to_body = np.swapaxes(matrix(body.motion()(t).q), 1, 2)  # from ICRF
    e, s = (np.einsum("nij,nj->ni", to_body, towards[:, k]) for k in (0, 1))
    phase = np.degrees(np.arccos(np.sum(e * s, axis=1)))
    y = 18 + 0.035 * phase + 5 * np.log10(np.prod(distances, axis=1)) + ellipsoid_magnitude((1, b, c), e, s)[0]
    y = y + noise * random.normal(size=len(t))
    rows = Rows("magnitude", "random", np.arange(1, len(t) + 1), [body.epoch + float(x) for x in t], y, np.full(len(t), noise), towards=towards, distances_au=distances)
    return body, rows


def tumbles(body, momentum):
    """Whether the tumbling can be seen: the momentum is far from an axis."""
    return np.max(np.abs(momentum)) < 0.97 * np.linalg.norm(momentum)


def is_the_truth(body, fit):
    """Within 5 % of the periods and 10 deg of the momentum, as far as the magnitudes decide."""
    true, mine = body.info()["motion"], fit.body.info()["motion"]
    lon, lat = np.radians(np.array([true["momentum_ecliptic_deg"], mine["momentum_ecliptic_deg"]]).T)
    apart = np.degrees(np.arccos(np.clip(np.sin(lat[0]) * np.sin(lat[1]) + np.cos(lat[0]) * np.cos(lat[1]) * np.cos(lon[0] - lon[1]), -1, 1)))
    same_periods = abs(mine["polhode_period_s"] / true["polhode_period_s"] - 1) < 0.01 and abs(mine["long_axis"]["precession_period_s"] / true["long_axis"]["precession_period_s"] - 1) < 0.01
    return bool(same_periods and mine["mode"] == true["mode"] and apart < 10), apart, same_periods


def main():
    found, first, last = 0, int(sys.argv[1]), int(sys.argv[2])
    for seed in range(first, last):
        body, rows = light_curve(np.random.default_rng(seed))
        begin = time.time()
        try:
            fit = polhode.fit("random", [rows])
            among = [is_the_truth(body, one) for one in fit.solutions]
            rank = next((k + 1 for k, one in enumerate(among) if one[0]), 0)
            found += rank > 0
            print(seed, body.info()["motion"]["mode"], "rank", rank, "of", len(among), f"chi2 {fit.chi_squared:.1f} dof {fit.dof}", f"{time.time() - begin:.0f} s", among[:2], flush=True)
        except polhode.Error as error:
            print(seed, "failed:", error, f"{time.time() - begin:.0f} s", flush=True)
    print(f"{found} of {last - first}")


if __name__ == "__main__":
    main()
