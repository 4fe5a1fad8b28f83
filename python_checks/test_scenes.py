"""Scenes: what plan says, and propagate against an integration of the equations of motion that is not ours."""

import re
import resource

import astropy.units as u
import numpy as np
import pytest
from astropy.table import QTable, Table
from astropy.time import Time
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation
from support import ROOT, angle_rad, assert_within, run

SCENES = ROOT / "data/scenes"


def test_plan_says_what_is_kept_and_dropped():
    text = run("plan", SCENES / "spin-up.toml").stdout
    rows = {line.split("  ")[0]: line for line in text.splitlines()}
    assert " kept " in rows["constant"]
    assert " dropped " in rows["linear damping"]
    assert "dropped" not in run("plan", "--full", SCENES / "spin-up.toml").stdout.replace("which dropped effects", "")
    assert "the attitude is known to 1 deg" in run("plan", SCENES / "apophis-2029.toml").stdout


@pytest.mark.parametrize("scene", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_each_scene_is_propagated_as_it_stands(tmp_path, scene):
    """To its very ends, in whatever time scale the rows are evenly spaced."""
    for options in [], ["--count", "50"], ["--count", "50", "--scale", "TT"]:
        out = tmp_path / f"{len(options)}.fits"
        run("propagate", scene, "-o", out, *options)
        q = np.asarray(Table.read(out, 1)["QPARAM"])
        assert len(q) == 50 or not options
        assert_within(np.abs(np.linalg.norm(q, axis=1) - 1.0), 1e-15)


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


def test_toutatis_on_a_trajectory_follows_the_equations_of_motion(tmp_path):
    """Through the approach of December 1992, the trajectories read and interpolated by other code."""
    zero = Time("1992-11-09T17:49:47", scale="utc").tdb

    def trajectory(name):
        lines = (SCENES / "trajectories" / name).read_text().splitlines()
        rows = [line.split() for line in lines[lines.index("META_STOP") + 1 :] if line]
        t = (Time([row[0] for row in rows], scale="tdb") - zero).sec
        states = np.array([row[1:] for row in rows], float) * 1e3
        c, s = np.cos(np.radians(84381.448 / 3600)), np.sin(np.radians(84381.448 / 3600))
        ecliptic = np.array([[1, 0, 0], [0, c, s], [0, -s, c]]).T
        return CubicHermiteSpline(t, states[:, :3] @ ecliptic, states[:, 3:] @ ecliptic)

    masses = ((3.986004418e14, trajectory("toutatis-earth.oem")), (1.32712440018e20, trajectory("toutatis-sun.oem")))
    moments = np.array([3.0836, 3.235, 1.0])

    def rate(t, y):
        R, w = Rotation.from_quat(y[:4]).as_matrix(), y[4:]
        torque = np.zeros(3)
        for mu, place in masses:
            r = R.T @ place(t)
            torque += 3 * mu / np.linalg.norm(r) ** 5 * np.cross(r, moments * r)
        return np.concatenate(((y[3] * w + np.cross(y[:3], w)) / 2, [-y[:3] @ w / 2],
                               (np.cross(moments * w, w) + torque) / moments))  # fmt: skip

    q = Rotation.from_euler("ZXZ", [145.498, 65.865, 241.524], degrees=True).as_quat()
    start = np.concatenate((q, np.radians([14.51, 33.529, -98.709]) / 86400))
    days = np.arange(0.0, 41.0, 10.0)
    scale = np.array([1.0] * 4 + [1e-5] * 3)
    solution = solve_ivp(rate, (0, 40 * 86400), start, "DOP853", days * 86400, rtol=1e-10, atol=1e-11 * scale)

    out = tmp_path / "toutatis.fits"
    run("propagate", "--full", SCENES / "toutatis-1992-2008.toml", "-o", out, "--stop", "+40 d", "--step", "10 d")
    found = np.asarray(Table.read(out, 1)["QPARAM"])[:, [3, 0, 1, 2]]
    assert_within(angle_rad(found, solution.y[[3, 0, 1, 2]].T), 1e-6)


def test_a_trajectory_written_by_astropy_is_the_orbit_it_was_made_from(tmp_path):
    scene = (SCENES / "librator.toml").read_text().replace("bodies/", f"{SCENES}/bodies/")
    start = scene.index("periapsis_m")
    elements = scene[start : scene.index("[[torque]]")]
    seconds = np.arange(-600.0, 88000.0, 60.0)
    angle = np.sqrt(3.986004418e14 / 7.0e6**3) * seconds
    table = QTable({"time": Time("2025-01-01T00:00:00", scale="tdb") + seconds * u.s})
    table["x"], table["y"], table["z"] = 7000.0 * np.cos(angle) * u.km, 7000.0 * np.sin(angle) * u.km, 0.0 * angle * u.km
    table.write(tmp_path / "orbit.ecsv", format="ascii.ecsv")
    (tmp_path / "elements.toml").write_text(scene)
    (tmp_path / "table.toml").write_text(scene.replace(elements, 'trajectory = "orbit.ecsv"\n'))
    attitudes = []
    for name in ("elements", "table"):
        run("propagate", tmp_path / f"{name}.toml", "-o", tmp_path / f"{name}.fits", "--step", "1 h")
        attitudes.append(np.asarray(Table.read(tmp_path / f"{name}.fits", 1)["QPARAM"])[:, [3, 0, 1, 2]])
    assert_within(angle_rad(*attitudes), 2e-5)  # two runs to 1e-3 deg


def test_a_scene_refuses_what_it_does_not_cover(tmp_path):
    wrong = (["--frame", "ECLIPJ2000", "--step", "60 s"], ["--method", "theta"], ["--stop", "+2 h", "--step", "60 s"])
    for options in wrong:
        result = run("propagate", SCENES / "spin-up.toml", "-o", tmp_path / "x.fits", *options, check=False)
        assert result.returncode == 2, (options, result.stderr)
        assert not (tmp_path / "x.fits").exists()


def test_a_scene_ends_where_it_says(tmp_path):
    scene = SCENES / "spin-up.toml"  # 30 minutes
    for options, rows in [(["--step", "600 s"], 4), (["--start", "+10 min", "--step", "600 s"], 3), (["--start", "+10 min", "--count", "5"], 5)]:
        run("propagate", scene, "-o", tmp_path / "a.fits", *options)
        times = Table.read(tmp_path / "a.fits", 1)["TIME"]
        assert len(times) == rows
        last = times[-1]
        run("propagate", scene, "-o", tmp_path / "whole.fits", "--count", "2")
        assert abs(last - Table.read(tmp_path / "whole.fits", 1)["TIME"][-1]) < 1e-6
    for options in ["--stop", "+1 h", "--count", "2"], ["--start", "-1 s", "--count", "2"], ["--stop", "+1 h", "--tolerance", "1 deg"], ["--times", "2050-01-01 TT"]:
        refused = run("propagate", scene, "-o", tmp_path / "b.fits", *options, check=False)
        assert refused.returncode == 2 and not (tmp_path / "b.fits").exists()
        assert f"{scene}: the scene lasts from " in refused.stderr and "stop or times" in refused.stderr


def test_plan_says_the_users_units(tmp_path):
    text = run("plan", SCENES / "envisat-month.toml").stdout
    assert "from the epoch (0 s to 30 d)" in text and "accuracy   0.0175 rad (1 deg)" in text
    assert " deg), of which dropped effects " in text


def test_toutatis_keeps_what_its_body_says_of_the_periods():
    text = run("plan", SCENES / "toutatis-1992-2008.toml").stdout
    assert "the attitude is known to 1 deg (one sigma) not even at the epoch" in text
    assert "what is asked for lies beyond that, up to 16 years from the epoch" in text


def changed(folder, name, *changes):
    """A scene with its files' absolute paths, and regular expressions replaced in it."""
    text = (SCENES / f"{name}.toml").read_text()
    for old, new in [(r'(body|trajectory) = "', rf'\1 = "{SCENES}/'), (r"(period_uncertainty|\w+_sigma) = .*\n", ""), *changes]:
        text, found = re.subn(old, new, text)
        assert found or "_sigma" in old
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("periapsis_m = 3.*", "periapsis_m = 5e-324", "orbit.earth.periapsis_m: "),
        ("to_periapsis = .-0.5.*", "to_periapsis = [0, 0, 0]", "orbit.earth.to_periapsis: the direction of periapsis is (0, 0, 0)"),
        ("mu_m3_s2 = 3.*", "mu_m3_s2 = nan", "orbit.earth.mu_m3_s2: "),
    ],
)
def test_what_bounds_an_effect_by_no_number_is_refused(tmp_path, old, new, message):
    scene = changed(tmp_path, "apophis-2029", (old, new))
    for command in (["plan", scene], ["propagate", scene, "-o", tmp_path / "a.fits", "--count", "2"]):
        result = run(*command, check=False)
        assert result.returncode == 2 and message in result.stderr and f"{scene}:" in result.stderr
    assert not (tmp_path / "a.fits").exists()


@pytest.mark.parametrize("place, message", [("1e308", "holds a number that is not finite"), ("0", "is where the mass is")])
def test_a_trajectory_through_no_place_is_refused(tmp_path, place, message):
    lines = (SCENES / "trajectories/toutatis-earth.oem").read_text().splitlines()
    rows = [i for i, line in enumerate(lines) if re.match(r"\d{4}-", line)]
    for i in rows[4:5] if place == "1e308" else rows:
        words = lines[i].split()
        lines[i] = " ".join([words[0], place, *([place] * 2 if place == "0" else words[2:4]), *words[4:]])
    (tmp_path / "earth.oem").write_text("\n".join(lines) + "\n")
    body = re.sub(r"\w+_sigma = .*\n", "", (ROOT / "data/bodies/toutatis.toml").read_text())
    (tmp_path / "toutatis.toml").write_text(body)
    places = [(r'body = ".*"', f'body = "{tmp_path}/toutatis.toml"'), (r'"[^"]*toutatis-earth.oem"', f'"{tmp_path}/earth.oem"')]
    result = run("plan", changed(tmp_path, "toutatis-1992-2008", *places), check=False)
    assert result.returncode == 2 and f"{tmp_path}/earth.oem:" in result.stderr and message in result.stderr


@pytest.mark.parametrize(
    "name, old, new",
    [
        ("apophis-2029", "periapsis_m = 3.*", "periapsis_m = 1e3"),
        ("apophis-2029", "eccentricity = 4.*", "eccentricity = 1e100"),
        ("apophis-2029", "mu_m3_s2 = 3.*", "mu_m3_s2 = 1e300"),
        ("relaxing", "after = .*", 'after = "1e9 d"'),
        ("relaxing", "after = .*", 'after = "1e10 d"'),
    ],
)
def test_plan_ends_within_seconds(tmp_path, name, old, new):
    scene = changed(tmp_path, name, (old, new))
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (5, 5))
    result = run("plan", scene, check=False, preexec_fn=limit)
    assert result.returncode in (0, 2) and str(scene) in (result.stderr or str(scene))


def test_a_mesh_must_say_where_the_centre_of_mass_is(tmp_path):
    sunlight = (
        f'[[torque]]\nkind = "sunlight"\nmesh = "{ROOT}/data/samples/mesh/box.obj"\nunit_m = 1.0\nspecular = 0.3\n'
        'diffuse = 0.2\norbit = "earth"\n{}[[torque]]'
    )
    for key, status in [("", 2), ('centre_of_mass = "mesh origin"\n', 0)]:
        scene = changed(tmp_path, "envisat-month", (r"(?s)\[\[torque\]\].*", sunlight.replace("{}[[torque]]", key)))
        result = run("plan", scene, check=False)
        assert result.returncode == status, result.stderr
        assert "centre_of_mass: this key is missing" in result.stderr or status == 0
