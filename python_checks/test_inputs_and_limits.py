"""Inputs from pipes, and what is too deep, too large, too many or oddly named: said at once, never a crash."""

import gzip
import json
import os
import resource
import subprocess
import threading
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from support import PROGRAM, ROOT, SPINNER, TOUTATIS, propagate, run

SHORT = ["--stop", "+1 d", "--count", "9"]
SCENE = ROOT / "data/scenes/envisat-month.toml"

# --- Read once -----------------------------------------------------------------------------------------------------


def through(way, path, arguments, tmp_path):
    """The program with a file in place of FILE, given it by a pipe of some kind."""
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    if way == "fifo":
        fifo = tmp_path / "fifo"
        os.mkfifo(fifo)
        writer = threading.Thread(target=lambda: fifo.write_bytes(path.read_bytes()), daemon=True)
        writer.start()
        place, options = fifo, {}
    else:
        place, options = "/dev/stdin", {"input": path.read_bytes()}
    command = [PROGRAM, *(place if word == "FILE" else str(word) for word in arguments)]
    result = subprocess.run(command, capture_output=True, timeout=60, env=environment, **options)
    if way == "fifo":
        fifo.unlink()
    return result


@pytest.mark.parametrize("way", ["fifo", "stdin"])
def test_inputs_may_be_pipes(tmp_path, way):
    case = tmp_path / "a.case"
    case.write_text("I 1 2 3\nq 1 0 0 0\nm 0.1 0.2 0.3\nt 0\nt 10\n")
    history = propagate(TOUTATIS, tmp_path / "rows.fits", *SHORT)
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.read_text().replace('"bodies/', f'"{SCENE.parent}/bodies/'))
    for path, arguments in [
        (TOUTATIS, ["info", "FILE"]),
        (TOUTATIS, ["propagate", "FILE", "-o", tmp_path / "out.csv", *SHORT]),
        (scene, ["propagate", "FILE", "-o", tmp_path / "out.csv", *SHORT]),
        (history, ["propagate", "FILE", "-o", tmp_path / "out.csv"]),
        (scene, ["plan", "FILE"]),
        (case, ["eval", "FILE"]),
        (case, ["bench", "FILE", "10"]),
        (history, ["compare", "FILE", TOUTATIS]),
        (TOUTATIS, ["compare", history, "FILE"]),
    ]:
        result = through(way, path, arguments, tmp_path)
        assert result.returncode == 0, (arguments, result.stderr)
        (tmp_path / "out.csv").unlink(missing_ok=True)


# --- Nesting, sizes, counts ------------------------------------------------------------------------------------------

DEEP = 50_000
DEEP_TOML = {
    "dotted key": "a" + ".a" * DEEP + " = 1",
    "dotted header": "[a" + ".a" * DEEP + "]\nb = 1",
    "dotted header of a list": "[[a" + ".a" * DEEP + "]]\nb = 1",
    "lists": "a = " + "[" * DEEP + "]" * DEEP,
    "inline tables": "a = " + "{a = " * DEEP + "1" + "}" * DEEP,
    "dotted inline tables": "a = " + ("{a" + ".a" * 99 + " = ") * (DEEP // 100) + "1" + "}" * (DEEP // 100),
    "quoted parts": "'a'" + ".'a'" * DEEP + " = 1",
    "behind a text": "s = '''\n\" [\n'''\nt = \"\\\"\" # \"\n" + "a" + ".a" * DEEP + " = 1",
}


@pytest.mark.parametrize("kind", DEEP_TOML)
@pytest.mark.parametrize("scene", [False, True])
def test_deep_nesting_is_refused(tmp_path, kind, scene):
    path = tmp_path / "deep.toml"
    path.write_text(("accuracy = '1 deg'\n" if scene else "") + DEEP_TOML[kind] + "\n")
    reads = "plan" if scene else "info"
    for command in ([reads, path], ["propagate", path, "-o", tmp_path / "out.csv", *SHORT]):
        result = run(*command, check=False)
        assert result.returncode == 2
        assert "nested more than 100 levels" in result.stderr
        assert f"deep.toml:{path.read_text()[:60].count(chr(10)) + 1}" in result.stderr


def test_brackets_and_dots_in_texts_are_no_nesting(tmp_path):
    path = tmp_path / "body.toml"
    odd = "source = '''" + "[{." * 200 + "''' # " + "[{." * 200
    path.write_text(SPINNER.replace('source = "a test"', odd))
    run("info", path)
    path.write_text(SPINNER.replace('"a test"', '"' + "[.\\\\\\\"" * 200 + '"'))
    run("info", path)


def test_deep_xml_is_no_crash(tmp_path):
    path = tmp_path / "deep.xml"
    deep = 10**6
    path.write_text('<apm id="CCSDS_APM_VERS" version="2.0"><header>' + "<a>" * deep + "</a>" * deep + "</header></apm>")
    assert run("info", path, check=False).returncode == 2


def limited(*arguments, megabytes=10_000):
    """The program within that much memory, and the seconds of processor time that it takes."""
    command = f"ulimit -v {megabytes * 1024}; exec \"$@\""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = subprocess.run(["bash", "-c", command, "bash", PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return result, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "zeros"
    with open(path, "wb") as file:
        file.truncate(10**9)
    result, takes = limited("info", path, megabytes=500)
    assert result.returncode == 2
    assert "is too large: at most 512 MiB" in result.stderr
    assert takes < 5


@pytest.mark.parametrize("way", ["pipe", "gzip"])
def test_a_stream_that_is_too_large_ends_at_the_limit(tmp_path, way):
    source = "/dev/zero"
    if way == "gzip":  # packs by less than a hundred, so that no other rule refuses it
        path = tmp_path / "a.gz"
        rows = np.random.default_rng(1).integers(97, 123, 16 << 20, dtype=np.uint8).tobytes()
        path.write_bytes(gzip.compress(rows, compresslevel=1) * 40)
        result, _ = limited("info", path, megabytes=2500)
    else:
        command = f"head -c 700000000 {source} | '{PROGRAM}' info /dev/stdin"
        result = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert result.returncode == 2
    assert "is too large: at most 512 MiB" in result.stderr


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_other_encodings_than_utf_8_are_named(tmp_path, encoding):
    path = tmp_path / "message.xml"
    text = (ROOT / "data/samples/ccsds/valid/AEMExample11.xml").read_text().replace("UTF-8", encoding)
    path.write_bytes(text.encode(encoding))
    result = run("info", path, check=False)
    assert result.returncode == 2
    assert f"polhode: {path}: is text in UTF-16 or UTF-32, and UTF-8 is read" in result.stderr


def test_what_follows_packed_data_is_not_passed_over(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits.gz", *SHORT)
    whole = out.read_bytes()
    out.write_bytes(whole + b"junk")
    result = run("info", out, check=False)
    assert result.returncode == 2 and f"{out}: something else follows the data that gzip packed" in result.stderr
    out.write_bytes(whole + bytes(512))  # the padding of tapes
    run("info", out)


def test_sums_of_fits_are_held_against_the_bytes(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", *SHORT)
    whole = out.read_bytes()
    assert "CHECKSUM" not in run("info", out).stdout
    damaged = bytearray(whole)
    damaged[-2880 + 3] ^= 1  # in the padding or the last rows
    out.write_bytes(damaged)
    result = run("propagate", out, "-o", tmp_path / "b.csv", check=False)
    assert result.returncode == 2 and f"polhode: {out}: DATASUM is " in result.stderr
    out.write_bytes(whole.replace(b"TUNIT1  = 's ", b"TUNIT1  = 'd ", 1))
    assert f"polhode: warning: {out}: CHECKSUM is wrong" in run("propagate", out, "-o", tmp_path / "b.csv").stderr


def test_a_rate_beyond_all_bodies_is_refused(tmp_path):
    """In degrees it would be infinite."""
    path = tmp_path / "rows.csv"
    rows = ["date_tt,q_x,q_y,q_z,q_scalar,omega_body_x_rad_s,omega_body_y_rad_s,omega_body_z_rad_s"]
    rows += [f"2000-01-01T12:00:0{second}.0,0,0,0,1,0,{rate},0" for second, rate in ((0, "0"), (2, "1e308"))]
    path.write_text("\n".join(rows) + "\n")
    result = run("propagate", path, "--history", "--count", 3, "-o", tmp_path / "rows.xml", check=False)
    assert result.returncode == 2
    assert ":3: row 2: the rate is 1e+308 rad/s, up to 1e+50 rad/s can be read" in result.stderr


def test_zeros_are_refused_quickly(tmp_path):
    path = tmp_path / "zeros"
    with open(path, "wb") as file:
        file.truncate(500_000_000)
    result, takes = limited("info", path, megabytes=1500)
    assert result.returncode == 2
    assert "no kind of file that is known" in result.stderr
    assert takes < 10


@pytest.mark.parametrize("ending", ["fits", "fits.gz", "aem", "xml", "csv", "ecsv", "jsonl"])
@pytest.mark.parametrize("count", ["18446744073709551615", "18446744073709551616", "1" + "0" * 40, "1000000000000001", "0", "-1", "1e3", "0x10", "ten"])
def test_counts_that_are_none(tmp_path, ending, count):
    result = run("propagate", TOUTATIS, "-o", tmp_path / f"a.{ending}", "--stop", "+1 d", f"--count={count}", check=False)
    assert result.returncode == 2
    assert "a whole number from 1 to 1000000000000000 is wanted" in result.stderr
    assert len(result.stderr) < 300
    assert list(tmp_path.iterdir()) == []


def test_counts_are_decimal(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.csv", "--stop", "+1 d", "--count", "010")
    assert len(out.read_text().splitlines()) == 11
    dates = run("convert-time", "--from", "TT", "--to", "TT", "--decimals", "010", input="2000-01-01\n").stdout
    assert dates == "2000-01-01T00:00:00.0000000000\n"
    case = tmp_path / "a.case"
    case.write_text("I 1 2 3\nq 1 0 0 0\nm 0.1 0.2 0.3\nt 0\nt 10\n")
    assert "count=10\n" in run("bench", case, "010").stdout


@pytest.mark.parametrize("scale", ["TDB", "TT", "UTC"])
def test_a_million_dates(tmp_path, scale):
    times = tmp_path / "times"
    seconds = np.arange(1_000_000)
    days = np.datetime64("2020-01-01T00:00:00.000") + (seconds * 61_001).astype("timedelta64[ms]")
    times.write_text("\n".join(np.datetime_as_string(days)) + "\n")
    result, takes = limited("propagate", TOUTATIS, "-o", tmp_path / "a.csv", "--times", times, "--scale", scale)
    assert result.returncode == 0, result.stderr
    assert takes < 6  # less than 2 s where nothing else runs; it was a minute
    with open(tmp_path / "a.csv") as file:
        assert sum(1 for _ in file) == 1_000_001


# --- Names -----------------------------------------------------------------------------------------------------------

NAMES = {
    "empty": ("", None),
    "blank": ("  \t ", None),
    "of 200 characters": ("nineteen letters in " * 10).strip(),
    "of 70, ending in blanks at the card's end": "x" * 66 + "  y" * 30,
    "with quotes": "the \"big\" one's 'other' name \\ back\\\\slash \"",
    "with many quotes": "'" * 150,
    "with brackets": "Sputnik [1]",
    "with ampersands": "&amp; <b> & AT&T &" + "&" * 70 + "x",  # astropy takes a last & away
    "with control characters": ("a\x01b\x7fc\nd\x85e\u2028f", "a b c d e f"),
    "with no characters": ("a\uffffb\ufffec\ufdd0d", "a b c d"),
    "beyond ASCII": "Čapek 石 🛰",
    "like syntax": "= : # --- [x] {y} , ; ",
}


@pytest.mark.parametrize("kind", NAMES)
def test_names_come_back(tmp_path, kind):
    """From our files by our reader and those of others."""
    given = NAMES[kind]
    name, wanted = given if isinstance(given, tuple) else (given, given.strip())
    body = tmp_path / "body.toml"
    quoted = '"' + "".join(f"\\U{ord(c):08X}" for c in name) + '"'
    body.write_text(SPINNER.replace('"spinner"', quoted))
    for ending in ("fits", "aem", "xml", "ecsv"):
        out = propagate(body, tmp_path / f"out.{ending}", *SHORT)
        again = json.loads(run("info", "--json", out).stdout)[0]
        found = again["history"]["object"]
        if wanted is None:
            assert found == ("" if ending in ("fits", "ecsv") else "unknown")
        elif ending == "fits":
            assert found == "".join(c if c.isascii() else "?" for c in wanted)
        else:
            assert found == wanted
        run("compare", out, body, "--tolerance", "1e-6 rad")
        if ending == "fits":
            with fits.open(out, checksum=True) as file:
                file.verify("exception")
                assert file["ATTITUDE"].header["OBJECT"] == found
        elif ending == "xml":
            assert ElementTree.parse(out).find(".//OBJECT_NAME").text == found
        elif ending == "ecsv":
            table = Table.read(out, format="ascii.ecsv")
            assert table.meta.get("object", "") == found


# --- Command line ------------------------------------------------------------------------------------------------------


def test_json_lines(tmp_path):
    rows = [json.loads(line) for line in propagate(TOUTATIS, tmp_path / "a.jsonl", *SHORT, "--momentum").read_text().splitlines()]
    table = Table.read(propagate(TOUTATIS, tmp_path / "a.csv", *SHORT, "--momentum"))
    assert len(rows) == len(table) == 9
    for row, line in zip(rows, table):
        assert list(row) == table.colnames
        assert list(row.values()) == list(line)


def test_endings_in_any_case(tmp_path):
    for ending in ("FITS", "Fits.GZ", "AEM", "XML", "CSV", "Ecsv", "JSONL"):
        out = propagate(TOUTATIS, tmp_path / f"A.{ending}", *SHORT)
        assert (out.read_bytes()[:2] == b"\x1f\x8b") == ending.endswith("GZ")


def test_version():
    assert run("--version").stdout.startswith("polhode 0.")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["propagat", TOUTATIS], "'propagat' is no subcommand; allowed are compare, chart, eval, info"),
        (["chart", "speed"], "'speed' is no subcommand; allowed are speed-accuracy, torqued, stability"),
        (["--frame", "ICRF"], "is no subcommand"),
        ([], "subcommand is required"),
    ],
)
def test_misspelt_subcommands(words, message):
    result = run(*words, check=False)
    assert result.returncode == 2
    assert message in result.stderr


def test_formats_that_are_none(tmp_path):
    assert "--format" in run("propagate", TOUTATIS, "-o", "-", *SHORT, check=False).stderr
    result = run("propagate", TOUTATIS, "-o", "-", *SHORT, "--format", "its", check=False)
    assert result.returncode == 2
    assert "'its' is no format" in result.stderr and ".jsonl" in result.stderr


def test_a_full_standard_output_is_status_3():
    for words in (["--help"], ["--version"], ["propagate", "--help"], ["methods"]):
        with open("/dev/full", "w") as full:
            assert subprocess.run([PROGRAM, *words], stdout=full, stderr=subprocess.DEVNULL).returncode == 3
