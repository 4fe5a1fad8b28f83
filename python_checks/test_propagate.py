"""polhode propagate as a command: what it refuses, how it says so, and that nothing is left behind."""

import os
import pty
import re
import signal
import subprocess
import time

import pytest
from support import PROGRAM, TOUTATIS, leap_second_kernel, propagate, run

SPAN = ("--stop", "+1 d", "--step", "1 h")


@pytest.mark.parametrize(
    "options, message",
    [
        (("-o", "out.fits"), "one of --step and --count"),
        (("-o", "out.fits", "--step", "60"), "--stop is missing"),
        (("-o", "out.dat", *SPAN), "names no format"),
        (("-o", "out.fits", "--stop", "+1 d", "--step", "0"), "positive"),
        (("-o", "out.fits", "--stop", "+1 d", "--step", "-60"), "positive"),
        (("-o", "out.fits", "--stop", "+1 d", "--step", "nan"), "span of time"),
        (("-o", "out.fits", "--stop", "+1 d", "--step", "60 parsec"), "s, min, h, d"),
        (("-o", "out.fits", "--stop", "1992-02-30 TDB", "--step", "60"), "1992-02-30"),
        (("-o", "out.fits", "--stop", "1980-01-01 TDB", "--step", "60"), "before start"),
        (("-o", "out.fits", "--stop", "+1 d", "--step", "1e-12"), "rows"),
        (("-o", "out.fits", "--stop", "+1 d", "--count", "0"), "--count"),
        (("-o", "out.fits", *SPAN, "--frame", "nonsense"), "ICRF"),
        (("-o", "out.fits", *SPAN, "--scale", "nonsense"), "TDB"),
        (("-o", "out.fits", *SPAN, "--method", "nonsense"), "auto"),
        (("-o", "out.aem", *SPAN, "--attitude-type", "SPIN"), "QUATERNION"),
        (("-o", "out.aem", *SPAN, "--adm", "3.0"), "2.0"),
        (("-o", "out.aem", *SPAN, "--adm", "1.0", "--attitude-type", "QUATERNION/ANGVEL"), "ADM 1.0"),
        (("-o", "out.aem", *SPAN, "--attitude-type", "EULER_ANGLE", "--euler-sequence", "XXZ"), "XXZ"),
        (("-o", "out.fits", "--times", "2000-01-01 TDB,tomorrow"), "tomorrow"),
        (("-o", "out.fits", *SPAN, "--start", "+1 d", "--start", "+2 d", "--stop", "+1 d"), "which only these hold: .aem .txt (CCSDS AEM), .xml"),
        (("-o", "out.fits", *SPAN, "--unknown"), "--unknown"),
    ],
)
def test_bad_usage_is_refused(tmp_path, options, message):
    result = run("propagate", TOUTATIS, *options, check=False, cwd=tmp_path)
    assert result.returncode == 2
    assert message in result.stderr + result.stdout
    assert list(tmp_path.iterdir()) == []


def test_a_fault_in_a_list_of_times_names_its_line(tmp_path):
    (tmp_path / "times").write_text("# instants\n2000-01-01 TDB\n\n2000-01-32 TDB\n")
    result = run("propagate", TOUTATIS, "-o", "out.fits", "--times", "times", check=False, cwd=tmp_path)
    assert result.returncode == 2
    assert "times:4: " in result.stderr
    assert not (tmp_path / "out.fits").exists()


@pytest.mark.parametrize("out", ["none/out.fits", "folder.csv", "device.fits", "device.csv"])
def test_what_cannot_be_written_is_status_3(tmp_path, out):
    (tmp_path / "folder.csv").mkdir()
    for ending in ("fits", "csv"):
        (tmp_path / f"device.{ending}").symlink_to("/dev/full")
    result = run("propagate", TOUTATIS, "-o", out, *SPAN, check=False, cwd=tmp_path)
    assert result.returncode == 3
    assert "cannot write" in result.stderr


def test_an_existing_file_is_replaced_whole(tmp_path):
    out = tmp_path / "out.csv"
    out.write_text("old")
    propagate(TOUTATIS, out, *SPAN)
    assert len(out.read_text().splitlines()) == 26
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.parametrize("ending", ["fits", "aem", "csv"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_leaves_nothing(tmp_path, ending, number):
    out = tmp_path / f"out.{ending}"
    process = subprocess.Popen(
        [PROGRAM, "propagate", TOUTATIS, "-o", out, "--stop", "+10000 d", "--step", "0.01"], stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 20
    while not any(tmp_path.iterdir()):  # the hidden file has begun
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.01)
    time.sleep(0.2)
    process.send_signal(number)
    _, stderr = process.communicate(timeout=20)
    assert process.returncode == -number  # as if it had not been caught
    assert "not written" in stderr
    assert list(tmp_path.iterdir()) == []


def test_no_progress_line_without_a_terminal(tmp_path):
    result = run("propagate", TOUTATIS, "-o", tmp_path / "out.csv", *SPAN)
    assert "\r" not in result.stderr
    assert result.stdout == ""


def test_progress_on_a_terminal(tmp_path):
    """Part, rate and time left; Ctrl-C typed at it takes the line away and leaves nothing."""
    ours, its = pty.openpty()
    command = [PROGRAM, "propagate", TOUTATIS, "-o", tmp_path / "out.fits", "--stop", "+100000 d", "--step", "0.01"]
    process = subprocess.Popen(
        command, stderr=its, stdin=its, start_new_session=True, preexec_fn=lambda: os.close(os.open(os.ttyname(its), os.O_RDWR))
    )
    os.close(its)
    text = b""
    while not re.search(rb"left", text):
        text += os.read(ours, 4096)
    assert re.fullmatch(rb"\r\x1b\[Kpolhode:  *0\.\d %, [\d.e+]+ rows/s, \d+:\d\d:\d\d left", text), text
    os.write(ours, b"\x03")
    end = b""
    while b"not written" not in end:
        end += os.read(ours, 4096)
    assert re.search(rb"\r\x1b\[K.*polhode: stopped; .*out.fits is not written", end, re.S), end
    assert process.wait(timeout=20) == -signal.SIGINT
    assert list(tmp_path.iterdir()) == []
    os.close(ours)


@pytest.mark.parametrize("ending", ["fits", "aem"])
def test_memory_does_not_grow_with_the_rows(tmp_path, ending):
    peaks = []
    for rows in (100_000, 1_000_000):
        command = [PROGRAM, "propagate", TOUTATIS, "-o", tmp_path / f"out.{ending}", "--stop", "+1000 d", "--count", str(rows)]
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss)  # kB; the longer one writes 64 or 178 MB
    assert peaks[1] < peaks[0] + 4000


def test_doubtful_utc_is_said_and_a_table_can_be_given(tmp_path):
    out = tmp_path / "out.csv"
    spans = {
        "not known": ("--start", "2090-01-01 UTC", "--stop", "+1 d", "--step", "12 h"),
        "1960": ("--start", "1950-01-01", "--stop", "+1 d", "--step", "12 h", "--scale", "UTC"),
    }
    for word, span in spans.items():
        assert word in run("propagate", TOUTATIS, "-o", out, *span).stderr
    kernel = leap_second_kernel(tmp_path / "naif.tls", extra=[(2035, 7, 38.0)])
    span = ("--start", "2035-06-30T23:59:59", "--stop", "+2 s", "--step", "1", "--scale", "UTC")
    run("propagate", TOUTATIS, "-o", out, *span, "--leap-seconds", kernel)
    dates = [line.split(",")[0] for line in out.read_text().splitlines()[1:]]
    assert dates == ["2035-06-30T23:59:59.000", "2035-06-30T23:59:60.000", "2035-07-01T00:00:00.000"]


def test_the_same_input_gives_the_same_bytes(tmp_path):
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "0"}
    texts = []
    for name in "ab":
        run("propagate", TOUTATIS, "-o", tmp_path / f"{name}.fits", "--stop", "+30 d", "--step", "60", env=environment)
        texts.append((tmp_path / f"{name}.fits").read_bytes())
        time.sleep(1.1)  # no clock but the given one is asked
    assert texts[0] == texts[1]


def test_a_name_alone_is_a_file_here(tmp_path):
    for name in ("a.fits", "a.csv", "./b.aem"):
        run("propagate", TOUTATIS, "-o", name, "--stop", "+1 d", "--count", "3", cwd=tmp_path)
        assert (tmp_path / name).is_file()
    refused = run("propagate", TOUTATIS, "-o", "nowhere/a.csv", "--stop", "+1 d", "--count", "3", cwd=tmp_path, check=False)
    assert refused.returncode == 3 and "there is no folder" in refused.stderr
