"""Our kernels in the SPICE toolkit (spiceypy) and in ANISE: attitudes, rates, directions, promised errors."""

import re
import subprocess
import sys

import anise
import numpy as np
import pytest
import spiceypy
from astropy.io import fits as fits_file
from astropy.table import Table
from astropy.time import Time
from scipy.spatial.transform import Rotation
from support import ROOT, SPINNER, T_HANDLE, TOUTATIS, assert_within, propagate, toutatis

from polhode import InputError, spice

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


def make_kernels(*arguments, **options):
    command = [sys.executable, "-m", "polhode", "spice", *arguments]
    return subprocess.run(command, capture_output=True, text=True, **options)


def kernels(fits, folder, *options):
    result = make_kernels(fits, "-o", folder, *options)
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
    said = kernels(fits, tmp_path, "--id", "-999123", "--name", "spin")
    assert "spin.bpc" in said  # its z axis is that of J2000, but 23 deg from that of ECLIPJ2000
    spiceypy.kclear()
    spiceypy.furnsh(str(tmp_path / "spin.tm"))
    et = spice_et(Table.read(fits, hdu="ATTITUDE", astropy_native=True))[10]
    assert_within(np.abs(spiceypy.pxform("J2000", "SPIN_AXES", et) @ [0, 1, 0] - [1, 0, 0]), 1e-11)
    assert_within(np.abs(spiceypy.pxform("J2000", "SPIN_AXES_PCK", et) @ [0, 1, 0] - [1, 0, 0]), TOLERANCE_RAD)
    matrix, omega = spiceypy.xf2rav(spiceypy.sxform("J2000", "SPIN_AXES", et))
    assert_within(np.abs(omega - [0, 0, np.radians(9)]), 1e-11)
    spiceypy.kclear()


ENVISAT = ROOT / "data/bodies/envisat.toml"


@pytest.mark.parametrize("scale", ["TT", "TAI", "UTC", "TDB"])
def test_every_time_scale_over_a_leap_second(tmp_path, scale):
    """2016-12-31T23:59:60: a body of 9 deg/s is where the equations say, to the microsecond."""
    body = tmp_path / "spinner.toml"
    body.write_text(SPINNER.replace("2000-01-01T12:00:00 TT", "2016-12-31T23:59:30 UTC"))
    fits = propagate(body, tmp_path / "a.fits", "--stop", "+60 s", "--step", "1 s", "--scale", scale)
    kernels(fits, tmp_path, "--id", "-999123", "--name", "spin")
    spiceypy.kclear()
    spiceypy.furnsh(str(tmp_path / "spin.tm"))
    (first,) = spice_et({"TIME": Time(["2016-12-31T23:59:30"], scale="utc")})
    for elapsed in (5.5, 29.5, 31.5, 55.5):  # the leap second is the 30th
        about = Rotation.from_matrix(spiceypy.pxform("SPIN_AXES", "J2000", first + elapsed)).as_rotvec()
        assert_within(np.abs(Rotation.from_rotvec([0, 0, np.radians(9) * elapsed]).as_rotvec() - about), 1e-6)
    spiceypy.kclear()


def test_eme2000_is_turned_to_icrf(tmp_path, loaded):
    """It is 0.02 arcsec from the axes that SPICE calls J2000."""
    table, et = loaded
    spiceypy.kclear()
    fits = propagate(TOUTATIS, tmp_path / "eme.fits", "--stop", "+40 d", "--step", "1 h", "--frame", "EME2000")
    kernels(fits, tmp_path)
    spiceypy.furnsh(str(tmp_path / "toutatis.tm"))
    k = slice(1, len(et) - 1, 50)
    assert_within([turned(spiceypy.pxform("J2000", "TOUTATIS_AXES", t), row) for t, row in zip(et[k], table[k])], AT_ROWS_RAD)


@pytest.mark.parametrize("scale", ["ET", "GPS", "UT1", None])
def test_time_scales_that_readers_take_differently_are_refused(tmp_path, folder, scale):
    with fits_file.open(folder / "toutatis.fits") as file:
        header = file["ATTITUDE"].header
        if scale is None:
            del header["TIMESYS"]
        else:
            header["TIMESYS"] = scale
        file.writeto(tmp_path / "a.fits", checksum=True)
    result = make_kernels(tmp_path / "a.fits", "-o", tmp_path / "kernels")
    assert result.returncode == 2 and result.stderr.count("\n") == 1 and "TIMESYS" in result.stderr
    assert not (tmp_path / "kernels").exists()


def test_a_folder_is_made_and_the_kernels_load_from_anywhere(tmp_path, folder, monkeypatch):
    """With a long path, with a quote, a space, a plus at its end, and letters beyond ASCII in it."""
    for name in ("a/b", "it's a folder " + "ü" * 20 + "+", "c" * 70 + "'" * 20, "d" * (220 - len(str(tmp_path)))):
        where = tmp_path / name
        result = make_kernels(folder / "toutatis.fits", "-o", name, cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        monkeypatch.chdir("/")
        spiceypy.kclear()
        spiceypy.furnsh(str(where / "toutatis.tm"))
        spiceypy.pxform("J2000", "TOUTATIS_AXES_PCK", spice_et(Table.read(folder / "toutatis.fits", hdu=1, astropy_native=True))[9])
        assert all(len(line) <= 82 for line in (where / "toutatis.tm").read_text().splitlines() if "'" in line)
        assert {path.name for path in where.iterdir()} == {f"toutatis{e}" for e in ("_ck3.bc", "_ck5.bc", ".bpc", ".tsc", ".tf", ".tm")}
    spiceypy.kclear()
    result = make_kernels(folder / "toutatis.fits", "-o", "e" * 200 + "/" + "f" * 100, cwd=tmp_path)
    assert result.returncode == 2 and "too long" in result.stderr and result.stderr.count("\n") == 1


def test_moved_kernels_load_after_one_line_is_changed(tmp_path, folder):
    kernels(folder / "toutatis.fits", tmp_path / "a")
    (tmp_path / "a").rename(tmp_path / "b")
    meta = tmp_path / "b/toutatis.tm"
    meta.write_text(re.sub(r"PATH_VALUES = \([^)]*\)", f"PATH_VALUES = ( '{tmp_path / 'b'}' )", meta.read_text()))
    spiceypy.kclear()
    spiceypy.furnsh(str(meta))
    assert spiceypy.ktotal("ALL") == 5
    spiceypy.kclear()


@pytest.mark.parametrize(
    "name, options, made",
    [
        ("4179 Toutatis", [], (2004179, "toutatis")),
        ("214869 2007 PA8", [], (2214869, "2007_pa8")),
        ("2007 PA8", [], None),  # not 2007 McCuskey
        ("1P/Halley", [], None),
        ("1I/'Oumuamua", [], None),
        ("Envisat", [], None),
        ("4179 " + "T" * 17, [], (2004179, "t" * 17)),
        ("4179 " + "T" * 18, [], None),  # FRAME_..._AXES_PCK would have 33 characters
        ("4179 " + "T" * 18, ["--name", "t"], (2004179, "t")),
        ("4179 ---", [], None),
        ("Envisat", ["--id", "-999123"], (-999123, "envisat")),
        ("1I/'Oumuamua", ["--id", "7"], (7, "1i_oumuamua")),
        ("Envisat", ["--id", "0"], None),
        ("Envisat", ["--id", "4000000000"], None),
        ("Envisat", ["--id", "-5", "--tolerance", "nan"], None),
    ],
)
def test_ids_and_names(tmp_path, folder, name, options, made):
    with fits_file.open(folder / "toutatis.fits") as file:
        file["ATTITUDE"].header["OBJECT"] = name
        file["ATTITUDE"].data = file["ATTITUDE"].data[:50]
        file.writeto(tmp_path / "a.fits", checksum=True)
    arguments = [str(tmp_path / "a.fits"), "-o", str(tmp_path / "kernels"), *options]
    spiceypy.kclear()
    if made is None:
        with pytest.raises(InputError):
            spice.main(arguments)
        assert not (tmp_path / "kernels").exists()
        return
    spice.main(arguments)
    body_id, name = made
    spiceypy.kclear()
    spiceypy.furnsh(str(tmp_path / f"kernels/{name}.tm"))
    assert spiceypy.bodn2c(name) == body_id
    assert spiceypy.namfrm(f"{name.upper()}_AXES_PCK") > 0
    spiceypy.kclear()


def test_envisat_at_one_second_has_a_pck(tmp_path):
    """Its z axis passes the poles of J2000 within 0.01 rad, those of ECLIPJ2000 at 0.04."""
    fits = propagate(ENVISAT, tmp_path / "a.fits", "--stop", "+20 min", "--step", "1 s")
    said = kernels(fits, tmp_path, "--id", "-999123")
    promised = float(re.search(r"([0-9.e-]+) rad promised", said)[1])
    assert promised < 2e-8
    spiceypy.kclear()
    spiceypy.furnsh(str(tmp_path / "envisat.tm"))
    table = Table.read(fits, hdu="ATTITUDE", astropy_native=True)
    rows = list(zip(spice_et(table), table))[1:-1]
    assert_within([turned(spiceypy.pxform("J2000", "ENVISAT_AXES_PCK", t), row) for t, row in rows], promised)
    spiceypy.kclear()


def test_rows_too_far_apart_are_refused(tmp_path):
    fits = propagate(T_HANDLE, tmp_path / "a.fits", "--stop", "+100 s", "--step", "1 s")  # a turn takes half a second
    result = make_kernels(fits, "-o", tmp_path / "kernels", "--id", "-5", "--name", "t")
    assert result.returncode == 2 and "too far apart" in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.parametrize("output, status", [("/dev/full", 3), ("/dev/null/a", 3)])
def test_outputs_that_cannot_be(folder, output, status):
    result = make_kernels(folder / "toutatis.fits", "-o", output)
    assert result.returncode == status and result.stderr.count("\n") == 1, result.stderr


def test_other_files_are_refused_in_one_line(tmp_path, folder):
    whole = (folder / "toutatis.fits").read_bytes()
    (tmp_path / "cut.fits").write_bytes(whole[:20000])
    for name, status in (("cut.fits", 2), ("none.fits", 3), (".", 3), (TOUTATIS, 2)):
        result = make_kernels(name, "-o", "kernels", cwd=tmp_path)
        assert result.returncode == status and result.stderr.count("\n") == 1, result.stderr
        assert not (tmp_path / "kernels").exists()
