"""CCSDS messages, shapes and comparisons through the program: exit statuses, what info says, compare on our own files."""

import json

import numpy as np
import pytest
from support import ROOT, TOUTATIS, propagate, run

CCSDS = ROOT / "data/samples/ccsds"


@pytest.mark.parametrize("path", sorted((CCSDS / "valid").iterdir()), ids=lambda p: p.name)
def test_valid_messages_are_understood(path, tmp_path):
    result = run("info", "--json", path)
    (report,) = json.loads(result.stdout)
    # What cannot be propagated says why, and is refused: an attitude history goes no further than its last row.
    refused = run("propagate", path, "--stop", "+1000 d", "--step", "500 d", "-o", tmp_path / "out.csv", check=False)
    if report["missing"]:
        assert refused.returncode == 2
        assert report["missing"][0] in refused.stderr
    else:
        assert path.name == "APMExample12.txt" and refused.returncode == 0


@pytest.mark.parametrize("path", sorted((CCSDS / "invalid").iterdir()), ids=lambda p: p.name)
def test_invalid_messages_are_refused_with_their_line(path):
    result = run("info", path, check=False)
    assert result.returncode == 2 and result.stdout == ""
    assert f"{path}:" in result.stderr and result.stderr.split(f"{path}:")[1].split(":")[0].isdigit()


def test_euler_angles_of_an_apm():
    (report,) = json.loads(run("info", "--json", CCSDS / "valid/APMExample12.txt").stdout)
    q = np.array(report["state"]["q_frame_from_body_scalar_first"])
    half_z, half_x = np.radians([5.0, 10.0])  # ZXZ by 10, 20, 0 deg
    wanted = np.array([np.cos(half_z) * np.cos(half_x), np.cos(half_z) * np.sin(half_x),
                       np.sin(half_z) * np.sin(half_x), np.sin(half_z) * np.cos(half_x)])
    assert np.max(np.abs(q - wanted)) < 1e-15


def test_compare_reads_what_propagate_writes(tmp_path):
    options = ("--stop", "+20 d", "--count", "200")
    files = [propagate(TOUTATIS, tmp_path / f"t.{ending}", *options) for ending in ("fits", "aem", "xml", "ecsv")]
    for other in [*files[1:], TOUTATIS]:
        report = json.loads(run("compare", files[0], other, "--json", "--tolerance", "1e-9 rad").stdout)
        assert report["rows_compared"] == 200 and report["rows_outside"] == 0
        assert report["largest_rad"] < 1e-12
    # Another body: far away, and said so.
    assert run("compare", files[0], ROOT / "data/bodies/apophis.toml", "--tolerance", "1 deg", check=False).returncode == 1
    assert run("compare", TOUTATIS, TOUTATIS, check=False).returncode == 2
