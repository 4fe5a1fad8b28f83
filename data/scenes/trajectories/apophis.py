#!/usr/bin/env python3
"""Prints the hyperbola on which 99942 Apophis passes the Earth on 2029-04-13, for ../apophis-2029.toml.

JPL's osculating elements of epoch 2021-01-01 (Horizons, solution 218, with its non-gravitational A1 and A2) are integrated
as in toutatis.py to the day of the encounter. The published perigee (38,012 km at 21:46 UTC) tells how good that is.

    build/venv/bin/python data/scenes/trajectories/apophis.py
"""

import numpy as np
import toutatis
from astropy.time import Time
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

# a from the perihelion distance, e, i, node, argument of perihelion (deg, ecliptic and equinox of J2000), JD TDB twice
E = 0.1915216892529348
ELEMENTS = (0.7458270479403062 / (1.0 - E), E, 3.336751319526047, 204.0389271089114, 126.6520518833791,
            2459101.039422418, 2459215.5)  # fmt: skip
A1, A2 = 4.999999873689e-13, -2.901092102547e-14  # au/d2 at 1 au, falling with the square of the distance


def rate(t_s, y):
    derivative = toutatis.rate(t_s, y)
    r, v = y[:3], y[3:]
    outward = r / np.linalg.norm(r)
    along = np.cross(np.cross(r, v) / np.linalg.norm(np.cross(r, v)), outward)
    unit = toutatis.AU_KM / toutatis.DAY_S**2 * toutatis.AU_KM**2 / (r @ r)
    derivative[3:] += unit * (A1 * outward + A2 * along)
    return derivative


def main():
    span = ((ELEMENTS[-1] - toutatis.J2000) * toutatis.DAY_S, toutatis.seconds("2029-04-20"))
    tolerance = np.array([1e-4] * 3 + [1e-11] * 3)
    solution = solve_ivp(rate, span, toutatis.state(*ELEMENTS), method="DOP853", rtol=1e-13, atol=tolerance,
                         dense_output=True)  # fmt: skip

    def from_earth(t_s):
        return solution.sol(t_s) - np.concatenate(toutatis.earth(t_s / toutatis.DAY_S))

    near = toutatis.seconds("2029-04-13T21:46:00")
    found = minimize_scalar(lambda t: np.linalg.norm(from_earth(t)[:3]), method="bounded",
                            bounds=(near - 86400.0, near + 86400.0), options={"xatol": 0.01})  # fmt: skip
    r, v = np.split(from_earth(found.x), 2)
    excess2 = v @ v - 2.0 * toutatis.EARTH / found.fun
    c, s = np.cos(toutatis.OBLIQUITY), np.sin(toutatis.OBLIQUITY)
    ecliptic_from_equator = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    when = Time(toutatis.J2000 + found.x / toutatis.DAY_S, format="jd", scale="tdb").utc.iso[:19]
    print(f"perigee {found.fun:.0f} km at {when} UTC; published 38012 km at 21:46")
    print(f"eccentricity {1.0 + found.fun * excess2 / toutatis.EARTH:.3f}, excess speed {np.sqrt(excess2):.3f} km/s")
    print("to perigee", np.round(ecliptic_from_equator @ r / found.fun, 4), "ecliptic of J2000")
    print("normal    ", np.round(ecliptic_from_equator @ np.cross(r, v) / np.linalg.norm(np.cross(r, v)), 4))


if __name__ == "__main__":
    main()
