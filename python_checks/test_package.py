"""The Python package gives what the program gives, to the bit, and refuses what it refuses."""

import datetime
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation
from support import ROOT, TOUTATIS, angle_rad, assert_within, propagate, run

import polhode

APOPHIS = ROOT / "data/bodies/apophis.toml"
ENVISAT = ROOT / "data/scenes/envisat-month.toml"
FORMATS = ["fits", "fits.gz", "aem", "xml", "csv", "ecsv", "jsonl"]
CASE = ROOT / "data/truth/dev/sam-01.case"


@pytest.fixture
def same_date(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


# --- The program's results, to the bit ------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_has_the_bytes_that_the_program_writes(tmp_path, same_date, ending):
    ours, theirs = tmp_path / f"ours.{ending}", tmp_path / f"theirs.{ending}"
    propagate(TOUTATIS, theirs, "--start", "1992-12-01 UTC", "--stop", "+3 d", "--tolerance", "10 arcsec", "--scale", "UTC")
    motion = polhode.read(TOUTATIS).motion()
    rows = motion.ephemeris("1992-12-01 UTC", "+3 d", tolerance="10 arcsec", scale="UTC").write(ours)
    assert rows > 10
    assert ours.read_bytes() == theirs.read_bytes()


@pytest.mark.parametrize(
    "options, ours",
    [
        (("--stop", "+2 d", "--step", "10 min", "--momentum"), dict(stop="+2 d", step="10 min")),
        (("--stop", "+2 d", "--count", "77", "--momentum"), dict(stop=2 * 86400.0, count=77)),
        (("--times", "1992-12-01 TT,1992-12-03T01:02:03.25 TT", "--momentum"), dict(times=["1992-12-01 TT", "1992-12-03T01:02:03.25 TT"])),
    ],
)
def test_every_spacing_has_the_rows_of_the_program(tmp_path, same_date, options, ours):
    scale = "TT" if "--count" in options else "TDB"
    propagate(APOPHIS, tmp_path / "theirs.csv", *options, "--scale", scale, "--frame", "ECLIPJ2000")
    motion = polhode.read(APOPHIS).motion(frame="ECLIPJ2000")
    motion.ephemeris(scale=scale, **ours).write(tmp_path / "ours.csv", momentum=True)
    assert (tmp_path / "ours.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()


def test_a_message_of_several_segments(tmp_path, same_date):
    spans = ("--start", "1992-12-01 TT", "--stop", "+1 d", "--start", "1992-12-05 TT", "--stop", "+1 d")
    options = ("--adm", "1.0", "--attitude-type", "EULER_ANGLE", "--euler-sequence", "ZYX")
    propagate(TOUTATIS, tmp_path / "theirs.aem", *spans, "--count", "5", *options)
    motion = polhode.read(TOUTATIS).motion()
    segments = [motion.ephemeris(f"1992-12-0{day} TT", "+1 d", count=5) for day in (1, 5)]
    rows = polhode.write(segments, tmp_path / "ours.aem", adm="1.0", attitude_type="EULER_ANGLE", euler_sequence="ZYX")
    assert rows == 10
    assert (tmp_path / "ours.aem").read_bytes() == (tmp_path / "theirs.aem").read_bytes()


def test_a_scene_moves_as_the_program_moves_it(tmp_path, same_date):
    scene = polhode.read(ENVISAT)
    motion = scene.motion()
    motion.ephemeris(count=1000).write(tmp_path / "ours.fits")
    propagate(ENVISAT, tmp_path / "theirs.fits", "--count", "1000")
    assert (tmp_path / "ours.fits").read_bytes() == (tmp_path / "theirs.fits").read_bytes()
    account = motion.account()
    assert account.max_error_rad <= scene.accuracy_rad and account.torque_evaluations > 0
    plan = scene.plan()
    printed = run("plan", ENVISAT).stdout
    assert plan.model in printed and plan.why in printed and f"{plan.error_rad:.2e}" in printed
    assert [effect.kept for effect in plan.effects] == [" kept " in line for line in printed.split("why\n")[1].split("\n\n")[0].splitlines()]
    with pytest.raises(polhode.InputError, match="propagated|span|reached"):
        motion(scene.span[1] + 3600)


def test_a_scene_built_without_a_file(tmp_path):
    """The same as one of a file, and its motion that of an independent run at a finer accuracy."""
    body = polhode.Body(
        "box", inertia=polhode.Inertia([8.0, 5.0, 11.0], absolute=True), epoch="2027-01-01 TT",
        q=Rotation.from_euler("z", 90, degrees=True), omega=[0.01, 0.002, 0.03],
    )
    orbit = polhode.Orbit.kepler(3.986004418e14, 7e6, 0.01, 0.0, [1, 0, 0], [0, 0, 1])
    torques = [polhode.Torque.gravity_gradient(3.986004418e14, orbit), polhode.Torque.constant([1e-6, 0, 2e-6])]
    scene = polhode.Scene("box in orbit", body, torques, after="2 h", accuracy="1e-5 rad")
    (tmp_path / "box.toml").write_text(
        'name = "box"\nsource = "a test"\n[inertia]\nmoments = [8.0, 5.0, 11.0]\nunit = "kg m2"\n[state]\n'
        'epoch = "2027-01-01 TT"\nframe = "ICRF"\n[state.attitude]\nq_frame_from_body_scalar_first = [1, 0, 0, 1]\n'
        '[state.angular_velocity]\ncomponents = [0.01, 0.002, 0.03]\naxes = "body"\nunit = "rad/s"\n'
    )
    (tmp_path / "scene.toml").write_text(
        'name = "box in orbit"\nsource = "a test"\nbody = "box.toml"\nframe = "ICRF"\nafter = "2 h"\naccuracy = "1e-5 rad"\n'
        "[orbit.earth]\nmu_m3_s2 = 3.986004418e14\nperiapsis_m = 7e6\neccentricity = 0.01\nperiapsis_after_epoch_s = 0\n"
        'to_periapsis = [1, 0, 0]\nnormal = [0, 0, 1]\n[[torque]]\nkind = "gravity gradient"\norbit = "earth"\n'
        '[[torque]]\nkind = "constant"\ntorque_n_m = [1e-6, 0, 2e-6]\naxes = "body"\n'
    )
    t = np.linspace(0, 7200, 100)
    of_file = polhode.read(tmp_path / "scene.toml").motion()(t)
    ours = scene.motion()(t)
    assert_within(angle_rad(ours.q, of_file.q), 1e-12)
    position, velocity = orbit(0.0)
    assert np.allclose(position, [7e6, 0, 0]) and velocity[1] > 7e3
    # Another way: in principal axes (y, x with a sign, z), at a finer tolerance.
    P = body.inertia.named_from_principal
    inertia = body.inertia.principal_moments
    q0 = (Rotation.from_quat([0, 0, np.sqrt(0.5), np.sqrt(0.5)]) * Rotation.from_matrix(P)).as_quat()[[3, 0, 1, 2]]
    turned = [torques[0], polhode.Torque.constant(P.T @ [1e-6, 0, 2e-6])]
    fine = polhode.TorquedMotion(inertia, q0, inertia * (P.T @ [0.01, 0.002, 0.03]), turned, 0.0, 7200.0, tolerance_rad=1e-11)
    finer = Rotation.from_quat(np.roll(fine(t).q, -1, axis=1)) * Rotation.from_matrix(P.T)
    assert_within((ours.rotation.inv() * finer).magnitude(), 1e-5)
    # In the inertial frame the momentum changes by what the torques do.
    assert np.allclose(fine(t).momentum, inertia * fine(t).omega)


@pytest.mark.parametrize("path", [TOUTATIS, ENVISAT, *sorted((ROOT / "data/samples").rglob("*.*"))], ids=lambda p: p.name)
def test_everything_is_read_and_said_as_by_info(path):
    said = run("info", "--json", path, check=False)
    if said.returncode != 0:
        if "is a scene" in said.stderr or polhode.InputError is None:
            assert isinstance(polhode.read(path), polhode.Scene)
            return
        try:
            assert isinstance(polhode.read(path), polhode.Scene)
        except polhode.Error as error:
            assert str(error) in said.stderr
        return
    assert polhode.read(path).info() == json.loads(said.stdout)[0]


def test_states_of_a_case_are_those_of_eval():
    for name in ("dev/sam-01", "torqued/combined-01"):
        path = ROOT / f"data/truth/{name}.case"
        case = polhode.read_case(path)
        tolerance = 1e-9 if case.torques else 1e-12
        printed = run("eval", "--tolerance", tolerance, path).stdout.split("\n")[:-1]
        state = case.motion(tolerance_rad=tolerance)(case.times)
        assert [f"{' '.join(f'{x:.17g}' for x in row)}" for row in np.hstack([state.q, state.momentum])] == printed


def test_histories_are_resampled_and_compared_as_by_the_program(tmp_path, same_date):
    propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+2 d", "--step", "30 min")
    history = polhode.read(tmp_path / "a.fits")
    assert isinstance(history, polhode.AttitudeHistory) and history.rows == 97 and history.scale == "TDB"
    propagate(tmp_path / "a.fits", tmp_path / "theirs.csv", "--start", "+1 h", "--step", "7 min", "--frame", "EME2000")
    history.ephemeris("+1 h", step="7 min", frame="EME2000").write(tmp_path / "ours.csv")
    assert (tmp_path / "ours.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    for other in (TOUTATIS, APOPHIS, tmp_path / "a.fits"):
        said = json.loads(run("compare", tmp_path / "a.fits", other, "--json").stdout)
        for difference in (polhode.compare(history, polhode.read(other)), polhode.compare(polhode.read(other), history)):
            assert (difference.largest_rad, difference.root_mean_square_rad) == (said["largest_rad"], said["root_mean_square_rad"])
            assert (difference.compared, difference.time_of_largest.text("TDB", 6)) == (said["rows_compared"], said["largest_at"])
    assert polhode.compare(history, polhode.read(TOUTATIS).motion(frame="EME2000")).largest_rad < 1e-14
    segment = history.segments[0]
    assert len(segment) == 97 and segment.q.shape == (97, 4) and segment.omega.shape == (97, 3)
    state = history(segment.t)
    assert_within(angle_rad(state.q, segment.q), 1e-15)
    assert state.frame == "ICRF" and np.array_equal(history(float(segment.t[3])).omega, segment.omega[3])
    again = polhode.AttitudeHistory("Toutatis", segment.epoch.to_astropy() + TimeDelta(segment.t, format="sec"), segment.q, segment.omega)
    assert polhode.compare(again, history).largest_rad < 1e-12
    with pytest.raises(polhode.InputError, match="no attitude"):
        history("2001-01-01 TT")


def test_dates_and_frames_are_those_of_the_program():
    dates = ["2016-12-31T23:59:60.5 UTC", "2029-04-13T21:46:00 UTC", "JD 2451545.25 TT", "1980-001 TAI"]
    for scale in ("TT", "TAI", "UTC", "TDB", "GPS", "ET"):
        said = run("convert-time", "--to", scale, input="\n".join(dates)).stdout.splitlines()
        assert [polhode.Instant(date).text(scale, 9) for date in dates] == said
        mjd = run("convert-time", "--to", scale, "--mjd", input="\n".join(dates)).stdout.splitlines()
        assert [f"{d:.0f} {f:.17g}" for d, f in (polhode.Instant(date).mjd(scale) for date in dates)] == mjd
    said = run("convert-frame", "--from", "TEME", "--to", "ITRF", "--ut1-utc", "-0.17", input="\n".join(dates)).stdout
    q = polhode.frame_rotation("TEME", "ITRF", dates, ut1_minus_utc_s=-0.17)
    assert [" ".join(f"{x:.17g}" for x in row) for row in q] == said.splitlines()
    assert np.array_equal(polhode.frame_rotation("TEME", "ITRF", dates[1], ut1_minus_utc_s=-0.17), q[1])
    assert np.array_equal(polhode.frame_rotation("TEME", "ITRF", polhode.Instant(dates[1]), -0.17), q[1])
    x = Rotation.from_quat(np.roll(polhode.frame_rotation("ECLIPJ2000", "ICRF"), -1)).apply([0, 1, 0])
    assert np.allclose(np.arctan2(x[2], x[1]), np.radians(84381.448 / 3600), atol=1e-15)


def test_instants():
    a, b = polhode.Instant("2029-04-13T21:46:00 UTC"), polhode.Instant("2029-04-13T21:46:00", "UTC")
    assert a == b and hash(a) == hash(b) and not a < b and a + 10.0 > a and (a + 10.0) - a == 10.0 and a - 1.0 < a
    time = Time("2029-04-13T21:46:00", scale="utc")
    assert abs(polhode.Instant.of(time) - a) < 1e-9 and abs((a.to_astropy() - time).sec) < 1e-9
    assert "2029-04-13T21:47:09.18" in repr(a)
    assert polhode.Instant("1950-01-01 UTC").utc_doubt and not polhode.Instant("2000-01-01 UTC").utc_doubt
    assert (1999, 1, 32.0) in polhode.leap_seconds()
    with pytest.raises(polhode.InputError, match="scale"):
        polhode.Instant("2029-04-13")


# --- Bodies without a file ------------------------------------------------------------------------------------------


def test_a_body_built_without_a_file_is_that_of_the_file():
    read = polhode.read(TOUTATIS)
    angles = np.radians([145.498, 65.865, 241.524])
    body = polhode.Body(
        "(4179) Toutatis", inertia=polhode.Inertia([3.0836, 3.235, 1.0]), epoch=Time("1992-11-09T17:49:47", scale="utc"),
        frame="ECLIPJ2000", q=polhode.q_from_euler("313", angles), omega=np.radians([14.51, 33.529, -98.709]) / 86400,
    )
    t = np.linspace(0, 1e6, 50)
    assert_within(angle_rad(body.motion()(t).q, read.motion()(t).q), 1e-13)
    assert not body.missing and body.info()["motion"]["mode"] == "long-axis mode"
    assert np.allclose(polhode.euler_angles("ZXZ", body.q) % (2 * np.pi), angles)
    assert np.allclose(body.momentum("ECLIPJ2000"), body.motion("ECLIPJ2000")(0.0).rotation.apply(body.motion()(0.0).momentum))
    rates = polhode.euler_rates("ZXZ", angles, body.omega)
    assert np.allclose(polhode.omega_from_euler_rates("ZXZ", angles, rates), body.omega)
    with pytest.raises(polhode.InputError, match="lacks an inertia"):
        polhode.Body("nothing").motion()


def test_what_would_lose_its_meaning_as_a_number_is_refused():
    one = polhode.FreeMotion([1, 2, 3], [1, 0, 0, 0], [0.1, 0.2, 0.3])
    body = lambda omega: polhode.Body("box", inertia=polhode.Inertia([8, 5, 11]), epoch="2027-01-01 TT", q=[1, 0, 0, 0], omega=omega)
    assert_within(np.abs(body([1, 2, 3] * u.deg / u.s).omega - np.deg2rad([1, 2, 3])), 1e-16)
    assert_within(np.abs(polhode.q_from_euler("ZXZ", [90, 0, 0] * u.deg) - polhode.q_from_euler("ZXZ", [np.pi / 2, 0, 0])), 1e-16)
    with pytest.raises(u.UnitConversionError):
        body([1, 2, 3] * u.m)
    masked = np.ma.array([1.0, 2.0], mask=[0, 1])
    for wrong, message in [
        (lambda: polhode.Inertia([8, 5, 11] * u.g * u.cm**2, absolute=True), "a Quantity in cm2 g"),
        (lambda: polhode.Torque.constant([1, 0, 0] * u.mN * u.m), "a Quantity in m mN"),
        (lambda: polhode.Inertia.from_tensor([[1, 0.1, 0], [-0.3, 1, 0], [0, 0, 1]]), "not symmetric"),
        (lambda: one(masked), "masked"),
        (lambda: one(np.array([1 + 2j])), "complex"),
        (lambda: one(np.datetime64("2000-01-01")), "no time scale"),
        (lambda: one(datetime.datetime(2000, 1, 1)), "no time scale"),
    ]:
        with pytest.raises(polhode.InputError, match=message):
            wrong()
    for right in (np.timedelta64(5000, "ms"), datetime.timedelta(seconds=5), 5 * u.s):
        assert np.array_equal(one(right).q, one(5.0).q)
    assert np.array_equal(one(np.array([5000], "m8[ms]")).q, one([5.0]).q)
    with pytest.raises(OverflowError):
        one(10**400)
    with pytest.raises(TypeError, match="a file's name"):
        polhode.read(b"/tmp/x")
    inertia = polhode.Inertia([8, 5, 11], [0.1, -0.2, 0.3])
    assert_within(np.abs(inertia.tensor - [[8, 0.1, -0.2], [0.1, 5, 0.3], [-0.2, 0.3, 11]]), 1e-14)


def test_partial_derivatives_are_those_of_eval():
    case = polhode.read_case(CASE)
    ours = case.motion().partials(case.times)
    assert ours.shape == (len(case.times), 6, 9)
    rows = np.loadtxt(run("eval", "--partials", CASE).stdout.splitlines())
    assert np.array_equal(ours, rows[:, 7:].reshape(-1, 6, 9))
    assert np.array_equal(case.motion().partials(float(case.times[0])), ours[0])
    with pytest.raises(polhode.InputError, match="the motion of one body"):
        polhode.FreeMotion([[1, 2, 3], [1, 2, 3]], [1, 0, 0, 0], [1, 2, 3]).partials(0.0)


def test_partial_derivatives_are_in_the_axes_of_the_states():
    """Against differences of bodies whose attitude and rate at the epoch are a little other, in the named axes."""
    body = polhode.read(TOUTATIS)
    motion, t, h = body.motion(), 10 * 86400.0, 1e-6
    start, partials = motion(0.0), motion.partials(t)

    def end(theta, momentum):
        turned = start.rotation * Rotation.from_rotvec(theta)
        q = np.roll(turned.as_quat(), 1)
        omega = np.linalg.solve(body.inertia.tensor, momentum)
        return polhode.Body("other", inertia=body.inertia, epoch=motion.epoch, q=q, omega=omega, frame=start.frame).motion()(t)

    size = np.linalg.norm(start.momentum)
    for column in range(6):
        step = np.zeros(6)
        step[column] = h if column < 3 else h * size
        low, high = (end(sign * step[:3], start.momentum + sign * step[3:]) for sign in (-1, 1))
        turn = (low.rotation.inv() * high.rotation).as_rotvec() / (2 * h)
        change = (high.momentum - low.momentum) / (2 * h)
        wanted = partials[:, column] * (1 if column < 3 else size)
        assert_within(np.abs(turn - wanted[:3]) / max(1, np.linalg.norm(wanted[:3])), 1e-7)
        assert_within(np.abs(change - wanted[3:]) / max(size, np.linalg.norm(wanted[3:])), 1e-7)


def test_meshes():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
    facets = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    box = polhode.Mesh(corners, facets)
    solid = box.mass_properties()
    assert solid.volume == pytest.approx(6) and np.allclose(solid.centre_of_mass, [0.5, 1, 1.5])
    assert np.allclose(solid.inertia_about_centre, np.diag([13, 10, 5]) / 2)
    assert np.allclose(polhode.Inertia.from_tensor(solid.inertia_about_centre).principal_moments, [2.5, 5, 6.5])
    assert np.array_equal(box.facets, facets) and np.array_equal(box.vertices, corners)
    with pytest.raises(polhode.InputError, match="facet"):
        polhode.Mesh(corners, facets[:-1]).mass_properties()
    sample = next((ROOT / "data/samples").rglob("*.obj"))
    assert polhode.read_mesh(sample).vertices.shape[1] == 3


def test_published_periods_give_back_their_motion():
    inertia = polhode.Inertia([1.0, 1.2, 1.7])
    for solution in polhode.solve_periods(inertia, 3600.0, 7000.0):
        q, momentum, theta = solution.state(inertia, 0.3, 0.2)
        assert polhode.energy_at(inertia, theta, 0.2) == pytest.approx(solution.energy)
        rates = polhode.FreeMotion(inertia.principal_moments, q, momentum).mean_rates()
        assert rates["polhode_period_s"] == pytest.approx(7000, rel=1e-9)
        assert 2 * np.pi / rates["long_axis_precession_rad_s"] == pytest.approx(3600, rel=1e-9)
    z = Rotation.from_quat(np.roll(polhode.q_frame_from_momentum(1.0, 0.5), -1)).apply([0, 0, 1])
    assert np.allclose(z, [np.cos(0.5) * np.cos(1), np.cos(0.5) * np.sin(1), np.sin(0.5)])


def test_torques_are_what_their_formulas_say():
    q, omega, moments = [1, 0, 0, 0], np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 3.0])
    mu, r = 4e14, np.array([7e6, 1e6, 2e6])
    orbit = polhode.Orbit.table([0.0, 10, 20, 30, 40, 50, 60, 70], np.tile(r, (8, 1)))
    value = polhode.Torque.gravity_gradient(mu, orbit)(30.0, q, omega, moments)
    assert np.allclose(value, 3 * mu / np.linalg.norm(r) ** 5 * np.cross(r, moments * r), rtol=1e-12)
    assert np.allclose(polhode.Torque.damping(0.5)(0, q, omega, moments), -0.5 * omega)
    assert np.allclose(polhode.Torque.damping([1, 2, 3])(0, q, omega, moments), -omega * [1, 2, 3])
    assert np.allclose(polhode.Torque.constant([1, 2, 3], "frame")(0, Rotation.from_euler("z", 90, degrees=True), omega, moments), [2, -1, 3])
    pulse = polhode.Torque.pulse(10.0, 5.0, [1, 0, 0])
    assert np.array_equal(pulse(12.0, q, omega, moments), [1, 0, 0]) and np.array_equal(pulse(16.0, q, omega, moments), [0, 0, 0])
    field = 7.8e15 / np.linalg.norm(r) ** 3 * (3 * r[2] * r / (r @ r) - [0, 0, 1])
    eddy = polhode.Torque.eddy_currents(np.diag([1e6, 2e6, 3e6]), [0, 0, 1], 7.8e15, orbit)(30.0, q, omega, moments)
    assert np.allclose(eddy, np.cross(field, [1e6, 2e6, 3e6] * np.cross(field, omega)), rtol=1e-6)
    assert [torque.name for torque in polhode.read(ENVISAT).torques] == [name.split(",")[0] for name in polhode.read(ENVISAT).torque_names]


# --- Faults ---------------------------------------------------------------------------------------------------------


def test_faults_say_file_line_and_message(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(TOUTATIS.read_text().replace('"deg/day"', '"deg/fortnight"'))
    with pytest.raises(polhode.InputError) as caught:
        polhode.read(path)
    error = caught.value
    lines = path.read_text().splitlines()
    assert error.file == str(path) and "deg/fortnight" in lines[error.line - 1] and "fortnight" in error.message
    assert str(error) == f"{path}:{error.line}: {error.message}" and isinstance(error, ValueError)
    assert f"polhode: {error}\n" == run("info", path, check=False).stderr
    with pytest.raises(polhode.FileError) as caught:
        polhode.read(tmp_path / "nothing.toml")
    assert isinstance(caught.value, OSError) and isinstance(caught.value, polhode.Error)
    with pytest.raises(polhode.InputError, match="moments"):
        polhode.FreeMotion([3, 2, 1], [1, 0, 0, 0], [0, 0, 1])
    with pytest.raises(polhode.InputError, match="unknown method 'rk4'"):
        polhode.read(TOUTATIS).motion(method="rk4")
    with pytest.raises(polhode.InputError, match="epoch"):
        polhode.FreeMotion([1, 2, 3], [1, 0, 0, 0], [0, 0, 1])("2029-04-13 UTC")
    with pytest.raises(polhode.ComputationError, match="evaluations"):
        polhode.read(ENVISAT).motion(max_evaluations=10)
    motion = polhode.read(TOUTATIS).motion()
    with pytest.raises(polhode.InputError, match="one of them is allowed"):
        motion.ephemeris(stop="+1 d", step=60, count=3)
    with pytest.raises(polhode.InputError, match="no format"):
        motion.ephemeris(stop="+1 d", step=60).write(tmp_path / "a.doc")
    with pytest.raises(polhode.FileError):
        motion.ephemeris(stop="+1 d", step=60).write(tmp_path / "no folder" / "a.csv")
    with pytest.raises((TypeError, ValueError)):
        motion("yesterday")
    with pytest.raises(TypeError):
        motion(None)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["wrong.toml"]


# --- The package itself ---------------------------------------------------------------------------------------------


def python(code, **environment):
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, **environment})
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_astropy_and_scipy_are_imported_only_when_used():
    code = f"""import sys, polhode
motion = polhode.read({str(TOUTATIS)!r}).motion()
motion(0.0).q; motion([0.0, 1.0]).omega; motion("1993-01-01 UTC").momentum
assert not set(sys.modules) & {{"astropy", "scipy", "matplotlib", "spiceypy"}}, "imported"
motion(0.0).rotation
assert "scipy" in sys.modules and "astropy" not in sys.modules"""
    python(code)


def test_the_program_is_there():
    said = subprocess.run([sys.executable, "-m", "polhode", "info", TOUTATIS], capture_output=True, text=True)
    assert said.returncode == 0 and said.stdout == run("info", TOUTATIS).stdout
    assert run("--version").stdout.strip().endswith(polhode.__version__)


def test_every_name_says_what_it_is():
    for name in polhode.__all__:
        thing = getattr(polhode, name)
        assert name.startswith("__") or thing.__doc__, f"{name} has no docstring"


def test_the_stub_is_that_of_the_module(tmp_path):
    out = tmp_path / "_core.pyi"
    subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "polhode._core", "-o", out], check=True)
    assert out.read_text() == (ROOT / "lib/python/polhode/_core.pyi").read_text(), "run python -m nanobind.stubgen -m polhode._core -o lib/python/polhode/_core.pyi"
