"""Time scales and frames against astropy: 1 ns and 1 micro-arcsecond, 1960 to 2100, with the edges of leap seconds.

SPICE's ET is checked by its toolkit where spiceypy is installed."""

import erfa
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import ICRS, BarycentricMeanEcliptic, CartesianRepresentation, CustomBarycentricEcliptic
from astropy.coordinates.builtin_frames import intermediate_rotation_transforms as rotations
from astropy.time import Time, TimeDelta
from support import leap_second_kernel
from support import run as run_program

MICROARCSECOND = np.radians(1e-6 / 3600)
SEED = 20290413

pytestmark = pytest.mark.filterwarnings("ignore::erfa.ErfaWarning")  # dubious years, on purpose


def run(lines, *arguments, check=True):
    result = run_program(*arguments, check=check, input="".join(f"{line}\n" for line in lines))
    if check:
        assert result.stdout.count("\n") == len(lines)
    return result


def converted(dates, source, target, *options):
    return run(dates, "convert-time", "--from", source, "--to", target, "--decimals", 12, *options).stdout.split()


def random_dates(count):
    random = np.random.default_rng(SEED)
    day = Time("1960-01-02", scale="tai") + TimeDelta(random.uniform(0, 140 * 365.25, count), format="jd")
    seconds = random.integers(0, 86399, count)
    fraction = random.integers(0, 10**12, count)
    return [
        f"{d[:10]}T{s // 3600:02d}:{s // 60 % 60:02d}:{s % 60:02d}.{f:012d}"
        for d, s, f in zip(day.isot, seconds, fraction)
    ]


def leap_second_edges():
    """Instants in UTC around every step of TAI - UTC since 1972, inside the leap second too."""
    dates = []
    for year, month, _ in erfa.leap_seconds.get()[15:]:
        start = Time(f"{year:04d}-{month:02d}-01", scale="utc")
        before = (start - TimeDelta(2, format="sec")).isot[:10]
        dates += [f"{before}T23:59:{s}" for s in ("59", "59.999999999", "60", "60.5", "60.999999999")]
        dates += [f"{year:04d}-{month:02d}-01T00:00:00", f"{year:04d}-{month:02d}-01T00:00:00.000000001"]
    assert len(dates) >= 7 * 27
    return dates


HAND_PICKED = [
    "1960-01-01T00:00:00", "1961-07-31T23:59:59.9", "1961-08-01T00:00:00", "1965-08-31T23:59:60.05",
    "1968-02-01T00:00:00", "1971-12-31T23:59:59", "1972-01-01T00:00:00", "2000-01-01T12:00:00", "2029-04-13T21:46:00",
    "2099-12-31T23:59:59.999999999",
]  # fmt: skip


def astropy_time(dates, scale):
    return Time(dates, scale=scale, format="isot")


def seconds_apart(a, b):
    assert a.scale == b.scale
    return ((a.jd1 - b.jd1) + (a.jd2 - b.jd2)) * 86400


SCALES = ["UTC", "TAI", "TT", "TDB"]


def check_scales(dates, source, target, limit_s=1e-9):
    expected = getattr(astropy_time(dates, source.lower()), target.lower())
    ours = astropy_time(converted(dates, source, target), target.lower())
    apart = np.abs(seconds_apart(ours, expected))
    assert np.all(apart <= limit_s), f"worst {np.max(apart)} s at {dates[np.argmax(apart)]} {source} to {target}"


@pytest.mark.parametrize("source", SCALES)
@pytest.mark.parametrize("target", SCALES)
def test_random_epochs(source, target):
    check_scales(random_dates(400), source, target)


@pytest.mark.parametrize("target", SCALES)
def test_leap_seconds_and_hand_picked_epochs(target):
    dates = leap_second_edges() + HAND_PICKED
    check_scales(dates, "UTC", target)
    if target != "UTC":  # and back: the text must be the same
        there = converted(dates, "UTC", target)
        back = converted(there, target, "UTC")
        assert [f"{d:0<32}" if "." in d else f"{d}.{'0' * 12}" for d in dates] == back


def test_gps_is_19_s_behind_tai():
    dates = random_dates(50)
    ours = astropy_time(converted(dates, "TAI", "GPS"), "tai") + TimeDelta(19, format="sec")
    assert np.max(np.abs(seconds_apart(ours, astropy_time(dates, "tai")))) < 1e-9
    assert converted(["1980-01-06T00:00:00"], "UTC", "GPS") == ["1980-01-06T00:00:00.000000000000"]


@pytest.mark.parametrize("scale", SCALES)
def test_julian_dates_in_and_out(scale):
    dates = random_dates(100) + (leap_second_edges() if scale == "UTC" else [])
    expected = astropy_time(dates, scale.lower())
    # out: whole day and fraction of the MJD
    day, fraction = np.array(
        [line.split() for line in run(dates, "convert-time", "--from", scale, "--to", scale, "--mjd").stdout.splitlines()],
        dtype=float,
    ).T
    assert np.max(np.abs((day + 2400000.5 - expected.jd1) + (fraction - expected.jd2))) * 86400 < 1e-9
    # in: as a pair whose sum counts
    pairs = [f"JD {a:.1f} {b:.20f}" for a, b in zip(expected.jd1, expected.jd2)]
    ours = astropy_time(converted(pairs, scale, scale), scale.lower())
    assert np.max(np.abs(seconds_apart(ours, expected))) < 1e-9


def test_day_of_year_dates():
    days = [Time(d, scale="tai").yday.replace(":", "-", 1).replace(":", "T", 1) for d in random_dates(50)]
    ours = converted(days, "TAI", "TAI")
    assert [o[:23] for o in ours] == [Time(d.replace("T", ":").replace("-", ":"), scale="tai").isot for d in days]


def test_a_table_of_leap_seconds_can_be_given(tmp_path):
    kernel = leap_second_kernel(tmp_path / "naif.tls", extra=[(2035, 7, 38.0)])
    ours = converted(["2035-06-30T23:59:60.5"], "UTC", "TAI", "--leap-seconds", kernel)
    assert ours == ["2035-07-01T00:00:37.500000000000"]
    assert run(["2035-06-30T23:59:60.5 UTC"], "convert-time", "--to", "TAI", check=False).returncode == 2
    kernel.write_text("KPL/LSK\n\\begindata\nDELTET/DELTA_AT = ( 10, @1972-JAN-2 )\n")
    result = run([], "convert-time", "--to", "TAI", "--leap-seconds", kernel, check=False)
    assert result.returncode == 2 and f"{kernel}:3: " in result.stderr and "@1972-JAN-1" in result.stderr


def test_et_is_that_of_spice(tmp_path):
    spice = pytest.importorskip("spiceypy")
    spice.furnsh(str(leap_second_kernel(tmp_path / "naif.tls")))
    dates = [d for d in random_dates(200) if d > "1972-01-02"]
    expected = np.array([spice.unitim(float(t), "TDT", "ET") for t in tt_seconds(astropy_time(dates, "tt"))])
    ours = tt_seconds(astropy_time(converted(dates, "TT", "ET"), "tt"))  # ET read as if on a uniform scale
    assert np.max(np.abs(ours - expected)) < 1e-6  # one double of seconds: 5e-7 s in 2100


def tt_seconds(times):
    return ((times.jd1 - 2451545.0) + times.jd2) * 86400


def test_et_by_its_formula():
    """NAIF's time required reading: ET - TT = K sin E, E = M + EB sin M; numbers of its kernels."""
    dates = random_dates(200)
    tt = astropy_time(dates, "tt")
    m = 6.239996 + 1.99096871e-7 * tt_seconds(tt)
    expected = 1.657e-3 * np.sin(m + 1.671e-2 * np.sin(m))
    ours = seconds_apart(astropy_time(converted(dates, "TT", "ET"), "tt"), tt)
    assert np.max(np.abs(ours - expected)) < 1e-9
    # within some tens of microseconds of the TDB that astropy has
    tdb = np.array([float(x) for x in tt.delta_tdb_tt])
    assert 1e-6 < np.max(np.abs(ours - tdb)) < 1e-4
    assert converted(converted(dates, "TT", "ET"), "ET", "TT") == dates


def matrices(dates, source, target, *options):
    """v_target = matrix v_source, from the program's quaternions."""
    text = run(dates, "convert-frame", "--from", source, "--to", target, "--scale", "UTC", *options).stdout
    out = []
    for w, x, y, z in (map(float, line.split()) for line in text.splitlines()):
        assert abs(w * w + x * x + y * y + z * z - 1) < 1e-14
        out.append(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
    return np.array(out)


def assert_same_rotation(ours, expected, limit_rad=MICROARCSECOND):
    apart = np.linalg.norm(ours - expected, axis=(-2, -1)) / np.sqrt(2)  # sine of the angle, for small ones
    assert np.all(apart <= limit_rad), f"worst {np.max(apart) / MICROARCSECOND:.3g} micro-arcsec"


def astropy_frame(frame):
    """Components in the frame of the ICRS unit vectors: the matrix from ICRS."""
    axes = ICRS(CartesianRepresentation(np.eye(3) * u.kpc)).transform_to(frame)
    return axes.cartesian.xyz.to_value(u.kpc)


def frame_bias():
    """Mean equator and equinox of J2000 from GCRS, IERS Conventions 2010, 5.4.4: R1(-eta0) R2(xi0) R3(dalpha0)."""
    xi, eta, alpha = np.radians(np.array([-0.0166170, -0.0068192, -0.01460]) / 3600)

    def turn(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        matrix = np.eye(3)
        a, b = [(1, 2), (2, 0), (0, 1)][axis]
        matrix[a, a] = matrix[b, b] = c
        matrix[a, b], matrix[b, a] = s, -s
        return matrix

    return turn(0, -eta) @ turn(1, xi) @ turn(2, alpha)


FIXED = {
    "J2000": lambda: np.eye(3),
    "GCRF": lambda: np.eye(3),
    "EME2000": frame_bias,
    "ECLIPJ2000": lambda: astropy_frame(CustomBarycentricEcliptic(obliquity=84381.448 * u.arcsec)),
    "ECLIPIAU2006": lambda: astropy_frame(BarycentricMeanEcliptic(equinox="J2000")),
}


@pytest.mark.parametrize("name", FIXED)
def test_inertial_frames(name):
    expected = FIXED[name]()
    date = ["2029-04-13T21:46:00"]
    assert_same_rotation(matrices(date, "ICRF", name)[0], expected)
    assert_same_rotation(matrices(date, name, "ICRF")[0], expected.T)


def earth_frames(dates, monkeypatch, ut1_minus_utc_s=0.0, pole_rad=(0.0, 0.0)):
    """ITRS and TEME from GCRS as astropy turns them, with given Earth orientation."""
    monkeypatch.setattr(rotations, "get_polar_motion", lambda time: pole_rad)
    itrs, teme = [], []
    for date in dates:
        time = Time(date, scale="utc")
        time.delta_ut1_utc = ut1_minus_utc_s
        itrs_from_gcrs = rotations.cirs_to_itrs_mat(time) @ rotations.gcrs_to_cirs_mat(time)
        itrs.append(itrs_from_gcrs)
        teme.append(rotations.teme_to_itrs_mat(time).T @ itrs_from_gcrs)
    return np.array(itrs), np.array(teme)


@pytest.mark.parametrize(
    "ut1_minus_utc_s, pole_arcsec", [(0.0, (0.0, 0.0)), (-0.4321, (0.2, 0.35)), (0.8765, (-0.1, 0.5))]
)
def test_earth_frames(monkeypatch, ut1_minus_utc_s, pole_arcsec):
    dates = [d[:29] for d in random_dates(60)] + HAND_PICKED + leap_second_edges()[-14:]
    pole_rad = tuple(np.radians(np.array(pole_arcsec) / 3600))
    itrs, teme = earth_frames(dates, monkeypatch, ut1_minus_utc_s, pole_rad)
    options = ("--ut1-utc", ut1_minus_utc_s, "--pole-x", pole_arcsec[0], "--pole-y", pole_arcsec[1])
    assert_same_rotation(matrices(dates, "GCRF", "ITRF", *options), itrs)
    assert_same_rotation(matrices(dates, "ITRF", "GCRF", *options), np.swapaxes(itrs, 1, 2))
    assert_same_rotation(matrices(dates, "ICRF", "TEME", *options), teme)
    assert_same_rotation(matrices(dates, "TEME", "ICRF", *options), np.swapaxes(teme, 1, 2))


def test_doubts_are_said_and_the_answer_given():
    for date, word in (("1950-01-01T00:00:00", "1960"), ("2090-01-01T00:00:00", "not known")):
        result = run([date], "convert-time", "--from", "UTC", "--to", "TAI")
        assert word in result.stderr and result.stderr.count("\n") == 1
    assert run(["2016-12-31T23:59:60"], "convert-time", "--from", "UTC", "--to", "TAI").stderr == ""
    assert "taken as zero" in run(["2020-01-01 UTC"], "convert-frame", "--from", "ITRF", "--to", "ICRF").stderr


def test_bad_lines_are_refused_with_their_number():
    result = run(["2000-01-01", "2000-02-30"], "convert-time", "--from", "TT", "--to", "TAI", check=False)
    assert result.returncode == 2 and "standard input:2: no such date" in result.stderr and result.stdout == ""
    assert run(["2000-01-01"], "convert-time", "--to", "TAI", check=False).returncode == 2
    assert run([], "convert-frame", "--from", "FK4", "--to", "ICRF", check=False).returncode == 2
