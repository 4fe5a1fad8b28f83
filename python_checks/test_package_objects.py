"""Objects of the package: pickles and copies, and with them processes."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, run

import polhode

ENVISAT = ROOT / "data/scenes/envisat-month.toml"
APOPHIS = ROOT / "data/scenes/apophis-2029.toml"
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
FACETS = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]


def copies(thing):
    return [copy.copy(thing), copy.deepcopy(thing), *(pickle.loads(pickle.dumps(thing, protocol)) for protocol in (2, 5))]


# --- Pickles and copies ---------------------------------------------------------------------------------------------


def test_bodies():
    for path in (TOUTATIS, *sorted((ROOT / "data/samples/ccsds").glob("*.*"))[:8]):
        try:
            body = polhode.read(path)
        except polhode.Error:
            continue
        for other in copies(body):
            assert type(other) is type(body) and other.info() == body.info() and other.path == body.path
            assert other.notes == body.notes and other.warnings == body.warnings
    body, t = polhode.read(TOUTATIS), np.linspace(0, 1e7, 100)
    for other in copies(body):
        assert np.array_equal(other.motion()(t).q, body.motion()(t).q)
        assert other.known_until("10 deg") == body.known_until("10 deg")
    for inertia, instant in zip(copies(body.inertia), copies(body.epoch), strict=True):
        assert np.array_equal(inertia.tensor, body.inertia.tensor) and instant == body.epoch


def test_motions():
    t = np.linspace(-1e5, 1e6, 50)
    motion = polhode.read(TOUTATIS).motion("ECLIPJ2000", method="legendre")
    random = np.random.default_rng(3)
    clones = polhode.FreeMotion([1, 2, 2.5], random.normal(size=(4, 1, 4)), random.normal(size=(3, 3)))
    case = polhode.read_case(ROOT / "data/truth/dev/sam-01.case").motion()
    for one, when in ((motion, t), (clones, 10.0), (case, t)):
        for other in copies(one):
            assert (other.shape, other.frame, other.epoch, other.axes) == (one.shape, one.frame, one.epoch, one.axes)
            assert np.array_equal(other(when).q, one(when).q) and np.array_equal(other(when).momentum, one(when).momentum)
    assert pickle.loads(pickle.dumps(motion)).account(0, 1e6).method == "legendre"
    with pytest.raises(TypeError, match="pickle the Scene"):
        pickle.dumps(polhode.read(ENVISAT).motion())


def test_states():
    motion = polhode.read(TOUTATIS).motion()
    history = polhode.AttitudeHistory("a", ["2000-01-01 TT", "2000-01-02 TT"], Rotation.from_euler("z", [[0.0], [1.0]]))
    scene = polhode.read(APOPHIS).motion()
    for state in (motion(5.0), motion(np.arange(6.0).reshape(2, 3)), history(3600.0), history([0.0, 7.0]), scene([0.0, 3.0]), scene(1.0)):
        for other in copies(state):
            assert np.array_equal(other.q, state.q) and np.array_equal(other.omega, state.omega, equal_nan=True)
            assert np.array_equal(other.t, state.t) and (other.units, other.axes) == (state.units, state.axes)
            assert (other.epoch, other.frame, repr(other)) == (state.epoch, state.frame, repr(state))
            if "momentum" in state.units:
                assert np.array_equal(other.momentum, state.momentum)
    alone = motion(np.arange(3.0), out=(np.empty((3, 4)), None))
    with pytest.raises(polhode.InputError, match="not asked for"):
        _ = pickle.loads(pickle.dumps(alone)).momentum


def test_scenes_with_every_torque():
    orbit = polhode.Orbit.kepler(3.986004418e14, 7e6, 0.01, 0.0, [1, 0, 0], [0, 0, 1])
    times = np.linspace(-100.0, 4000.0, 60)
    table = polhode.Orbit.table(times, [orbit(t)[0] for t in times], [orbit(t)[1] for t in times])
    sun = polhode.Orbit.kepler(1.32712440018e20, 1.496e11, 0.0, 0.0, [-0.92, -0.39, 0.0], [0.0, 0.0, 1.0])
    moments = [5.0, 8.0, 11.0]
    torques = [
        polhode.Torque.gravity_gradient(3.986004418e14, orbit),
        polhode.Torque.gravity_gradient(1e12, table),
        polhode.Torque.constant([1e-6, 0, 2e-6], "frame"),
        polhode.Torque.pulse(100.0, 50.0, [1e-4, 0, 0]),
        polhode.Torque.damping([[1e-6, 0, 0], [0, 2e-6, 1e-7], [0, 1e-7, 3e-6]]),
        polhode.Torque.eddy_currents(np.diag([1.0, 2.0, 3.0]), [0, 0, -1], 7.8e15, orbit),
        polhode.Torque.dissipation(100.0, moments, 0.3),
        polhode.Torque.sunlight(polhode.Mesh(CORNERS - [0.5, 1, 1.5], FACETS), sun, 0.1, 0.5),
    ]
    body = polhode.Body(
        "box", inertia=polhode.Inertia([8.0, 5.0, 11.0], absolute=True), epoch="2027-01-01 TT", q=[1, 0, 0, 0], omega=[0.01, 0.002, 0.03]
    )
    for torque in torques:
        for other in copies(torque):
            assert other.name == torque.name
            where = (120.0, [1, 0.2, 0, 0], [0.01, 0.002, 0.03], moments)
            assert np.array_equal(other(*where), torque(*where))
    scene = polhode.Scene("all of them", body, torques, after="1 h", accuracy="1e-6 rad")
    t = np.linspace(0, 3600, 20)
    expected = scene.motion()(t).q
    for other in copies(scene)[1::2]:
        assert other.torque_names == scene.torque_names and other.span == scene.span
        assert np.array_equal(other.motion()(t).q, expected)
    of_file = polhode.read(ENVISAT)
    again = pickle.loads(pickle.dumps(of_file))
    assert (again.path, again.name, again.plan().model) == (of_file.path, of_file.name, of_file.plan().model)
    assert again.plan().effects[1].secular_rad == of_file.plan().effects[1].secular_rad
    mesh = copy.deepcopy(polhode.Mesh(CORNERS, FACETS))
    assert np.array_equal(mesh.vertices, CORNERS) and np.array_equal(mesh.facets, FACETS)
    assert np.array_equal(copy.copy(table)(77.0), table(77.0))


def day(motion):
    return motion(86400.0)


def test_processes_share_the_work():
    motion = polhode.read(TOUTATIS).motion()
    bodies = [polhode.FreeMotion([1, 2, 3], [1, 0, 0, 0], [0.1, 0.2, k]) for k in range(3)]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        states = pool.map(day, [motion, *bodies])
    assert np.array_equal(states[0].q, motion(86400.0).q) and states[0].frame == "ICRF"
    assert all(np.array_equal(state.q, body(86400.0).q) for state, body in zip(states[1:], bodies, strict=True))


def test_a_pickle_of_another_version_or_a_part_of_one_is_refused():
    class_, (version, data) = type(polhode.read(TOUTATIS)), polhode.read(TOUTATIS).__getstate__()
    with pytest.raises(polhode.InputError, match="the pickle is of polhode 0.0.1"):
        class_.__new__(class_).__setstate__(("polhode 0.0.1", data))
    with pytest.raises(polhode.InputError, match="cut short"):
        class_.__new__(class_).__setstate__((version, data[:-5]))


def test_errors_are_pickled_whole(tmp_path):
    (tmp_path / "a.toml").write_text("name = 1\n")
    with pytest.raises(polhode.InputError) as caught:
        polhode.read(tmp_path / "a.toml")
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.file, again.line, again.message) == (str(caught.value), caught.value.file, caught.value.line, caught.value.message)


# --- Arguments ------------------------------------------------------------------------------------------------------


def test_arrays_to_write_to_must_not_overlap():
    free = polhode.FreeMotion([1, 2, 3], [1, 0, 0, 0], [0.1, 0.2, 0.3])
    t = np.linspace(0, 10, 20)
    both = np.empty((20, 7))
    free(t, out=(both[:, :4], both[:, 4:]))  # beside each other
    assert np.array_equal(both[:, :4], free(t).q) and np.array_equal(both[:, 4:], free(t).momentum)
    numbers = np.zeros(80)
    for out, at, said in [
        ((both[:, :4], both[:, 3:6]), t, "attitude and momentum share memory"),
        ((numbers.reshape(20, 4), None), numbers[:20], "and the times share memory"),
        ((np.lib.stride_tricks.as_strided(np.empty(100), (20, 4), (16, 8)), None), t, "elements of q share memory"),
        ((np.lib.stride_tricks.as_strided(np.empty(4), (20, 4), (0, 8)), None), t, "elements of q share memory"),
    ]:
        with pytest.raises(polhode.InputError, match=said):
            free(at, out=out)


def test_rotations_go_in_and_nan_does_not_come_out_as_one():
    q = np.random.default_rng(1).normal(size=(5, 4))
    rotations = Rotation.from_quat(np.roll(q, -1, axis=1))
    a, b = (polhode.FreeMotion([1, 2, 3], attitude, [0.1, 0.2, 0.3]) for attitude in (q, rotations))
    assert b.shape == (5,) and np.abs((a(7.0).rotation.inv() * b(7.0).rotation).magnitude()).max() < 1e-15
    assert polhode.FreeMotion([1, 2, 3], rotations[0], [0.1, 0.2, 0.3]).shape == ()
    with pytest.raises(polhode.InputError, match="1 of 2 attitudes are NaN"):
        _ = polhode.FreeMotion([1, 2, 3], q[0], [0.1, 0.2, 0.3])([0.0, np.nan]).rotation


def test_times_in_any_order_and_the_accuracy_of_a_scene(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    dates = ["1993-01-03 TT", "1993-01-01 TT", "1993-01-02 TT", "1993-01-01 TT"]
    run("propagate", TOUTATIS, "--times", ",".join(dates), "-o", tmp_path / "theirs.csv")
    for times in (dates, ",".join(dates)):
        assert polhode.read(TOUTATIS).motion().ephemeris(times=times).write(tmp_path / "ours.csv") == 3
        assert (tmp_path / "ours.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    run("propagate", APOPHIS, "-o", tmp_path / "theirs.fits")
    polhode.read(APOPHIS).motion().ephemeris().write(tmp_path / "ours.fits")
    assert (tmp_path / "ours.fits").read_bytes() == (tmp_path / "theirs.fits").read_bytes()


def test_what_only_the_program_has_is_asked_of_the_program(tmp_path, capfd):
    assert polhode.program("methods") == run("methods").stdout
    case = ROOT / "data/truth/dev/sam-01.case"
    assert polhode.program("eval", "--method", "matrix-basis", case) == run("eval", "--method", "matrix-basis", case).stdout
    assert "ns" in polhode.program("bench", "--help")
    assert polhode.program("convert-time", "--to", "TT", input="2000-01-01 TAI\n").startswith("2000-01-01T00:00:32.184")
    with pytest.raises(polhode.InputError, match="no subcommand"):
        polhode.program("dance")
    with pytest.raises(polhode.FileError):
        polhode.program("info", tmp_path / "nothing.toml")
    polhode.program("chart", "speed-accuracy", "--size", "0.01", "-o", tmp_path, f"{TOUTATIS}@10d")
    assert (tmp_path / "speed-accuracy.ecsv").exists()
