"""What the checks share: running the program, and attitudes by independent means."""

import os
import signal
import subprocess
from pathlib import Path

import erfa
import mpmath
import numpy as np
from astropy.time import Time

# What is run in the background by a shell ignores these signals, and so would the programs that the checks start.
for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = Path(os.environ.get("POLHODE", ROOT / "build/bin/polhode")).resolve()
TOUTATIS = ROOT / "data/bodies/toutatis.toml"
T_HANDLE = ROOT / "data/bodies/t-handle.toml"


def run(*arguments, check=True, **options):
    """The program with these arguments; its result, which must be success if `check`."""
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)
    if check:
        assert result.returncode == 0, result.stderr
    return result


def propagate(body, out, *options):
    run("propagate", body, "-o", out, *options)
    return out


def angle_rad(p, q):
    """Angle between attitudes as quaternions, n x 4, any sign, scalar first; NaN where an input is NaN."""
    p, q = np.atleast_2d(p), np.atleast_2d(q)
    scalar = np.sum(p * q, axis=1)
    vector = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
    return 2 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(scalar))


def assert_within(errors, limit):
    """Every error is within the limit; a NaN is not."""
    errors = np.atleast_1d(errors)
    assert errors.size > 0
    worst = np.max(np.where(np.isnan(errors), np.inf, errors))
    assert worst <= limit, f"worst {worst:.3g}, allowed {limit:.3g}, in row {np.argmax(errors)} of {errors.size}"


def sign_is_continuous(q):
    return np.all(np.sum(q[1:] * q[:-1], axis=1) > 0)


def times_of(table):
    """Times of a FITS table as astropy has them."""
    return table["TIME"] if isinstance(table["TIME"], Time) else Time(table["TIME"])


# Takahashi, Busch & Scheeres 2013: x the intermediate axis, y the short one, z the long one; ecliptic J2000.
TOUTATIS_MOMENTS = ("3.0836", "3.235", "1.0")
TOUTATIS_EPOCH = Time("1992-11-09T17:49:47", scale="utc")
TOUTATIS_EULER_DEG = ("145.498", "65.865", "241.524")
TOUTATIS_OMEGA_DEG_DAY = ("14.51", "33.529", "-98.709")
OBLIQUITY_ARCSEC = "84381.448"


def horner(coefficients, x):
    value = mpmath.mpf(0)
    for c in reversed(coefficients):
        value = value * x + c
    return value


SPINNER = """name = "spinner"
source = "a test"
[inertia]
moments = [1.0, 2.0, 3.0]
unit = "kg m2"
[state]
epoch = "2000-01-01T12:00:00 TT"
frame = "ICRF"
[state.attitude]
q_frame_from_body_scalar_first = [1.0, 0.0, 0.0, 0.0]
[state.angular_velocity]
components = [0.0, 0.0, 9.0]
axes = "body"
unit = "deg/s"
"""  # turned by +90 deg about inertial z ten seconds after its epoch


def leap_second_kernel(path, extra=()):
    """A NAIF leap-second kernel with the constants of NAIF's own and ERFA's table."""
    names = "JAN FEB MAR APR MAY JUN JUL AUG SEP OCT NOV DEC".split()
    table = [(int(y), int(m), float(d)) for y, m, d in erfa.leap_seconds.get() if y >= 1972] + list(extra)
    rows = ",\n".join(f"{offset:.0f}, @{year}-{names[month - 1]}-1" for year, month, offset in table)
    path.write_text(
        "KPL/LSK\n\nText of no meaning.\n\\begindata\nDELTET/DELTA_T_A = 32.184\nDELTET/K = 1.657D-3\n"
        "DELTET/EB = 1.671D-2\nDELTET/M = ( 6.239996D0 1.99096871D-7 )\n"
        f"DELTET/DELTA_AT = ( {rows} )\n\\begintext\n"
    )
    return path


class TaylorMotion:
    """Torque-free motion by Taylor series of Euler's equations and of the quaternion's kinematics, in multiprecision:
    no elliptic function, nothing of the library's formulas."""

    order = 34
    step_s = 21600

    def __init__(self, moments, omega_deg_day, euler_zxz_deg, digits=34):
        mpmath.mp.dps = digits
        mpf, radians = mpmath.mpf, mpmath.radians
        self.moments = [mpf(m) for m in moments]
        omega = [radians(mpf(w)) / 86400 for w in omega_deg_day]
        first, second, third = (radians(mpf(a)) / 2 for a in euler_zxz_deg)
        cos, sin = mpmath.cos, mpmath.sin
        q = [  # z(first) x(second) z(third)
            cos(second) * cos(first + third),
            sin(second) * cos(first - third),
            sin(second) * sin(first - third),
            cos(second) * sin(first + third),
        ]
        half = radians(mpf(OBLIQUITY_ARCSEC) / 3600) / 2  # ecliptic J2000 to ICRF: a turn about x
        c, s = cos(half), sin(half)
        self.initial = [c * q[0] - s * q[1], c * q[1] + s * q[0], c * q[2] - s * q[3], c * q[3] + s * q[2], *omega]

    def coefficients(self, state):
        i1, i2, i3 = self.moments
        a = [(i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3]
        series = [[value] for value in state]
        q, w = series[:4], series[4:]

        def product(u, v, n):
            return mpmath.fsum(u[k] * v[n - k] for k in range(n + 1))

        for n in range(self.order):
            rates = [
                -(product(q[1], w[0], n) + product(q[2], w[1], n) + product(q[3], w[2], n)) / 2,
                (product(q[0], w[0], n) + product(q[2], w[2], n) - product(q[3], w[1], n)) / 2,
                (product(q[0], w[1], n) + product(q[3], w[0], n) - product(q[1], w[2], n)) / 2,
                (product(q[0], w[2], n) + product(q[1], w[1], n) - product(q[2], w[0], n)) / 2,
                a[0] * product(w[1], w[2], n),
                a[1] * product(w[2], w[0], n),
                a[2] * product(w[0], w[1], n),
            ]
            for component, rate in zip(series, rates):
                component.append(rate / (n + 1))
        return series

    def states(self, seconds):
        """q (n x 4, scalar first) and omega (n x 3) at increasing times >= 0, given as mpmath numbers."""
        rows = []
        state, begin = self.initial, mpmath.mpf(0)
        series = self.coefficients(state)
        for t in seconds:
            while t - begin > self.step_s:
                state = [horner(c, self.step_s) for c in series]
                begin += self.step_s
                series = self.coefficients(state)
            rows.append([float(horner(c, t - begin)) for c in series])
        rows = np.array(rows)
        return rows[:, :4], rows[:, 4:]


def toutatis():
    return TaylorMotion(TOUTATIS_MOMENTS, TOUTATIS_OMEGA_DEG_DAY, TOUTATIS_EULER_DEG)


def elapsed_tt(times, epoch):
    """TT seconds from epoch, as multiprecision numbers, of astropy times."""
    times, epoch = times.tt, epoch.tt
    mpf = mpmath.mpf
    return [(mpf(float(a)) - mpf(epoch.jd1) + (mpf(float(b)) - mpf(epoch.jd2))) * 86400 for a, b in zip(times.jd1, times.jd2)]
