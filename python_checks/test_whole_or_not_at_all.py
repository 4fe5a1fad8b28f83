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


@pytest.fixture
def start():
    """Starts a program; what still runs when the test ends is killed."""
    started = []

    def one(command, **options):
        started.append(subprocess.Popen(command, **options))
        return started[-1]

    yield one
    for process in started:
        process.kill()
        process.communicate()


def begun(process, folder, begins_with=b"", least_bytes=1):
    """Waits until there are hidden files of that many bytes in all, of those that begin so."""
    deadline = time.monotonic() + 60
    begins_so = lambda path: path.open("rb").read(len(begins_with)) == begins_with
    while sum(path.stat().st_size for path in folder.glob(".polhode-*") if begins_so(path)) < least_bytes:
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.005)


def ending_signals():
    """Every signal that can be caught and ends a program unless it is."""
    harmless = {"SIGKILL", "SIGSTOP", "SIGCHLD", "SIGCLD", "SIGCONT", "SIGTSTP", "SIGTTIN", "SIGTTOU", "SIGURG", "SIGWINCH", "SIGXFSZ"}
    return sorted(s for s in signal.valid_signals() if not (isinstance(s, signal.Signals) and s.name in harmless))


@pytest.mark.parametrize("number", ending_signals())
def test_a_signal_ends_the_program_and_leaves_nothing(tmp_path, start, number):
    command = [PROGRAM, "propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--stop", "+10000 d", "--step", "0.01"]
    # The tests themselves may run under nohup, which lets the program inherit an ignored signal.
    not_ignored = lambda: signal.signal(number, signal.SIG_DFL)
    process = start(command, stderr=subprocess.PIPE, text=True, preexec_fn=not_ignored)
    begun(process, tmp_path)
    process.send_signal(number)
    _, stderr = process.communicate(timeout=20)
    assert process.returncode == -number
    assert "a.csv is not written" in stderr
    assert list(tmp_path.iterdir()) == []


def test_ignored_signals_stay_ignored(tmp_path, start):
    """As under nohup."""
    out = tmp_path / "a.csv"
    process = start(
        [PROGRAM, "propagate", TOUTATIS, "-o", out, "--stop", "+60 d", "--count", "3000000"],
        stderr=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )
    begun(process, tmp_path)
    process.send_signal(signal.SIGHUP)
    assert process.wait(timeout=120) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("times", [1, 2])
def test_compression_can_be_interrupted(tmp_path, start, times):
    rows = 2_000_000
    command = [PROGRAM, "propagate", TOUTATIS, "-o", tmp_path / "a.fits.gz", "--stop", "+60 d", "--count", str(rows)]
    not_ignored = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    process = start(command, stderr=subprocess.DEVNULL, preexec_fn=not_ignored)
    begun(process, tmp_path, begins_with=b"\x1f\x8b", least_bytes=2_000_000)  # gzip has packed a fiftieth of it
    for _ in range(times):
        process.send_signal(signal.SIGINT)
    asked = time.monotonic()
    assert process.wait(timeout=60) == -signal.SIGINT
    assert list(tmp_path.iterdir()) == []
    assert time.monotonic() - asked < 5


@pytest.mark.parametrize("redirection", ["2>&-", "2>/dev/full", "2> >(true)"])
@pytest.mark.parametrize("body", ["bodies/toutatis.toml", "bodies/mms.toml"])
def test_standard_error_does_not_matter(tmp_path, redirection, body):
    out = tmp_path / "a.csv"
    script = f"'{PROGRAM}' propagate '{TOUTATIS.parent.parent / body}' -o '{out}' --stop '+1 d' --count 9 --scale UTC {redirection}"
    result = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert result.returncode == 0
    assert len(out.read_text().splitlines()) == 10


SHORT = ["--stop", "+1 d", "--count", "9"]


def test_the_mode_is_kept(tmp_path):
    for ending in ("csv", "fits", "fits.gz"):
        out = tmp_path / f"a.{ending}"
        for mode in (0o600, 0o664, 0o640):
            out.write_text("old")
            out.chmod(mode)
            run("propagate", TOUTATIS, "-o", out, *SHORT)
            assert out.stat().st_size > 3
            assert out.stat().st_mode & 0o7777 == mode


def test_a_read_only_file_stays(tmp_path):
    out = tmp_path / "a.csv"
    out.write_text("old")
    out.chmod(0o444)
    result = run("propagate", TOUTATIS, "-o", out, *SHORT, check=False)
    assert result.returncode == 3
    assert "read-only" in result.stderr
    assert out.read_text() == "old"


def test_links_are_followed(tmp_path):
    (tmp_path / "folder").mkdir()
    there, hop, dangling = tmp_path / "folder/there.csv", tmp_path / "hop.csv", tmp_path / "dangling.csv"
    hop.symlink_to("folder/there.csv")
    dangling.symlink_to("hop.csv")
    for _ in range(2):  # without and with the file at its end
        run("propagate", TOUTATIS, "-o", dangling, *SHORT)
        assert dangling.is_symlink() and hop.is_symlink() and not there.is_symlink()
        assert len(there.read_text().splitlines()) == 10
    circle = tmp_path / "circle.csv"
    circle.symlink_to("circle.csv")
    assert run("propagate", TOUTATIS, "-o", circle, *SHORT, check=False).returncode == 3


@pytest.mark.parametrize("ending", [".csv", ".fits", ".fits.gz"])
def test_names_as_long_as_the_system_takes(tmp_path, ending):
    out = tmp_path / ("n" * (255 - len(ending)) + ending)
    run("propagate", TOUTATIS, "-o", out, *SHORT)
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    result = run("propagate", TOUTATIS, "-o", tmp_path / ("n" * 256 + ending), *SHORT, check=False)
    assert result.returncode == 3
    assert "File name too long" in result.stderr


@pytest.mark.parametrize("ending", ["fits", "fits.gz", "aem", "xml", "csv", "ecsv", "jsonl"])
def test_pipes_devices_and_standard_output_are_written_to(tmp_path, ending):
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    command = [PROGRAM, "propagate", TOUTATIS, *SHORT, "--format", ending, "-o"]
    wanted = tmp_path / f"a.{ending}"
    subprocess.run([*command, wanted], check=True, env=environment, capture_output=True)
    for name in ("-", "/dev/stdout", "/dev/fd/1"):
        result = subprocess.run([*command, name], capture_output=True, env=environment)
        assert result.returncode == 0, result.stderr
        assert result.stdout == wanted.read_bytes()
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    with subprocess.Popen(["cat", fifo], stdout=subprocess.PIPE) as reader:
        subprocess.run([*command, fifo], check=True, env=environment, capture_output=True)
        assert reader.communicate()[0] == wanted.read_bytes()
    assert fifo.is_fifo()
    subprocess.run([*command, "/dev/null"], check=True, capture_output=True)
    result = subprocess.run([*command, "/dev/full"], capture_output=True, text=True)
    assert result.returncode == 3
    assert "No space left on device" in result.stderr
    both = tmp_path / "both"
    script = f"echo before; '{PROGRAM}' propagate '{TOUTATIS}' -o - --format {ending} --stop '+1 d' --count 9; echo after"
    with open(both, "w") as file:
        subprocess.run(["sh", "-c", script], check=True, stdout=file, stderr=subprocess.DEVNULL, env=environment)
    assert both.read_bytes() == b"before\n" + wanted.read_bytes() + b"after\n"


def test_a_reader_that_goes_ends_it_quietly():
    script = f"'{PROGRAM}' propagate '{TOUTATIS}' -o - --format csv --stop '+1000 d' --step 0.1 | head -3; echo ${{PIPESTATUS[0]}}"
    result = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=60)
    assert result.stdout.splitlines()[-1] == str(128 + signal.SIGPIPE)
    assert result.stderr == ""


def test_gzip_takes_any_name_and_length(tmp_path):
    """The rows are not held in memory."""
    out = tmp_path / "a[1](2)+{3}@!.fits.gz"
    peaks = []
    for rows in (60_000, 600_000):
        command = [PROGRAM, "propagate", TOUTATIS, "-o", out, "--stop", "+60 d", "--count", str(rows)]
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss)
    assert peaks[1] < peaks[0] + 8000  # kB; the table has 38 MB
