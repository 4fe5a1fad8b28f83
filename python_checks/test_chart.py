"""`polhode chart` and its plots, at tiny sizes: tables that astropy reads, and figures that hold something."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from astropy.table import Table

ROOT = Path(__file__).resolve().parent.parent
POLHODE = os.environ.get("POLHODE", str(ROOT / "build/bin/polhode"))


def chart(folder, *arguments):
    subprocess.run([POLHODE, "chart", *arguments, "-o", str(folder)], check=True, capture_output=True, timeout=300)


def run_plot(*arguments, **options):
    command = [sys.executable, "-m", "polhode", "plot", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)


def plot(table):
    run = run_plot(table)
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.fixture(scope="module")
def speed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("speed")
    bodies = [f"{ROOT}/data/bodies/toutatis.toml@30d", f"{ROOT}/data/truth/dev/nearsphere-01.case@600"]
    chart(folder, "speed-accuracy", *bodies, "--size", "0.01")
    return folder / "speed-accuracy.ecsv"


def test_speed_accuracy_table_has_units_and_every_method(speed):
    table = Table.read(speed, format="ascii.ecsv")
    listed = subprocess.run([POLHODE, "methods"], check=True, capture_output=True, text=True).stdout
    names = {line for line in listed.splitlines() if line and not line.startswith(" ")}
    assert set(table["method"]) == names
    assert set(table["body"]) == {"toutatis", "nearsphere-01"}
    assert str(table["attitude_error"].unit) == "rad" and str(table["time"].unit) == "ns"
    assert table["span"][0] == 30 * 86400
    assert np.all(np.isfinite(table["attitude_error"]))
    theta = table[table["method"] == "theta"]
    assert np.all(theta["attitude_error"] < 1e-14)


def test_speed_accuracy_figures(speed):
    output = plot(speed)
    for name in ("speed-accuracy", "speed-accuracy-last", "speed-accuracy-evaluations", "speed-accuracy-main"):
        for ending in ("png", "svg"):
            assert (speed.parent / f"{name}.{ending}").stat().st_size > 10_000
    assert "| toutatis |" in output  # the table of how much faster theta is


def test_each_method_is_drawn_by_the_family_that_the_table_names(speed, tmp_path):
    table = Table.read(speed, format="ascii.ecsv")
    family = dict(zip(table["method"], table["family"]))
    known = {"exact", "splitting", "moser-veselov", "lie group", "adaptive", "quaternion"}
    assert set(family.values()) == known
    assert family["theta"] == "exact" and family["rk4"] == "quaternion"
    other = tmp_path / "other.ecsv"  # a family that has no style of its own
    other.write_text(speed.read_text().replace("lie group", "newcomers"))
    plot(other)
    assert "newcomers" in (tmp_path / "speed-accuracy-main.svg").read_text()


def test_torqued_table_and_figures(tmp_path):
    subjects = [f"{ROOT}/data/truth/torqued/toutatis-01.case@100000", f"{ROOT}/data/scenes/relaxing.toml@20min"]
    chart(tmp_path, "torqued", *subjects, "--size", "0.01")
    table = Table.read(tmp_path / "torqued.ecsv", format="ascii.ecsv")
    assert set(table["body"]) == {"toutatis-01", "relaxing"}
    assert set(table["kind"]) == {"to an accuracy", "exact kernel", "other kernel", "general"}
    assert np.all(np.isfinite(table["attitude_error"])) and np.all(table["reference_error"] <= 1e-14)
    assert np.all(table["kept_evaluations"] <= table["evaluations"])
    best = {method: min(table["attitude_error"][table["method"] == method]) for method in set(table["method"])}
    assert best["auto"] < 1e-9 and best["fehlberg-78"] < 1e-9
    output = plot(tmp_path / "torqued.ecsv")
    for name in ("torqued", "torqued-last", "torqued-evaluations", "torqued-last-evaluations", "torqued-main"):
        for ending in ("png", "svg"):
            assert (tmp_path / f"{name}.{ending}").stat().st_size > 10_000
    assert "| toutatis-01 |" in output  # the table of the cheapest


def test_without_a_body_the_standard_ones_are_charted(tmp_path):
    chart(tmp_path, "speed-accuracy", "--size", "0.01")
    table = Table.read(tmp_path / "speed-accuracy.ecsv", format="ascii.ecsv")
    assert set(table["body"]) == {"toutatis", "t-handle", "envisat", "apophis", "needle", "near-sphere"}
    assert np.all(table["attitude_error"][table["method"] == "theta"] < 1e-14)


def test_stability_table_and_figures(tmp_path):
    chart(tmp_path, "stability", "--size", "0.02")
    table = Table.read(tmp_path / "stability.ecsv", format="ascii.ecsv")
    assert set(table["outcome"]) <= {"answered", "failed", "too long", "undetermined"}
    theta = table[table["method"] == "theta"]
    assert set(theta["outcome"]) <= {"answered", "undetermined"}
    plot(tmp_path / "stability.ecsv")
    for name in set(table["map"]):
        assert (tmp_path / f"stability-{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "arguments",
    [
        ["speed-accuracy", "no-such-file.toml"],
        ["speed-accuracy", f"{ROOT}/data/bodies/toutatis.toml@-5d"],
        ["speed-accuracy", f"{ROOT}/data/bodies/toutatis.toml@soon"],
        ["speed-accuracy", f"{ROOT}/data/truth/dev/rest-01.case"],
        ["torqued", f"{ROOT}/data/truth/dev/sam-01.case"],  # no torque
        ["torqued", f"{ROOT}/data/scenes/relaxing.toml@0s"],
        ["stability", "--size", "-1"],
        ["stability", "--size", "nan"],
        ["nonsense"],
    ],
)
def test_bad_arguments_are_refused(tmp_path, arguments):
    run = subprocess.run([POLHODE, "chart", *arguments, "-o", str(tmp_path / "out")], capture_output=True, text=True)
    assert run.returncode in (2, 3)
    assert run.stderr.strip()
    assert not list(tmp_path.glob("out/*.ecsv"))


def lines_of(table):
    text = table.read_text().splitlines(keepends=True)
    head = next(i for i, line in enumerate(text) if not line.startswith("#"))
    return text[: head + 1], text[head + 1 :]


def test_a_table_that_is_not_whole_is_refused_in_one_line(speed, tmp_path):
    """As an interrupted copy leaves it."""
    head, rows = lines_of(speed)
    for cut in ([], head[:3], head[:-1], head, [*head, rows[0]], [*head, *rows[:-1], rows[-1][:9]]):
        table = tmp_path / "cut.ecsv"
        table.write_text("".join(cut))
        run = run_plot(table, "-o", tmp_path / "out")
        assert run.returncode == 2 and run.stderr.count("\n") == 1, (len(cut), run.stderr)
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name, status", [("none.ecsv", 3), (".", 3), ("text.ecsv", 2), ("bytes.ecsv", 2)])
def test_files_that_are_no_table_are_refused(tmp_path, name, status):
    (tmp_path / "text.ecsv").write_text("a table\n")
    (tmp_path / "bytes.ecsv").write_bytes(b"\xff\xfe\x00")
    run = run_plot(name, cwd=tmp_path)
    assert run.returncode == status and run.stderr.count("\n") == 1, run.stderr
    assert run.stderr.startswith("polhode: ")


def test_figures_that_cannot_be_written(speed, tmp_path):
    (tmp_path / "file").write_text("")
    run = run_plot(speed, "-o", tmp_path / "file")
    assert run.returncode == 3 and run.stderr.count("\n") == 1, run.stderr


def test_a_chart_without_a_row_is_an_error(tmp_path):
    command = [POLHODE, "chart", "torqued", ROOT / "data/scenes/envisat-month.toml", "--size", "0.01", "-o", tmp_path / "charts"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert result.returncode == 1, result.stderr
    left_out, none = result.stderr.splitlines()
    assert left_out.startswith("polhode: envisat-month is left out: its reference did not reach the end within 1000")
    assert none == "polhode: no table is written, as everything is left out; take a shorter FILE@SPAN or a larger --size"
    assert not (tmp_path / "charts").exists()


def seconds_of(*arguments):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([POLHODE, "chart", *arguments], check=True, capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def test_the_least_size_takes_seconds(tmp_path):
    """A map of stability took half a minute; a reference under torques was allowed too little to reach the end."""
    assert seconds_of("stability", "-o", tmp_path, "--size", "0.01") < 10
    chart(tmp_path, "torqued", f"{ROOT}/data/scenes/envisat-month.toml@6h", "--size", "0.01")
    assert len(Table.read(tmp_path / "torqued.ecsv", format="ascii.ecsv")) > 0
