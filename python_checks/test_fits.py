"""Our FITS in the hands of astropy, fitsverify and scipy, and against an independent integration."""

import re
import shutil
import subprocess
import warnings

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from astropy.time import Time
from astropy.timeseries import TimeSeries
from scipy.spatial.transform import Rotation, Slerp
from support import (
    ROOT,
    SPINNER,
    T_HANDLE,
    TOUTATIS,
    TOUTATIS_EPOCH,
    angle_rad,
    assert_within,
    elapsed_tt,
    propagate,
    sign_is_continuous,
    toutatis,
)


def scalar_first(qparam):
    return np.asarray(qparam)[:, [3, 0, 1, 2]]


@pytest.fixture(scope="module")
def thirty_days(tmp_path_factory):
    return propagate(TOUTATIS, tmp_path_factory.mktemp("fits") / "toutatis.fits", "--stop", "+30 d", "--step", "5 h")


def test_rows_agree_with_the_integration_of_the_equations(thirty_days):
    table = Table.read(thirty_days, hdu="ATTITUDE", astropy_native=True)
    q, omega = toutatis().states(elapsed_tt(table["TIME"], TOUTATIS_EPOCH))
    assert_within(angle_rad(scalar_first(table["QPARAM"]), q), 1e-12)
    assert_within(np.linalg.norm(table["OMEGA"] - omega, axis=1) / np.linalg.norm(omega[0]), 1e-12)
    assert_within(angle_rad(scalar_first(table["QPARAM"]), q), max(1e-14, table.meta["MAXERR"]))


def test_published_angles_at_the_epoch(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+0 s", "--count", "1", "--frame", "ECLIPJ2000")
    row = Table.read(out, hdu="ATTITUDE")
    angles = Rotation.from_quat(row["QPARAM"][0]).as_euler("ZXZ", degrees=True) % 360
    assert_within(np.abs(angles - [145.498, 65.865, 241.524]), 1e-10)


@pytest.mark.parametrize("scale", ["tdb", "tt", "tai", "utc"])
def test_astropy_reads_the_times_of_every_scale(tmp_path, scale):
    # Over the leap second at the end of 2016.
    start, stop = "2016-12-31T23:59:57", "2017-01-01T00:00:03"
    out = propagate(TOUTATIS, tmp_path / "a.fits", "--scale", scale, "--start", start, "--stop", stop, "--step", "0.5")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        series = TimeSeries.read(out, format="fits", time_column="TIME", astropy_native=True)
        table = Table.read(out, hdu="ATTITUDE", astropy_native=True)
    assert series.time.scale == scale
    first = Time(start, scale=scale)
    count = 15 if scale == "utc" else 13
    assert len(series) == count
    assert_within(np.abs((series.time - first).to_value("s") - 0.5 * np.arange(count)), 1e-10)
    assert_within(np.abs((table["TIME"] - series.time).to_value("s")), 0)
    header = fits.getheader(out, "ATTITUDE")
    assert (header["DATE-BEG"], header["DATE-END"]) == (start + ".000000000", stop + ".000000000")
    assert header["TIMESYS"] == scale.upper()


def test_rows_do_not_depend_on_the_scale(tmp_path):
    """One instant, four scales: one attitude, to the resolution of the times."""
    quaternions = []
    instant = Time("2016-12-31T12:00:00", scale="tai")
    for scale in ["tdb", "tt", "tai", "utc"]:
        out = propagate(T_HANDLE, tmp_path / f"{scale}.csv", "--scale", scale, "--times", "2016-12-31T12:00:00 TAI")
        date = out.read_text().splitlines()[1].split(",")[0]
        assert abs((Time(date, scale=scale) - instant).to_value("s")) <= 1e-9
        fits_row = propagate(TOUTATIS, tmp_path / f"{scale}.fits", "--scale", scale, "--times", "2016-12-31T12:00:00 TAI")
        quaternions.append(scalar_first(Table.read(fits_row, hdu="ATTITUDE")["QPARAM"])[0])
    for q in quaternions[1:]:
        assert_within(angle_rad(q, quaternions[0]), 1e-15 + 2e-5 * 1e-11)


@pytest.mark.parametrize("scale", ["TDB", "UTC"])
@pytest.mark.parametrize("ending", [".fits", ".fits.gz"])
def test_fitsverify_finds_nothing(tmp_path, scale, ending):
    if shutil.which("fitsverify") is None:
        pytest.skip("no fitsverify on this machine")
    out = propagate(TOUTATIS, tmp_path / ("a" + ending), "--stop", "+9 d", "--step", "1 h", "--scale", scale, "--momentum")
    result = subprocess.run(["fitsverify", out], capture_output=True, text=True)
    assert "Verification found 0 warning(s) and 0 error(s)" in result.stdout, result.stdout
    assert result.returncode == 0


def test_checksums_by_astropy(thirty_days):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with fits.open(thirty_days, checksum=True) as file:
            assert [hdu.verify_checksum() for hdu in file] == [1, 1]
            assert [hdu.verify_datasum() for hdu in file] == [1, 1]


def test_direction_and_order(tmp_path):
    """A body turned by +90 deg about inertial z: QPARAM (0, 0, 0.7071, 0.7071), its x axis along inertial y."""
    body = tmp_path / "spinner.toml"
    body.write_text(SPINNER)
    out = propagate(body, tmp_path / "a.fits", "--stop", "+10 s", "--step", "10", "--scale", "TT", "--momentum")
    table = Table.read(out, hdu="ATTITUDE", astropy_native=True)
    half = np.sqrt(0.5)
    assert_within(np.abs(table["QPARAM"][1] - [0, 0, half, half]), 1e-15)
    assert_within(np.abs(Rotation.from_quat(table["QPARAM"][1]).apply([1, 0, 0]) - [0, 1, 0]), 1e-15)
    assert_within(np.abs(table["OMEGA"][1] - [0, 0, np.radians(9)]), 1e-15)
    assert_within(np.abs(table["L"][1] - [0, 0, 3 * np.radians(9)]), 1e-15)
    header = fits.getheader(out, "ATTITUDE")
    assert (header["QORDER"], header["QDIR"], header["REFFRAMA"]) == ("XYZS", "A2B", "ICRF")
    assert table["OMEGA"].unit == "rad/s" and table["L"].unit == "N m s"


def test_rates_are_those_of_the_attitude(tmp_path):
    """Central differences of the attitude, in body axes, give OMEGA; the sign of the quaternion is continuous."""
    out = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+20 d", "--step", "60", "--scale", "TT")
    table = Table.read(out, hdu="ATTITUDE", astropy_native=True)
    assert sign_is_continuous(np.asarray(table["QPARAM"]))
    turn = Rotation.from_quat(table["QPARAM"])
    rate = (turn[:-2].inv() * turn[2:]).as_rotvec() / 120
    assert_within(np.linalg.norm(rate - table["OMEGA"][1:-1], axis=1), 3e-12)  # h^2 omega''/6, about 1e-12


def test_great_circle_between_rows(tmp_path):
    """A HEASoft-like reader goes along great circles: scipy's Slerp through every second row hits the others."""
    out = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+10 d", "--step", "300", "--scale", "TT")
    table = Table.read(out, hdu="ATTITUDE")
    time = np.asarray(table["TIME"])
    turn = Rotation.from_quat(table["QPARAM"])
    middle = Slerp(time[::2], turn[::2])(time[1:-1:2])
    assert_within((middle.inv() * turn[1:-1:2]).magnitude(), 1e-5)


def test_the_lines_of_the_manual_do_what_they_say(tmp_path, monkeypatch):
    propagate(TOUTATIS, tmp_path / "toutatis.fits", "--count", "1")
    manual = (ROOT / "tools/manual/propagate.md").read_text()
    lines = re.search(r"```python\n(.*?)```", manual, re.S).group(1)
    monkeypatch.chdir(tmp_path)
    known = {}
    exec(lines, known)  # as a reader would paste them
    assert isinstance(known["table"]["TIME"], Time) and isinstance(known["series"].time, Time)
    assert not isinstance(Table.read("toutatis.fits", hdu="ATTITUDE")["TIME"], Time)
    # The body file's ZXZ angles say where its z axis points in the ecliptic; from there to ICRF it is a turn about x.
    first, second = np.radians([145.498, 65.865])
    ecliptic = [np.sin(second) * np.sin(first), -np.sin(second) * np.cos(first), np.cos(second)]
    icrf = Rotation.from_euler("x", 84381.448 / 3600, degrees=True).apply(ecliptic)
    assert_within(np.linalg.norm(known["z_axis"][0] - icrf), 1e-12)
