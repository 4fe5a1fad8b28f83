#!/usr/bin/env python3
"""Makes toutatis-earth.oem and toutatis-sun.oem: where asteroid 4179 Toutatis was from 1992 to 2012.

The osculating elements below are JPL's of epoch JD 2461200.5 TDB (Small-Body Database, as public code repeats them). From
there the equations of motion are integrated back to 1992: the Sun with its post-Newtonian term, the planets (ERFA's
plan94; the Earth from epv00) and the Moon (moon98). No radar range and no light-pressure drift enters. What comes out is
held against the published approaches to the Earth; the script prints by how much it misses them.

    build/venv/bin/python data/scenes/trajectories/toutatis.py
"""

import pathlib

import erfa
import numpy as np
from astropy.time import Time
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

AU_KM, DAY_S, C_KM_S, J2000 = 149597870.700, 86400.0, 299792.458, 2451545.0
OBLIQUITY = np.radians(84381.448 / 3600.0)

# a (au), e, i, node, argument of perihelion (deg, ecliptic and equinox of J2000), time of perihelion (JD TDB), epoch
ELEMENTS = (2.54304716, 0.624630225, 0.448084, 125.36548, 277.861538, 2460684.051308, 2461200.5)

# km3/s2, DE440.
SUN, EARTH, MOON = 132712440041.279, 398600.435507, 4902.800118
PLANETS = {1: 22031.868551, 2: 324858.592, 4: 42828.375816, 5: 126712764.1, 6: 37940584.8418, 7: 5794556.4, 8: 6836527.10058}

# Published approaches to the Earth: date (UTC), au.
APPROACHES = [("1992-12-08", 0.0242), ("1996-11-29", 0.0354), ("2000-10-31", 0.0739), ("2004-09-29", 0.0104),
              ("2008-11-09", 0.0502), ("2012-12-12", 0.0463)]  # fmt: skip

FIRST, LAST = "1992-07-04", "2012-12-31"


def earth(days):
    """Position and velocity of the Earth from the Sun, km and km/s, ICRF axes."""
    heliocentric, _ = erfa.epv00(J2000, days)
    return heliocentric["p"] * AU_KM, heliocentric["v"] * AU_KM / DAY_S


def perturbers(days):
    for number, mu in PLANETS.items():
        yield mu, erfa.plan94(J2000, days, number)["p"] * AU_KM
    place, _ = earth(days)
    yield EARTH, place
    yield MOON, place + erfa.moon98(J2000, days)["p"] * AU_KM


def rate(t_s, y):
    r, v = y[:3], y[3:]
    distance = np.linalg.norm(r)
    a = -SUN * r / distance**3
    a += SUN / (C_KM_S**2 * distance**3) * ((4.0 * SUN / distance - v @ v) * r + 4.0 * (r @ v) * v)
    for mu, place in perturbers(t_s / DAY_S):
        away = place - r
        a += mu * (away / np.linalg.norm(away) ** 3 - place / np.linalg.norm(place) ** 3)
    return np.concatenate((v, a))


def state(a, e, i, node, peri, perihelion, epoch):
    a, i, node, peri = a * AU_KM, *np.radians([i, node, peri])
    n = np.sqrt(SUN / a**3)
    mean = n * (epoch - perihelion) * DAY_S
    E = mean
    for _ in range(50):
        E -= (E - e * np.sin(E) - mean) / (1.0 - e * np.cos(E))

    def turned(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * np.cos(node) - s * np.sin(node) * np.cos(i),
                         c * np.sin(node) + s * np.cos(node) * np.cos(i), s * np.sin(i)])  # fmt: skip

    p, q = turned(peri), turned(peri + np.pi / 2.0)
    c, s = np.cos(OBLIQUITY), np.sin(OBLIQUITY)
    equator_from_ecliptic = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    b, rate_E = a * np.sqrt(1.0 - e * e), n / (1.0 - e * np.cos(E))
    r = a * (np.cos(E) - e) * p + b * np.sin(E) * q
    v = rate_E * (-a * np.sin(E) * p + b * np.cos(E) * q)
    return np.concatenate((equator_from_ecliptic @ r, equator_from_ecliptic @ v))


def seconds(date):
    return (Time(date, scale="tdb").jd - J2000) * DAY_S


def integrate():
    """State from the Sun by TDB seconds from J2000."""
    tolerance = np.array([1e-3] * 3 + [1e-10] * 3)
    solution = solve_ivp(rate, ((ELEMENTS[-1] - J2000) * DAY_S, seconds(FIRST) - DAY_S), state(*ELEMENTS),
                         method="DOP853", rtol=1e-12, atol=tolerance, dense_output=True)  # fmt: skip
    assert solution.success, solution.message
    return solution.sol


def report(from_earth):
    for date, published in APPROACHES:
        day = seconds(date) / DAY_S
        found = minimize_scalar(lambda d: np.linalg.norm(from_earth(d * DAY_S)[:3]) / AU_KM, method="bounded",
                                bounds=(day - 10.0, day + 10.0), options={"xatol": 1e-6})  # fmt: skip
        when = Time(J2000 + found.x, format="jd", scale="tdb").utc.iso[:16]
        print(f"closest to the Earth {when} UTC, {found.fun:.5f} au; published {date}, {published} au")


def write(path, centre, motion):
    """Rows an eighth of r/v apart, four days at most: HERMITE of degree 7 is then within a hundred metres."""
    times = [seconds(FIRST)]
    while times[-1] < seconds(LAST):
        y = motion(times[-1])
        step = min(0.125 * np.linalg.norm(y[:3]) / np.linalg.norm(y[3:]), 4.0 * DAY_S)
        times.append(times[-1] + max(3600.0, 3600.0 * np.floor(step / 3600.0)))

    def date(t_s):
        hours = round(t_s / 3600.0)
        return Time(J2000, hours / 24.0, format="jd", scale="tdb").isot[:19]

    lines = ["CCSDS_OEM_VERS = 2.0", "COMMENT made by toutatis.py, which says how", "CREATION_DATE = 2026-11-30T00:00:00",
             "ORIGINATOR = POLHODE", "", "META_START", "OBJECT_NAME = TOUTATIS", "OBJECT_ID = 4179",
             f"CENTER_NAME = {centre}", "REF_FRAME = ICRF", "TIME_SYSTEM = TDB", f"START_TIME = {date(times[0])}",
             f"STOP_TIME = {date(times[-1])}", "INTERPOLATION = HERMITE", "INTERPOLATION_DEGREE = 7", "META_STOP", ""]  # fmt: skip
    for t_s in times:
        y = motion(t_s)
        lines.append(date(t_s) + "".join(f" {x:.3f}" for x in y[:3]) + "".join(f" {x:.8f}" for x in y[3:]))
    path.write_text("\n".join(lines) + "\n")
    print(f"{path.name}: {len(times)} rows, {path.stat().st_size} bytes")


def main():
    from_sun = integrate()

    def from_earth(t_s):
        return from_sun(t_s) - np.concatenate(earth(t_s / DAY_S))

    report(from_earth)
    folder = pathlib.Path(__file__).parent
    write(folder / "toutatis-earth.oem", "EARTH", from_earth)
    write(folder / "toutatis-sun.oem", "SUN", from_sun)


if __name__ == "__main__":
    main()
