"""A kill at any moment and a full disk: never a truncated file under the final name."""

import os
import random
import re
import shutil
import signal
import subprocess
import time

import pytest
from astropy.io import fits
from support import PROGRAM, TOUTATIS, run

ROWS = 60000


def is_whole(path):
    if path.suffix == ".fits":
        with fits.open(path, checksum=True) as file:
            return len(file["ATTITUDE"].data) == ROWS and file["ATTITUDE"].verify_datasum() == 1
    text = path.read_text()
    if path.suffix == ".csv":
        return text.endswith("\n") and text.count("\n") == ROWS + 1
    return text.endswith("DATA_STOP\n") and len(re.findall(r"^\d{4}-", text, re.M)) == ROWS


KILLS = 34  # of each format: a hundred in all


@pytest.mark.parametrize("ending", ["fits", "aem", "csv"])
def test_killed_at_random_moments(tmp_path, ending):
    seed = 20260101
    moments = random.Random(seed)
    command = [PROGRAM, "propagate", TOUTATIS, "-o", None, "--stop", "+60 d", "--count", str(ROWS)]
    command[4] = tmp_path / f"whole.{ending}"
    begin = time.monotonic()
    subprocess.run(command, check=True, capture_output=True)
    takes = time.monotonic() - begin
    whole = absent = 0
    for i in range(KILLS):
        out = command[4] = tmp_path / f"{i}.{ending}"
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        time.sleep(moments.uniform(0, 1.2 * takes))
        process.send_signal(signal.SIGKILL)
        process.wait()
        if out.exists():
            assert is_whole(out), f"seed {seed}, run {i}"
            whole += 1
            out.unlink()
        else:
            absent += 1
        for left in tmp_path.glob(".polhode-*"):
            left.unlink()
    assert absent > 0, "no kill came in time"


@pytest.mark.parametrize("ending", ["fits", "fits.gz", "aem", "csv"])
def test_file_size_limit(tmp_path, ending):
    """RLIMIT_FSIZE, which every system has, stands for a full disk."""
    out = tmp_path / f"a.{ending}"
    command = f"ulimit -f 300; exec {PROGRAM} propagate {TOUTATIS} -o {out} --stop '+60 d' --count {ROWS}"
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert result.returncode == 3, result.stderr
    assert "cannot write" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", ["fits", "fits.gz", "aem", "csv"])
def test_full_disk(tmp_path, ending):
    if shutil.which("unshare") is None:
        pytest.skip("no unshare on this machine")
    as_root = [] if os.geteuid() == 0 else ["--map-root-user"]
    script = f"mount -t tmpfs -o size=1m none {tmp_path} || exit 77; \
        {PROGRAM} propagate {TOUTATIS} -o {tmp_path}/a.{ending} --stop '+60 d' --count {ROWS}; \
        echo status $?; ls -A {tmp_path}"
    result = subprocess.run(["unshare", "--mount", *as_root, "sh", "-c", script], capture_output=True, text=True)
    if result.returncode == 77 or "status" not in result.stdout:
        pytest.skip(f"a small tmpfs cannot be mounted here: {result.stderr.strip()[:100]}")
    assert result.stdout == "status 3\n", result.stdout  # and nothing is left
    assert "No space left on device" in result.stderr


def test_gzip_is_fits_inside(tmp_path):
    out = tmp_path / "a.fits.gz"
    run("propagate", TOUTATIS, "-o", out, "--stop", "+60 d", "--count", ROWS)
    assert out.read_bytes()[:2] == b"\x1f\x8b"
    with fits.open(out, checksum=True) as file:
        assert len(file["ATTITUDE"].data) == ROWS


def test_gzip_refuses_what_memory_cannot_hold(tmp_path):
    result = run("propagate", TOUTATIS, "-o", tmp_path / "a.fits.gz", "--stop", "+60 d", "--count", 10**9, check=False)
    assert result.returncode == 2
    assert "64.00 GB, all held in memory" in result.stderr and "Write .fits" in result.stderr
    assert list(tmp_path.iterdir()) == []
