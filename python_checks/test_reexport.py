"""Attitude histories written again by polhode propagate: in other formats, frames, scales and at other times, against the
motion from which the history was made (numpy, scipy) and through independent readers."""

import json

import astropy.units as u
import erfa
import numpy as np
import pytest
from aem_reader import read
from astropy.io import fits
from astropy.table import QTable, Table
from astropy.time import Time
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, assert_within, propagate, run, sign_is_continuous

START = Time("2016-12-31T23:59:50", scale="utc")  # a leap second stands within
CCSDS = ROOT / "data/samples/ccsds/valid"


def attitude(seconds, cone=0.5):
    """A coning motion, body to frame."""
    t = np.asarray(seconds, dtype=float)
    return (
        Rotation.from_rotvec(np.outer(0.3 * t, [0, 0, 1]))
        * Rotation.from_rotvec([cone, 0, 0])
        * Rotation.from_rotvec(np.outer(0.2 * t, [0, 0, 1]))
    )


def rate(seconds, cone=0.5):
    """Its angular velocity in body axes."""
    t = np.asarray(seconds, dtype=float)
    tilt = Rotation.from_rotvec([cone, 0, 0]) * Rotation.from_rotvec(np.outer(0.2 * t, [0, 0, 1]))
    return tilt.inv().apply([0, 0, 0.3]) + np.array([0, 0, 0.2])


def history(path, count=61, step=0.5, method=("HERMITE", 7), usable=None, cone=0.5):
    """An AEM 2.0 of the coning motion with rates; every third quaternion with its sign turned."""
    seconds = step * np.arange(count)
    dates = [(START + s * u.s).isot for s in seconds]
    q = attitude(seconds, cone).as_quat() * np.where(np.arange(count) % 3 == 1, -1, 1)[:, None]
    degrees = np.degrees(rate(seconds, cone))
    span = "" if usable is None else f"USEABLE_START_TIME = {usable[0]}\nUSEABLE_STOP_TIME = {usable[1]}\n"
    how = "" if method is None else f"INTERPOLATION_METHOD = {method[0]}\nINTERPOLATION_DEGREE = {method[1]}\n"
    rows = "\n".join(f"{d} " + " ".join(f"{v:.17g}" for v in (*a, *w)) for d, a, w in zip(dates, q, degrees))
    path.write_text(
        "CCSDS_AEM_VERS = 2.0\nCREATION_DATE = 2020-01-01T00:00:00\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = CONE\n"
        "OBJECT_ID = 2020-001A\nREF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\nTIME_SYSTEM = UTC\n"
        f"START_TIME = {dates[0]}\n{span}STOP_TIME = {dates[-1]}\nATTITUDE_TYPE = QUATERNION/ANGVEL\n"
        f"ANGVEL_FRAME = SC_BODY_1\n{how}META_STOP\nDATA_START\n{rows}\nDATA_STOP\n"
    )
    return path


def elapsed(table):
    """SI seconds from START of the rows of a FITS table. In UTC they count leap seconds from MJDREF on."""
    scale, seconds = table.meta["TIMESYS"].lower(), np.asarray(table["TIME"])
    if scale == "utc":
        return seconds + (Time(table.meta["MJDREF"], format="mjd", scale=scale).tai - START.tai).to_value("s")
    return (Time(table.meta["MJDREF"], seconds / 86400, format="mjd", scale=scale).tai - START.tai).to_value("s")


def test_own_rows_in_every_format(tmp_path):
    source = history(tmp_path / "in.aem")
    table = Table.read(propagate(source, tmp_path / "a.fits"), hdu="ATTITUDE")
    seconds = elapsed(table)
    assert_within(np.abs(seconds - 0.5 * np.arange(61)), 1e-9)
    q = np.asarray(table["QPARAM"])
    assert sign_is_continuous(q)
    assert_within((Rotation.from_quat(q).inv() * attitude(seconds)).magnitude(), 2e-11)
    assert_within(np.abs(table["OMEGA"] - rate(seconds)), 1e-11)
    assert (table.meta["TIMESYS"], table.meta["REFFRAMA"], table.meta["OBJECT"]) == ("UTC", "ICRF", "CONE")
    assert "MAXERR" not in table.meta  # nothing is known of the history's errors

    version, (segment,) = read(propagate(source, tmp_path / "a.aem"))
    assert (version, segment.meta["OBJECT_ID"], segment.meta["TIME_SYSTEM"]) == ("2.0", "2020-001A", "UTC")
    assert (segment.meta["INTERPOLATION_METHOD"], segment.meta["INTERPOLATION_DEGREE"]) == ("HERMITE", "7")
    assert segment.dates[20] == "2016-12-31T23:59:60.000" and segment.dates[22] == "2017-01-01T00:00:00.000"
    assert_within(np.abs(segment.rows[:, :4] - q), 1e-15)
    for ending in ("csv", "ecsv"):
        out = Table.read(propagate(source, tmp_path / f"a.{ending}"), format=f"ascii.{ending}")
        assert_within(np.abs(np.stack([out[n] for n in ("q_x", "q_y", "q_z", "q_scalar")], axis=1) - q), 1e-15)
    # And what was written is a history again.
    for ending in ("fits", "aem", "csv", "ecsv"):
        again = propagate(tmp_path / f"a.{ending}", tmp_path / f"again-{ending}.fits")
        assert_within(np.abs(Table.read(again, hdu="ATTITUDE")["QPARAM"] - q), 1e-15)


@pytest.mark.parametrize("ending", ["csv", "ecsv", "fits", "aem"])
def test_the_frame_comes_back(tmp_path, ending):
    options = ("--step", "1", "--frame", "ECLIPJ2000")
    first = propagate(history(tmp_path / "in.aem"), tmp_path / f"a.{ending}", *options)
    (report,) = json.loads(run("info", "--json", first).stdout)
    assert report["history"]["segments"][0]["frame"] == "ECLIPJ2000"
    assert not any("ICRF" in warning for warning in report["warnings"])
    back = Table.read(propagate(first, tmp_path / "back.fits", "--frame", "ICRF"), hdu="ATTITUDE")
    assert back.meta["REFFRAMA"] == "ICRF"
    wanted = Table.read(propagate(tmp_path / "in.aem", tmp_path / "wanted.fits", "--step", "1"), hdu="ATTITUDE")
    assert_within((Rotation.from_quat(back["QPARAM"]).inv() * Rotation.from_quat(wanted["QPARAM"])).magnitude(), 1e-14)


@pytest.mark.parametrize("name", ["RTN", 'MY "FRAME", NO. 1', "#1"])
def test_a_frame_of_any_name_comes_back_from_csv(tmp_path, name):
    source = history(tmp_path / "in.aem")
    source.write_text(source.read_text().replace("REF_FRAME_A = ICRF", f"REF_FRAME_A = {name}"))
    table = Table.read(propagate(source, tmp_path / "a.csv"), format="ascii.csv")
    assert set(table["frame"]) == {name}
    rows = [json.loads(line) for line in propagate(source, tmp_path / "a.jsonl").read_text().splitlines()]
    assert {row["frame"] for row in rows} == {name}
    (report,) = json.loads(run("info", "--json", tmp_path / "a.csv").stdout)
    assert report["history"]["segments"][0]["frame"] == name


def test_a_table_of_text_has_one_frame_and_json_lines_are_not_read(tmp_path):
    table = propagate(history(tmp_path / "in.aem"), tmp_path / "a.csv")
    lines = table.read_text().splitlines()
    lines[2] = lines[2].replace(",ICRF", ",GCRF")
    table.write_text("\n".join(lines) + "\n")
    assert f"{table}:3: the frame is 'GCRF', after 'ICRF'" in run("info", table, check=False).stderr
    json_lines = propagate(tmp_path / "in.aem", tmp_path / "a.jsonl")
    result = run("propagate", json_lines, "-o", tmp_path / "b.csv", check=False)
    assert result.returncode == 2 and "JSON lines, which are written but not read" in result.stderr


@pytest.mark.parametrize(
    "method, allowed_rad, allowed_rad_s",
    [(("HERMITE", 7), 1e-10, 1e-8), (("LAGRANGE", 5), 3e-6, 3e-5), (("LINEAR", 1), 5e-3, 2e-2), (None, 3e-6, 3e-5)],
)
def test_resampled_in_another_frame_and_scale(tmp_path, method, allowed_rad, allowed_rad_s):
    source = history(tmp_path / "in.aem", method=method)
    options = ("--step", "0.07", "--scale", "TDB", "--frame", "ECLIPJ2000", "--start", "+1 s", "--stop", "+20 s")
    table = Table.read(propagate(source, tmp_path / "a.fits", *options), hdu="ATTITUDE")
    assert len(table) == 286 and table.meta["TIMESYS"] == "TDB"
    seconds = elapsed(table)
    assert_within([seconds[0] - 1, seconds[-1] - 20.95], 1e-6)
    ecliptic = Rotation.from_rotvec([-erfa.obl80(2451545.0, 0), 0, 0])  # v_ecliptic = R v_icrf
    q = Rotation.from_quat(np.asarray(table["QPARAM"]))
    assert_within((q.inv() * ecliptic * attitude(seconds)).magnitude(), allowed_rad)
    assert_within(np.abs(table["OMEGA"] - rate(seconds)), allowed_rad_s)


def test_lists_counts_and_turns_beyond_180_degrees(tmp_path):
    source = history(tmp_path / "in.aem", count=8, step=13.0, cone=0.05)  # 370 deg from row to row
    listed = ",".join((START + s * u.s).isot for s in (1.0, 6.5, 40.0))
    table = Table.read(propagate(source, tmp_path / "a.fits", "--times", listed, "--scale", START.scale), hdu="ATTITUDE")
    seconds = elapsed(table)
    assert_within(np.abs(seconds - [1.0, 6.5, 40.0]), 1e-9)
    assert_within((Rotation.from_quat(table["QPARAM"]).inv() * attitude(seconds, 0.05)).magnitude(), 0.25)  # the cone is not resolved
    table = Table.read(propagate(source, tmp_path / "b.fits", "--count", "400"), hdu="ATTITUDE")
    q = np.asarray(table["QPARAM"])
    assert len(table) == 400 and sign_is_continuous(q)
    # The rates are the derivative of what is written.
    gap = np.diff(np.asarray(table["TIME"]))[:, None]
    turned = (Rotation.from_quat(q[:-1]).inv() * Rotation.from_quat(q[1:])).as_rotvec() / gap
    middle = (np.asarray(table["OMEGA"])[1:] + np.asarray(table["OMEGA"])[:-1]) / 2
    assert_within(np.abs(turned - middle), 0.01)


@pytest.mark.parametrize(
    "options, words",
    [
        (("--stop", "+31 s"), "outside of the attitude history, which can be used from 2016-12-31T23:59:52.000 to"),
        (("--start", "2016-12-31T23:59:51 UTC"), "2016-12-31T23:59:51.000 UTC is outside"),
        (("--times", "2016-12-31T23:59:53Z,2017-01-02 UTC"), "2017-01-02T00:00:00.000 UTC is outside"),
        (("--step", "1", "--count", "3"), "one of --step and --count"),
        (("--tolerance", "1 arcsec"), "--tolerance is for bodies"),
        (("--method", "legendre"), "--method is for bodies"),
        (("--momentum",), "needs an inertia"),
        (("--frame", "ITRF"), "ITRF"),
        (("--step", "0"), "must be positive"),
    ],
)
def test_what_cannot_be_had_is_refused(tmp_path, options, words):
    source = history(tmp_path / "in.aem", usable=("2016-12-31T23:59:52", "2017-01-01T00:00:15"))
    result = run("propagate", source, "-o", tmp_path / "a.fits", *options, check=False)
    assert result.returncode == 2 and words in result.stderr, result.stderr
    assert not (tmp_path / "a.fits").exists()


def test_usable_span(tmp_path):
    source = history(tmp_path / "in.aem", usable=("2016-12-31T23:59:52", "2017-01-01T00:00:15"))
    _, (segment,) = read(propagate(source, tmp_path / "a.aem"))
    assert (segment.dates[0], segment.dates[-1]) == ("2016-12-31T23:59:52.000", "2017-01-01T00:00:15.000")
    assert len(segment.rows) == 49


def test_segments_stay_apart(tmp_path):
    two = ("--start", "1992-12-01 TDB", "--stop", "+1 d", "--start", "1996-11-25 TDB", "--stop", "+2 d", "--step", "1 h")
    source = propagate(TOUTATIS, tmp_path / "in.aem", *two)
    _, segments = read(propagate(source, tmp_path / "a.aem", "--step", "30 min"))
    assert [len(s.rows) for s in segments] == [49, 97]
    result = run("propagate", source, "-o", tmp_path / "a.csv", check=False)
    assert result.returncode == 2 and "2 segments" in result.stderr
    part = propagate(source, tmp_path / "b.csv", "--start", "1996-11-25 TDB", "--stop", "+1 d")
    assert len(Table.read(part, format="ascii.csv")) == 25
    # Between rows it is the motion itself, as well as cubics with rates have it.
    assert run("compare", tmp_path / "a.aem", TOUTATIS, "--tolerance", "1e-6 rad").returncode == 0


def test_a_message_with_inertia_is_a_body_unless_its_history_is_asked_for(tmp_path):
    acm = tmp_path / "a.acm"
    rows = "\n".join(f"{s} " + " ".join(f"{v:.17g}" for v in attitude([s]).as_quat()[0]) + " 0 0 9" for s in range(5))
    acm.write_text(
        "CCSDS_ACM_VERS = 2.0\nCREATION_DATE = 2020-01-01T00:00:00\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = CONE\n"
        "TIME_SYSTEM = TT\nEPOCH_TZERO = 2020-01-01T00:00:00\nMETA_STOP\nATT_START\nREF_FRAME_A = ICRF\n"
        "REF_FRAME_B = SC_BODY_1\nNUMBER_STATES = 7\nATT_TYPE = QUATERNION\nRATE_TYPE = ANGVEL\n"
        f"{rows}\nATT_STOP\nPHYS_START\nIXX = 1 [kg*m**2]\nIYY = 2\nIZZ = 3\nPHYS_STOP\n"
    )
    result = run("propagate", acm, "-o", tmp_path / "a.csv", "--stop", "+1 d", "--count", "3")
    assert "--history" in result.stderr and len(Table.read(tmp_path / "a.csv", format="ascii.csv")) == 3
    table = Table.read(propagate(acm, tmp_path / "b.csv", "--history"), format="ascii.csv")
    assert list(table["date_tt"]) == [f"2020-01-01T00:00:0{s}.000" for s in range(5)]
    assert_within(np.abs(table["omega_body_z_rad_s"] - np.radians(9)), 1e-15)
    assert run("propagate", TOUTATIS, "-o", tmp_path / "c.csv", "--history", check=False).returncode == 2


@pytest.mark.parametrize("name, rows", [("AEMExample01.txt", 4), ("AEMExample04.txt", 11), ("AEMExample08.txt", 2),
                                        ("AEMExample11.xml", 2), ("ACMExample05.txt", 10)])  # fmt: skip
def test_published_examples_come_back(tmp_path, name, rows):
    """Rows within the usable spans; of AEMExample05 none is."""
    out = propagate(CCSDS / name, tmp_path / "a.aem")
    assert sum(len(segment.rows) for segment in read(out)[1]) == rows
    report = json.loads(run("compare", out, CCSDS / name, "--json", "--tolerance", "1e-12 rad").stdout)
    assert (report["rows_compared"], report["rows_outside"]) == (rows, 0)
    refused = run("propagate", CCSDS / "AEMExample05.txt", "-o", tmp_path / "b.aem", check=False)
    assert refused.returncode == 2 and "usable span" in refused.stderr


def test_info_says_what_a_history_has(tmp_path):
    source = history(tmp_path / "in.aem", usable=("2016-12-31T23:59:52", "2017-01-01T00:00:15"))
    (report,) = json.loads(run("info", "--json", source).stdout)
    (segment,) = report["history"]["segments"]
    assert (report["history"]["object"], segment["interpolation"], segment["degree"]) == ("CONE", "HERMITE", 7)
    assert segment["interpolation_stated"] and segment["rates"] and segment["rows"] == 61
    assert segment["usable_start"].startswith("2016-12-31T23:59:52") and segment["usable_stop"].startswith("2017-01-01T00:00:15")
    text = run("info", source).stdout
    assert "Attitude history of CONE: 61 rows in 1 segment, UTC" in text and "beyond its attitude history" in text


def test_an_ecsv_header_goes_before_the_names_of_its_columns(tmp_path):
    """A colleague led the table to another scale and unit with astropy, which leaves the names as they were."""
    table = QTable.read(propagate(TOUTATIS, tmp_path / "own.ecsv", "--stop", "+10 d", "--step", "1 d"))
    table["date_tdb"] = table["date_tdb"].utc
    for axis in "xyz":
        table[f"omega_body_{axis}_rad_s"] = table[f"omega_body_{axis}_rad_s"].to(u.deg / u.day)
    table.write(tmp_path / "other.ecsv", format="ascii.ecsv")
    result = run("compare", tmp_path / "other.ecsv", TOUTATIS, "--tolerance", "1e-8 rad")
    assert result.returncode == 0, result.stdout
    own = Table.read(propagate(tmp_path / "own.ecsv", tmp_path / "a.csv", "--scale", "TDB"), comment="#")
    other = Table.read(propagate(tmp_path / "other.ecsv", tmp_path / "b.csv", "--scale", "TDB"), comment="#")
    for axis in "xyz":
        name = f"omega_body_{axis}_rad_s"
        assert np.allclose(own[name], other[name], rtol=1e-12, atol=0)


@pytest.mark.parametrize("keyword", ["TIMEZERO", "TIMEOFFS"])
def test_what_fits_adds_to_its_times_is_added(tmp_path, keyword):
    path = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+10 d", "--step", "1 d")
    with fits.open(path, mode="update") as file:
        file["ATTITUDE"].data["TIME"] -= 86400.0
        file["ATTITUDE"].header[keyword] = 86400.0
    assert run("compare", path, TOUTATIS, "--tolerance", "1e-8 rad").returncode == 0


def test_no_file_that_a_scene_or_body_names_is_overwritten(tmp_path):
    (tmp_path / "body.toml").write_bytes(TOUTATIS.read_bytes())
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'name = "x"\nsource = "y"\nbody = "body.toml"\nframe = "ICRF"\nafter = "1 d"\naccuracy = "1 deg"\n'
    )
    before = (tmp_path / "body.toml").read_bytes()
    result = run("propagate", scene, "-o", tmp_path / "body.toml", "--format", "csv", "--step", "1 h", check=False)
    assert result.returncode == 2 and "that is read" in result.stderr
    assert (tmp_path / "body.toml").read_bytes() == before


def test_manoeuvres_that_are_left_out_are_a_warning(tmp_path):
    result = run("propagate", CCSDS / "APMExample02.txt", "-o", tmp_path / "a.csv", "--stop", "+60 s", "--step", "30 s", check=False)
    assert "warning" in result.stderr and "manoeuvres" in result.stderr
