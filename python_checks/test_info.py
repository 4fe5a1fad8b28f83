"""polhode info: published figures in its answers, and what it refuses with which exit status."""

import json

import numpy
import pytest
from scipy.integrate import solve_ivp
from support import ROOT, run

BODIES = ROOT / "data/bodies"


def info(*arguments):
    return run("info", *arguments, check=False)


def test_toutatis_and_apophis_have_their_published_figures():
    result = info("--json", BODIES / "toutatis.toml", BODIES / "apophis.toml")
    assert result.returncode == 0, result.stderr
    toutatis, apophis = json.loads(result.stdout)
    motion = toutatis["motion"]
    assert motion["mode"] == "long-axis mode"
    assert motion["polhode_period_s"] / 86400 == pytest.approx(5.3685, abs=5e-5)
    assert motion["long_axis"]["precession_period_s"] / 86400 == pytest.approx(7.4117, abs=5e-5)
    assert motion["momentum_ecliptic_deg"] == pytest.approx([181.03, -53.62], abs=0.005)
    # Zhao et al. 2015, MNRAS: 5.38 d, 7.40 d, (180.2, -54.75) deg.
    assert motion["polhode_period_s"] / 86400 == pytest.approx(5.38, abs=0.02)
    assert motion["long_axis"]["precession_period_s"] / 86400 == pytest.approx(7.40, abs=0.02)
    assert motion["momentum_ecliptic_deg"] == pytest.approx([180.2, -54.75], abs=1.2)
    # Lee et al. 2022: 264.178 h, 27.38547 h, (275, -85) deg; E/E0 derived from them.
    motion = apophis["motion"]
    assert motion["mode"] == "short-axis mode"
    assert motion["polhode_period_s"] / 3600 == pytest.approx(264.178, abs=1e-6)
    assert motion["long_axis"]["precession_period_s"] / 3600 == pytest.approx(27.38547, abs=1e-7)
    assert motion["momentum_ecliptic_deg"] == pytest.approx([275, -85], abs=1e-6)
    assert 1 + motion["energy_above_ground_relative"] == pytest.approx(1.0188, abs=5e-5)


def test_text_says_mode_periods_and_direction():
    text = info(BODIES / "toutatis.toml").stdout
    for words in ("long-axis mode", "5.36853 d", "7.411652 d", "181.030, -53.621 deg", "ratios only"):
        assert words in text


def test_the_first_flip_is_where_the_rate_about_the_intermediate_axis_passes_zero():
    motion = json.loads(info("--json", BODIES / "t-handle.toml").stdout)[0]["motion"]
    moments = numpy.array([1.2070835e-4, 2.7005881e-5, 1.4355145e-4])  # x is the intermediate axis
    rate = numpy.array([120.0, 0.2, 0.05]) * 2 * numpy.pi / 60

    def euler(_, omega):
        return numpy.cross(moments * omega, omega) / moments

    def crossing(_, omega):
        return omega[0]

    crossing.terminal = True
    path = solve_ivp(euler, (0, 100), rate, method="DOP853", rtol=1e-12, atol=1e-14, events=crossing)
    assert motion["first_flip_after_epoch_s"] == pytest.approx(path.t_events[0][0], rel=1e-8)


@pytest.mark.parametrize(
    "text, line, message",
    [
        ("", 0, "empty"),
        ("name = 'a'\n[inertia]\nmoments = [1, 2, 4]\nunit = 'ratios'\n", 3, "exceed the sum"),
        ("name = 'a'\n[inertia]\nmoments = [3, 4, 5]\nunit = 'ratios'\nshort_axis = 'x'\n", 5, "about x is 3"),
        ("name = 'a'\n[inertia]\nmoments = [1, 2, 'x']\nunit = 'ratios'\n", 3, "a finite number is wanted"),
        ("name = 'a'\n[inertia]\nmoments = [1, 2, nan]\nunit = 'ratios'\n", 3, "a finite number is wanted"),
        ("name = 'a'\n[inertia]\nmoments = [1, 2, 3]\nunit = 'pounds'\n", 4, "allowed: kg m2"),
        ("name = 'a'\nmass = 3\n", 2, "unknown key"),
        ("source = 'b'\n", 1, "name: this key is missing"),
        ("\x00\x01", 0, "no kind of file that is known"),
        ("251 -63\n2451545.0 10\n", 0, "no kind of file that is known"),
        ("name = 'a'\n\x00\x01", 2, "not valid TOML"),
    ],
)
def test_wrong_input_is_one_message_and_status_2(tmp_path, text, line, message):
    path = tmp_path / "body.toml"
    path.write_text(text)
    result = info(path)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.startswith(f"polhode: {path}:{line}: " if line else f"polhode: {path}: ")
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_files_that_are_none(tmp_path):
    assert info(tmp_path).returncode == 2
    assert info(tmp_path / "absent.toml").returncode == 3
    assert info().returncode == 2
