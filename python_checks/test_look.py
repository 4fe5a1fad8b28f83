"""Pictures of what an observer sees: `polhode look`, and light curves by `polhode plot`."""

import os
import subprocess
import sys

import numpy as np
import pytest
from support import PROGRAM, ROOT, TOUTATIS, run

import polhode
from polhode import InputError, lightcurve, look

WAY = ROOT / "data/scenes/trajectories/toutatis-sun.oem"
PHOTOMETRY = ROOT / "data/observations/toutatis-photometry-1992.csv"


def python(*arguments, **options):
    environment = {**os.environ, "POLHODE_PYTHON": sys.executable}
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, env=environment, **options)


def test_north_is_up_and_east_to_the_left():
    sky = look.Sky(np.array([-1.0, 0, 0]))  # a target at right ascension 0, declination 0
    assert np.allclose(sky(np.array([0, 0, 1.0])), [0, 1, 0])  # north
    assert np.allclose(sky(np.array([0, 1.0, 0])), [-1, 0, 0])  # east
    assert np.allclose(sky(np.array([-1.0, 0, 0])), [0, 0, 1])  # towards the observer


def test_the_ellipsoid_is_closed_and_looks_outwards():
    vertices, facets = look.ellipsoid(np.array([3.0, 2.0, 1.0]))
    volume = polhode.Mesh(vertices, facets).mass_properties().volume  # refuses what is open or inside out
    assert abs(volume / (4 / 3 * np.pi * 6) - 1) < 5e-3


def test_what_is_drawn_is_as_large_as_the_lit_area():
    """The facets that are drawn and lit cover the area that observe() finds."""
    from matplotlib.collections import PolyCollection

    motion = polhode.read(TOUTATIS).motion()
    time, axes = 30 * 86400.0, [1.2, 0.96, 2.3]
    figure = look.picture(motion, [motion.epoch + time], WAY, shape=axes, name="Toutatis")
    (collection,) = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
    dark = collection.get_facecolor()[:, 0] <= look.DARK + 1e-6
    area = 0.0
    for path, is_dark in zip(collection.get_paths(), dark):
        (ax, ay), (bx, by), (cx, cy) = path.vertices[:3]
        area += 0.0 if is_dark else 0.5 * abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
    wanted = motion.observe(time, WAY, shape=axes)["area_m2"]
    assert abs(area / wanted - 1) < 0.05


def test_a_strip_by_the_program(tmp_path):
    result = python("look", TOUTATIS, "--target", WAY, "--shape", "1.2 0.96 2.3 km", "--start", "1992-12-08 UTC",
                    "--step", 7200, "--count", 7, "-o", tmp_path / "a.svg")  # fmt: skip
    assert result.returncode == 0, result.stderr
    text = (tmp_path / "a.svg").read_text()
    assert "1992-12-08 12:00:00 UTC" in text and "4179 Toutatis" in text
    mesh = ROOT / "data/samples/mesh/box.ply"
    result = python("look", TOUTATIS, "--target", WAY, "--shape", mesh, "--start", "1992-12-08 UTC", "-o", tmp_path / "b.png")
    assert result.returncode == 0 and (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG"), result.stderr


@pytest.mark.parametrize(
    "options, word",
    [
        (["--count", 0], "instants"),
        (["--start", "1980-01-01 UTC"], "trajectory"),
        (["--site", "1 2"], "--site"),
        (["-o", "a.jpg"], "picture"),
        (["--shape", "none.obj"], "none.obj"),
    ],
)
def test_looks_that_are_refused(tmp_path, options, word):
    usual = {"--target": WAY, "--shape": "1 2 3 km", "--start": "1992-12-08 UTC", "-o": "a.png"}
    usual.update(dict(zip(options[::2], options[1::2])))
    result = python("look", TOUTATIS, *[x for pair in usual.items() for x in pair], cwd=tmp_path)
    assert result.returncode in (2, 3) and word in result.stderr and result.stderr.count("\n") == 1, result.stderr
    assert not list(tmp_path.iterdir())


def test_light_curves(tmp_path):
    out = tmp_path / "model.ecsv"
    run("observe", TOUTATIS, "--times", PHOTOMETRY, "-o", out, "--scale", "UTC", "--shape", "1.2 0.96 2.3 km")
    assert lightcurve.is_light_curve(out) and not lightcurve.is_light_curve(PHOTOMETRY)
    result = python("plot", out, "-o", tmp_path / "a.png")
    assert result.returncode == 0 and (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG"), result.stderr
    figure = lightcurve.picture(out, "7.35 d")
    drawn = figure.axes[0].lines[-1].get_xdata()
    assert len(drawn) == 202 and 0 <= drawn.min() and drawn.max() < 1
    upper, lower = figure.axes[0].get_ylim()
    assert upper > lower  # bright is up
    for fold in ("0 h", "7 weeks", "x"):
        with pytest.raises(InputError, match="--fold"):
            lightcurve.picture(out, fold)
    assert python("plot", TOUTATIS, "--fold", "1 h", "-o", tmp_path / "b.png").returncode == 2
