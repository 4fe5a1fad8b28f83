"""States that the package gives: of one body and of many, at times of every kind, and events between them."""

import threading

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, angle_rad, assert_within, toutatis

import polhode


def random_bodies(count, seed=1):
    random = np.random.default_rng(seed)
    moments = np.sort(random.uniform(1, 1.9, (count, 3)), axis=1)
    return moments, random.normal(size=(count, 4)), random.normal(size=(count, 3))


def test_states_of_a_body_agree_with_multiprecision():
    seconds = [0, 86400, 10 * 86400 + 0.5]
    q, omega = toutatis().states(seconds)
    motion = polhode.read(TOUTATIS).motion(frame="ICRF")
    state = motion(np.array(seconds))
    assert_within(angle_rad(state.q, q), 5e-14)
    assert np.allclose(state.omega, omega, rtol=0, atol=1e-18)
    assert (state.frame, state.axes, state.epoch) == ("ICRF", "named", polhode.read(TOUTATIS).epoch)
    assert state.units["omega"] == "rad / s" and state.units["t"] == "s"


def test_times_may_be_anything():
    motion = polhode.read(TOUTATIS).motion()
    epoch = Time("1992-11-09T17:49:47", scale="utc")
    t = np.array([[0.0, 3600.0, 7200.25], [1e5, 2e5, 3e6]])
    expected = motion(t)
    assert expected.q.shape == (2, 3, 4) and expected.omega.shape == (2, 3, 3) and expected.momentum.shape == (2, 3, 3)
    for other in (epoch + TimeDelta(t, format="sec"), t * u.s, t / 3600 * u.h, TimeDelta(t, format="sec"), t.astype(int) + (t % 1), t.tolist()):
        assert_within(angle_rad(motion(other).q.reshape(-1, 4), expected.q.reshape(-1, 4)), 1e-13)
    one = motion(3600.0)
    assert one.q.shape == (4,) and np.array_equal(one.q, expected.q[0, 1]) and np.array_equal(one.omega, expected.omega[0, 1])
    instant = polhode.read(TOUTATIS).epoch + 3600.0
    for other in (3600, np.float64(3600), np.array(3600.0), instant, instant.text("TT", 9) + " TT", 1 * u.h, epoch + 1 * u.h):
        assert_within(angle_rad(motion(other).q, one.q), 1e-13)
        assert motion(other).q.shape == (4,)
    several = motion([instant, instant + 1.0])
    assert several.q.shape == (2, 4)
    assert_within(angle_rad(several.rotation.as_quat()[:, [3, 0, 1, 2]], several.q), 1e-15)
    assert isinstance(one.rotation, Rotation) and len(expected.rotation) == 6
    assert np.isnan(motion(np.nan).q).all()
    assert motion(np.arange(10.0)[::2]).q.shape == (5, 4) and motion([]).q.shape == (0, 4)


def near(a, b, relative=2e-15):
    """Bodies side by side and alone agree to some units in the last place."""
    return a.shape == b.shape and np.abs(a - b).max() <= relative * np.abs(b).max()


def test_bodies_are_broadcast_against_times():
    moments, q, m = random_bodies(6)
    bodies = polhode.FreeMotion(moments, q, m)
    assert bodies.shape == (6,) and bodies.axes == "principal"
    t = np.random.default_rng(2).uniform(-1e4, 1e4, 5)
    alone = [polhode.FreeMotion(*body)(t) for body in zip(moments, q, m)]
    outer = bodies(t[:, None])
    assert outer.q.shape == (5, 6, 4) and outer.momentum.shape == (5, 6, 3) and outer.omega.shape == (5, 6, 3)
    for k in range(6):
        assert near(outer.q[:, k], alone[k].q) and near(outer.omega[:, k], alone[k].omega)
    grid = polhode.FreeMotion(moments[:, None], q[:, None], m[:, None])
    rows = grid(t)
    assert grid.shape == (6, 1) and rows.q.shape == (6, 5, 4)
    assert np.array_equal(rows.q, outer.q.transpose(1, 0, 2)) and np.array_equal(rows.momentum, outer.momentum.transpose(1, 0, 2))
    each = bodies(np.arange(6.0))
    assert each.q.shape == (6, 4) and near(each.q[2], polhode.FreeMotion(moments[2], q[2], m[2])(2.0).q)
    assert near(bodies(3.0).q[4], polhode.FreeMotion(moments[4], q[4], m[4])(3.0).q)
    three = polhode.FreeMotion(moments.reshape(2, 3, 3), q.reshape(2, 3, 4), m.reshape(2, 3, 3))
    cube = three(np.arange(4.0)[:, None, None])
    assert cube.q.shape == (4, 2, 3, 4) and near(cube.q[3, 1, 2], polhode.FreeMotion(moments[5], q[5], m[5])(3.0).q)
    middle = polhode.FreeMotion(moments[:2, None, None], q[:2, None, None], m[:2, None, None])(t.reshape(1, 5, 1) + np.zeros((1, 5, 3)))
    assert middle.q.shape == (2, 5, 3, 4) and near(middle.q[1, :, 2], alone[1].q)
    one_inertia = polhode.FreeMotion(moments[0], q[0], m)
    assert one_inertia.shape == (6,) and near(one_inertia(7.0).q[3], polhode.FreeMotion(moments[0], q[0], m[3])(7.0).q)
    by_legendre = polhode.FreeMotion(moments, q, m, method="legendre")
    assert near(by_legendre(t[:, None]).q, outer.q, 1e-9)
    many = polhode.FreeMotion(moments[0], q[0], m[0] * (1 + 1e-3 * np.arange(1000.0)[:, None]))
    assert near(many(5.0).q[999], polhode.FreeMotion(moments[0], q[0], m[0] * 1.999)(5.0).q)
    assert np.array_equal(many([[5.0]] * 3).q[2], many(5.0).q)
    for threads in (0, 2, 3):
        assert np.array_equal(bodies(t[:, None], threads=threads).q, outer.q)
    with pytest.raises(polhode.InputError, match="do not go together"):
        bodies(np.zeros(5))
    with pytest.raises(polhode.InputError, match="do not go together"):
        polhode.FreeMotion(moments, q[:4], m)


def test_results_are_written_where_they_are_wanted():
    moments, q, m = random_bodies(1)
    free = polhode.FreeMotion(moments[0], q[0], m[0])
    t = np.linspace(-1e3, 1e6, 2000)
    expected = free(t)
    for layout in (lambda n, w: np.empty((n, w)), lambda n, w: np.empty((w, n)).T, lambda n, w: np.empty((n, 9))[:, 1 : 1 + w]):
        out = layout(2000, 4), layout(2000, 3)
        state = free(t, out=out)
        assert state.q is out[0] and state.momentum is out[1] and np.array_equal(out[0], expected.q)
        assert np.array_equal(out[1], expected.momentum) and np.array_equal(state.omega, expected.omega)
    alone = np.empty((2000, 4))
    assert free(t, out=(alone, None), threads=2).q is alone and np.array_equal(alone, expected.q)
    body = polhode.read(TOUTATIS).motion()
    state = body(t, out=(np.empty((2000, 4)), np.empty((2000, 3))))
    assert np.array_equal(state.q, body(t).q) and np.allclose(state.omega, body(t).omega, rtol=1e-14)
    frozen = np.empty((2000, 4))
    frozen.flags.writeable = False
    for wrong in ((np.empty((1999, 4)), None), (np.empty((2000, 4), "f4"), None), (np.empty((4, 2000)), None), (frozen, None), alone):
        with pytest.raises(polhode.InputError, match="out"):
            free(t, out=wrong)


def test_threads_of_python_share_a_motion():
    motion = polhode.read(TOUTATIS).motion()
    t = np.linspace(0, 1e7, 100_000)
    results = [None] * 4
    workers = [threading.Thread(target=lambda i=i: results.__setitem__(i, motion(t).q)) for i in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert all(np.array_equal(result, results[0]) for result in results)


def test_events():
    handle = polhode.read(ROOT / "data/bodies/t-handle.toml")
    motion = handle.motion()
    said = handle.info()["motion"]
    assert motion.next_flip() == said["first_flip_after_epoch_s"]
    assert motion.mean_rates()["polhode_period_s"] == pytest.approx(said["polhode_period_s"], rel=1e-12)
    assert abs(motion(motion.next_flip()).momentum @ handle.inertia.named_from_principal[:, 1]) < 1e-9 * said["momentum_ratios_rad_s" if "momentum_ratios_rad_s" in said else "momentum_N_m_s"]
    t, angle = motion.next_pass([1, 0, 0], [0.6, 0, 0.8], "40 deg", 0.0, 1000.0)
    assert angle <= np.radians(40) + 1e-9
    assert motion(t).rotation.apply([1, 0, 0]) @ [0.6, 0, 0.8] == pytest.approx(np.cos(angle), abs=1e-9)
    assert motion.condition_number(1000.0) > 1
