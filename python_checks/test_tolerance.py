"""--tolerance: the file read back by its own format's readers, interpolated as they do, against a dense table."""

import json

import numpy as np
import pytest
from aem_reader import read
from astropy.io import fits
from astropy.table import Table
from brahe.ccsds import AEM
from scipy.spatial.transform import Rotation, Slerp
from support import ROOT, TOUTATIS, assert_within, propagate, run

APOPHIS = ROOT / "data/bodies/apophis.toml"
T_HANDLE = ROOT / "data/bodies/t-handle.toml"


def dense(body, folder, stop):
    out = propagate(body, folder / "dense.fits", "--stop", stop, "--count", "20011", "--scale", "TT")
    table = Table.read(out, hdu="ATTITUDE")
    return np.asarray(table["TIME"]), Rotation.from_quat(table["QPARAM"])


@pytest.mark.parametrize("tolerance", ["1e-3", "1e-6"])
@pytest.mark.parametrize("body, stop", [(TOUTATIS, "+60 d"), (APOPHIS, "+30 d"), (T_HANDLE, "+20 s")])
def test_great_circles_through_fits(tmp_path, body, stop, tolerance):
    out = propagate(body, tmp_path / "a.fits", "--stop", stop, "--tolerance", tolerance, "--scale", "TT")
    table = Table.read(out, hdu="ATTITUDE")
    header = fits.getheader(out, "ATTITUDE")
    assert header["INTERERR"] == float(tolerance) and header["INTERPOL"].startswith("great circle")
    time, truth = dense(body, tmp_path, stop)
    time = np.clip(time, table["TIME"][0], table["TIME"][-1])
    errors = (Slerp(table["TIME"], Rotation.from_quat(table["QPARAM"]))(time).inv() * truth).magnitude()
    assert_within(errors, float(tolerance))
    assert errors.max() > 0.7 * float(tolerance)  # no more rows than needed


@pytest.mark.parametrize("tolerance", ["1e-4", "1e-8"])
@pytest.mark.parametrize("body, stop, days", [(TOUTATIS, "+60 d", 60), (APOPHIS, "+30 d", 30)])
def test_lagrange_through_aem_by_brahe(tmp_path, body, stop, days, tolerance):
    out = propagate(body, tmp_path / "a.aem", "--stop", stop, "--tolerance", tolerance, "--scale", "TT")
    _, (segment,) = read(out)
    assert (segment.meta["INTERPOLATION_METHOD"], segment.meta["INTERPOLATION_DEGREE"]) == ("LAGRANGE", "7")
    assert f"within {float(tolerance):.3e} rad" in out.read_text()
    trajectory = AEM.from_file(str(out)).segment_to_attitude_trajectory(0)
    time, truth = dense(body, tmp_path, stop)
    picked = np.arange(10, len(time) - 10, 13)
    start = trajectory.start_epoch
    matrices = np.array([trajectory.rotation_matrix(start + float(time[i] - time[0])).to_matrix() for i in picked])
    errors = (Rotation.from_matrix(matrices.transpose(0, 2, 1)).inv() * truth[picked]).magnitude()
    assert_within(errors, float(tolerance))


@pytest.mark.parametrize("tolerance", ["0.3", "1e-4", "1e-8"])
@pytest.mark.parametrize("body, stop", [(TOUTATIS, "+60 d"), (APOPHIS, "+30 d"), (T_HANDLE, "+20 s")])
def test_our_own_reader_keeps_what_a_message_promises(tmp_path, body, stop, tolerance):
    out = propagate(body, tmp_path / "a.aem", "--stop", stop, "--tolerance", tolerance, "--scale", "TT")
    again = propagate(out, tmp_path / "between.aem", "--count", "3001", "--attitude-type", "QUATERNION")
    difference = json.loads(run("compare", again, body, "--json").stdout)
    assert difference["rows_compared"] == 3001
    assert 0 < difference["largest_rad"] <= float(tolerance)


def test_rows_of_a_fast_body_are_not_half_a_turn_apart(tmp_path):
    fast = tmp_path / "fast.toml"
    fast.write_text(
        "name = 'fast'\nsource = 'none'\n[inertia]\nmoments = [1.0, 2.0, 2.5]\nunit = 'kg m2'\n"
        "[state]\nepoch = '2000-01-01T00:00:00 TDB'\nframe = 'ICRF'\n"
        "[state.attitude]\nq_frame_from_body_scalar_first = [1.0, 0.0, 0.0, 0.0]\n"
        "[state.angular_velocity]\ncomponents = [10.0, 20.0, 6283.1]\naxes = 'body'\nunit = 'rad/s'\n"
    )
    out = propagate(fast, tmp_path / "a.fits", "--stop", "+0.5 s", "--tolerance", "1.5")
    q = np.asarray(Table.read(out, 1)["QPARAM"])
    assert len(q) > 6283.1 * 0.5


@pytest.mark.parametrize(
    "options, message",
    [
        (("--tolerance", "0"), "1e-15 rad or more"),
        (("--tolerance", "-1e-6"), "1e-15 rad or more"),
        (("--tolerance", "1e-6 furlong"), "arcsec"),
        (("--tolerance", "1e-16"), "1e-15 rad or more"),
        (("--tolerance", "1e-6", "--step", "60"), "one of"),
    ],
)
def test_bad_tolerances(tmp_path, options, message):
    result = run("propagate", TOUTATIS, "-o", tmp_path / "a.aem", "--stop", "+1 d", *options, check=False)
    assert result.returncode == 2
    assert message in result.stderr
    assert list(tmp_path.iterdir()) == []
