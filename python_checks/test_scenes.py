"""Scenes: what plan says, and propagate against an integration of the equations of motion that is not ours."""

import numpy as np
from astropy.table import Table
from support import ROOT, angle_rad, assert_within, run

SCENES = ROOT / "data/scenes"


def test_plan_says_what_is_kept_and_dropped():
    text = run("plan", SCENES / "spin-up.toml").stdout
    rows = {line.split("  ")[0]: line for line in text.splitlines()}
    assert " kept " in rows["constant torque"]
    assert " dropped " in rows["linear damping"]
    assert "dropped" not in run("plan", "--full", SCENES / "spin-up.toml").stdout.replace("which dropped effects", "")
    assert "horizon" in run("plan", SCENES / "apophis-2029.toml").stdout


def test_spin_up_follows_the_equations_of_motion(tmp_path):
    out = tmp_path / "spin-up.fits"
    run("propagate", SCENES / "spin-up.toml", "-o", out, "--step", "100 s")
    table = Table.read(out, 1)
    q = np.asarray(table["QPARAM"])[:, [3, 0, 1, 2]]
    assert len(q) == 19

    moments, torque = np.array([70.0, 100.0, 120.0]), np.array([0.0007, 0.0014, -0.0008])

    def rate(y):
        w = y[4:] / moments
        s, v = y[0], y[1:4]
        return np.concatenate(([-v @ w / 2], (s * w + np.cross(v, w)) / 2, np.cross(y[4:], w) + torque))

    y = np.concatenate(([1.0, 0.0, 0.0, 0.0], moments * np.radians([2.0, 0.3, 0.2])))
    expected, h = [y[:4]], 0.1
    for _ in range(18):
        for _ in range(1000):  # the classical Runge-Kutta method
            a = rate(y)
            b = rate(y + h / 2 * a)
            c = rate(y + h / 2 * b)
            y = y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))
        expected.append(y[:4])
    assert_within(angle_rad(q, np.array(expected)), 1e-7)


def test_a_scene_refuses_what_it_does_not_cover(tmp_path):
    wrong = (["--frame", "ECLIPJ2000", "--step", "60 s"], ["--method", "theta"], ["--stop", "+2 h", "--step", "60 s"])
    for options in wrong:
        result = run("propagate", SCENES / "spin-up.toml", "-o", tmp_path / "x.fits", *options, check=False)
        assert result.returncode == 2, (options, result.stderr)
        assert not (tmp_path / "x.fits").exists()
