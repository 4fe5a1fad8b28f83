"""Times on the command line: dates, spans and lists, and that no file says a time that its readers misread."""

import csv
import json
import re
import time

import numpy as np
import pytest
from astropy import units as u
from astropy.io import fits
from astropy.table import QTable, Table
from astropy.time import Time
from support import ROOT, TOUTATIS, leap_second_kernel, propagate, run

CCSDS = ROOT / "data/samples/ccsds"


def refused(*options, **others):
    result = run(*options, check=False, **others)
    assert result.returncode == 2, result.stderr
    assert result.stdout == ""
    return result.stderr


def dates(path):
    return [row[0] for row in csv.reader(path.read_text().splitlines()[1:])]


@pytest.mark.parametrize("scale, instead", [("ET", "TDB"), ("GPS", "TAI")])
def test_fits_says_no_time_scale_that_its_readers_misread(tmp_path, scale, instead):
    out = tmp_path / "a.fits"
    message = refused("propagate", TOUTATIS, "-o", out, "--stop", "+1 d", "--count", "3", "--scale", scale)
    assert scale in message and instead in message
    assert not out.exists()


def test_fits_in_et_is_not_read(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+1 d", "--count", "3")
    fits.setval(out, "TIMESYS", value="ET", extname="ATTITUDE")
    assert "TIMESYS is ET" in refused("info", out)


def test_dates_without_a_scale_are_refused_unless_an_option_gives_it(tmp_path):
    (tmp_path / "times").write_text("1993-01-01\n")
    for options in (
        ("--start", "1993-01-01", "--count", "1"),
        ("--stop", "1993-01-01", "--count", "2"),
        ("--times", "1993-01-01"),
        ("--times", "times"),
    ):
        message = refused("propagate", TOUTATIS, "-o", "a.csv", *options, cwd=tmp_path)
        assert "needs its time scale" in message and "TT, TAI, UTC, TDB, GPS, ET" in message
        run("propagate", TOUTATIS, "-o", "a.csv", *options, "--scale", "UTC", cwd=tmp_path)
        assert (tmp_path / "a.csv").read_text().startswith("date_utc,")
        assert dates(tmp_path / "a.csv")[-1] == "1993-01-01T00:00:00.000"
        (tmp_path / "a.csv").unlink()
    history = propagate(TOUTATIS, tmp_path / "a.aem", "--stop", "+90 d", "--count", "50")
    message = refused("propagate", history, "-o", tmp_path / "b.csv", "--times", "1993-01-01")
    assert "needs its time scale" in message


def test_a_free_body_is_known_before_its_epoch(tmp_path):
    epoch = Time("1992-11-09T17:49:47", scale="utc").tdb
    out = propagate(TOUTATIS, tmp_path / "a.csv", "--start", "-2 d", "--stop", "+2 d", "--step", "1 d")
    rows = Time(dates(out), scale="tdb")
    assert np.max(np.abs((rows - epoch).to_value("s") - 86400 * np.array([-2, -1, 0]))) < 1e-8
    # Seen from there, the same motion.
    same = propagate(TOUTATIS, tmp_path / "b.csv", "--times", "1992-11-07T17:49:47 UTC")
    first, other = (np.array(p.read_text().splitlines()[1].split(",")[1:-1], float) for p in (out, same))
    assert np.max(np.abs(first - other)) < 1e-9


def test_one_row_needs_no_stop(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.csv", "--start", "1993-01-01 TDB", "--count", "1")
    assert dates(out) == ["1993-01-01T00:00:00.000"]
    assert len(dates(propagate(TOUTATIS, tmp_path / "a.csv", "--count", "1"))) == 1


def test_lists_need_no_order(tmp_path):
    listed = "1993-01-03 TDB,1993-01-01 TDB,1993-01-02 TDB,1993-01-01 TDB"
    result = run("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", listed)
    assert [d[:10] for d in dates(tmp_path / "a.csv")] == ["1993-01-01", "1993-01-02", "1993-01-03"]
    assert "not in order" in result.stderr and "1 times" in result.stderr


@pytest.mark.parametrize("kind", ["csv", "ecsv", "ours", "jd"])
def test_a_table_with_dates_is_a_list(tmp_path, kind):
    wanted = Time(["1993-01-01T00:00:00.5", "1993-01-02T12:00:00"], scale="utc")
    table = tmp_path / f"observations.{'ecsv' if kind == 'ecsv' else 'csv'}"
    if kind == "csv":
        table.write_text("magnitude,date_utc,note\n# the first night\n15.2,1993-01-01T00:00:00.5,a\n15.3,1993-01-02T12:00:00,b\n")
    elif kind == "jd":
        table.write_text("jd_utc magnitude\n2448988.500005787037 15.2\n2448990.0 15.3\n")
    elif kind == "ecsv":
        wanted.format = "isot"
        Table({"time": wanted, "magnitude": [15.2, 15.3]}).write(table, format="ascii.ecsv", delimiter=",")
    else:
        propagate(TOUTATIS, table, "--times", "1993-01-01T00:00:00.5 UTC,1993-01-02T12:00:00 UTC", "--scale", "UTC")
    out = propagate(TOUTATIS, tmp_path / "out.csv", "--times", table, "--scale", "TAI")
    assert np.max(np.abs((Time(dates(out), scale="tai") - wanted).to_value("s"))) < 1e-6
    if kind == "csv":
        table.write_text("magnitude,date_utc\n15.2,1993-01-01\n15.3\n")
        assert f"{table}:3: 1 cells; 2 are wanted" in refused("propagate", TOUTATIS, "-o", out, "--times", table)


@pytest.mark.parametrize("delimiter", [" ", ","])
@pytest.mark.parametrize("kind", ["isot", "iso", "jd", "mjd", "jd1_jd2"])
def test_times_that_astropy_wrote_are_a_list(tmp_path, kind, delimiter):
    wanted = Time(["1993-01-01T00:00:00.5", "1993-01-02T12:00:00"], scale="utc")
    wanted.format = "jd" if kind == "jd1_jd2" else kind
    table = tmp_path / "observations.ecsv"
    columns = {"note": ["the first, of two", "b"], "time of": wanted, "magnitude": [15.2, 15.3]}
    method = {"serialize_method": {"time of": "jd1_jd2"}} if kind == "jd1_jd2" else {}
    Table(columns).write(table, format="ascii.ecsv", delimiter=delimiter, **method)
    out = propagate(TOUTATIS, tmp_path / "out.csv", "--times", table, "--scale", "TAI")
    assert np.max(np.abs((Time(dates(out), scale="tai") - wanted).to_value("s"))) < 3e-5 * (kind in ("jd", "mjd")) + 1e-6


def test_a_list_that_is_none_says_what_one_is(tmp_path):
    table = tmp_path / "list"
    for text, message in [
        (b"jd,mag\n2448989.5,15.2\n", f"{table}:1: 'jd,mag' is no date, and names no column of dates"),
        (b"1993-01-01,15.2\n", f"{table}:1: '1993-01-01,15.2' is no date, and names no column of dates"),
        (b"JD 2448989.5\n", "needs its time scale"),
        (b"1993-13-01 UTC\n", "no such date"),
        (b"\0\1\2", f"{table}: is no text; a list of times is a file of text"),
    ]:
        table.write_bytes(text)
        assert message in refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", table)
    rows = propagate(TOUTATIS, tmp_path / "rows.fits", "--stop", "+1 d", "--count", "3")
    assert f"{rows}: is no text; " in refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", rows)
    wanted = Time(["1993-01-01", "1993-01-02"], scale="utc")
    wanted.format = "unix"
    Table({"time": wanted}).write(table, format="ascii.ecsv", overwrite=True)
    message = refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", table)
    assert f"{table}:" in message and "astropy's format unix; isot, iso, jd and mjd are read" in message


@pytest.mark.parametrize("scale", ["TT", "TAI", "UTC", "TDB", "GPS", "ET"])
def test_a_day_has_as_many_rows_in_every_scale(tmp_path, scale):
    for number, span in enumerate((("--stop", "+1 d"), ("--start", "2000-03-01 TT", "--stop", "2000-03-02 TT"))):
        out = propagate(TOUTATIS, tmp_path / f"{number}.csv", *span, "--step", "10 s", "--scale", scale)
        assert len(dates(out)) == 8641
    first, last = dates(tmp_path / "0.csv")[0], dates(tmp_path / "0.csv")[-1]
    assert first[10:] == last[10:] and first != last  # exactly a day of the scale


def test_now_is_a_date(tmp_path):
    before = time.time() - 1
    out = propagate(TOUTATIS, tmp_path / "a.csv", "--start", "now", "--count", "1", "--scale", "UTC")
    assert before <= Time(dates(out)[0], scale="utc").unix <= time.time() + 1
    out = propagate(TOUTATIS, tmp_path / "a.csv", "--times", "now", "--scale", "UTC")
    assert before <= Time(dates(out)[0], scale="utc").unix <= time.time() + 1
    there = run("convert-time", "--to", "UTC", "--decimals", "0", input="now\n").stdout.strip()
    assert before <= Time(there, scale="utc").unix <= time.time() + 1


@pytest.mark.parametrize(
    "options, message",
    [
        (("--times", "nofile.txt"), "there is no file 'nofile.txt'"),
        (("--stop", "60 d", "--count", "2"), "'60 d' is a span of time, not a date; '+60 d' counts"),
        (("--stop", "1993-01-01 XYZ", "--count", "2"), "'XYZ' is none; allowed: TT, TAI, UTC, TDB, GPS, ET"),
        (("--stop", "+1 d", "--count", "2", "--frame", "FK5"), "'FK5' is not an inertial frame; allowed: ICRF"),
        (("--stop", "+1e300 d", "--count", "2"), "too long a span of time"),
    ],
)
def test_what_is_no_date_is_said_so(tmp_path, options, message):
    stderr = refused("propagate", TOUTATIS, "-o", "a.csv", *options, cwd=tmp_path)
    assert message in stderr and "ITRF" not in stderr


def test_all_days_of_the_years_0000_to_9999_are_dates():
    """UTC of before 1960 is TAI; of the years to come it stays 37 s behind TAI."""
    for date, tt in [
        ("0000-01-01T00:00:00", "0000-01-01T00:00:32.184"),
        ("JD 1721059.5", "0000-01-01T00:00:32.184"),
        ("9999-12-31T00:00:00", "9999-12-31T00:01:09.184"),
        ("9999-12-31T23:58:50.5", "9999-12-31T23:59:59.684"),
    ]:
        assert run("convert-time", "--from", "UTC", "--to", "TT", "--decimals", "3", input=date).stdout.strip() == tt
    assert "outside the years 0000 to 9999" in refused("convert-time", "--to", "TT", input="9999-12-31T23:59:59 UTC\n")


@pytest.mark.parametrize("option", ["--start", "--stop"])
@pytest.mark.parametrize("span", ["+1e17", "-1e17", "+1e18 s", "+3e6 d"])
def test_spans_that_lead_out_of_all_years_are_said_so(tmp_path, option, span):
    for way in (("--count", "2"), ("--step", "1e16")):
        span_of_other = ("--stop", "+1 d") if option == "--start" else ()
        message = refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", option, span, "--scale", "TT", *way, *span_of_other)
        assert f"{option}: '{span}' leads from 1992-11-09T17:50:46 TT out of the years 0000 to 9999" in message


def test_a_unit_that_contradicts_the_name_of_its_column_is_refused(tmp_path):
    table = tmp_path / "times.ecsv"
    QTable({"mjd_tdb": [49000.0, 49001.0] * u.h}).write(table, format="ascii.ecsv")
    message = refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", table)
    assert f"{table}:" in message and "column mjd_tdb has the unit h by the header; d is wanted" in message
    QTable({"mjd_tdb": [49000.0, 49001.0] * u.d}).write(table, format="ascii.ecsv", overwrite=True)
    assert len(dates(propagate(TOUTATIS, tmp_path / "a.csv", "--times", table))) == 2
    table.write_text("mjd_tdb,mjd_tdb\n49000.0,49001.0\n")
    assert "there are two columns mjd_tdb" in refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", table)


@pytest.mark.parametrize("option, value", [("--ut1-utc", "nan"), ("--ut1-utc", "1e300"), ("--ut1-utc", "-69"), ("--pole-x", "inf")])
def test_an_earth_orientation_that_cannot_be_is_refused(option, value):
    message = refused("convert-frame", "--from", "ITRF", "--to", "ICRF", option, value, input="2020-01-01 UTC\n")
    assert "standard input:1: " in message and "is allowed" in message


@pytest.mark.parametrize("offset", [-12.0, 12.5, 39.0])
def test_leap_seconds_come_one_by_one(tmp_path, offset):
    kernel = leap_second_kernel(tmp_path / "naif.tls")
    kernel.write_text(kernel.read_text().replace(" )\n\\begintext", f", {offset}, @2035-JUL-1 )\n\\begintext"))
    message = refused("convert-time", "--to", "TAI", "--leap-seconds", kernel, input="2020-01-01 UTC\n")
    assert f"{kernel}: a leap second changes TAI - UTC by 1 s" in message


def test_accuracies_below_what_doubles_hold_are_refused(tmp_path):
    scene = tmp_path / "scene.toml"
    text = (ROOT / "data/scenes/librator.toml").read_text().replace('"bodies/', f'"{ROOT}/data/scenes/bodies/')
    scene.write_text(re.sub("accuracy = .*", 'accuracy = "1e-17 rad"', text))
    message = refused("plan", scene)
    assert "accuracy" in message and "1e-15 rad or more" in message
    case = ROOT / "data/truth/dev/sam-01.case"
    for value in ("1e-17", "inf", "nan"):
        assert "1e-15" in refused("eval", "--tolerance", value, case)


def test_angles_in_degrees_under_radians_are_warned_of(tmp_path):
    body = tmp_path / "body.toml"
    body.write_text(TOUTATIS.read_text().replace('unit = "deg"\n', 'unit = "rad"\n'))
    line = 1 + [text.startswith("euler_angles") for text in body.read_text().splitlines()].index(True)
    (report,) = json.loads(run("info", "--json", body).stdout)
    assert any(f"{body}:{line}: euler_angles has 241.524" in w and "degrees" in w for w in report["warnings"])
    result = run("propagate", body, "-o", tmp_path / "a.csv", "--count", "1")
    assert "are degrees meant?" in result.stderr
