"""Spin states and ratios of inertia from measurements: polhode.fit and the subcommand."""

import numpy as np
import pytest
from fit_bodies import RATE, attitudes, off_by, random_body, share_of_region
from scipy.spatial.transform import Rotation
from scipy.stats import binom
from support import ROOT, TOUTATIS, run

import polhode
from polhode.fitting import motions, read_observations, rotations
from polhode.fitting.brightness import ellipsoid_magnitude
from polhode.fitting.parameters import parameters_of
from polhode.fitting.problem import Photometry, Problem

RADAR = ROOT / "data/observations/toutatis-radar-attitudes.csv"
SCENE = ROOT / "data/scenes/toutatis-1992-2008.toml"
A_PRIORI = (ROOT / "data/bodies/toutatis.toml").read_text()
for published, before in (
    ("euler_angles = [145.498, 65.865, 241.524]", "euler_angles = [144.863, 65.467, 241.785]"),
    ("components = [14.51, 33.529, -98.709]", "components = [14.514, 33.532, -98.713]"),
    ("moments = [3.0836, 3.235, 1.0]", "moments = [3.091, 3.2178, 1.0]"),
):
    assert published in A_PRIORI
    A_PRIORI = A_PRIORI.replace(published, before)
A_PRIORI_SIGMA = {"euler_angles": 15.0, "components": 0.1, "moments.x": 0.1, "moments.y": 0.1}
PUBLISHED = {  # Takahashi et al. 2013, Table 2
    "euler_angles.1": (145.498, 3.762), "euler_angles.2": (65.865, 2.388), "euler_angles.3": (241.524, 2.586),
    "components.x": (14.510, 0.0994), "components.y": (33.529, 0.0971), "components.z": (-98.709, 0.0957),
    "moments.x": (3.0836, 0.0282), "moments.y": (3.235, 0.0714),
}  # fmt: skip


# --- Derivatives ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["bodies/toutatis", "bodies/apophis", "bodies/mms", "scenes/bodies/envisat-2013"])
def test_derivatives_are_those_of_differences(name):
    parameters = parameters_of(polhode.read(ROOT / f"data/{name}.toml"))
    for number in parameters.numbers:
        number.free = True
    free = motions.FreeMotions(parameters)
    t = np.array([0.0, 3.0, 11.0, 30.0]) / np.linalg.norm(parameters.body.omega)
    states = free.states(parameters.values, t)
    for k, number in enumerate(parameters.numbers):
        ends = []
        for sign in (1, -1):
            values = parameters.values
            values[k] += sign * 1e-6 * number.scale
            ends.append(free.states(values, t, derivatives=False))
        turn = rotations.logarithm(rotations.multiply(rotations.conjugate(ends[1].q), ends[0].q)) / 2e-6
        size = 1 + np.abs(turn).max()
        assert np.abs(turn - states.by_turn[:, :, k] * number.scale).max() < 1e-5 * size, number.name
        omega = (ends[0].omega - ends[1].omega) / 2e-6
        assert np.abs(omega - states.by_omega[:, :, k] * number.scale).max() < 1e-5 * size * np.linalg.norm(parameters.body.omega), number.name


def test_residuals_of_every_kind_have_their_derivatives():
    parameters = parameters_of(polhode.read(TOUTATIS))
    random = np.random.default_rng(1)
    instants = [parameters.epoch + 86400.0 * x for x in (0.5, 2.0, 7.0)]
    towards = random.normal(size=(3, 2, 3))
    towards[:, 1] = towards[:, 0] + 0.5 * towards[:, 1]
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    rows = read_observations(RADAR)[0]
    q = random.normal(size=(3, 4))
    common = dict(source="here", lines=np.arange(3), instants=instants)
    kinds = [
        type(rows)("attitude", values=q / np.linalg.norm(q, axis=1)[:, None], sigma=np.full(3, 0.1), frame="ICRF", **common),
        type(rows)("rate", values=1e-5 * random.normal(size=(3, 3)), sigma=np.full(3, 1e-6), **common),
        type(rows)("magnitude", values=np.full(3, 15.0), sigma=np.full(3, 0.1), towards=towards, distances_au=np.ones((3, 2)), **common),
    ]
    for photometry in (Photometry(None), Photometry((1.0, 0.6, 0.4))):
        problem = Problem(parameters, motions.FreeMotions(parameters), kinds, photometry)
        for number in problem.numbers:
            number.free = True
        values = problem.values
        _, by = problem.residuals(values, problem.everything())
        for k, number in enumerate(problem.numbers):
            step = 1e-6 * number.scale * np.eye(len(values))[k]
            difference = (problem.residuals(values + step, problem.everything(), False) - problem.residuals(values - step, problem.everything(), False)) / 2e-6
            assert np.abs(difference - by[:, k] * number.scale).max() < 1e-5 * (1 + np.abs(difference).max()), number.name


def test_an_ellipsoid_shows_its_cross_section_at_opposition():
    for axis, area in zip(np.eye(3), (0.6 * 0.4, 0.4, 0.6)):
        magnitude = ellipsoid_magnitude((1.0, 0.6, 0.4), axis[None], axis[None])[0]
        assert magnitude == pytest.approx(-2.5 * np.log10(area / 0.24 ** (2 / 3)), abs=1e-12)


# --- Toutatis ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def a_priori(tmp_path):
    """The scene from the a-priori state of Takahashi et al."""
    (tmp_path / "apriori.toml").write_text(A_PRIORI)
    text = SCENE.read_text().replace("../bodies/toutatis.toml", "apriori.toml")
    (tmp_path / "scene.toml").write_text(text.replace('"trajectories/', f'"{SCENE.parent}/trajectories/'))
    return tmp_path / "scene.toml"


def known_beforehand(monkeypatch):
    """The sigmas of the a-priori state."""
    from polhode.fitting import api

    def with_sigmas(*arguments):
        parameters = parameters_of(*arguments)
        for name, sigma in A_PRIORI_SIGMA.items():
            for number in parameters._meant(name):
                number.sigma = sigma
        return parameters

    monkeypatch.setattr(api, "parameters_of", with_sigmas)


def test_toutatis_from_1992_to_2008(a_priori, monkeypatch):
    known_beforehand(monkeypatch)
    fit = polhode.fit(a_priori, RADAR, robust=True, sigma_rates="10 deg/day")
    assert fit.rms("attitude") <= 7.6
    assert sum(row["used"] for row in fit.residuals() if row["kind"] == "attitude") == 33
    for name, (value, sigma) in PUBLISHED.items():
        assert abs(fit.parameters[name] - value) < sigma, name
    assert any("rate of 2008-11-22" in name and ":38:" in name for name in fit.rejected)
    assert len(fit.rejected) <= 3


# --- From nothing -----------------------------------------------------------------------------------------------------


def test_bodies_from_attitudes_alone():
    count, shares, found = 12, [], 0
    for seed in range(1000, 1000 + count):
        random = np.random.default_rng(seed)
        body = random_body(random)
        history = attitudes(body, random)
        fit = polhode.fit("random", history, sigma="2 deg")
        if off_by(body, fit, [history.epoch + float(t) for t in history.segments[0].t]) < 10:
            found += 1
            share = share_of_region(body, fit)[0]
            shares += [] if share is None else [share]
        else:  # never a silent wrong one
            assert any("chi-squared" in warning for warning in fit.warnings)
    assert binom.cdf(found, count, 0.95) > 0.01
    inside = sum(share < 0.68 for share in shares)
    assert 0.001 < binom.cdf(inside, len(shares), 0.68) and binom.sf(inside - 1, len(shares), 0.68) > 0.001


def fixed_motion(moments, omega, count=30, turns=10):
    random = np.random.default_rng(5)
    omega = np.array(omega, dtype=float)
    inertia = polhode.Inertia(moments)
    body = polhode.Body("body", inertia=inertia, epoch="2020-01-01 TDB", q=random.normal(size=4), omega=omega * RATE / np.linalg.norm(omega))
    return body, attitudes(body, random, count, turns)


@pytest.mark.parametrize("moments, omega", [([0.5, 1, 1], [1, 0.7, 0.2]), ([0.6, 0.6, 1], [0.3, 0.7, 1]), ([0.5, 0.8, 1], [0.5, 0.3, 0.6])])
def test_symmetric_bodies_and_others(moments, omega):
    body, history = fixed_motion(moments, omega)
    fit = polhode.fit("body", history)  # the sigma is estimated
    assert off_by(body, fit, [history.epoch + float(t) for t in history.segments[0].t]) < 4
    assert fit.residuals()[0]["sigma"] == pytest.approx(2, rel=0.25)
    for name, moment in zip("xyz", moments):
        sigma = fit.sigma.get(f"moments.{name}", 0.0)
        assert abs(fit.parameters[f"moments.{name}"] - moment) < 4 * sigma + 0.02


def test_a_rotation_about_one_axis_does_not_tell_the_moments():
    fit = polhode.fit("body", fixed_motion([0.5, 0.8, 1], [0, 0, 1])[1], sigma="2 deg")
    assert any("moments of inertia" in sentence for sentence in fit.undetermined)
    assert not any(name.startswith("moments") for name in fit.sigma)


def test_too_few_attitudes_are_refused():
    with pytest.raises(polhode.InputError, match="there are 1 attitudes: 4 at different times are wanted"):
        polhode.fit("body", fixed_motion([0.5, 0.8, 1], [0.5, 0.3, 0.6], count=1)[1], sigma="2 deg")


def test_what_is_known_beforehand_may_contradict(tmp_path):
    body, history = fixed_motion([0.5, 0.8, 1], [0.5, 0.3, 0.6])
    fit = polhode.fit(body, history, sigma="2 deg")
    text = fit.text()
    tables = text.replace(f"{fit.parameters['moments.x']}", "0.8", 1).split("[uncertainty]")[0]
    assert tables != text
    from polhode.fitting.documents import read_toml
    from polhode.fitting.leading import led_along
    from polhode.fitting.parameters import Parameters
    from polhode.fitting.result import Fit

    (tmp_path / "body.toml").write_text(tables)
    parameters = Parameters(read_toml(tmp_path / "body.toml"))
    assert parameters.named("moments.x").sigma == pytest.approx(fit.sigma["moments.x"])
    rows = read_observations(history)
    rows[0].sigma = np.full(len(rows[0]), np.radians(2))
    problem = Problem(parameters, motions.FreeMotions(parameters), rows[:1])
    values, course = led_along(problem)
    warnings = Fit(problem, values, problem.everything(), course).warnings
    assert any("moments.x ends" in warning or "chi-squared is" in warning for warning in warnings)


def test_the_scale_of_inertia_is_said_not_to_be_determined():
    body, history = fixed_motion([0.5, 0.8, 1], [0.5, 0.3, 0.6])
    fit = polhode.fit(body, history, sigma="2 deg", free=["+moments"])
    assert "not determined: the scale of inertia; the ratios of the moments are" in fit.undetermined
    assert all(sigma < 1 for name, sigma in fit.sigma.items() if name.startswith("moments"))


def test_a_wrong_row_is_found_and_named():
    body, history = fixed_motion([0.5, 0.8, 1], [0.5, 0.3, 0.6])
    q = np.array(history.segments[0].q)
    q[7] = (Rotation.from_quat(q[7][[1, 2, 3, 0]]) * Rotation.from_rotvec([0, 0.6, 0])).as_quat()[[3, 0, 1, 2]]
    wrong = polhode.AttitudeHistory("wrong", [history.epoch + float(t) for t in history.segments[0].t], q)
    fit = polhode.fit(body, wrong, sigma="2 deg", robust=True)
    assert [name.split(":")[1] for name in fit.rejected] == ["8"]


# --- Tables and the command -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line, instead, message",
    [
        (4, "# sequenz: ZXZ", "6: the sequence of the angles is not said"),
        (5, "# frame: ECLIP", "6: frame: "),
        (8, "1992-12-03T19:30:00,86.3,81.8,24.5,-16.4,-29.1,x,15,Goldstone", "8: column omega_z_deg_day: found 'x', a number is wanted"),
        (9, "1992-12-04T18:10:00,47.8,60.7,284.0,29.1,-23.2,-97.8,-15,Goldstone", "9: column sigma_angles_deg: found '-15', a positive number is wanted"),
        (9, "1992-12-04T18:10:00,47.8", "9: found 2 cells, 9 are wanted as in line 6"),
        (9, "1992-13-04T18:10:00,47.8,60.7,284.0,29.1,-23.2,-97.8,15,Goldstone", "9: column date_utc: "),
    ],
)
def test_messages_name_the_line(tmp_path, line, instead, message):
    lines = RADAR.read_text().splitlines()
    lines[line - 1] = instead
    path = tmp_path / "table.csv"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(polhode.InputError) as error:
        read_observations(path)
    assert str(error.value).startswith(f"{path}:{message}")


def test_the_command_writes_what_it_found(tmp_path):
    body, history = fixed_motion([0.5, 0.8, 1], [0.5, 0.3, 0.6])
    times = [history.epoch + float(t) for t in history.segments[0].t]
    lines = ["# frame: ICRF", "date_tdb,q_x,q_y,q_z,q_scalar,sigma_angles_deg"]
    for time, q in zip(times, history.segments[0].q):
        lines.append(",".join([time.text("TDB", 3), *(repr(float(x)) for x in q[[1, 2, 3, 0]]), "2"]))
    (tmp_path / "table.csv").write_text("\n".join(lines) + "\n")
    result = run("fit", "my body", tmp_path / "table.csv", "-o", tmp_path / "fitted.toml", "--residuals", tmp_path / "residuals.csv", "--picture", tmp_path / "residuals.png")
    assert "degrees of freedom" in result.stdout
    assert len((tmp_path / "residuals.csv").read_text().splitlines()) == 31
    assert (tmp_path / "residuals.png").read_bytes()[:4] == b"\x89PNG"
    written = (tmp_path / "fitted.toml").read_text()
    assert 'name = "my body"' in written and "moments_sigma" in written and "[uncertainty]" in written
    # Of a body whose file names its axes, products that are found leave these names out; the program reads what it wrote.
    named = tmp_path / "named.toml"
    named.write_text(
        'name = "named"\n[inertia]\nmoments = [0.5, 0.8, 1.0]\nproducts = [0.0, 0.0, 0.0]\nproducts_are = "tensor elements"\nunit = "ratios"\nlong_axis = "x"\nshort_axis = "z"\n'
        f'[state]\nepoch = "{history.epoch.text("TDB", 6)} TDB"\nframe = "ICRF"\n[state.attitude]\nq_frame_from_body_scalar_first = {history.segments[0].q[0].tolist()}\n'
        '[state.angular_velocity]\ncomponents = [0.5, 0.3, 0.6]\naxes = "body"\nunit = "rad/s"\n'
    )
    run("fit", named, tmp_path / "table.csv", "-o", tmp_path / "again.toml")
    assert "P_phi" in run("info", tmp_path / "again.toml").stdout and "long_axis" not in (tmp_path / "again.toml").read_text()
    refused = run("fit", "my body", TOUTATIS, "-o", tmp_path / "x.toml", check=False)
    assert refused.returncode == 2 and "found no measurements" in refused.stderr
