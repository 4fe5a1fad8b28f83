"""SIGMA and COV, and the horizons of info, against clones drawn from the published uncertainties; what files say of them."""

import json
import pickle

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from scipy.spatial.transform import Rotation
from support import ROOT, assert_within, run

import polhode

DAY = 86400.0
BODIES = ROOT / "data/bodies"
TOUTATIS = BODIES / "toutatis.toml"
TUMBLER = """name = "of periods"
[inertia]
moments = [0.61, 0.965, 1.0]
moments_sigma = [0.003, 0.0004, 0.0]
unit = "ratios"
[spin]
epoch = "2012-12-23T00:00:00 TDB"
frame = "ECLIPJ2000"
unit = "deg"
lambda = 250.0
beta = -75.0
phi0 = 152.0
psi0 = 14.0
lambda_sigma = 0.9
beta_sigma = 0.6
phi0_sigma = 0.5
psi0_sigma = 0.5
convention = "long-axis"
mode = "short-axis"
period_unit = "h"
P_phi = 27.38
P_psi = 263.0
P_phi_sigma = 0.003
P_psi_sigma = 0.2
"""
PRODUCTS = """name = "with products"
[inertia]
moments = [70.0, 100.0, 120.0]
moments_sigma = [0.5, 0.3, 0.2]
products = [1.0, -2.0, 3.0]
products_sigma = [0.3, 0.2, 0.2]
products_are = "tensor elements"
unit = "kg m2"
[state]
epoch = "2025-01-01T00:00:00 TDB"
frame = "ICRF"
[state.attitude]
euler_angles = [10.0, 20.0, 30.0]
euler_angles_sigma = [0.5, 0.5, 0.5]
sequence = "ZXZ"
unit = "deg"
[state.angular_velocity]
components = [2.0, 0.3, 0.2]
axes = "body"
unit = "deg/s"
[uncertainty]
parameters = ["components.x", "components.z"]
covariance = [[1e-6, 5e-7], [5e-7, 1e-6]]
"""


class Clones:
    """Bodies with other values of the published numbers, moved by the package's free motion."""

    def __init__(self, body, count, seed=1):
        self.nominal = body.motion()
        uncertainty = body.uncertainty
        rng = np.random.default_rng(seed)
        draws = rng.multivariate_normal(uncertainty.values, uncertainty.covariance, count)
        moments, axes, q, momenta = [], [], [], []
        for draw in draws:
            clone = uncertainty.body(draw)
            inertia = clone.inertia
            moments.append(inertia.principal_moments)
            axes.append(inertia.named_from_principal)
            q.append(clone.q)
            momenta.append(inertia.principal_moments * (inertia.named_from_principal.T @ clone.omega))
        self.axes = Rotation.from_matrix(np.array(axes))
        ecliptic = Rotation.from_quat(polhode.frame_rotation(body.frame, "ICRF"), scalar_first=True) if body.frame != "ICRF" else Rotation.identity()
        principal = ecliptic * Rotation.from_quat(np.array(q), scalar_first=True) * self.axes
        self.free = polhode.FreeMotion(np.array(moments), principal.as_quat(scalar_first=True), np.array(momenta))

    def turns(self, t):
        """Of each clone from the body, a vector in body axes, rad."""
        named = Rotation.from_quat(self.free(float(t)).q, scalar_first=True) * self.axes.inv()
        return (self.nominal(float(t)).rotation.inv() * named).as_rotvec()

    def sigma(self, t):
        return np.sqrt(np.linalg.eigvalsh(np.cov(self.turns(t).T))[-1])


def read(folder, text):
    path = folder / "body.toml"
    path.write_text(text)
    return polhode.read(path)


def sigma_of(motion, t):
    return np.sqrt(np.linalg.eigvalsh(motion.covariance(t))[..., -1])


def bodies_with_uncertainties():
    return [path.name for path in sorted(BODIES.glob("*.toml")) if polhode.read(path).uncertainty]


def test_the_bodies_whose_papers_print_uncertainties_have_them():
    assert "toutatis.toml" in bodies_with_uncertainties() and "apophis.toml" in bodies_with_uncertainties()


@pytest.mark.parametrize("name", [*bodies_with_uncertainties(), "periods", "products"])
def test_sigma_is_that_of_clones(tmp_path, name):
    """Within 5 % where it is below 0.1 rad and the linear picture holds. 4000 clones are good to 1 %."""
    body = {"periods": TUMBLER, "products": PRODUCTS}.get(name)
    body = read(tmp_path, body) if body else polhode.read(BODIES / name)
    clones = Clones(body, 4000)
    turn = 2.0 * np.pi / np.linalg.norm(body.omega)
    horizon = min(body.known_until(0.1), 1e5 * turn)
    looked = 0
    for t in horizon * np.array([0.0, 0.01, 0.1, 0.3, 0.6, 0.98]):
        linear = sigma_of(body.motion(), t)
        if 1e-9 < linear < 0.1:
            looked += 1
            assert abs(clones.sigma(t) / linear - 1.0) < 0.05, (t, linear)
    assert looked > 0 or horizon == 0.0
    if horizon > 0.0:  # the horizon is where the clones have that sigma
        assert abs(clones.sigma(horizon) / 0.1 - 1.0) < 0.06


def test_covariances_of_an_array_of_times(tmp_path):
    motion = read(tmp_path, PRODUCTS).motion()
    times = np.linspace(-1e4, 1e4, 3000).reshape(2, 1500)
    matrices = motion.covariance(times, threads=2)
    assert matrices.shape == (2, 1500, 3, 3)
    assert_within(matrices - np.swapaxes(matrices, -1, -2), 0.0)
    assert_within(matrices[1, 7] - motion.covariance(times[1, 7]), 1e-15)
    with pytest.raises(polhode.InputError, match="no uncertainty"):
        polhode.read(BODIES / "envisat.toml").motion().covariance(0.0)


def test_covariance_at_the_epoch_goes_with_the_partials(tmp_path):
    """Of a body whose principal axes are exact: P C P^T."""
    body = read(tmp_path, TUMBLER)
    motion = body.motion()
    for t in 0.0, 3e6:
        partials = motion.partials(t)[:3]
        expected = partials @ body.covariance @ partials.T
        assert_within(motion.covariance(t) - expected, 1e-12 * np.linalg.norm(expected))


@pytest.mark.parametrize("ending", ["fits", "csv", "ecsv", "jsonl"])
def test_columns_of_covariances(tmp_path, ending):
    out = tmp_path / f"a.{ending}"
    result = run("propagate", TOUTATIS, "-o", out, "--covariance", "--stop", "+80 d", "--count", "11")
    motion = polhode.read(TOUTATIS).motion()
    expected = motion.covariance(np.linspace(0.0, 80 * DAY, 11))
    six = expected[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    names = [f"cov_{element}_rad2" for element in ("xx", "xy", "xz", "yy", "yz", "zz")]
    if ending == "fits":
        table = Table.read(out, 1)
        sigma, found = table["SIGMA"], table["COV"]
        assert table["SIGMA"].unit == "rad" and table["COV"].unit == "rad2"
        said = " ".join(str(card) for card in fits.getheader(out, 1)["COMMENT"])
    else:
        rows = [json.loads(line) for line in out.read_text().splitlines()] if ending == "jsonl" else None
        table = Table(rows) if rows else Table.read(out, format=f"ascii.{ending}")
        sigma, found = table["sigma_rad"], np.array([table[name] for name in names]).T
        said = out.read_text() if ending == "ecsv" else result.stderr
    assert_within(np.abs(np.asarray(found) - six), 1e-6 * np.abs(six).max())  # TT is within ms of TDB
    assert_within(np.abs(np.asarray(sigma) - np.sqrt(np.linalg.eigvalsh(expected)[:, -1])), 1e-6)
    assert "polhodesample" in "".join(said.split()) and "firstorder" in "".join(said.split())  # cards break anywhere
    assert "polhode sample" in result.stderr


def test_a_message_with_covariances_is_read_back(tmp_path):
    (tmp_path / "body.toml").write_text(PRODUCTS)
    body = polhode.read(tmp_path / "body.toml")
    out = tmp_path / "a.acm"
    run("propagate", tmp_path / "body.toml", "-o", out, "--covariance", "--stop", "+100 s", "--count", "11")
    back = polhode.read(out)
    assert np.allclose(back.inertia.principal_moments, body.inertia.principal_moments, rtol=1e-12)
    assert_within(back.inertia.named_from_principal - body.inertia.named_from_principal, 1e-12)
    assert_within(back.omega - body.omega, 1e-15)
    assert back.uncertainty.names[:3] == ["turn.x", "turn.y", "turn.z"]
    variances = np.diag(body.motion().covariance(0.0)) * np.degrees(1.0) ** 2
    assert np.allclose(np.diag(back.uncertainty.covariance), variances, rtol=1e-12)
    assert_within(np.diag(back.motion().covariance(0.0)) - np.radians(1.0) ** 2 * variances, 1e-15)
    assert back.history.segments[0].q.shape == (11, 4)
    lines = out.read_text().splitlines()
    assert "COV_TYPE = ANGLE" in lines and "RATE_TYPE = ANGVEL" in lines
    assert any(line.startswith("IXY = -") and abs(float(line.split()[2]) + 1.0) < 1e-10 for line in lines)  # integral of xy dm
    rows = lines[lines.index("COV_TYPE = ANGLE") + 1 : lines.index("COV_STOP")]
    assert len(rows) == 11 and all(len(row.split()) == 4 for row in rows)
    assert "covariance" in run("info", out).stdout
    assert run("propagate", TOUTATIS, "-o", tmp_path / "a.aem", "--covariance", "--stop", "+1 d", "--count", "2", check=False).returncode == 2


def test_a_clone_is_a_body_with_other_numbers(tmp_path):
    body = read(tmp_path, TUMBLER)
    uncertainty = body.uncertainty
    assert uncertainty.names == ["moments.x", "moments.y", "lambda", "beta", "phi0", "psi0", "P_phi", "P_psi"]
    values = uncertainty.values.copy()
    values[-1] = 264.0
    clone = uncertainty.body(values)
    assert abs(clone.info()["motion"]["polhode_period_s"] / 3600.0 - 264.0) < 1e-9
    assert clone.uncertainty is None
    with pytest.raises(polhode.InputError):
        uncertainty.body(-values)


def test_info_says_what_a_state_is_worth():
    told = json.loads(run("info", "--json", TOUTATIS).stdout)[0]["uncertainty"]
    assert len(told["parameters"]) == 11 == len(told["sigmas"])
    assert told["known_to_1_deg_until_s"] == 0.0 and told["sigma_at_epoch_deg"] > 2.0
    assert told["known_to_10_deg_until_s"] < told["known_to_10_deg_with_it_ten_times_better_until_s"] < told["known_until_s"]
    body = polhode.read(TOUTATIS)
    assert abs(np.degrees(sigma_of(body.motion(), told["known_to_10_deg_until_s"])) - 10.0) < 1e-4
    text = run("info", TOUTATIS).stdout
    assert "known to 10 deg" in text and told["largest_term"] in text


def test_energy_of_apophis_as_published():
    """1.024 +- 0.013 (3 sigma) by Pravec et al. 2014, from the periods and ratios that they print."""
    told = json.loads(run("info", "--json", BODIES / "incomplete/apophis-2014.toml").stdout)[0]
    energy = 1.0 + told["motion"]["energy_above_ground_relative"]
    sigma = told["uncertainty"]["energy_above_ground_sigma"]
    assert abs(energy - 1.0285) < 5e-4
    assert 0.5 * 0.013 / 3 < sigma < 3 * 0.013 / 3  # theirs has the correlations of the fit
    assert abs(energy - 1.024) < 0.013
    lee = json.loads(run("info", "--json", BODIES / "apophis.toml").stdout)[0]
    assert abs(lee["motion"]["energy_above_ground_relative"] - 0.0188) < 5e-5


def test_a_torque_below_the_uncertainties_is_not_modelled(tmp_path):
    """The Sun's torque on Apophis at the Earth: kept for exact numbers and by --full, dropped for the published ones."""
    text = (ROOT / "data/scenes/apophis-2029.toml").read_text()
    text = text.replace('"bodies/', f'"{ROOT}/data/scenes/bodies/').replace("uncertainty = 1e-3", "uncertainty = 1e-2")
    scene = tmp_path / "scene.toml"
    scene.write_text(text)
    plan = run("plan", scene).stdout
    sun = next(line for line in plan.splitlines() if line.startswith("gravity gradient, sun"))
    assert "dropped" in sun and "that the uncertainties do anyway" in sun
    assert "kept" in next(line for line in run("plan", scene, "--full").stdout.splitlines() if "sun" in line)
    scene.write_text(text.replace("period_uncertainty = 1e-2\n", ""))
    assert "kept" in next(line for line in run("plan", scene).stdout.splitlines() if "sun" in line)


def test_covariance_under_torques_is_that_of_clones(tmp_path):
    """A scene: rows of SIGMA against propagations of clones."""
    text = (ROOT / "data/scenes/apophis-2029.toml").read_text()
    (tmp_path / "scene.toml").write_text(text.replace('"bodies/', f'"{ROOT}/data/scenes/bodies/'))
    scene = polhode.read(tmp_path / "scene.toml")
    motion = scene.motion()
    sigma = sigma_of(motion, np.array([1.0, 3.0, 5.5]) * DAY)
    up, down = (
        polhode.Scene("clone", scene.body.uncertainty.body([x]), scene.torques, frame=scene.frame, after=6 * DAY, accuracy="0.001 deg").motion()
        for x in (1e-4, -1e-4)
    )
    for t, one in zip(np.array([1.0, 3.0, 5.5]) * DAY, sigma):
        apart = (down(t).rotation.inv() * up(t).rotation).magnitude() / 2e-4 * 1e-3
        assert abs(apart / one - 1.0) < 0.02


BALL = """name = "ball"
[inertia]
moments = [2.0, 2.0, 2.0]
unit = "kg m2"
[state]
epoch = "2025-01-01T00:00:00 TDB"
frame = "ICRF"
[state.attitude]
euler_angles = [0.0, 0.0, 0.0]
sequence = "ZXZ"
unit = "deg"
[state.angular_velocity]
components = [0.0, 0.0, 1.0]
axes = "body"
unit = "deg/s"
"""
PUSHED = """name = "a ball that is pushed"
source = "by hand"
body = "ball.toml"
frame = "ICRF"
after = "100 s"
accuracy = "1e-6 rad"
[[torque]]
kind = "constant"
torque_n_m = [0.0, 0.0, 1e-4]
torque_n_m_sigma = [0.0, 0.0, 1e-5]
axes = "body"
[[torque]]
kind = "linear damping"
coefficient_n_m_s = 0.0
coefficient_n_m_s_sigma = 1e-5
"""
ORBIT = """[orbit.earth]
mu_m3_s2 = 3.986004418e14
periapsis_m = 7.146e6
eccentricity = 0.0
periapsis_after_epoch_s = 0.0
to_periapsis = [1.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[torque]]
kind = "gravity gradient"
orbit = "earth"
"""


def test_numbers_of_torques_have_uncertainties(tmp_path):
    """A ball about one axis: I w' = N - d w, so that a change of N turns it by N t^2 / 2 I, and one of d at d = 0 by
    -(w0 t^2 / 2 + N t^3 / 6 I) / I."""
    (tmp_path / "ball.toml").write_text(BALL)
    (tmp_path / "scene.toml").write_text(PUSHED)
    inertia, push, rate = 2.0, 1e-4, np.radians(1.0)

    def sigma(t):
        return np.hypot(1e-5 * t**2 / (2 * inertia), 1e-5 * (rate * t**2 / 2 + push * t**3 / (6 * inertia)) / inertia)

    run("propagate", tmp_path / "scene.toml", "--covariance", "--count", 3, "-o", tmp_path / "rows.ecsv")
    rows = Table.read(tmp_path / "rows.ecsv")
    assert np.allclose(rows["sigma_rad"], sigma(np.array([0.0, 50.0, 100.0])), rtol=1e-3)
    assert np.allclose(rows["cov_zz_rad2"], rows["sigma_rad"] ** 2, rtol=1e-6)
    times = "2025-01-01T00:00:50 TDB, 2025-01-01T00:01:40 TDB"
    run("sample", tmp_path / "scene.toml", "--count", 20_000, "--seed", 5, "--times", times, "-o", tmp_path / "clones.ecsv")
    spread = np.radians(Table.read(tmp_path / "clones.ecsv")["attitude_spread_deg"])
    assert np.allclose(spread, sigma(np.array([50.0, 100.0])), rtol=0.02)
    uniform = ["--uniform", "torque.1.torque_n_m.z=2e-5", "--times", times, "-o", tmp_path / "even.ecsv"]
    run("sample", tmp_path / "scene.toml", "--count", 20_000, "--seed", 5, *uniform)
    within = np.radians(Table.read(tmp_path / "even.ecsv")["attitude_spread_deg"])
    assert np.all(within < 0.7 * spread)  # a sigma of 2e-5 / sqrt(12)


def test_numbers_of_torques_may_go_together(tmp_path):
    (tmp_path / "ball.toml").write_text(BALL)
    together = """[uncertainty]
parameters = ["torque.2.coefficient_n_m_s", "torque.1.torque_n_m.z"]
covariance = [[1e-10, 6e-11], [6e-11, 1e-10]]
"""
    (tmp_path / "scene.toml").write_text(PUSHED + together)
    by_push, by_damping = 1e-5 * 1e4 / 4, -1e-5 * (np.radians(1.0) * 1e4 / 2 + 1e-4 * 1e6 / 12) / 2
    expected = np.sqrt(by_push**2 + by_damping**2 + 2 * 0.6 * by_push * by_damping)
    run("propagate", tmp_path / "scene.toml", "--covariance", "--count", 2, "-o", tmp_path / "rows.ecsv")
    assert Table.read(tmp_path / "rows.ecsv")["sigma_rad"][1] == pytest.approx(expected, rel=1e-3)
    for old, new, message in [
        ("torque.2.coefficient_n_m_s", "torque.2.axes", "'torque.2.axes' is no number of the scene with its _sigma beside it; allowed are torque.1.torque_n_m.z, torque.2.coefficient_n_m_s"),
        ("[[1e-10,", "[[4e-10,", "of torque.2.coefficient_n_m_s it gives a sigma of 2e-05, beside the number stands 1e-05"),
        ("6e-11", "2e-10", "uncertainty.covariance: the covariance of"),
    ]:
        (tmp_path / "scene.toml").write_text(PUSHED + together.replace(old, new))
        result = run("plan", tmp_path / "scene.toml", check=False)
        assert result.returncode == 2 and message in result.stderr, result.stderr


def test_a_scene_with_uncertain_torques_in_python(tmp_path):
    (tmp_path / "ball.toml").write_text(BALL)
    (tmp_path / "scene.toml").write_text(PUSHED)
    scene = polhode.read(tmp_path / "scene.toml")
    assert sigma_of(scene.motion(), np.array([100.0])) == pytest.approx(1e-5 * 1e4 / 4, rel=0.02)
    with pytest.raises(TypeError, match="read its file again"):
        pickle.dumps(scene)


@pytest.mark.parametrize(
    "line, message",
    [
        ("torque_n_m_sigma = [0, 0]", "has the form of its number"),
        ("torque_n_m_sigma = 1e-5", "has the form of its number"),
        ("torque_n_m_sigma = [0, 0, -1e-5]", "an uncertainty of 0 or more"),
        ("torque_n_m_sigma = [0, 0, 1e300]", "an uncertainty of 0 or more is wanted, up to 1e100"),
        ("torque_n_m_sigma = [0, 0, nan]", "has the form of its number"),
        ("torque_sigma = 1e-5", "there is no number that it goes with"),
        ('axes_sigma = 1e-5', "has the form of its number"),
    ],
)
def test_an_uncertainty_that_is_none_is_refused(tmp_path, line, message):
    (tmp_path / "ball.toml").write_text(BALL)
    text = PUSHED.replace("torque_n_m_sigma = [0.0, 0.0, 1e-5]", line)
    (tmp_path / "scene.toml").write_text(text)
    result = run("propagate", tmp_path / "scene.toml", "-o", tmp_path / "rows.csv", check=False)
    number = 1 + text.splitlines().index(line)
    assert result.returncode == 2 and f"scene.toml:{number}: torque.1." in result.stderr and message in result.stderr


def test_clones_whose_torques_cannot_be_are_drawn_again(tmp_path):
    """An eccentricity of 0.0 with a sigma: half of the draws are negative."""
    (tmp_path / "ball.toml").write_text(BALL)
    orbit = ORBIT.replace("eccentricity = 0.0", "eccentricity = 0.0\neccentricity_sigma = 0.01")
    (tmp_path / "scene.toml").write_text(PUSHED[: PUSHED.index("[[torque]]")] + orbit)
    times = "2025-01-01T00:00:50 TDB"
    run("sample", tmp_path / "scene.toml", "--count", 50, "--seed", 5, "--times", times, "--rows", "-o", tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) > 50


def test_a_torque_whose_numbers_are_uncertain_is_kept(tmp_path):
    """One that is too small to matter as given, and large within a sigma."""
    (tmp_path / "ball.toml").write_text(BALL)
    text = PUSHED.replace("[0.0, 0.0, 1e-4]", "[0.0, 0.0, 1e-15]").replace("1e-6 rad", "1 deg")
    (tmp_path / "scene.toml").write_text(text)
    plan = run("plan", tmp_path / "scene.toml").stdout
    assert plan.count("its numbers are uncertain") == 2
    assert "caution    the torques' numbers are uncertain: `propagate --covariance` and `sample`" in plan
    exact = text.replace("torque_n_m_sigma", "# torque_n_m_sigma")
    (tmp_path / "exact.toml").write_text(exact.replace("coefficient_n_m_s_sigma", "# coefficient_n_m_s_sigma"))
    assert "dropped" in run("plan", tmp_path / "exact.toml").stdout
    run("propagate", tmp_path / "scene.toml", "--covariance", "--count", 2, "-o", tmp_path / "rows.ecsv")
    damped = 1e-5 * np.radians(1.0) * 1e4 / 4
    assert Table.read(tmp_path / "rows.ecsv")["sigma_rad"][1] == pytest.approx(np.hypot(1e-5 * 1e4 / 4, damped), rel=1e-3)


def orbiting(folder, change=lambda orbit: orbit):
    """A body that is no ball, on a circular orbit, for two revolutions."""
    (folder / "brick.toml").write_text(BALL.replace("[2.0, 2.0, 2.0]", "[1.0, 1.5, 2.0]"))
    scene = PUSHED[: PUSHED.index("[[torque]]")].replace("ball.toml", "brick.toml").replace("100 s", "12000 s")
    path = folder / "orbiting.toml"
    path.write_text(scene.replace("1e-6 rad", "1e-9 rad") + change(ORBIT))
    return path


def sigmas_of(path, *arguments):
    run("propagate", path, "--covariance", "--count", 5, "-o", path.with_suffix(".ecsv"), *arguments)
    table = Table.read(path.with_suffix(".ecsv"))
    return np.array(table["sigma_rad"]), table.meta


def attitudes_of(path):
    run("propagate", path, "--count", 5, "-o", path.with_suffix(".ecsv"))
    table = Table.read(path.with_suffix(".ecsv"))
    return Rotation.from_quat(np.array([table[f"q_{c}"] for c in ("x", "y", "z", "scalar")]).T)


def test_an_orbit_that_is_known_from_one_side(tmp_path):
    """An eccentricity of 0 has no neighbour below; the other side serves."""
    sigma, meta = sigmas_of(orbiting(tmp_path, lambda orbit: orbit.replace("eccentricity = 0.0", "eccentricity = 0.0\neccentricity_sigma = 0.04")))
    assert any("first order only" in str(value) for value in meta.values())  # its square counts, too
    circle = attitudes_of(orbiting(tmp_path))
    ellipse = attitudes_of(orbiting(tmp_path, lambda orbit: orbit.replace("eccentricity = 0.0", "eccentricity = 1e-4")))
    apart = 400 * (circle.inv() * ellipse).magnitude()
    assert apart[-1] > 5e-4 and np.allclose(sigma, apart, rtol=0.02, atol=2e-6)


def test_a_normal_that_is_uncertain_stays_one(tmp_path):
    """Its components are drawn each by itself: what they leave of a right angle to the periapsis is put right."""
    path = orbiting(tmp_path, lambda orbit: orbit.replace("normal = [0.0, 0.0, 1.0]", "normal = [0.0, 0.0, 1.0]\nnormal_sigma = [1e-3, 1e-3, 1e-3]"))
    sigma, _ = sigmas_of(path)
    times = "2025-01-01T03:20:00 TDB"
    run("sample", path, "--count", 2000, "--seed", 5, "--times", times, "-o", tmp_path / "clones.ecsv")
    spread = np.radians(Table.read(tmp_path / "clones.ecsv")["attitude_spread_deg"][0])

    def tilted(y):
        return attitudes_of(orbiting(tmp_path, lambda orbit: orbit.replace("0.0, 1.0]\n[[", f"{y}, 1.0]\n[[")))

    up, down = tilted(5e-4), tilted(-5e-4)
    apart = (down.inv() * up).magnitude()
    assert apart[-1] > 1e-5 and np.allclose(sigma, apart, rtol=0.01, atol=1e-7)  # x and z turn no plane
    assert spread == pytest.approx(sigma[-1], rel=0.06)


def test_facets_have_the_same_sigma_at_any_accuracy(tmp_path):
    """The differences are of motions good enough for them, whatever the scene asks."""
    scenes = ROOT / "data/scenes"
    text = (scenes / "satellite/satellite.toml").read_text()
    text = text.replace('"../bodies', f'"{scenes}/bodies').replace('"envisat-36.obj"', f'"{scenes}/satellite/envisat-36.obj"')
    text = text.replace("30 d", "0.5 d").replace("[surface.array]", "[surface.array]\nspecular_sigma = 0.05")
    (tmp_path / "coarse.toml").write_text(text)
    (tmp_path / "fine.toml").write_text(text.replace("1 deg", "1e-4 deg"))
    (coarse, _), (fine, _) = sigmas_of(tmp_path / "coarse.toml", "--full"), sigmas_of(tmp_path / "fine.toml", "--full")
    assert coarse[-1] > 1e-5 and np.allclose(coarse[1:], fine[1:], rtol=0.05)


@pytest.mark.parametrize("angle", [float("nan"), 0.0, -1.0, "0 deg", float("inf")])
def test_an_angle_that_is_none_has_no_horizon(angle):
    with pytest.raises(polhode.InputError, match="a positive one is wanted"):
        polhode.read(TOUTATIS).known_until(angle)
