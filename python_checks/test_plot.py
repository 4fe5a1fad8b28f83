"""The picture script runs on an ephemeris and on a body file."""

import os
import subprocess
import sys

import pytest
from support import PROGRAM, ROOT, T_HANDLE, TOUTATIS, propagate


def plot(argument, out):
    environment = {**os.environ, "POLHODE": str(PROGRAM)}
    return subprocess.run(
        [sys.executable, ROOT / "tools/plot_body.py", argument, "-o", out], capture_output=True, text=True, env=environment
    )


def test_of_an_ephemeris(tmp_path):
    result = plot(propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+60 d", "--step", "1 h"), tmp_path / "a.png")
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("body", [T_HANDLE])
def test_of_a_body_file(tmp_path, body):
    result = plot(body, tmp_path / "b.png")
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")
