"""`polhode observe` and Motion.observe: geometry against the SPICE toolkit and astropy, brightness of Toutatis in 1992."""

import subprocess

import erfa
import numpy as np
import pytest
import spiceypy
from astropy import units as u
from astropy.coordinates import EarthLocation
from astropy.table import Table
from astropy.time import Time
from astropy.utils import iers
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, assert_within, propagate, run

import polhode
from polhode import InputError, spice

PHOTOMETRY = ROOT / "data/observations/toutatis-photometry-1992.csv"
WAY = ROOT / "data/scenes/trajectories/toutatis-sun.oem"
AU = 149597870700.0
LIGHT = 299792458.0
ELLIPSOID = "1.2 0.96 2.3 km"  # x intermediate, y short, z long
DEG = 1e-6
MICROSECOND = 1e-6


def et_of(instant):
    return sum(instant.since_j2000("ET"))


def earth_and_sun(times):
    """From the barycentre, m and m/s, by ERFA itself."""
    tdb = times.tdb
    from_sun, from_barycentre = erfa.epv00(tdb.jd1, tdb.jd2)
    scale = np.array([AU, AU / 86400])
    earth = [from_barycentre["p"] * scale[0], from_barycentre["v"] * scale[1]]
    sun = [(from_barycentre["p"] - from_sun["p"]) * scale[0], (from_barycentre["v"] - from_sun["v"]) * scale[1]]
    return earth, sun


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Our CK, an SPK of the same trajectory and of ERFA's Earth and Sun, and what we make of them."""
    folder = tmp_path_factory.mktemp("observe")
    fits = propagate(TOUTATIS, folder / "toutatis.fits", "--start", "1992-12-01 TDB", "--stop", "1992-12-21 TDB", "--step", "20 min")
    spice.kernels(fits, folder)
    motion = polhode.read(TOUTATIS).motion()
    orbit = polhode.Orbit.read(WAY, "Sun", motion.epoch)
    start = polhode.Instant("1992-12-01 TDB")
    nodes = [start + 7200.0 * k for k in range(20 * 12 + 1)]
    et = np.array([et_of(node) for node in nodes])
    earth, sun = earth_and_sun(Time([node.text("TT", 6) for node in nodes], scale="tt"))
    states = np.array([np.concatenate(orbit(node - motion.epoch)) for node in nodes]) / 1e3
    spk = folder / "ways.bsp"
    handle = spiceypy.spkopn(str(spk), "ways", 0)
    for body, centre, rows in [
        (2004179, 10, states),
        (399, 0, np.concatenate(earth, axis=1) / 1e3),
        (10, 0, np.concatenate(sun, axis=1) / 1e3),
    ]:
        spiceypy.spkw13(handle, body, centre, "J2000", et[0], et[-1], str(body), 7, len(et), rows, et)
    spiceypy.spkcls(handle)
    spiceypy.kclear()
    spiceypy.furnsh(str(folder / "toutatis.tm"))
    spiceypy.furnsh(str(spk))
    spiceypy.pdpool("BODY2004179_RADII", [1e-3, 1e-3, 1e-3])  # km: the places are those of the centre, within 1e-12 rad
    random = np.sort(np.random.default_rng(18).uniform(1, 19, 60)) * 86400
    times = [start + float(s) for s in random]
    yield motion, times, motion.observe(times, WAY), folder
    spiceypy.kclear()


def angle_deg(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1)))


def direction(longitude_deg, latitude_deg):
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    return np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], -1)


def test_geometry_is_that_of_spice(seen):
    _, times, rows, _ = seen
    target, frame, correction, observer = "2004179", "TOUTATIS_AXES", "CN", "399"
    observed, solar, light, phase, distance = [], [], [], [], []
    for time in times:
        et = et_of(time)
        state, light_time = spiceypy.spkpos(target, et, "J2000", correction, observer)
        light.append(light_time)
        distance.append(np.linalg.norm(state) * 1e3)
        point, _, _ = spiceypy.subpnt("INTERCEPT/ELLIPSOID", target, et, frame, correction, observer)
        observed.append(point / np.linalg.norm(point))
        sub_solar, _, _ = spiceypy.subslr("INTERCEPT/ELLIPSOID", target, et, frame, correction, observer)
        solar.append(sub_solar / np.linalg.norm(sub_solar))
        _, _, of_point, incidence, emission = spiceypy.ilumin("ELLIPSOID", target, et, frame, correction, observer, point)
        assert emission < 1e-8 and abs(of_point - incidence) < 1e-8
        phase.append(np.degrees(of_point))
    assert_within(np.abs(rows["light_time_s"] - light), MICROSECOND)
    assert_within(np.abs(rows["range_m"] - distance), LIGHT * MICROSECOND)
    assert_within(angle_deg(direction(rows["sub_observer_lon_deg"], rows["sub_observer_lat_deg"]), np.array(observed)), DEG)
    assert_within(angle_deg(direction(rows["sub_solar_lon_deg"], rows["sub_solar_lat_deg"]), np.array(solar)), DEG)
    assert_within(np.abs(rows["phase_deg"] - phase), DEG)


def test_axes_on_the_sky_and_angles_are_those_of_the_state(seen):
    motion, times, rows, _ = seen
    emission = np.array([time - motion.epoch for time in times]) - rows["light_time_s"]
    state = motion(emission)
    long_axis = state.rotation.apply([0, 0, 1])
    moments = polhode.read(TOUTATIS).inertia.tensor
    momentum = state.rotation.apply(state.omega @ moments)
    towards = np.array([spiceypy.spkpos("2004179", et_of(t), "J2000", "CN", "399")[0] for t in times])
    towards = -towards / np.linalg.norm(towards, axis=1)[:, None]
    for name, axis in (("long_axis", long_axis), ("momentum", momentum)):
        found = direction(rows[f"{name}_ra_deg"], rows[f"{name}_dec_deg"])
        assert_within(angle_deg(found, axis), 1e-9)
        assert_within(np.abs(rows[f"{name}_aspect_deg"] - angle_deg(axis, towards)), DEG)
        # A small step along the axis moves the place on the sky to the position angle.
        ra, dec = np.arctan2(-towards[:, 1], -towards[:, 0]), np.arcsin(-towards[:, 2])
        north = np.stack([-np.sin(dec) * np.cos(ra), -np.sin(dec) * np.sin(ra), np.cos(dec)], -1)
        east = np.stack([-np.sin(ra), np.cos(ra), 0 * ra], -1)
        angle = np.radians(rows[f"{name}_pa_deg"])
        along = np.cos(angle)[:, None] * north + np.sin(angle)[:, None] * east
        across = axis - np.sum(axis * towards, axis=1)[:, None] * towards
        assert_within(angle_deg(along, across), 1e-5)
    # The attitude from phi, theta, psi about the momentum in ECLIPJ2000.
    ecliptic = polhode.frame_rotation("ICRF", "ECLIPJ2000")
    to_ecliptic = Rotation.from_quat(ecliptic[[1, 2, 3, 0]])
    z = to_ecliptic.apply(momentum)
    z /= np.linalg.norm(z, axis=1)[:, None]
    lon, lat = np.arctan2(z[:, 1], z[:, 0]), np.arcsin(z[:, 2])
    frame = Rotation.from_euler("ZY", np.stack([lon, np.pi / 2 - lat], 1))
    angles = np.radians(np.stack([rows["phi_deg"], rows["theta_deg"], rows["psi_deg"]], 1))
    found = to_ecliptic.inv() * frame * Rotation.from_euler("ZXZ", angles)  # x intermediate, y short, z long: Toutatis' own
    assert_within(np.degrees((found.inv() * state.rotation).magnitude()), DEG)


def test_an_orbit_from_spice_is_the_trajectory(seen):
    motion, times, rows, _ = seen
    orbit = spice.orbit(2004179, motion, "1992-12-01T01:00 TDB", "1992-12-20T23:00 TDB", 7200.0)
    again = motion.observe(times, orbit)
    assert_within(np.abs(again["light_time_s"] - rows["light_time_s"]), MICROSECOND)
    assert_within(np.abs(again["phase_deg"] - rows["phase_deg"]), DEG)


def test_a_rotation_about_one_axis_is_spices_text_pck():
    """A pole and a prime meridian as a text kernel gives them."""
    ra, dec, w0, rate = 37.0, -21.0, 113.0, 31.0  # deg, deg, deg, deg/day
    spiceypy.kclear()
    for name, value in {
        "POLE_RA": [ra, 0, 0], "POLE_DEC": [dec, 0, 0], "PM": [w0, rate, 0], "RADII": [1e-3, 1e-3, 1e-3],
    }.items():  # fmt: skip
        spiceypy.pdpool(f"BODY2099999_{name}", value)
    spiceypy.pdpool("FRAME_1099999_CLASS", [2])
    spiceypy.pdpool("FRAME_1099999_CLASS_ID", [2099999])
    spiceypy.pdpool("FRAME_1099999_CENTER", [2099999])
    spiceypy.pcpool("FRAME_1099999_NAME", ["TEST_FIXED"])
    spiceypy.pdpool("FRAME_TEST_FIXED", [1099999])
    at_j2000 = np.array(spiceypy.pxform("TEST_FIXED", "J2000", 0.0))
    body = polhode.Body(
        "spinner", inertia=polhode.Inertia([1.0, 2.0, 3.0]), epoch="2000-01-01T12:00:00 TDB", frame="ICRF",
        q=Rotation.from_matrix(at_j2000), omega=[0, 0, np.radians(rate) / 86400],
    )  # fmt: skip
    motion = body.motion()
    orbit = polhode.Orbit.kepler(1.32712440018e20, 1.7 * AU, 0.1, 0.0, [1, 0.2, 0.1], [-0.1, 0, 1.0])
    times = [motion.epoch + 86400.0 * day for day in np.linspace(0, 200, 30)]
    rows = motion.observe(times, orbit, observer="sun")
    for time, lon, lat, light_time in zip(times, rows["sub_observer_lon_deg"], rows["sub_observer_lat_deg"], rows["light_time_s"]):
        emission = time - motion.epoch - light_time
        to_observer = -np.array(orbit(emission)[0])
        _, sun = earth_and_sun(Time([(motion.epoch + emission).text("TT", 6), time.text("TT", 6)], scale="tt"))
        to_observer = sun[0][1] - (sun[0][0] - to_observer)  # the Sun at reception, the target at emission
        fixed = np.array(spiceypy.pxform("J2000", "TEST_FIXED", et_of(motion.epoch + emission))) @ to_observer
        assert angle_deg(direction(lon, lat), fixed) < DEG
    spiceypy.kclear()


def test_a_site_is_astropys():
    """The Earth and a site on it with the orientation of IERS, and light time by a plain iteration."""
    motion = polhode.read(TOUTATIS).motion()
    orbit = polhode.Orbit.read(WAY, "Sun", motion.epoch)
    place = EarthLocation.from_geodetic(-17.88 * u.deg, 28.76 * u.deg, 2326 * u.m)
    table = iers.IERS_B.open()
    for day in (0.0, 3.37, 11.71):
        time = Time("1992-12-02T03:00:00", scale="utc") + day * u.day
        ut1, (pole_x, pole_y) = table.ut1_utc(time), table.pm_xy(time)
        time.delta_ut1_utc = ut1
        with iers.earth_orientation_table.set(table):
            site = place.get_gcrs(time).cartesian.xyz.to_value("m")
        row = motion.observe(
            time, WAY, site=(-17.88, 28.76, 2326.0), ut1_minus_utc_s=ut1.to_value("s"),
            pole_x_arcsec=pole_x.to_value("arcsec"), pole_y_arcsec=pole_y.to_value("arcsec"),
        )  # fmt: skip
        earth, _ = earth_and_sun(time)
        observer = earth[0] + site
        light_time = 0.0
        for _ in range(10):
            emission = time - light_time * u.s
            _, sun = earth_and_sun(emission)
            target = sun[0] + np.array(orbit(polhode.Instant.of(emission) - motion.epoch)[0])
            light_time = np.linalg.norm(target - observer) / LIGHT
        assert abs(row["light_time_s"] - light_time) < MICROSECOND
        assert abs(row["range_m"] - LIGHT * light_time) < 1.0  # the site within a metre
        geocentric = motion.observe(time, WAY)
        assert abs(row["range_m"] - geocentric["range_m"]) > 1e5  # and the site does matter


# --- Toutatis 1992 ----------------------------------------------------------------------------------------------------


def scatter(magnitude, phase_deg, *more):
    """Rms of the residuals of a line and a parabola in phase (and of `more`)."""
    columns = np.stack([np.ones_like(phase_deg), phase_deg, phase_deg**2, *more], 1)
    return np.sqrt(np.mean((magnitude - columns @ np.linalg.lstsq(columns, magnitude, rcond=None)[0]) ** 2))


@pytest.fixture(scope="module")
def toutatis_1992(tmp_path_factory):
    def rows(law):
        out = tmp_path_factory.mktemp("toutatis") / "model.ecsv"
        run("observe", TOUTATIS, "--times", PHOTOMETRY, "-o", out, "--scale", "UTC", "--shape", ELLIPSOID, "--law", law)
        return Table.read(out)

    return rows


def test_the_magnitudes_of_toutatis(toutatis_1992):
    rows = toutatis_1992("projected-area")
    assert len(rows) == 202
    measured, phase = np.array(rows["given_magnitude"]), np.array(rows["phase_deg"])
    reduced = measured - 5 * np.log10(rows["r_au"] * rows["delta_au"])
    assert abs(scatter(reduced, phase) - 0.357) < 5e-4
    light = -2.5 * np.log10(np.array(rows["area_m2"]))
    assert scatter(reduced - light, phase) < 0.225
    assert scatter(reduced, phase, light) < 0.215  # with the amplitude of the light curve free: 0.81
    assert abs(np.array(rows["magnitude"]) - light - 5 * np.log10(rows["r_au"] * rows["delta_au"])).std() < 1e-4
    rows = toutatis_1992("lommel-seeliger")
    assert scatter(measured - np.array(rows["magnitude"]), phase) < 0.179


def test_the_geometry_of_the_table_is_that_of_horizons(toutatis_1992):
    rows = toutatis_1992("lommel-seeliger")
    # Their phase angles, with stellar aberration; ours without: 20 arcsec of 5.7e-3 deg, and Horizons' Earth.
    assert np.abs(rows["phase_deg"] - rows["given_phase_deg"]).max() < 0.02
    assert np.abs(rows["range_m"] / AU - rows["delta_au"]).max() < 1e-12
    time = rows["date_utc"]
    assert isinstance(time, Time) and np.abs(time.jd1 - 2448827.017361111 + time.jd2)[0] < 1e-8


def test_columns_that_are_kept_have_names_of_their_own(tmp_path):
    """Called as ours, as another but for capital letters, in no letters of FITS, or not at all."""
    table = tmp_path / "table.csv"
    names = ["Magnitude", "magnitude", "TIME", "Filter", "filter", "", "Größe", "a,b", "x" * 90]
    table.write_text(",".join(["date_utc", *(f'"{name}"' for name in names), "ra_deg", "dec_deg", "delta_au"]) + "\n" +
                     "".join(f"1992-12-0{day}T00:00:00,{','.join(map(str, range(9)))},{10 + day},20,0.05\n" for day in (1, 2, 3)))  # fmt: skip
    for ending in ("csv", "ecsv", "fits"):
        out = tmp_path / f"rows.{ending}"
        run("observe", TOUTATIS, "--times", table, "-o", out, "--shape", ELLIPSOID)
        rows = Table.read(out, format="ascii.csv") if ending == "csv" else Table.read(out)
        kept = rows.colnames[rows.colnames.index("area_m2") + 1 :][:9]
        letters = ["Gr__e", "a,b", "x" * 60] if ending == "fits" else ["Größe", "a,b", "x" * 90]
        assert kept == ["given_Magnitude", "given_magnitude_2", "given_TIME", "Filter", "filter_2", "column_6", *letters]
        assert [rows[name][0] for name in kept] == list(range(9))
        assert len({name.lower() for name in rows.colnames}) == len(rows.colnames)


# --- What else there is -----------------------------------------------------------------------------------------------


def test_program_and_package_say_the_same(tmp_path):
    out = tmp_path / "a.csv"
    run("observe", TOUTATIS, "--target", WAY, "-o", out, "--start", "1992-12-05 TDB", "--stop", "+2 d", "--count", 50,
        "--shape", ELLIPSOID, "-H", 15.3, "--hg1g2", 0.26, 0.38)  # fmt: skip
    table = Table.read(out)
    motion = polhode.read(TOUTATIS).motion()
    rows = motion.observe(
        [polhode.Instant(date, "TDB") for date in table["date_tdb"]], WAY, shape=[1200, 960, 2300], H=15.3, hg1g2=(0.26, 0.38)
    )
    assert list(rows) == table.colnames[1:]
    for name, values in rows.items():
        assert np.allclose(values, table[name], rtol=0, atol=1e-9 * np.abs(values).max()), name


def test_fits_holds_what_ecsv_does(tmp_path):
    """Rows in any order, with columns of numbers and of words that are kept."""
    dates = ["1992-12-05T01:00:00.5", "1992-12-04T22:00:00", "1992-12-05T03:00:00"]
    lines = ["date_utc,who,flux", *(f"{date},{who},{k}.5" for k, (date, who) in enumerate(zip(dates, ("Spencer", "de Pater", "Spencer"))))]
    (tmp_path / "times.csv").write_text("\n".join(lines) + "\n")
    for ending in ("ecsv", "fits"):
        run("observe", TOUTATIS, "--target", WAY, "--times", tmp_path / "times.csv", "-o", tmp_path / f"rows.{ending}",
            "--scale", "UTC", "--shape", ELLIPSOID)  # fmt: skip
    text = Table.read(tmp_path / "rows.ecsv")
    fits = Table.read(tmp_path / "rows.fits", hdu="OBSERVED", astropy_native=True)
    assert fits.colnames == ["TIME", *text.colnames[1:]]
    assert fits["TIME"].scale == "utc" and np.abs((fits["TIME"] - text["date_utc"]).to_value("s")).max() < 1e-6
    assert [str(who).strip() for who in fits["who"]] == list(text["who"])
    for name in text.colnames[1:]:
        if name != "who":
            assert np.array_equal(fits[name], text[name]) and fits[name].unit == text[name].unit, name
    assert fits.meta["OBJECT"] == "4179 Toutatis"
    with subprocess.Popen(["fitsverify", "-q", tmp_path / "rows.fits"], stdout=subprocess.PIPE, text=True) as verified:
        assert "OK" in verified.stdout.read()
    refused = run("observe", TOUTATIS, "--target", WAY, "-o", tmp_path / "rows.txt", "--stop", "+1 d", "--count", 2, check=False)
    assert refused.returncode == 2 and ".fits .fit (FITS)" in refused.stderr


def test_many_rows_are_interpolated_and_still_right():
    motion = polhode.read(TOUTATIS).motion()
    t = np.linspace(25 * 86400, 35 * 86400, 40001)
    rows = motion.observe(t, WAY)
    few = motion.observe(t[::4000], WAY)
    for name in ("light_time_s", "range_m", "phase_deg", "sub_observer_lon_deg", "sub_solar_lat_deg"):
        assert_within(np.abs(rows[name][::4000] - few[name]) / np.abs(few[name]), 1e-9)


def test_an_exposure_sums_the_light():
    motion = polhode.read(TOUTATIS).motion()
    exposure, centre = 86400.0, 26 * 86400.0
    long = motion.observe(centre, WAY, shape=[1200, 960, 2300], exposure=exposure)
    x, weight = np.polynomial.legendre.leggauss(200)
    moments = motion.observe(centre + 0.5 * exposure * x, WAY, shape=[1200, 960, 2300])
    light = np.sum(0.5 * weight * 10 ** (-0.4 * moments["magnitude"]))
    assert abs(long["magnitude"] + 2.5 * np.log10(light)) < 1e-5
    assert abs(long["area_m2"] / np.sum(0.5 * weight * moments["area_m2"]) - 1) < 1e-5


def horizons(frame, csv, units="KM-S"):
    """A vector table of Toutatis about the Sun, as Horizons prints it."""
    motion = polhode.read(TOUTATIS).motion()
    orbit = polhode.Orbit.read(WAY, "Sun", motion.epoch, frame)
    length, time = (1e-3, 1.0) if units == "KM-S" else (1 / AU, 86400.0)
    rows = []
    for day in range(1, 26):
        instant = polhode.Instant(f"1992-12-{day:02} TDB")
        p, v = (np.array(part) for part in orbit(instant - motion.epoch))
        numbers = [f"{value: .15E}" for value in (*(p * length), *(v * length * time))]
        jd = f"{2448957.5 + day - 1:.9f}"
        date = f"A.D. 1992-Dec-{day:02} 00:00:00.0000"
        if csv:
            rows.append(f"{jd}, {date}, {', '.join(numbers)},")
        else:
            rows.append(f"{jd} = {date} TDB \n X ={numbers[0]} Y ={numbers[1]} Z ={numbers[2]}")
            rows.append(f" VX={numbers[3]} VY={numbers[4]} VZ={numbers[5]}\n LT= 1.0E+02 RG= 1.0E+07 RR=-2.0E+00")
    names = "JDTDB,            Calendar Date (TDB),  X,  Y,  Z,  VX,  VY,  VZ," if csv else "JDTDB\n   X     Y     Z\n   VX    VY    VZ\n   LT    RG    RR"
    plane = "ICRF" if frame == "ICRF" else "Ecliptic of J2000.0"
    stars = "*" * 79
    return f"""{stars}
Target body name: 4179 Toutatis (1989 AC)         {{source: JPL#1}}
Center body name: Sun (10)                        {{source: DE441}}
Center-site name: BODY CENTER
{stars}
Output units    : {units}
Output type     : GEOMETRIC cartesian states
Output format   : {2 if csv else 3} (position and velocity)
Reference frame : {plane}
{stars}
{names}
{stars}
$$SOE
{chr(10).join(rows)}
$$EOE
"""


@pytest.mark.parametrize("frame, csv, units", [("ICRF", False, "KM-S"), ("ECLIPJ2000", True, "AU-D"), ("ECLIPJ2000", False, "AU-D")])
def test_tables_of_horizons(tmp_path, frame, csv, units):
    path = tmp_path / "vectors.txt"
    path.write_text(horizons(frame, csv, units))
    motion = polhode.read(TOUTATIS).motion()
    t = np.linspace(30, 38, 9) * 86400
    ours, theirs = motion.observe(t, WAY), motion.observe(t, path)
    assert_within(np.abs(ours["range_m"] - theirs["range_m"]), 2e4)  # Hermite's polynomials between daily rows
    assert_within(np.abs(ours["phase_deg"] - theirs["phase_deg"]), 1e-3)


@pytest.mark.parametrize(
    "change, word",
    [
        (("GEOMETRIC", "ASTROMETRIC"), "GEOMETRIC"),
        (("KM-S", "FT-S"), "units"),
        (("BODY CENTER", "Greenwich"), "site"),
        (("$$EOE", ""), "EOE"),
        (("ICRF", "FK4/B1950"), "frame"),
        (("ICRF", "Ecliptic of B1950.0"), "frame"),
        (("Reference frame : ICRF", ""), "Reference frame"),
        (("X =", "X = a"), "number"),
        (("1992-Dec-07", "1992-Foo-07"), "date"),
    ],
)
def test_tables_of_horizons_that_are_refused(tmp_path, change, word):
    path = tmp_path / "vectors.txt"
    path.write_text(horizons("ICRF", False).replace(*change))
    result = run("observe", TOUTATIS, "--target", path, "-o", "-", "--start", "1992-12-05 TDB", "--count", 1, check=False)
    assert result.returncode == 2 and word in result.stderr and str(path) in result.stderr, result.stderr


ONE_ROW = ("-o", "-", "--start", "1992-12-08 TDB", "--count", 1)


@pytest.mark.parametrize(
    "options, said",
    [
        (("-H", "nan"), "absolute magnitude"),
        (("-H", "1e308"), "absolute magnitude"),
        (("--hg1g2", "nan", "0"), "G1 = nan"),
        (("--hg1g2", "-1", "0"), "G1 = -1"),
        (("--phase-polynomial", "1e308", "1e308"), "phase function"),
        (("--law", "lommel-seeliger-lambert", "--lambert-weight", "1e300"), "1e+300"),
        (("--shape", "1e-150 1 1 m"), "semi-axes"),
        (("--shape", "1 1 1 au"), "the observer is"),
    ],
)
def test_a_brightness_that_is_no_number_is_refused(options, said):
    shape = () if "--shape" in options else ("--shape", ELLIPSOID)
    result = run("observe", TOUTATIS, "--target", WAY, *ONE_ROW, *shape, *options, check=False)
    assert result.returncode == 2 and said in result.stderr and result.stdout == "", result.stderr


@pytest.mark.parametrize("cells", [("10", "120", "0.03"), ("1e20", "0", "0.03"), ("10", "0", "-0.03"), ("10", "0", "1e300")])
def test_a_table_of_directions_names_its_line(tmp_path, cells):
    table = tmp_path / "points.csv"
    table.write_text("date_utc,ra_deg,dec_deg,delta_au\n1992-12-08,10,0,0.03\n1992-12-09," + ",".join(cells) + "\n")
    result = run("observe", TOUTATIS, "--times", table, "-o", "-", check=False)
    assert result.returncode == 2 and f"{table}:3: column " in result.stderr and "allowed are" in result.stderr, result.stderr


def test_an_orbit_is_about_its_centre(tmp_path):
    path = tmp_path / "leo.toml"
    elements = 'epoch = "1992-12-01 TDB"\neccentricity = 0.0\nsemi_major_axis_au = 4.67e-5\nmu_m3_s2 = 3.986e14\ninclination_deg = 0.5\n'
    path.write_text(elements + "node_deg = 128.0\nperiapsis_deg = 274.0\nmean_anomaly_deg = 350.0\n")
    motion = polhode.read(TOUTATIS).motion()
    assert motion.observe("1992-12-01 TDB", path, centre="Earth")["range_m"] == pytest.approx(4.67e-5 * AU, rel=1e-3)
    about_earth = polhode.Orbit.kepler(3.986e14, 7e6, 0.0, 0.0, [1, 0, 0], [0, 0, 1])
    assert motion.observe("1992-12-01 TDB", about_earth, centre="Earth")["range_m"] == pytest.approx(7e6, rel=1e-3)
    with pytest.raises(InputError, match="not the Sun's"):
        motion.observe("1992-12-01 TDB", about_earth)


def test_earth_and_sun_far_from_now_are_said_to_be_less_exact(tmp_path):
    path = tmp_path / "orbit.toml"
    path.write_text('epoch = "1992-12-01 TDB"\neccentricity = 0.1\nsemi_major_axis_au = 2.5\ninclination_deg = 0.5\nnode_deg = 1.0\nperiapsis_deg = 2.0\nmean_anomaly_deg = 3.0\n')
    for date, noted in (("2099-12-31 TDB", False), ("2100-01-02 TDB", True), ("1899-12-30 TDB", True)):
        said = run("observe", TOUTATIS, "--target", path, "-o", "-", "--start", date, "--count", 1).stderr
        assert ("from 1900 to 2100" in said) == noted, said


def test_orbital_elements(tmp_path):
    path = tmp_path / "orbit.toml"
    path.write_text(
        'epoch = "1992-12-01 TDB"\neccentricity = 0.64\nsemi_major_axis_au = 2.5\ninclination_deg = 0.5\nnode_deg = 128.0\n'
        "periapsis_deg = 274.0\nmean_anomaly_deg = 350.0\n"
    )
    motion = polhode.read(TOUTATIS).motion()
    row = motion.observe("1992-12-01 TDB", path, observer="sun")
    anomaly = np.radians(350.0)
    eccentric = anomaly
    for _ in range(50):
        eccentric = anomaly + 0.64 * np.sin(eccentric)
    assert abs(row["range_m"] / (2.5 * AU * (1 - 0.64 * np.cos(eccentric))) - 1) < 1e-4  # at emission, 15 min before
    assert abs(row["phase_deg"]) < 1e-5
    path.write_text(path.read_text().replace("mean_anomaly_deg = 350.0", "mean_anomaly = 350.0"))
    with pytest.raises(InputError, match="mean_anomaly"):
        motion.observe("1992-12-01 TDB", path)


@pytest.mark.parametrize(
    "options, word",
    [
        ([], "--target"),
        (["--target", WAY, "--law", "lambert"], "--shape"),
        (["--target", WAY, "--shape", "1 2 km"], "--shape"),
        (["--target", WAY, "--shape", "1 2 3 km", "--law", "hapke"], "--law"),
        (["--target", WAY, "--shape", "1 -2 3 km"], "positive"),
        (["--target", WAY, "--site", "0 91 0"], "--site"),
        (["--target", WAY, "--site", "0 0"], "--site"),
        (["--target", WAY, "--sun", WAY], "Sun"),
        (["--target", "geocentre"], "--target"),
        (["--target", WAY, "--start", "1980-01-01 TDB"], "1980"),
        (["--target", WAY, "--convention", "x"], "--convention"),
        (["--target", WAY, "--shape", "1 2 3 km", "--exposure", "-1 s"], "exposure"),
        (["--target", WAY, "--shape", ROOT / "data/samples/mesh/box.ply"], "unit"),
    ],
)
def test_what_is_refused(options, word):
    start = [] if "--start" in options else ["--start", "1992-12-05 TDB"]
    result = run("observe", TOUTATIS, "-o", "-", *start, "--count", 1, *options, check=False)
    assert result.returncode == 2 and word in result.stderr and result.stdout == "", result.stderr
