"""Motion.observe_partials and `polhode observe --covariance`: against displaced motions, clones and displaced files."""

import re

import numpy as np
import pytest
from astropy.table import Table
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, run

import polhode

WAY = ROOT / "data/scenes/trajectories/toutatis-sun.oem"


def displaced(body, parameter, by):
    """The body with another initial state, principal moment, or (of "scale") none."""
    tensor, q, omega = body.inertia.tensor, Rotation.from_quat(body.q, scalar_first=True), body.omega
    momentum, axes, moments = tensor @ omega, body.inertia.named_from_principal, body.inertia.principal_moments.copy()
    if parameter.startswith("theta0"):
        q = q * Rotation.from_rotvec(by * np.eye(3)["xyz".index(parameter[-1])])
    elif parameter.startswith("m0"):
        momentum = momentum + by * np.eye(3)["xyz".index(parameter[-1])]
    elif parameter.startswith("I"):
        moments[int(parameter[1]) - 1] += by
    elif parameter.startswith("axes"):  # the principal axes go on as they were
        turn = Rotation.from_rotvec(by * np.eye(3)["xyz".index(parameter[-1])])
        axes, momentum, q = turn.as_matrix() @ axes, turn.apply(momentum), q * turn.inv()
    tensor = axes @ np.diag(moments) @ axes.T
    inertia = polhode.Inertia.from_tensor((tensor + tensor.T) / 2)
    return polhode.Body("displaced", inertia=inertia, epoch=body.epoch, frame=body.frame, q=q, omega=np.linalg.solve(tensor, momentum))


@pytest.mark.parametrize("exposure", [None, "3 h"])
def test_partials_of_what_is_seen(exposure):
    """Against differences of fourth order of displaced motions."""
    body = polhode.read(TOUTATIS)
    times = [polhode.Instant(f"1992-12-{day:02d}T07:00", "TDB") for day in (9, 14, 21)]
    axes = np.array([1200.0, 960.0, 2300.0])
    options = dict(target=WAY, exposure=exposure, hg1g2=(0.26, 0.38))
    rows = body.motion().observe(times, shape=axes, **options)
    parameters, partials = body.motion().observe_partials(times, shape=axes, **options)
    assert parameters == ["theta0_x", "theta0_y", "theta0_z", "m0_x", "m0_y", "m0_z", "I1", "I2", "I3", "axes_x", "axes_y", "axes_z", "scale"]
    assert list(partials) == list(rows)
    momentum = np.linalg.norm(body.inertia.tensor @ body.omega)
    sizes = {"t": 1.0, "a": 1.0, "m": momentum, "I": body.inertia.principal_moments[2], "s": 1.0}
    for k, parameter in enumerate(parameters):
        step = 2e-5 * sizes[parameter[0]]

        def seen(by, parameter=parameter):
            if parameter == "scale":
                return body.motion().observe(times, shape=(1 + by) * axes, **options)
            return displaced(body, parameter, by).motion().observe(times, shape=axes, **options)

        near, far = [(seen(h), seen(-h)) for h in (step, 2 * step)]
        for name in rows:
            if parameter.startswith("axes") and name.startswith(("long", "phi_", "theta", "psi")):  # may count the other way
                assert np.all(partials[name][:, k] == 0)
                continue
            across = [up[name] - down[name] for up, down in (near, far)]
            if name.endswith("_deg"):
                across = [np.remainder(a + 180, 360) - 180 for a in across]
            expected = (8 * across[0] - across[1]) / (12 * step)
            size = np.abs(partials[name] @ np.diag([sizes[p[0]] for p in parameters])).max() + 1e-300
            assert np.abs(partials[name][:, k] - expected).max() * sizes[parameter[0]] < 2e-6 * size, (parameter, name)
    assert np.allclose(partials["area_m2"][:, -1], 2 * rows["area_m2"], rtol=1e-12)
    assert np.all(partials["range_m"] == 0) and np.abs(partials["magnitude"][:, :9]).max() > 1 and np.all(partials["magnitude"][:, -1] == 0)


def test_partials_of_a_scene_are_those_of_its_displaced_motion():
    scene = polhode.read(ROOT / "data/scenes/toutatis-1992-2008.toml")
    body, times, options = scene.body, np.linspace(1, 400, 5) * 86400, dict(shape=[1200, 960, 2300])
    parameters, partials = scene.motion(full=True).observe_partials(times, WAY, **options)
    assert parameters[9:] == ["gravity gradient 1 mu_m3_s2", "gravity gradient 2 mu_m3_s2", "axes_x", "axes_y", "axes_z", "scale"]

    def seen(by):
        moved = displaced(body, "theta0_x", by)
        moved = polhode.Scene("moved", moved, scene.torques, frame=scene.frame, after="450 d", accuracy="1e-7 rad")
        return moved.motion(full=True).observe(times, WAY, **options)

    up, down = seen(1e-3), seen(-1e-3)
    for name in ("sub_observer_lat_deg", "phi_deg", "magnitude"):
        assert np.allclose(partials[name][:, 0], (up[name] - down[name]) / 2e-3, rtol=0, atol=1e-5 * np.abs(partials[name]).max()), name


KNOWN_TO_A_DEGREE = """name = "known to a degree"
[inertia]
moments = [0.61, 0.965, 1.0]
moments_sigma = [0.001, 0.0002, 0.0]
products = [0.01, 0.02, -0.015]
products_sigma = [0.001, 0.001, 0.001]
products_are = "tensor elements"
unit = "ratios"
[state]
epoch = "1992-12-08T00:00:00 TDB"
frame = "ECLIPJ2000"
[state.attitude]
euler_angles = [40.0, 60.0, 20.0]
euler_angles_sigma = [1.0, 0.7, 1.2]
sequence = "ZXZ"
unit = "deg"
[state.angular_velocity]
components = [30.0, 35.0, 98.0]
components_sigma = [0.05, 0.05, 0.1]
axes = "body"
unit = "deg/day"
"""


def test_sigmas_of_what_is_seen_are_those_of_clones(tmp_path):
    (tmp_path / "tumbler.toml").write_text(KNOWN_TO_A_DEGREE)
    body = polhode.read(tmp_path / "tumbler.toml")
    times = [polhode.Instant(f"1992-12-{day:02d}T00:00", "TDB") for day in (9, 11, 15)]
    options = dict(target=WAY, shape=[1200, 960, 2300])
    rows = body.motion().observe(times, covariance=True, **options)
    uncertainty = body.uncertainty
    draws = np.random.default_rng(1).multivariate_normal(uncertainty.values, uncertainty.covariance, 1500)
    clones = [uncertainty.body(draw).motion().observe(times, **options) for draw in draws]
    for name in rows:
        if not name.startswith("sigma_"):
            continue
        column = name.removeprefix("sigma_")
        apart = np.array([clone[column] for clone in clones]) - rows[column]
        if column.endswith("_deg"):
            apart = np.remainder(apart + 180, 360) - 180
        assert np.allclose(apart.std(0), rows[name], rtol=0.12, atol=1e-12), column
    assert "sigma_range_m" not in rows and rows["sigma_magnitude"].max() > 0.02
    out = tmp_path / "rows.ecsv"
    run("observe", tmp_path / "tumbler.toml", "--target", WAY, "-o", out, "--times", "1992-12-09T00:00 TDB, 1992-12-11T00:00 TDB, 1992-12-15T00:00 TDB",
        "--shape", "1200 960 2300 m", "--covariance")  # fmt: skip
    table = Table.read(out)
    assert list(rows) == table.colnames[1:] and np.allclose(table["sigma_psi_deg"], rows["sigma_psi_deg"], rtol=1e-9)
    assert str(table["sigma_psi_deg"].unit) == "deg"
    exact = polhode.Body("exact", inertia=body.inertia, epoch=body.epoch, frame=body.frame, q=body.q, omega=body.omega)
    with pytest.raises(polhode.InputError, match="uncertainty"):
        exact.motion().observe(times, covariance=True, **options)


def test_sigmas_where_there_is_no_derivative(tmp_path):
    """At rest, and of a rotation about one axis, whose phi and psi are nobody's."""
    text = KNOWN_TO_A_DEGREE.replace("[30.0, 35.0, 98.0]", "[0.0, 0.0, 0.0]").replace("components_sigma", "# components_sigma")
    (tmp_path / "rest.toml").write_text(text)
    times = [polhode.Instant("1992-12-09T00:00", "TDB")]
    rest = polhode.read(tmp_path / "rest.toml").motion()
    rows = rest.observe(times, WAY, covariance=True)
    assert np.isnan(rows["sigma_momentum_ra_deg"][0]) and np.isnan(rows["sigma_phi_deg"][0])
    assert 0.3 < rows["sigma_sub_observer_lat_deg"][0] < 3.0  # the sigmas of the Euler angles, about a degree
    parameters, partials = rest.observe_partials(times, WAY)
    assert np.all(partials["range_m"] == 0) and np.all(np.isfinite(partials["sub_solar_lat_deg"]))
    text = KNOWN_TO_A_DEGREE.replace("[30.0, 35.0, 98.0]", "[0.0, 0.0, 98.0]")
    (tmp_path / "short.toml").write_text(re.sub(r"products.*\n", "", text))
    rows = polhode.read(tmp_path / "short.toml").motion().observe(times, WAY, covariance=True, convention="short-axis")
    assert np.isnan([rows[f"sigma_{name}_deg"][0] for name in ("phi", "theta", "psi")]).all()
    assert 0.1 < rows["sigma_momentum_dec_deg"][0] < 3.0


def test_sigmas_of_a_scene_are_those_of_displaced_files(tmp_path):
    """A torque fixed in the body, whose axes are uncertain, and whose own component is."""
    (tmp_path / "body.toml").write_text(KNOWN_TO_A_DEGREE.replace('"ratios"', '"kg m2"').replace("deg/day", "deg/s"))
    scene = """name = "pushed"
source = "by hand"
body = "body.toml"
frame = "ECLIPJ2000"
before = "10 min"
after = "20 min"
accuracy = "1e-9 rad"
[[torque]]
kind = "constant"
torque_n_m = [2e-6, 1e-6, -1e-6]
torque_n_m_sigma = [1e-8, 0.0, 0.0]
axes = "body"
"""
    (tmp_path / "scene.toml").write_text(scene)
    body = (tmp_path / "body.toml").read_text()
    times = [polhode.Instant(f"1992-12-08T00:1{k}:00", "TDB") for k in (1, 4, 9)]
    options = dict(shape=[3, 2, 1], law="lambert", directions=([1.0] * 3, [0.3] * 3, [1e6] * 3))
    names = ["sub_observer_lat_deg", "long_axis_dec_deg", "momentum_dec_deg", "magnitude"]
    # One number at a time, so that what each does can be told apart.
    numbers = [("products", "[0.0, 1e-5, 0.0]", "products = \\[0.01, (0.02)", 0.02, 1e-5), ("torque", "[1e-8, 0.0, 0.0]", "torque_n_m = \\[(2e-6)", 2e-6, 1e-8),
               ("euler_angles", "[1.0, 0.0, 0.0]", "euler_angles = \\[(40.0)", 40.0, 1.0)]  # fmt: skip
    for key, sigmas, pattern, value, sigma in numbers:
        one = re.sub(r"\w+_sigma = .*\n", "", body).replace(f"\n{key} =", f"\n{key}_sigma = {sigmas}\n{key} =")
        other = scene if key == "torque" else re.sub(r"torque_n_m_sigma.*\n", "", scene)
        (tmp_path / "body.toml").write_text(one)
        (tmp_path / "scene.toml").write_text(other)
        rows = polhode.read(tmp_path / "scene.toml").motion().observe(times, covariance=True, **options)

        def seen(by, one=one, other=other, pattern=pattern, value=value):
            moved = [re.sub(pattern, lambda m: m[0].replace(m[1], repr(value + by)), text) for text in (one, other)]
            assert moved != [one, other]
            (tmp_path / "body.toml").write_text(moved[0])
            (tmp_path / "scene.toml").write_text(moved[1])
            return polhode.read(tmp_path / "scene.toml").motion().observe(times, **options)

        up, down = seen(0.1 * sigma), seen(-0.1 * sigma)
        for name in names:
            expected = np.abs(up[name] - down[name]) / (0.2)
            assert np.allclose(rows[f"sigma_{name}"], expected, rtol=0.01, atol=0.01 * expected.max() + 1e-7), (pattern, name)
