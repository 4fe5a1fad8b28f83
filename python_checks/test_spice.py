"""Our kernels in the SPICE toolkit (spiceypy) and in ANISE: attitudes, rates, directions, promised errors."""

import subprocess
import sys

import anise
import numpy as np
import pytest
import spiceypy
from astropy.table import Table
from scipy.spatial.transform import Rotation
from support import ROOT, SPINNER, TOUTATIS, assert_within, propagate, toutatis

TOLERANCE_RAD = 1e-9


def spice_et(table):
    """SPICE's ET of the rows by the toolkit's own conversion of TT."""
    spiceypy.pdpool("DELTET/DELTA_T_A", [32.184])
    spiceypy.pdpool("DELTET/K", [1.657e-3])
    spiceypy.pdpool("DELTET/EB", [1.671e-2])
    spiceypy.pdpool("DELTET/M", [6.239996, 1.99096871e-7])
    tt = table["TIME"].tt
    seconds = (tt.jd1 - 2451545.0) * 86400 + tt.jd2 * 86400
    return np.array([spiceypy.unitim(t, "TDT", "ET") for t in seconds])


def kernels(fits, folder, *options):
    result = subprocess.run(
        [sys.executable, ROOT / "tools/spice_kernels.py", fits, "-o", folder, *options], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("spice")
    fits = propagate(TOUTATIS, folder / "toutatis.fits", "--stop", "+40 d", "--step", "1 h")
    kernels(fits, folder)
    return folder


@pytest.fixture
def loaded(folder):
    spiceypy.kclear()
    spiceypy.furnsh(str(folder / "toutatis.tm"))
    table = Table.read(folder / "toutatis.fits", hdu="ATTITUDE", astropy_native=True)
    yield table, spice_et(table)
    spiceypy.kclear()


def turned(matrix, row):
    """Angle between a matrix that takes J2000 components to the body's and a row."""
    return (Rotation.from_matrix(np.asarray(matrix).T).inv() * Rotation.from_quat(row["QPARAM"])).magnitude()


# At the rows: the rate times the resolution of ET (3e-8 s in 1992) and the toolkit's own rounding.
AT_ROWS_RAD = 2e-5 * 6e-8 + 4e-15


def inside(et):
    """The first and last row's clock readings may round out of the covered span."""
    return slice(1, len(et) - 1)


@pytest.mark.parametrize("frame, limit", [("TOUTATIS_AXES", AT_ROWS_RAD), ("TOUTATIS_AXES_PCK", TOLERANCE_RAD)])
def test_pxform_at_the_rows(loaded, frame, limit):
    table, et = loaded
    errors = [turned(spiceypy.pxform("J2000", frame, t), row) for t, row in zip(et[inside(et)], table[inside(et)])]
    assert_within(errors, limit)


@pytest.mark.parametrize("frame, limit", [("TOUTATIS_AXES", 2e-15), ("TOUTATIS_AXES_PCK", 1e-11)])
def test_sxform_gives_the_rates(loaded, frame, limit):
    table, et = loaded
    errors = []
    for t, row in zip(et[inside(et)], table[inside(et)]):
        matrix, omega_inertial = spiceypy.xf2rav(spiceypy.sxform("J2000", frame, t))
        errors.append(np.linalg.norm(matrix @ omega_inertial - row["OMEGA"]))
    assert_within(errors, limit)


def test_type_3_by_ckgpav(folder, loaded):
    table, et = loaded
    spiceypy.unload(str(folder / "toutatis_ck5.bc"))
    spiceypy.furnsh(str(folder / "toutatis_ck3.bc"))
    attitude, rate = [], []
    for t, row in zip(et[inside(et)], table[inside(et)]):
        matrix, omega_inertial, _ = spiceypy.ckgpav(-2004179, spiceypy.sce2c(-2004179, t), 0.0, "J2000")
        attitude.append(turned(matrix, row))
        rate.append(np.linalg.norm(matrix @ omega_inertial - row["OMEGA"]))
    assert_within(attitude, AT_ROWS_RAD)
    assert_within(rate, 2e-5 * 1e-9)  # linear between rows: what the clock's rounding moves


@pytest.mark.parametrize("frame, limit", [("TOUTATIS_AXES", 1e-11), ("TOUTATIS_AXES_PCK", TOLERANCE_RAD)])
def test_between_the_rows_against_the_integration(loaded, frame, limit):
    """Everywhere: at random times, against the equations of motion."""
    table, et = loaded
    random = np.sort(np.random.default_rng(5).uniform(et[5], et[-6], 300))
    elapsed = np.interp(random, et, (table["TIME"].tt - table["TIME"][0].tt).to_value("s"))  # exact to 1e-9 s
    # The first row is the epoch itself.
    q, _ = toutatis().states(elapsed)
    matrices = np.array([spiceypy.pxform("J2000", frame, t) for t in random])
    errors = (Rotation.from_matrix(matrices.transpose(0, 2, 1)).inv() * Rotation.from_quat(q[:, [1, 2, 3, 0]])).magnitude()
    assert_within(errors, limit)


@pytest.mark.parametrize("kind, low, high", [("ck5", 1e-12, 1e-9), ("ck3", 1e-6, 1e-3)])
def test_comments_say_the_error_everywhere(folder, loaded, kind, low, high):
    """In the gaps at the ends too, against the equations of motion."""
    table, et = loaded
    path = str(folder / f"toutatis_{kind}.bc")
    handle = spiceypy.dafopr(path)
    _, lines, _ = spiceypy.dafec(handle, 10, 200)
    spiceypy.dafcls(handle)
    (said,) = [float(line.split()[-2]) for line in lines if line.startswith("Largest error")]
    assert low < said < high
    spiceypy.unload(str(folder / "toutatis_ck5.bc"))
    spiceypy.furnsh(path)
    random = np.random.default_rng(7)
    gaps = np.concatenate([np.arange(6), np.sort(random.integers(6, len(et) - 7, 60)), np.arange(len(et) - 7, len(et) - 1)])
    times = et[gaps] + random.uniform(0.1, 0.9, len(gaps)) * (et[gaps + 1] - et[gaps])
    q, _ = toutatis().states(np.interp(times, et, (table["TIME"].tt - table["TIME"][0].tt).to_value("s")))
    matrices = np.array([spiceypy.pxform("J2000", "TOUTATIS_AXES", t) for t in times])
    errors = (Rotation.from_matrix(matrices.transpose(0, 2, 1)).inv() * Rotation.from_quat(q[:, [1, 2, 3, 0]])).magnitude()
    assert_within(errors, 1.1 * said + 1e-13)


@pytest.mark.parametrize("frame", ["TOUTATIS_AXES", "TOUTATIS_AXES_PCK"])
def test_rates_are_those_of_the_attitude(loaded, frame):
    _, et = loaded
    h = 60.0
    errors = []
    for t in np.random.default_rng(6).uniform(et[5], et[-6], 50):
        before, after = (Rotation.from_matrix(spiceypy.pxform(frame, "J2000", s)) for s in (t - h, t + h))
        _, omega_inertial = spiceypy.xf2rav(spiceypy.sxform("J2000", frame, t))
        errors.append(np.linalg.norm((after * before.inv()).as_rotvec() / (2 * h) - omega_inertial))
    assert_within(errors, 2e-11)


def test_anise_reads_the_binary_pck(folder, loaded):
    table, et = loaded
    almanac = anise.Almanac(str(folder / "toutatis.bpc"))
    frame = anise.astro.Frame(0, 2004179)
    errors = []
    for t, row in list(zip(et, table))[1:-1:7]:
        epoch = anise.time.Epoch.from_et_seconds(float(t))
        dcm = almanac.rotate(anise.astro.Frame(0, 1), frame, epoch)
        errors.append(turned(np.array(dcm.rot_mat), row))
    assert_within(errors, TOLERANCE_RAD)


def test_direction(tmp_path):
    """A body turned by +90 deg about inertial z: pxform takes inertial y to body x."""
    body = tmp_path / "spinner.toml"
    body.write_text(SPINNER)
    fits = propagate(body, tmp_path / "a.fits", "--stop", "+20 s", "--step", "1", "--scale", "TT")
    assert "no binary PCK" in kernels(fits, tmp_path, "--id", "-999123", "--name", "spin")  # its z axis is inertial z
    spiceypy.kclear()
    spiceypy.furnsh(str(tmp_path / "spin.tm"))
    et = spice_et(Table.read(fits, hdu="ATTITUDE", astropy_native=True))[10]
    assert_within(np.abs(spiceypy.pxform("J2000", "SPIN_AXES", et) @ [0, 1, 0] - [1, 0, 0]), 1e-11)
    matrix, omega = spiceypy.xf2rav(spiceypy.sxform("J2000", "SPIN_AXES", et))
    assert_within(np.abs(omega - [0, 0, np.radians(9)]), 1e-11)
    spiceypy.kclear()
