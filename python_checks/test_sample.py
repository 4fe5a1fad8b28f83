"""polhode sample: parts, threads, restarts and array jobs give the bits of the whole."""

import os
import signal
import subprocess
import time

import numpy as np
import pytest
from astropy.io import fits
from astropy.table import Table
from scipy.spatial.transform import Rotation
from support import PROGRAM, ROOT, angle_rad, assert_within, run

BODY = """name = "tumbler"
[inertia]
moments = [3.0836, 3.235, 1.0]
moments_sigma = [0.005, 0.005, 0.0]
unit = "ratios"
long_axis = "z"
intermediate_axis = "x"
short_axis = "y"
[state]
epoch = "1992-11-09T17:49:47 UTC"
frame = "ECLIPJ2000"
[state.attitude]
euler_angles = [145.498, 65.865, 241.524]
euler_angles_sigma = [3.762, 2.388, 2.586]
sequence = "ZXZ"
unit = "deg"
[state.angular_velocity]
components = [14.51, 33.529, -98.709]
components_sigma = [0.099, 0.096, 0.097]
axes = "body"
unit = "deg/day"
"""
TIMES = "1993-01-01 TDB,2012-12-12 TDB"


@pytest.fixture
def body(tmp_path):
    path = tmp_path / "tumbler.toml"
    path.write_text(BODY)
    return path


def sample(body, out, *options, count=3000, seed=11):
    run("sample", body, "--count", count, "--seed", seed, "--times", TIMES, "-o", out, *options, env=os.environ | {"SOURCE_DATE_EPOCH": "0"})
    return out


def join(parts, out):
    run("sample", "--join", *parts, "-o", out, env=os.environ | {"SOURCE_DATE_EPOCH": "0"})
    return out


def test_threads_and_parts_give_the_same_bits(tmp_path, body):
    whole = sample(body, tmp_path / "whole.fits", "--threads", 1).read_bytes()
    assert sample(body, tmp_path / "two.fits", "--threads", 2).read_bytes() == whole
    assert list(tmp_path.glob("*.part")) == []
    parts = [sample(body, tmp_path / f"{i}.part", "--part", f"{i}/7") for i in range(7, 0, -1)]
    assert join(parts, tmp_path / "joined.fits").read_bytes() == whole
    assert sample(body, tmp_path / "other.fits", seed=12).read_bytes() != whole
    with fits.open(tmp_path / "whole.fits", checksum=True) as file:
        row = file["SAMPLE"].data[0]
        assert file["SAMPLE"].header["NCLONES"] == 3000
        assert row["PMODE"].sum() == pytest.approx(1) and row["PMODE"][1] > 0.99
        assert row["ANGLE"][0] < row["ANGLE"][1] < row["ANGLE"][2]
        assert row["RATE"][0] < row["RATE"][2] < row["RATE"][4]


def test_parts_that_do_not_belong_together_are_refused(tmp_path, body):
    one, two = (sample(body, tmp_path / f"{i}.part", "--part", f"{i}/2") for i in (1, 2))
    other = sample(body, tmp_path / "other.part", "--part", "2/2", seed=12)
    for parts, message in (((one,), "missing"), ((one, two, two), "twice"), ((one, other), "different samples")):
        result = run("sample", "--join", *parts, "-o", tmp_path / "out.csv", check=False)
        assert result.returncode == 2 and message in result.stderr
    text = two.read_text()
    two.write_text(text[: len(text) // 2])
    result = run("sample", "--join", one, two, "-o", tmp_path / "out.csv", check=False)
    assert result.returncode == 2 and "2.part" in result.stderr
    assert not (tmp_path / "out.csv").exists()


def test_rows_of_parts_follow_one_another(tmp_path, body):
    def lines(path):
        return [line for line in path.read_text().splitlines() if not line.startswith(("#", "clone"))]

    whole = lines(sample(body, tmp_path / "whole.csv", "--rows", "--threads", 2, count=500))
    assert len(whole) == 1000 and whole[0].startswith("0,1993-01-01T") and whole[-1].startswith("499,2012-12-12T")
    parts = [lines(sample(body, tmp_path / f"{i}.csv", "--rows", "--part", f"{i}/3", count=500)) for i in (1, 2, 3)]
    assert sum(parts, []) == whole
    # A clone is the same whoever draws it: of a longer sample, too.
    assert lines(sample(body, tmp_path / "more.csv", "--rows", count=600))[:1000] == whole


def test_statistics_are_those_of_the_rows(tmp_path, body):
    import polhode

    sample(body, tmp_path / "rows.fits", "--rows", count=4000)
    with fits.open(sample(body, tmp_path / "out.fits", count=4000)) as file:
        table = file["SAMPLE"].data
        with fits.open(tmp_path / "rows.fits", checksum=True) as rows:
            data = rows["CLONES"].data
            q = data["QPARAM"].reshape(4000, 2, 4)
            omega = data["OMEGA"].reshape(4000, 2, 3)
    published = polhode.read(body).motion()(["1993-01-01 TDB", "2012-12-12 TDB"])
    for j in range(2):
        values, vectors = np.linalg.eigh(np.einsum("ni,nk->ik", q[:, j], q[:, j]) / 4000)
        assert abs(table["QMEAN"][j] @ vectors[:, 3]) == pytest.approx(1, abs=1e-12)
        assert np.radians(table["SPREAD"][j]) == pytest.approx(2 * np.arcsin(np.sqrt(values[:3].sum())), rel=1e-9)
        angles = 2 * np.degrees(np.arccos(np.clip(np.abs(q[:, j] @ np.roll(published.q[j], -1)), 0, 1)))
        assert np.allclose(table["ANGLE"][j], np.quantile(angles, [0.5, 0.682689, 0.9545, 0.9973]), rtol=0.03)
        rates = np.linalg.norm(omega[:, j], axis=1) / np.linalg.norm(published.omega[j]) - 1
        assert np.allclose(table["RATE"][j][1:4], np.quantile(rates, [0.158655, 0.5, 0.841345]), rtol=0.05, atol=3e-5)


def test_what_was_killed_goes_on(tmp_path, body):
    count = 400_000
    out = tmp_path / "out.csv"
    arguments = ["sample", body, "--count", count, "--seed", 3, "--times", "1993-01-01 TDB", "-o", out]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], env=environment, stderr=subprocess.PIPE)
    begun = tmp_path / "out.csv.part"
    for _ in range(600):
        if begun.exists() or process.poll() is not None:
            break
        time.sleep(0.1)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not out.exists() or process.returncode == 0
    again = run(*arguments, env=environment)
    if begun.exists():
        assert "clones are there" in again.stderr
    parts = [tmp_path / f"{i}.part" for i in (1, 2)]
    for i, part in enumerate(parts):
        run(*arguments[:-1], part, "--part", f"{i + 1}/2", env=environment)
    assert join(parts, tmp_path / "joined.csv").read_bytes() == out.read_bytes()
    assert not begun.exists()


def test_the_array_job(tmp_path, body):
    environment = os.environ | {
        "POLHODE": str(PROGRAM), "BODY": str(body), "COUNT": "3000", "SEED": "11", "TIMES": TIMES, "OUT": str(tmp_path / "task"),
        "SLURM_ARRAY_TASK_MAX": "7", "SLURM_CPUS_PER_TASK": "1",
    }
    for task in range(1, 8):
        subprocess.run([ROOT / "tools/cluster/sample.slurm"], env=environment | {"SLURM_ARRAY_TASK_ID": str(task)}, check=True)
    joined = join(sorted(tmp_path.glob("task-*.part")), tmp_path / "joined.csv")
    assert joined.read_bytes() == sample(body, tmp_path / "whole.csv").read_bytes()


def test_from_python(tmp_path, body):
    import polhode

    ours = polhode.sample(body, count=3000, seed=11, times=TIMES.split(","), parts=3, output=tmp_path / "out.fits")
    with fits.open(sample(body, tmp_path / "whole.fits")) as file:
        table = file["SAMPLE"].data
    assert np.array_equal(ours["attitude_spread_deg"], table["SPREAD"]) and len(ours["date_tdb"]) == 2
    with fits.open(tmp_path / "out.fits") as file:
        assert np.array_equal(file["SAMPLE"].data["QMEAN"], table["QMEAN"])
    with pytest.raises(polhode.InputError, match="no number with an uncertainty"):
        polhode.sample(body, count=10, seed=1, times=TIMES, uniform={"nonsense": 1.0})


def test_lost_workers_parts_are_done_again(tmp_path, body):
    import threading

    from distributed import Client, LocalCluster

    import polhode

    options = dict(count=600_000, seed=5, times=TIMES)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        victim = next(iter(cluster.workers.values()))
        address, pid = victim.worker_address, victim.pid
        had = []

        def kill_in_the_middle():
            while not had:  # some parts are done, and the victim has others
                done = client.run_on_scheduler(lambda dask_scheduler: sum(t.state == "memory" for t in dask_scheduler.tasks.values()))
                its = client.processing().get(address)
                if done >= 2 and its:
                    os.kill(pid, signal.SIGKILL)
                    had.extend(its)
                time.sleep(0.01)

        thread = threading.Thread(target=kill_in_the_middle, daemon=True)
        thread.start()
        ours = polhode.sample(body, client=client, parts=12, **options)
        thread.join(10)
    expected = polhode.sample(body, **options)
    assert had and ours.keys() == expected.keys()
    assert all(np.array_equal(ours[name], expected[name]) for name in expected)


def attitudes(rows):
    """Of a table in CSV, scalar first."""
    return np.stack([rows[name] for name in ("q_scalar", "q_x", "q_y", "q_z")], axis=1)


EPOCH, AFTER = "2029-04-10T21:46:00 UTC", "2029-04-16T21:00:00 UTC"
ENCOUNTER = ROOT / "data/scenes/apophis-2029.toml"


def test_clones_under_torques_move_as_each_alone(tmp_path):
    run("sample", ENCOUNTER, "--count", 4, "--seed", 2, "--times", f"{EPOCH},{AFTER}", "--rows", "-o", tmp_path / "rows.csv")
    rows = Table.read(tmp_path / "rows.csv", comment="#")
    begin, end = rows[0::2], rows[1::2]
    run("propagate", ENCOUNTER, "--times", AFTER, "-o", tmp_path / "published.csv")
    published = attitudes(Table.read(tmp_path / "published.csv", comment="#"))
    apart = angle_rad(attitudes(end), np.repeat(published, 4, axis=0))
    assert np.all(apart > 2e-3) and np.all(np.isfinite(apart))
    for i in range(4):
        q = [float(begin[name][i]) for name in ("q_scalar", "q_x", "q_y", "q_z")]
        omega = [float(begin[f"omega_body_{axis}_rad_s"][i]) for axis in "xyz"]
        (tmp_path / "clone.toml").write_text(
            'name = "clone"\n[inertia]\nmoments = [0.64, 0.97, 1.0]\nunit = "ratios"\n'
            '[state]\nepoch = "2029-04-10T21:46:00 UTC"\nframe = "ECLIPJ2000"\n'
            f"[state.attitude]\nq_frame_from_body_scalar_first = {q}\n"
            f'[state.angular_velocity]\ncomponents = {omega}\naxes = "body"\nunit = "rad/s"\n'
        )
        scene = ENCOUNTER.read_text().replace("bodies/apophis-encounter.toml", "clone.toml").replace("period_uncertainty = 1e-3\n", "")
        (tmp_path / "scene.toml").write_text(scene)
        run("propagate", tmp_path / "scene.toml", "--times", AFTER, "-o", tmp_path / "alone.csv")
        alone = attitudes(Table.read(tmp_path / "alone.csv", comment="#"))
        assert_within(angle_rad(alone, attitudes(end[i : i + 1])), np.radians(0.01))  # the scene's accuracy


def test_threads_and_parts_give_the_same_bits_under_torques(tmp_path):
    def encounter(out, *options):
        run("sample", ENCOUNTER, "--count", 90, "--seed", 2, "--times", AFTER, "-o", out, *options, env=os.environ | {"SOURCE_DATE_EPOCH": "0"})
        return out

    whole = encounter(tmp_path / "whole.csv", "--threads", 1).read_bytes()
    assert encounter(tmp_path / "two.csv", "--threads", 2).read_bytes() == whole
    parts = [encounter(tmp_path / f"{i}.part", "--part", f"{i}/4") for i in range(1, 5)]
    assert join(parts, tmp_path / "joined.csv").read_bytes() == whole


def test_rows_say_mode_momentum_and_periods(tmp_path, body):
    import polhode

    polhode.sample_rows(
        body, tmp_path / "rows.ecsv", count=20, seed=3, times="1993-01-01 TDB", frame="ECLIPJ2000", uniform={"components.x": 10.0}
    )
    rows = Table.read(tmp_path / "rows.ecsv")
    assert set(rows["mode"]) <= {"short-axis", "long-axis"} and np.all(rows["polhode_period_s"] > 4e5)
    assert np.all(np.abs(rows["precession_period_s"] / 86400 - 7.4) < 1.0)
    # moments with sigmas of half a per cent: the momentum from the published ones points there within half a degree
    vectors = np.stack([rows[f"omega_body_{axis}_rad_s"] for axis in "xyz"], axis=1) * [3.0836, 3.235, 1.0]
    turned = Rotation.from_quat(np.roll(attitudes(rows), -1, axis=1)).apply(vectors)
    ra, dec = np.radians(rows["momentum_ra_deg"]), np.radians(rows["momentum_dec_deg"])
    there = np.stack([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)], axis=1)
    assert rows.meta["frame_a"] == "ECLIPJ2000"  # not that of right ascensions
    turned = Rotation.from_quat(np.roll(polhode.frame_rotation("ECLIPJ2000", "ICRF"), -1)).apply(turned)
    angles = np.degrees(np.arccos(np.sum(turned * there, axis=1) / np.linalg.norm(turned, axis=1)))
    assert 0 < angles.max() < 1.5


def test_a_hundred_thousand_draws_through_python(tmp_path, body):
    """The same bits as the program's, and their spread is that of the linear covariance, where that holds."""
    import polhode

    options = dict(count=100_000, seed=8, times="1992-11-20 TDB")
    ours = polhode.sample(body, **options)
    run("sample", body, "--count", 100_000, "--seed", 8, "--times", "1992-11-20 TDB", "-o", tmp_path / "sample.csv")
    theirs = Table.read(tmp_path / "sample.csv", comment="#")
    assert ours.keys() == set(theirs.colnames)
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours if name != "date_tdb")
    linear = polhode.read(body).motion().covariance("1992-11-20 TDB")
    assert np.radians(ours["attitude_spread_deg"][0]) == pytest.approx(np.sqrt(np.trace(np.squeeze(linear))), rel=0.02)


def test_rows_as_parquet(tmp_path, body):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed; with it polhode.sample_rows writes Parquet")
    import polhode

    options = dict(count=300, seed=3, times=TIMES)
    polhode.sample_rows(body, tmp_path / "rows.parquet", **options)
    polhode.sample_rows(body, tmp_path / "rows.ecsv", **options)
    ours, table = parquet.read_table(tmp_path / "rows.parquet"), Table.read(tmp_path / "rows.ecsv")
    assert ours.column_names == table.colnames and ours.num_rows == 600
    for name in table.colnames:
        assert np.array_equal(ours[name].to_numpy(), np.asarray(table[name]))
    assert b"seed: 3" in ours.schema.metadata[b"polhode"] and sorted(path.suffix for path in tmp_path.iterdir()) == [".ecsv", ".parquet", ".toml"]


def test_parquet_without_pyarrow_says_what_is_missing(tmp_path, body, monkeypatch):
    import sys

    import polhode

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(polhode.InputError, match="pyarrow, which is not installed"):
        polhode.sample_rows(body, tmp_path / "rows.parquet", count=3, seed=3, times=TIMES)


@pytest.mark.parametrize(
    "options, message",
    [
        (("--count", "10", "--seed", "1", "--times", TIMES, "-o", "out.dat"), ".fits"),
        (("--seed", "1", "--times", TIMES, "-o", "out.csv"), "--count"),
        (("--count", "10", "-o", "out.csv"), "--times"),
        (("--count", "10", "--times", TIMES, "--part", "8/7", "-o", "out.part"), "part 8 of 7"),
        (("--count", "10", "--times", TIMES, "--part", "one", "-o", "out.part"), "1/K"),
        (("--count", "10", "--times", TIMES, "--part", "1/7", "-o", "out.csv"), ".part"),
        (("--count", "10", "--times", TIMES, "--uniform", "psi", "-o", "out.csv"), "NAME=WIDTH"),
    ],
)
def test_what_is_refused(tmp_path, body, options, message):
    result = run("sample", body, *options, check=False, cwd=tmp_path)
    assert result.returncode == 2 and message in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == [body.name]


def test_exact_bodies_have_no_clones(tmp_path):
    result = run("sample", ROOT / "data/bodies/t-handle.toml", "--count", 5, "--times", TIMES, "-o", tmp_path / "out.csv", check=False)
    assert result.returncode == 2 and "uncertain" in result.stderr


def test_a_broken_part_is_refused(tmp_path, body):
    part = sample(body, tmp_path / "1.part", "--part", "1/1", count=200)
    whole = part.read_bytes()
    random = np.random.default_rng(3)
    broken = [whole + b"\n", whole[:-1]]
    for place in random.integers(0, len(whole), 40):
        broken.append(whole[:place] + bytes([whole[place] ^ (1 << int(random.integers(0, 7)))]) + whole[place + 1 :])
    for one in broken:
        part.write_bytes(one)
        result = run("sample", "--join", part, "-o", tmp_path / "a.csv", check=False)
        assert result.returncode == 2 and result.stderr.count("\n") == 1, result.stderr
    part.write_bytes(whole)
    join([part], tmp_path / "a.csv")


def test_what_has_no_bound_is_infinite_and_angles_end_at_180_deg(tmp_path):
    path = tmp_path / "resting.toml"
    at_rest = BODY.replace("components = [14.51, 33.529, -98.709]", "components = [0.0, 0.0, 0.0]").replace("[3.762, 2.388, 2.586]", "[100.0, 100.0, 100.0]")
    path.write_text(at_rest)
    row = Table.read(sample(path, tmp_path / "a.ecsv", count=2000), format="ascii.ecsv")[0]
    assert np.isinf(row["rate_deviation_50"]) and np.isnan(row["momentum_angle_deg_50"])
    assert 170 < row["attitude_angle_deg_997"] <= 180


def test_the_momentum_is_in_icrf(tmp_path, body):
    import polhode

    seen = [Table.read(sample(body, tmp_path / f"{frame}.ecsv", "--frame", frame), format="ascii.ecsv") for frame in ("ICRF", "ECLIPJ2000")]
    momentum = polhode.read(body).momentum("ICRF")
    ra, dec = np.degrees([np.arctan2(momentum[1], momentum[0]) % (2 * np.pi), np.arcsin(momentum[2] / np.linalg.norm(momentum))])
    for table in seen:
        assert np.allclose(table["momentum_ra_deg"], ra, atol=2) and np.allclose(table["momentum_dec_deg"], dec, atol=2)
    assert np.allclose(seen[0]["momentum_ra_deg"], seen[1]["momentum_ra_deg"], atol=1e-9)


def test_a_folder_that_is_not_there_is_said_at_once(tmp_path, body):
    begun = time.monotonic()
    result = run("sample", body, "--count", 10**9, "--seed", 1, "--times", TIMES, "-o", tmp_path / "no/a.csv", check=False)
    assert result.returncode == 3 and "no folder" in result.stderr and time.monotonic() - begun < 5, result.stderr
