"""`polhode plot`: what it draws and calls it, from any folder, and how it ends where it cannot."""

import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from astropy.io import fits
from support import PROGRAM, ROOT, SPINNER, T_HANDLE, TOUTATIS, propagate

import polhode
from polhode import InputError
from polhode import plot as plotting


def plot(*arguments, **options):
    environment = {**os.environ, "POLHODE_PYTHON": sys.executable}
    return subprocess.run([PROGRAM, "plot", *arguments], capture_output=True, text=True, env=environment, **options)


def assert_one_line(result, status):
    """Ends with the status, and says why in one line."""
    assert result.returncode == status, result.stderr
    assert result.stderr.startswith("polhode: ") and result.stderr.count("\n") == 1, result.stderr


@pytest.fixture(scope="module")
def ephemeris(tmp_path_factory):
    return propagate(TOUTATIS, tmp_path_factory.mktemp("plot") / "a.fits", "--stop", "+60 d", "--step", "1 h")


@pytest.mark.parametrize("ending, begin", [("PNG", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_of_an_ephemeris(tmp_path, ephemeris, ending, begin):
    result = plot(ephemeris, "-o", tmp_path / f"a.{ending}")
    assert result.returncode == 0, result.stderr
    picture = (tmp_path / f"a.{ending}").read_bytes()
    assert picture.startswith(begin)
    if ending == "svg":
        assert b"<!-- long-axis mode, moments 0.3091 : 0.9532 : 1 -->" in picture  # matplotlib's comment on each text


def body_file(path, moments="[1.0, 2.0, 3.0]", rate="[0.0, 0.0, 9.0]"):
    path.write_text(SPINNER.replace("[1.0, 2.0, 3.0]", moments).replace("[0.0, 0.0, 9.0]", rate))
    return path


@pytest.mark.parametrize(
    "moments, rate, called",
    [
        ("[1.0, 2.0, 3.0]", "[0.0, 0.0, 9.0]", "rotation about the short axis"),
        ("[1.0, 2.0, 2.5]", "[9.0, 0.0, 0.0]", "rotation about the long axis"),
        ("[1.0, 2.0, 2.5]", "[0.0, 9.0, 0.0]", "rotation about the intermediate axis"),
        ("[2.0, 2.0, 3.0]", "[3.0, 0.0, 9.0]", "short-axis mode of a symmetric body"),
        ("[1.0, 3.0, 3.0]", "[3.0, 0.0, 9.0]", "long-axis mode of a symmetric body"),
        ("[2.0, 2.0, 3.0]", "[0.0, 0.0, 9.0]", "rotation about the axis of symmetry"),
        ("[2.0, 2.0, 2.0]", "[3.0, 0.0, 9.0]", "rotation of a sphere"),
        ("[1.0, 2.0, 2.5]", "[3.0, 0.0, 9.0]", "short-axis mode"),
    ],
)
def test_the_motion_is_called_what_it_is(tmp_path, moments, rate, called):
    name, _ = plotting.mode(plotting.rows_of(body_file(tmp_path / "b.toml", moments, rate)))
    assert name == called


def colours(path):
    """How often each colour is in a PNG."""
    import matplotlib.pyplot as plt

    image = (plt.imread(path)[:, :, :3] * 255).round().astype(int)
    found, count = np.unique(image.reshape(-1, 3), axis=0, return_counts=True)
    return dict(zip(map(tuple, found), count))


def test_a_fixed_axis_is_a_point_on_both_spheres(tmp_path):
    result = plot(body_file(tmp_path / "b.toml"), "-o", "b.png", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert colours(tmp_path / "b.png").get((0xC2, 0x45, 0x2D), 0) > 200


def test_it_runs_by_the_package_as_by_the_program_from_any_folder(tmp_path):
    command = [sys.executable, "-m", "polhode", "plot", T_HANDLE, "-o", "b.png"]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")
    assert plot(T_HANDLE, "-o", "c.png", cwd=tmp_path).returncode == 0
    assert (tmp_path / "c.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_python_that_is_not_there(tmp_path):
    result = subprocess.run([PROGRAM, "plot", T_HANDLE], capture_output=True, text=True, env={"POLHODE_PYTHON": str(tmp_path / "none")})
    assert_one_line(result, 3)


def test_a_motion_and_its_file_make_one_picture(tmp_path, ephemeris):
    of_file = plotting.rows_of(ephemeris)
    of_body = plotting.rows_of(TOUTATIS)
    assert (of_body.object, of_body.frame) == (of_file.object, of_file.frame)
    assert np.allclose(of_body.moments, of_file.moments) and np.allclose(of_body.momentum[0], of_file.momentum[0], atol=1e-12)
    assert np.allclose(of_body.momentum_direction, of_file.momentum_direction, atol=1e-12)
    assert np.allclose(of_body.long_axis[0], of_file.long_axis[0], atol=1e-12)
    assert len(plotting.body(polhode.read(TOUTATIS)).axes) >= 3


@pytest.mark.parametrize(
    "out, status", [("/dev/full", 3), ("none/a.png", 3), (".", 3), ("a.jpg", 2), ("a", 2)]
)
def test_outputs_that_cannot_be(tmp_path, ephemeris, out, status):
    assert_one_line(plot(ephemeris, "-o", out, cwd=tmp_path), status)
    assert not list(tmp_path.iterdir())
    assert not os.path.exists("/dev/full.png")


def test_dev_stdout_gets_the_picture(tmp_path, ephemeris):
    command = [sys.executable, "-m", "polhode", "plot", ephemeris, "-o", "/dev/stdout"]
    result = subprocess.run(command, capture_output=True, cwd=tmp_path)
    assert result.returncode == 0 and result.stdout.startswith(b"\x89PNG"), result.stderr


def changed(ephemeris, path, change):
    with fits.open(ephemeris) as file:
        change(file["ATTITUDE"])
        file.writeto(path, checksum=True)
    return path


def value(column, what):
    def change(table):
        table.data[column][3] = what

    return change


def keyword(name, what=None):
    def change(table):
        if what is None:
            del table.header[name]
        else:
            table.header[name] = what

    return change


def rename(old, new):
    return lambda table: table.columns.change_name(old, new)


@pytest.mark.parametrize(
    "change, word",
    [
        (value("QPARAM", float("nan")), "QPARAM"),
        (value("OMEGA", float("inf")), "OMEGA"),
        (value("OMEGA", 0.0), "rest"),
        (value("QPARAM", 0.0), "QPARAM"),
        (value("TIME", 0.0), "TIME"),
        (keyword("INERTIA2"), "INERTIA2"),
        (keyword("INERTIA2", -1.0), "INERTIA"),
        (keyword("INERTIA2", "two"), "INERTIA2"),
        (keyword("QPRINC3"), "QPRINC3"),
        (keyword("TIMESYS", "ET"), "TIMESYS"),
        (keyword("TIMESYS"), "TIMESYS"),
        (keyword("MJDREF"), "MJDREF"),
        (keyword("QORDER", "SXYZ"), "QORDER"),
        (keyword("EXTNAME", "OTHER"), "ATTITUDE"),
        (rename("OMEGA", "RATE"), "OMEGA"),
        (rename("TIME", "T"), "TIME"),
    ],
)
def test_tables_that_are_not_ours(tmp_path, ephemeris, change, word):
    with pytest.raises(InputError, match=word):
        plotting.rows_of_file(changed(ephemeris, tmp_path / "b.fits", change))


@pytest.mark.parametrize("ending", ["fits", "fits.gz"])
def test_truncated_ephemerides(tmp_path, ending):
    whole = propagate(TOUTATIS, tmp_path / f"whole.{ending}", "--stop", "+60 d", "--step", "1 h").read_bytes()
    cut = tmp_path / f"cut.{ending}"
    for size in (0, 1, 79, 80, 2879, 2880, 2881, 5760, 8640, 12000, 50000, len(whole) * 9 // 10):
        cut.write_bytes(whole[:size])
        with pytest.raises(InputError):
            plotting.rows_of_file(cut)


def test_a_damaged_byte_is_seen(tmp_path, ephemeris):
    damaged = bytearray(ephemeris.read_bytes())
    damaged[-5000] ^= 1
    (tmp_path / "b.fits").write_bytes(damaged)
    with pytest.raises(InputError, match="damaged"):
        plotting.rows_of_file(tmp_path / "b.fits")


@pytest.mark.parametrize("name, status", [("none.fits", 3), (".", 3), ("/dev/null", 3), ("cut.fits", 2), ("text.fits", 2), ("picture.png", 2)])
def test_files_that_are_no_ephemeris(tmp_path, ephemeris, name, status):
    (tmp_path / "cut.fits").write_bytes(ephemeris.read_bytes()[:20000])
    (tmp_path / "text.fits").write_text("not FITS\n")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG" + struct.pack(">Q", 0))
    assert_one_line(plot(name, "-o", "out.png", cwd=tmp_path), status)
    assert not (tmp_path / "out.png").exists()


def test_what_is_there_keeps_its_mode_and_its_link(tmp_path, ephemeris):
    target = tmp_path / "target.png"
    target.write_bytes(b"old")
    target.chmod(0o600)
    (tmp_path / "link.png").symlink_to("target.png")
    assert plot(ephemeris, "-o", tmp_path / "link.png").returncode == 0
    assert (tmp_path / "link.png").is_symlink() and target.read_bytes().startswith(b"\x89PNG")
    assert target.stat().st_mode & 0o777 == 0o600


def test_a_scene_is_drawn_as_far_as_it_lasts(tmp_path):
    result = plot(ROOT / "data/scenes/spin-up.toml", "-o", tmp_path / "a.svg")  # 1800 s, twenty turns would be 3500 s
    assert result.returncode == 0, result.stderr
    assert b"2025-01-01 00:00:00 to 2025-01-01 00:30:00" in (tmp_path / "a.svg").read_bytes()
