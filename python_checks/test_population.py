"""polhode population: a table of bodies to their states, against the motion of each."""

import re

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from support import angle_rad, assert_within, run

COUNT = 41
NAMES = ("I1", "I2", "I3", "q_x", "q_y", "q_z", "q_scalar", "omega_body_x_rad_s", "omega_body_y_rad_s", "omega_body_z_rad_s")
TIMES = "2027-01-01T00:00:00 TT,2027-01-02T00:00:00.25 TT,2027-03-01T00:00:00 TT"


@pytest.fixture
def bodies():
    random = np.random.default_rng(5)
    moments = np.sort(random.uniform(1, 2, (COUNT, 3)), axis=1)
    moments[3] = moments[3, 0]  # a sphere, which is computed alone
    q = random.normal(size=(COUNT, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    rates = random.normal(size=(COUNT, 3)) * 1e-2
    rates[7, :2] = 0
    return moments, q, rates


def csv(path, bodies, header="", names=False, dates=None):
    moments, q, rates = bodies
    lines = [header + ("name," if names else "") + ",".join(NAMES) + (",date_utc" if dates else "")]
    for i in range(COUNT):
        cells = [*moments[i], *q[i, 1:], q[i, 0], *rates[i]]
        line = ",".join(repr(float(cell)) for cell in cells)
        lines.append((f"body {i}," if names else "") + line + (f",{dates[i % len(dates)]}" if dates else ""))
    path.write_text("\n".join(lines) + "\n")
    return path


def expected(bodies, seconds):
    import polhode

    moments, q, rates = bodies
    return [polhode.FreeMotion(moments[i], q[i], moments[i] * rates[i])(seconds) for i in range(COUNT)]


def test_states_are_those_of_each_body(tmp_path, bodies):
    table = csv(tmp_path / "bodies.csv", bodies, names=True)
    run("population", table, "--epoch", "2027-01-01 TT", "--times", TIMES, "--scale", "TT", "-o", tmp_path / "states.ecsv")
    rows = Table.read(tmp_path / "states.ecsv")
    assert len(rows) == 3 * COUNT and rows["body"][COUNT] == 1 and rows["name"][COUNT + 1] == "body 1"
    assert rows["date_tt"][COUNT] == "2027-01-02T00:00:00.250"
    day = 86400.0
    t = np.array([0, day + 0.25, 59 * day])
    q = np.stack([rows[name] for name in ("q_scalar", "q_x", "q_y", "q_z")], axis=1).reshape(3, COUNT, 4)
    omega = np.stack([rows[name] for name in NAMES[7:]], axis=1).reshape(3, COUNT, 3)
    for i, state in enumerate(expected(bodies, t)):
        assert_within(angle_rad(q[:, i], state.q), 2e-15)
        assert_within(np.abs(omega[:, i] - state.omega).max() / np.abs(state.omega).max(), 4e-15)


def test_every_format_holds_the_same(tmp_path, bodies):
    table = csv(tmp_path / "bodies.csv", bodies)
    for ending in ("csv", "ecsv", "fits"):
        run("population", table, "--epoch", "2027-01-01 TT", "--times", TIMES, "--scale", "TT", "-o", tmp_path / f"states.{ending}")
    of_csv, of_ecsv = Table.read(tmp_path / "states.csv", comment="#"), Table.read(tmp_path / "states.ecsv")
    with fits.open(tmp_path / "states.fits", checksum=True) as file:
        data, header = file["STATES"].data, file["STATES"].header
        assert header["TIMESYS"] == "TT" and header["MJDREF"] == 61406.0
        assert np.array_equal(data["TIME"][::COUNT], [0, 86400.25, 59 * 86400.0])
        assert np.array_equal(data["BODY"], of_csv["body"]) and np.array_equal(of_ecsv["body"], of_csv["body"])
        for k, name in enumerate(("q_x", "q_y", "q_z", "q_scalar")):
            assert np.array_equal(data["QPARAM"][:, k], of_csv[name]) and np.array_equal(of_csv[name], of_ecsv[name])
    # FITS in, and each body at its own epoch.
    moments, q, rates = bodies
    columns = [
        fits.Column("TIME", "D", unit="s", array=np.arange(COUNT) * 100.0),
        fits.Column("MOMENTS", "3D", array=moments),
        fits.Column("QPARAM", "4D", array=np.roll(q, -1, axis=1)),
        fits.Column("OMEGA", "3D", array=rates),
    ]
    hdu = fits.BinTableHDU.from_columns(columns, name="BODIES")
    hdu.header["MJDREF"], hdu.header["TIMESYS"] = 61406.0, "TT"
    hdu.writeto(tmp_path / "bodies.fits")
    run("population", tmp_path / "bodies.fits", "--times", "2027-01-02T00:00:00 TT", "--scale", "TT", "-o", tmp_path / "later.csv")
    later = Table.read(tmp_path / "later.csv", comment="#")
    states = expected(bodies, 86400.0 - 100.0 * np.arange(COUNT))
    ours = np.stack([later[name] for name in ("q_scalar", "q_x", "q_y", "q_z")], axis=1)
    assert_within(angle_rad(ours, np.stack([states[i].q[i] for i in range(COUNT)])), 4e-15)


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda text: text.replace("I1,", "J1,"), "no column I1"),
        (lambda text: text.replace("\n1.", "\n9.", 1), "bodies.csv:2: the principal moments are"),
        (lambda text: text.replace(",", ",x", 14), "bodies.csv:"),
        (lambda text: re.sub(r"\n[^,]*,[^,]*,[^,]*", "\n1,2,3.5", text, count=1), "bodies.csv:2: impossible inertia"),
        (lambda text: re.sub(r"(\n.*),[^,\n]*\n", r"\1,1e300\n", text, count=1), "bodies.csv:2: the angular velocity is 1e+300 rad/s"),
    ],
)
def test_what_is_refused_is_named_by_its_line(tmp_path, bodies, change, message):
    table = csv(tmp_path / "bodies.csv", bodies)
    table.write_text(change(table.read_text()))
    result = run("population", table, "--epoch", "2027-01-01 TT", "--times", TIMES, "--scale", "TT", "-o", tmp_path / "out.csv", check=False)
    assert result.returncode == 2 and message in result.stderr and not (tmp_path / "out.csv").exists()


def test_epochs_are_wanted(tmp_path, bodies):
    table = csv(tmp_path / "bodies.csv", bodies)
    result = run("population", table, "--times", TIMES, "--scale", "TT", "-o", tmp_path / "out.csv", check=False)
    assert result.returncode == 2 and "--epoch" in result.stderr
    dated = csv(tmp_path / "dated.csv", bodies, dates=["2027-01-01T00:00:00", "2027-01-01T12:00:00"])
    run("population", dated, "--times", TIMES, "--scale", "TT", "-o", tmp_path / "out.csv")
    result = run("population", dated, "--times", TIMES, "--scale", "TT", "-o", tmp_path / "out.dat", check=False)
    assert result.returncode == 2 and ".fits" in result.stderr
