"""What a file says ran, and what it promises, against what is true."""

import re

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from support import (
    ROOT,
    TOUTATIS,
    TOUTATIS_EPOCH,
    angle_rad,
    assert_within,
    elapsed_tt,
    propagate,
    run,
    times_of,
    toutatis,
)

APOPHIS = ROOT / "data/bodies/apophis.toml"
METHODS = [line.split()[0] for line in run("methods").stdout.splitlines() if line and not line[0].isspace()]
EXACT = {"theta", "legendre"}


def read(path):
    header = fits.getheader(path, "ATTITUDE")
    return header, np.asarray(Table.read(path, "ATTITUDE")["QPARAM"])[:, [3, 0, 1, 2]]


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    """Attitudes of Toutatis over twenty days by Taylor series in multiprecision."""
    out = propagate(TOUTATIS, tmp_path_factory.mktemp("truth") / "theta.fits", "--stop", "+20 d", "--count", "50")
    times = times_of(Table.read(out, "ATTITUDE", astropy_native=True))
    return toutatis().states(elapsed_tt(times, TOUTATIS_EPOCH))[0]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_says_its_name_and_keeps_its_promise(tmp_path, truth, method):
    out = tmp_path / "out.fits"
    result = run("propagate", TOUTATIS, "-o", out, "--stop", "+20 d", "--count", "50", "--method", method)
    header, q = read(out)
    assert header["METHOD"] == method and f"method {method}" in result.stderr
    assert header["ERRORIS"]
    errors = angle_rad(q, truth)
    assert_within(errors, header["MAXERR"])
    assert header["MAXERR"] <= 2 * errors.max() + 1e-11  # no excuse either
    if method not in EXACT:
        assert "measured" in header["ERRORIS"]


def test_a_tolerance_needs_a_method_that_promises(tmp_path):
    options = ("--stop", "+20 d", "--tolerance", "1e-9", "--method")
    for method in METHODS:
        out = tmp_path / f"{method}.fits"
        result = run("propagate", TOUTATIS, "-o", out, *options, method, check=False)
        assert (result.returncode, out.exists()) == ((0, True) if method in EXACT else (2, False)), result.stderr


def test_a_body_says_when_its_periods_lose_the_phase(tmp_path):
    """Apophis six years after the epoch: rows good to rounding, of a phase that is lost within weeks."""
    for name in ("a.fits", "a.aem", "a.ecsv"):
        out = tmp_path / name
        result = run("propagate", APOPHIS, "-o", out, "--start", "+2190 d", "--stop", "+1 d", "--count", "3")
        assert "rounding only" in result.stderr and "the attitude is known to 1 deg" in result.stderr
        text = " ".join(str(c) for c in fits.getheader(out, 1)["COMMENT"]) if name == "a.fits" else out.read_text()
        text = " ".join(text.replace("COMMENT", "").split())
        assert "andatall(180deg)until" in text.replace(" ", "") and "dafterthe" in text.replace(" ", "")
        beyond = "what is asked for lies beyond that, up to 6 years from the epoch"
        assert beyond.replace(" ", "") in text.replace(" ", "")  # cards of FITS break anywhere
    run("propagate", APOPHIS, "-o", tmp_path / "b.ecsv", "--stop", "+1 d", "--count", "3")
    assert "lies beyond" not in (tmp_path / "b.ecsv").read_text()
    assert "known at all (180 deg)" in run("info", APOPHIS).stdout
    assert "and at all (180 deg)" in run("plan", ROOT / "data/scenes/apophis-2029.toml").stdout


def test_what_ran_under_torques_is_what_the_file_says(tmp_path):
    """In full, another method runs than the one that the plan names for 1 deg."""
    scene = (ROOT / "data/scenes/envisat-month.toml").read_text().replace("bodies/", f"{ROOT}/data/scenes/bodies/")
    path = tmp_path / "envisat.toml"
    path.write_text(scene.replace('"30 d"', '"4 d"'))
    result = run("propagate", "--full", path, "-o", tmp_path / "full.fits", "--count", "9")
    full, q_full = read(tmp_path / "full.fits")
    assert f"method {full['METHOD']}, {full['TORQEVAL']:.0f} torque evaluations" in result.stderr
    assert full["METHOD"] == "series" and full["MAXERR"] <= 1.1e-9
    run("propagate", path, "-o", tmp_path / "planned.fits", "--count", "9")
    planned, q_planned = read(tmp_path / "planned.fits")
    assert planned["METHOD"] == "splitting, few kicks per turn"
    assert_within(angle_rad(q_planned, q_full), planned["MAXERR"] + full["MAXERR"])
    assert planned["TORQEVAL"] < full["TORQEVAL"]
    for options, used in (["--full"], full["TORQEVAL"]), ([], planned["TORQEVAL"]):
        predicted = re.search(r"about (\S+) torque evaluations", run("plan", path, *options).stdout)
        assert predicted is None or used / 2 < float(predicted[1]) < used * 2


@pytest.mark.parametrize("scene", sorted((ROOT / "data/scenes").glob("*.toml")), ids=lambda path: path.stem)
def test_every_scene_keeps_what_its_file_promises(tmp_path, scene):
    """The whole scene as it is planned, against its full model to 1e-9 rad, which unit tests hold against another method."""
    rows = {}
    for kind, options in ("planned", []), ("full", ["--full"]):
        out = tmp_path / f"{kind}.fits"
        result = run("propagate", scene, "-o", out, "--count", "60", *options)
        header, q = rows[kind] = read(out)
        assert f"method {header['METHOD']}, {header['TORQEVAL']:.0f} torque evaluations" in result.stderr
        assert f"rows good to {header['MAXERR']:.1e} rad ({header['ERRORIS'][:20]}" in result.stderr
        assert header["METHOD"] in ("series", "splitting, few kicks per turn") and header["TORQEVAL"] > 0
        predicted = re.search(r"about (\S+) torque evaluations", run("plan", scene, *options).stdout)
        assert predicted is None or header["TORQEVAL"] / 2.2 < float(predicted[1]) < header["TORQEVAL"] * 2.2  # two digits
    accuracy_rad = float(re.search(r"accuracy +(\S+) rad", run("plan", scene).stdout)[1])
    assert rows["planned"][0]["MAXERR"] <= 1.01 * accuracy_rad and rows["full"][0]["MAXERR"] <= 1.1e-9
    assert_within(angle_rad(rows["planned"][1], rows["full"][1]), rows["planned"][0]["MAXERR"] + rows["full"][0]["MAXERR"])


@pytest.mark.parametrize("accuracy", ["1e-17 rad", "1e-14 rad"])
def test_an_accuracy_below_rounding_is_refused(tmp_path, accuracy):
    scene = (ROOT / "data/scenes/spin-up.toml").read_text().replace("bodies/", f"{ROOT}/data/scenes/bodies/")
    start = scene.index("accuracy")
    line = scene[start : scene.index("\n", start)]
    path = tmp_path / "scene.toml"
    path.write_text(scene.replace(line, f'accuracy = "{accuracy}"'))
    result = run("propagate", path, "-o", tmp_path / "a.fits", check=False)
    assert result.returncode in (1, 2) and not (tmp_path / "a.fits").exists()
