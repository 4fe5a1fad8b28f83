"""Our CCSDS messages through a strict reader and through two public ones, brahe and ccsds-ndm."""

import astropy.units as u
import numpy as np
import pytest
from aem_reader import NUMBERS, read
from astropy.table import Table
from astropy.time import Time
from brahe.ccsds import AEM
from ccsds_ndm.ndm_io import NdmIo
from scipy.spatial.transform import Rotation
from support import SPINNER, TOUTATIS, assert_within, propagate, run, sign_is_continuous

SPAN = ("--start", "1992-12-01 TDB", "--stop", "+9 d", "--step", "1 h")
TYPES = list(NUMBERS)
VERSION_1 = ["QUATERNION", "QUATERNION/DERIVATIVE", "EULER_ANGLE"]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """The same rows as FITS: q scalar last, omega in body axes."""
    out = propagate(TOUTATIS, tmp_path_factory.mktemp("aem") / "a.fits", *SPAN)
    return Table.read(out, hdu="ATTITUDE")


def rotations(kind, numbers, sequence="ZXZ"):
    if kind.startswith("QUATERNION"):
        return Rotation.from_quat(numbers[:, :4])
    return Rotation.from_euler(sequence, numbers[:, :3], degrees=True)  # intrinsic turns of the body: A to B, passive


def check_rows(kind, numbers, rows, sequence="ZXZ"):
    turn = rotations(kind, numbers, sequence)
    assert_within((turn.inv() * Rotation.from_quat(rows["QPARAM"])).magnitude(), 2e-15 if kind[0] == "Q" else 2e-14)
    if kind[0] == "Q":
        assert np.array_equal(numbers[:, :4], np.asarray(rows["QPARAM"]))  # to the last printed digit
        assert sign_is_continuous(numbers[:, :4])
    if kind.endswith("/ANGVEL"):
        assert_within(np.abs(np.radians(numbers[:, -3:]) - rows["OMEGA"]), 1e-20)
    elif kind == "QUATERNION/DERIVATIVE":
        quarter = np.concatenate([rows["OMEGA"] / 2, np.zeros((len(rows), 1))], axis=1)
        q = np.asarray(rows["QPARAM"])
        expected = np.concatenate(
            [
                q[:, 3:] * quarter[:, :3] + np.cross(q[:, :3], quarter[:, :3]),
                -np.sum(q[:, :3] * quarter[:, :3], axis=1, keepdims=True),
            ],
            axis=1,
        )
        assert_within(np.abs(numbers[:, 4:] - expected), 1e-20)
    elif kind == "EULER_ANGLE/DERIVATIVE":
        step = 60.0  # the angles moved by their rates, against the attitude turned by omega: they part at order step^2
        moved = Rotation.from_euler(sequence, numbers[:, :3] + step * numbers[:, 3:], degrees=True)
        turned = turn * Rotation.from_rotvec(step * rows["OMEGA"])
        assert_within((moved.inv() * turned).magnitude(), 4e-6)


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_strict_reader(tmp_path, rows, kind, version):
    if version == "1.0" and kind not in VERSION_1:
        return  # refused: test_propagate
    out = propagate(TOUTATIS, tmp_path / "a.aem", *SPAN, "--adm", version, "--attitude-type", kind)
    found, (segment,) = read(out)
    assert found == version
    assert segment.meta["REF_FRAME_A"] == "ICRF" and segment.meta["TIME_SYSTEM"] == "TDB"
    start = Time("1992-12-01", scale="tdb")
    assert_within(np.abs((Time(segment.dates, scale="tdb") - start).to_value("s") - 3600 * np.arange(217)), 1e-9)
    check_rows(kind, segment.rows, rows)


@pytest.mark.parametrize("sequence", ["XYZ", "ZYX", "YXY", "ZYZ"])
def test_euler_sequences(tmp_path, rows, sequence):
    options = ("--attitude-type", "EULER_ANGLE/DERIVATIVE", "--euler-sequence", sequence)
    _, (segment,) = read(propagate(TOUTATIS, tmp_path / "a.aem", *SPAN, *options))
    assert segment.meta["EULER_ROT_SEQ"] == sequence
    turn = rotations("EULER_ANGLE", segment.rows, sequence)
    assert_within((turn.inv() * Rotation.from_quat(rows["QPARAM"])).magnitude(), 2e-14)


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("ending", ["aem", "xml"])
def test_brahe(tmp_path, rows, kind, ending):
    if (kind, ending) == ("EULER_ANGLE/ANGVEL", "xml"):
        pytest.skip("brahe 1.8.0 wants an element <angVel> that the CCSDS schema does not have there")
    message = AEM.from_file(str(propagate(TOUTATIS, tmp_path / f"a.{ending}", *SPAN, "--attitude-type", kind)))
    (segment,) = message.segments
    assert (segment.attitude_type, segment.ref_frame_a, segment.time_system) == (kind, "ICRF", "TDB")
    # brahe counts elapsed time in TT, and has a TDB of its own, good to some 10 microseconds.
    first = Time("1992-12-01", scale="tdb")
    elapsed = [((first + 3600 * i * u.s).tt - first.tt).to_value("s") for i in range(len(rows))]
    found = [state.epoch - segment.states[0].epoch for state in segment.states]
    assert_within(np.abs(np.array(found) - elapsed), 3e-5)
    # brahe's quaternion turns components from frame A to frame B, scalar first, Hamilton's or its conjugate: as matrices.
    trajectory = message.segment_to_attitude_trajectory(0)
    for state, row in list(zip(segment.states, rows))[::20]:
        passive = np.array(trajectory.rotation_matrix(state.epoch).to_matrix())
        expected = Rotation.from_quat(row["QPARAM"]).as_matrix().T  # v_body = M v_inertial
        assert_within(np.abs(passive - expected), 1e-14)
    if trajectory.has_rates:
        for state, row in list(zip(segment.states, rows))[::20]:
            assert_within(np.abs(trajectory.angular_velocity(state.epoch) - row["OMEGA"]), 1e-12)


@pytest.mark.parametrize("version, kind", [("1.0", "QUATERNION"), ("1.0", "QUATERNION/DERIVATIVE")] + [("2.0", k) for k in TYPES])
@pytest.mark.parametrize("ending", ["aem", "xml"])
def test_ccsds_ndm(tmp_path, rows, version, kind, ending):
    """Its classes are generated from the CCSDS schemas."""
    if (version, ending) == ("2.0", "aem"):
        pytest.skip("ccsds-ndm 3.1.1 fails on every AEM 2.0 in KVN (KeyError)")
    out = propagate(TOUTATIS, tmp_path / f"a.{ending}", *SPAN, "--adm", version, "--attitude-type", kind)
    states = NdmIo().from_path(out).body.segment[0].data.attitude_state
    assert len(states) == len(rows)
    for state, row in list(zip(states, rows))[::20]:
        (filled,) = [value for value in vars(state).values() if value is not None]
        if kind.startswith("QUATERNION"):
            q = filled.quaternion
            assert [q.q1, q.q2, q.q3, q.qc] == list(row["QPARAM"])
        else:
            angles = [filled.angle_1.value, filled.angle_2.value, filled.angle_3.value]
            turn = Rotation.from_euler("ZXZ", angles, degrees=True)
            assert_within((turn.inv() * Rotation.from_quat(row["QPARAM"])).magnitude(), 2e-14)


def test_two_segments(tmp_path):
    spans = ("--start", "1992-12-01 TDB", "--stop", "+1 d", "--start", "1996-11-25 TDB", "--stop", "+2 d", "--step", "1 h")
    out = propagate(TOUTATIS, tmp_path / "a.aem", *spans)
    _, segments = read(out)
    assert [len(segment.rows) for segment in segments] == [25, 49]
    assert segments[1].meta["START_TIME"] == "1996-11-25T00:00:00.000"
    assert len(AEM.from_file(str(out)).segments) == 2


def test_leap_second(tmp_path):
    span = ("--scale", "UTC", "--start", "2016-12-31T23:59:59", "--stop", "+2 s", "--step", "0.5")
    _, (segment,) = read(propagate(TOUTATIS, tmp_path / "a.aem", *span))
    assert segment.dates == [
        "2016-12-31T23:59:59.000",
        "2016-12-31T23:59:59.500",
        "2016-12-31T23:59:60.000",
        "2016-12-31T23:59:60.500",
        "2017-01-01T00:00:00.000",
    ]


def test_no_line_is_longer_than_the_standard_allows(tmp_path):
    body = tmp_path / "body.toml"
    source = "words of a source, " * 100 + "ü" * 600 + " and an end"
    body.write_text(SPINNER.replace("a test", source))
    for ending in ("aem", "xml"):
        text = propagate(body, tmp_path / f"a.{ending}", "--stop", "+1 min", "--count", "3").read_text()
        if ending == "aem":
            assert max(len(line.encode()) for line in text.splitlines()) <= 254
            words = "".join(line.removeprefix("COMMENT") for line in text.splitlines() if line.startswith("COMMENT"))
        else:
            words = text
        assert source.replace(" ", "") in words.replace(" ", "")
    body.write_text(SPINNER.replace("spinner", "a" * 241))
    result = run("propagate", body, "-o", tmp_path / "b.aem", "--stop", "+1 min", "--count", "3", check=False)
    assert result.returncode == 2 and "OBJECT_NAME has 241 bytes" in result.stderr
    assert not (tmp_path / "b.aem").exists()
    propagate(body, tmp_path / "b.xml", "--stop", "+1 min", "--count", "3")


@pytest.mark.parametrize("ending", ["aem", "csv", "ecsv"])
def test_direction_and_order(tmp_path, ending):
    """A body turned by +90 deg about inertial z: 0 0 0.7071 0.7071 in every format."""
    body = tmp_path / "spinner.toml"
    body.write_text(SPINNER)
    out = propagate(body, tmp_path / f"a.{ending}", "--stop", "+10 s", "--step", "10", "--scale", "TT")
    if ending == "aem":
        q = read(out)[1][0].rows[1, :4]
    else:
        table = Table.read(out, format="ascii.ecsv" if ending == "ecsv" else "ascii.csv")
        q = np.array([table[name][1] for name in ("q_x", "q_y", "q_z", "q_scalar")])
    assert_within(np.abs(q - [0, 0, np.sqrt(0.5), np.sqrt(0.5)]), 1e-15)


@pytest.mark.parametrize("scale", ["tdb", "tt", "tai", "utc"])
def test_ecsv_has_times_and_units(tmp_path, rows, scale):
    out = propagate(TOUTATIS, tmp_path / "a.ecsv", "--start", "1992-12-01", *SPAN[2:], "--scale", scale)
    table = Table.read(out, format="ascii.ecsv")
    time = table[f"date_{scale}"]
    assert time.scale == scale
    assert_within(np.abs((time - Time("1992-12-01", scale=scale)).to_value("s") - 3600 * np.arange(217)), 1e-9)
    assert table["omega_body_x_rad_s"].unit == "rad / s"
    if scale == "tdb":
        q = np.stack([table[name] for name in ("q_x", "q_y", "q_z", "q_scalar")], axis=1)
        assert np.array_equal(q, np.asarray(rows["QPARAM"]))
        assert table.meta["frame_a"] == "ICRF"
