"""CCSDS messages, shapes and comparisons through the program: exit statuses, what info says, compare on our own files."""

import json

import numpy as np
import pytest
from support import ROOT, SPINNER, TOUTATIS, propagate, run

CCSDS = ROOT / "data/samples/ccsds"


@pytest.mark.parametrize("path", sorted((CCSDS / "valid").iterdir()), ids=lambda p: p.name)
def test_valid_messages_are_understood(path, tmp_path):
    result = run("info", "--json", path)
    (report,) = json.loads(result.stdout)
    # What cannot be propagated says why, and is refused: an attitude history goes no further than its last row.
    refused = run("propagate", path, "--stop", "+1000 d", "--step", "500 d", "-o", tmp_path / "out.csv", check=False)
    if report["missing"]:
        assert refused.returncode == 2
        assert report["missing"][0] in refused.stderr
    else:
        assert path.name == "APMExample12.txt" and refused.returncode == 0


@pytest.mark.parametrize("path", sorted((CCSDS / "invalid").iterdir()), ids=lambda p: p.name)
def test_invalid_messages_are_refused_with_their_line(path):
    result = run("info", path, check=False)
    assert result.returncode == 2 and result.stdout == ""
    assert f"{path}:" in result.stderr and result.stderr.split(f"{path}:")[1].split(":")[0].isdigit()


def test_euler_angles_of_an_apm():
    (report,) = json.loads(run("info", "--json", CCSDS / "valid/APMExample12.txt").stdout)
    q = np.array(report["state"]["q_frame_from_body_scalar_first"])
    half_z, half_x = np.radians([5.0, 10.0])  # ZXZ by 10, 20, 0 deg
    wanted = np.array([np.cos(half_z) * np.cos(half_x), np.cos(half_z) * np.sin(half_x),
                       np.sin(half_z) * np.sin(half_x), np.sin(half_z) * np.cos(half_x)])
    assert np.max(np.abs(q - wanted)) < 1e-15


def test_segments_that_hold_at_one_time_are_not_compared(tmp_path):
    path = CCSDS / "valid/AEMExample14.txt"
    for command in (("compare", path, path), ("propagate", path, "-o", tmp_path / "out.aem")):
        result = run(*command, check=False)
        assert result.returncode == 2 and result.stdout == ""
        assert "segments 1 and 2" in result.stderr and "USEABLE_STOP_TIME" in result.stderr
    spans = ("--start", "+0 d", "--stop", "+2 d", "--start", "+1 d", "--stop", "+2 d", "--count", "5")
    result = run("propagate", TOUTATIS, "-o", tmp_path / "out.aem", *spans, check=False)
    assert result.returncode == 2 and "segments 1 and 2 both hold from" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_compare_reads_what_propagate_writes(tmp_path):
    options = ("--stop", "+20 d", "--count", "200")
    files = [propagate(TOUTATIS, tmp_path / f"t.{ending}", *options) for ending in ("fits", "aem", "xml", "ecsv")]
    for other in [*files[1:], TOUTATIS]:
        report = json.loads(run("compare", files[0], other, "--json", "--tolerance", "1e-9 rad").stdout)
        assert report["rows_compared"] == 200 and report["rows_outside"] == 0
        assert report["largest_rad"] < 1e-12
    # Another body: far away, and said so.
    assert run("compare", files[0], ROOT / "data/bodies/apophis.toml", "--tolerance", "1 deg", check=False).returncode == 1
    assert run("compare", TOUTATIS, TOUTATIS, check=False).returncode == 2


def refused(*options, status=2, **others):
    result = run(*options, check=False, **others)
    assert result.returncode == status, result.stderr
    return result.stderr


SPAN = ("--stop", "+1 d", "--count", "3")
CASE = ROOT / "data/truth/dev/sam-01.case"
TORQUED = ROOT / "data/truth/torqued/combined-01.case"


@pytest.mark.parametrize(
    "options, message",
    [
        (("-o", "a.fits", *SPAN, "--adm", "3.0"), "--adm is for .aem .txt (CCSDS AEM)"),
        (("-o", "a.csv", *SPAN, "--attitude-type", "QUATERNION"), "--attitude-type is for .aem .txt (CCSDS AEM)"),
        (("-o", "a.ecsv", *SPAN, "--euler-sequence", "ZXZ"), "--euler-sequence is for .aem .txt (CCSDS AEM)"),
        (("-o", "a.aem", *SPAN, "--euler-sequence", "ZXZ"), "--euler-sequence is for Euler angles"),
        (("-o", "a.aem", *SPAN, "--momentum"), "--momentum is for .fits .fit (FITS), "),
        (("-o", "a.fits", *SPAN, "--full"), "--full means something for scenes only"),
    ],
)
def test_options_that_mean_nothing_are_refused(tmp_path, options, message):
    assert message in refused("propagate", TOUTATIS, *options, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_old_version_has_an_attitude_type_of_its_own(tmp_path):
    text = propagate(TOUTATIS, tmp_path / "a.aem", *SPAN, "--adm", "1.0").read_text()
    assert "CCSDS_AEM_VERS = 1.0\n" in text and "ATTITUDE_TYPE = QUATERNION\n" in text
    assert "ATTITUDE_TYPE = QUATERNION/ANGVEL\n" in propagate(TOUTATIS, tmp_path / "b.aem", *SPAN).read_text()


def scene(folder, old="", new=""):
    """A scene with its files' absolute paths, one line of it changed; the number of that line."""
    text = (ROOT / "data/scenes/envisat-month.toml").read_text()
    text = text.replace('body = "', f'body = "{ROOT}/data/scenes/')
    assert old in text
    line = 1 + text[: text.index(old)].count("\n")
    path = folder / "scene.toml"
    path.write_text(text.replace(old, new, 1))
    return path, line


def test_a_missing_file_is_traced_to_the_line_that_names_it(tmp_path):
    path, line = scene(tmp_path, f"{ROOT}/data/scenes/bodies", f"{ROOT}/data/scenes/nothing")
    for command in ("plan", path), ("propagate", path, "-o", tmp_path / "a.csv"):
        message = refused(*command, status=3)
        assert f"{path}:{line}: body: " in message and "nothing/envisat" in message
    body = tmp_path / "body.toml"
    body.write_text('name = "a"\n[inertia]\nmesh = "nothing.obj"\n')
    assert f"{body}:3: inertia.mesh: " in refused("info", body, status=3)
    text = (ROOT / "data/scenes/toutatis-1992-2008.toml").read_text()
    path.write_text(text.replace('body = "', f'body = "{ROOT}/data/scenes/'))
    line = 1 + [t.startswith("trajectory") for t in text.splitlines()].index(True)
    assert f"{path}:{line}: orbit." in refused("plan", path, status=3)


def test_scenes_and_bodies_point_to_each_other(tmp_path):
    path, _ = scene(tmp_path)
    assert f"{path}: is a scene, not a body: `polhode plan`" in refused("info", path)
    assert f"{TOUTATIS}: is no scene" in refused("plan", TOUTATIS)
    assert "`polhode info`" in refused("plan", CCSDS / "valid/AEMExample01.txt")


@pytest.mark.parametrize(
    "line, message",
    [
        ("[inertia]\naxis_ratios = [3, 2, 1]", "moments, products, tensor, products_are, unit"),
        ("[inertia]\naxis_ratios = [3, 2, 1]", "mesh, semi_axes"),
        ("[state.attitude]\nsequence = ZXZ", 'ZXZ is text, which stands in quotes: "ZXZ"'),
        ("[state]\nepoch = '2000-01-01 TT'\nframe = 'FK5'", "'FK5' is not a frame for a state; allowed: ICRF"),
    ],
)
def test_messages_of_body_files_name_what_is_allowed(tmp_path, line, message):
    path = tmp_path / "body.toml"
    path.write_text(f'name = "a"\n{line}\n')
    stderr = refused("info", path)
    assert message in stderr and "ITRF" not in stderr
    assert stderr.startswith(f"polhode: {path}:{2 + line.count(chr(10))}: ")


def test_a_body_that_cannot_move_is_named_with_its_file(tmp_path):
    path = tmp_path / "body.toml"
    path.write_text('name = "a"\n[state]\nepoch = "2000-01-01 TT"\nframe = "ICRF"\n')
    assert f"{path}: body 'a' has no inertia" in refused("propagate", path, "-o", tmp_path / "a.csv", *SPAN)


def test_the_inertia_of_our_fits_is_read(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", *SPAN)
    (report,) = json.loads(run("info", "--json", out).stdout)
    (body,) = json.loads(run("info", "--json", TOUTATIS).stdout)
    assert report["inertia"]["principal_moments"] == body["inertia"]["principal_moments"]
    assert report["inertia"]["unit"] == "ratios"
    assert report["motion"]["polhode_period_s"] == pytest.approx(body["motion"]["polhode_period_s"], rel=1e-9)
    assert not any("no inertia" in warning for warning in report["warnings"])
    # The rows stay what is written again.
    again = propagate(out, tmp_path / "b.csv")
    assert len(again.read_text().splitlines()) == 4


def test_info_says_units(tmp_path):
    bodies = [ROOT / "data/bodies" / name for name in ("envisat.toml", "toutatis.toml")]
    absolute, ratios = (report["motion"] for report in json.loads(run("info", "--json", *bodies).stdout))
    assert {"momentum_N_m_s", "twice_energy_J", "energy_above_ground_relative"} <= set(absolute)
    assert {"momentum_ratios_rad_s", "twice_energy_ratios_rad2_s2"} <= set(ratios)
    assert not {"momentum", "twice_energy", "energy_above_ground"} & (set(absolute) | set(ratios))


def test_comparing_two_objects_is_said(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", *SPAN)
    assert "two objects" in run("compare", out, ROOT / "data/bodies/apophis.toml").stderr
    assert "two objects" not in run("compare", out, TOUTATIS).stderr


def test_designations_are_kept(tmp_path):
    body = tmp_path / "body.toml"
    body.write_text(TOUTATIS.read_text().replace("source =", 'id = "20004179"\nsource =', 1))
    assert "OBJECT_ID = 20004179\n" in propagate(body, tmp_path / "a.aem", *SPAN).read_text()
    acm = CCSDS / "valid/ACMExample05.txt"
    wanted = [line.split("=")[1].strip() for line in acm.read_text().splitlines() if line.startswith("INTERNATIONAL_DESIGNATOR")]
    (report,) = json.loads(run("info", "--json", acm).stdout)
    assert [report["id"]] == wanted


@pytest.mark.parametrize("unit", ["deg/min", "deg/d", "mas/h"])
def test_rates_in_every_unit_of_angle_and_time(tmp_path, unit):
    angle, duration = unit.split("/")
    size = {"deg": 1.0, "mas": 1 / 3.6e6}[angle] / {"min": 60, "d": 86400, "h": 3600}[duration]
    body = tmp_path / "body.toml"
    body.write_text(SPINNER.replace('"deg/s"', f'"{unit}"').replace('"kg m2"', '"kg m^2"'))
    (report,) = json.loads(run("info", "--json", body).stdout)
    assert report["state"]["omega_body_rad_s"][2] == pytest.approx(np.radians(9.0 * size), rel=1e-14)


def test_every_option_takes_the_same_units(tmp_path):
    out = propagate(TOUTATIS, tmp_path / "a.fits", *SPAN)
    assert run("compare", out, TOUTATIS, "--tolerance", "1 mas").returncode == 0
    assert "deg, rad, arcmin, arcsec, mas" in refused("compare", out, TOUTATIS, "--tolerance", "1 furlong")


@pytest.mark.parametrize("command", ["info", "propagate", "plan", "compare", "convert-time", "convert-frame", "eval", "bench", "chart"])
def test_help_has_examples(command):
    text = run(command, "--help").stdout
    assert "Examples:" in text and f"polhode {command}" in text.split("Examples:")[1]


@pytest.mark.parametrize(
    "options, message",
    [
        (("--stop", "+1 d", "--step", "1 x"), "polhode: --step: '1 x' is no span of time: "),
        (("--stop", "+1 d", "--step", "0"), "polhode: --step: the step is 0 s; it must be positive"),
        (("--stop", "60 d", "--count", "2"), "polhode: --stop: '60 d' is a span of time, not a date"),
        (("--start", "soon", "--stop", "+1 d", "--count", "2"), "polhode: --start: 'soon' is not a date"),
        (("--stop", "+1 d", "--tolerance", "1 x"), "polhode: --tolerance: '1 x' is no angle: "),
        (("--stop", "+1 d"), "one of --step and --count and --tolerance is needed"),
        (("--stop", "+1 d", "--step", "1 h", "--count", "2"), "--step, --count and --tolerance each say where rows are: one of them"),
        (("--step", "1 h"), '--stop is missing, the last time, as --stop "+1 d"'),
    ],
)
def test_messages_name_the_option(tmp_path, options, message):
    assert message in refused("propagate", TOUTATIS, "-o", tmp_path / "a.csv", *options)
    history = ROOT / "data/samples/attitude/spinner.ecsv"
    if message.startswith("polhode: --st"):
        assert message in refused("propagate", history, "-o", tmp_path / "a.csv", *options)


def test_warnings_say_so_and_name_their_file(tmp_path):
    table = ROOT / "data/samples/attitude/spinner.csv"
    warning = f"polhode: warning: {table}: the table has no column frame; ICRF is assumed\n"
    assert warning in run("propagate", table, "-o", tmp_path / "a.csv").stderr
    assert warning in run("compare", table, table).stderr
    rotator = ROOT / "data/samples/asteroid/spin.txt"
    stderr = run("propagate", rotator, "-o", tmp_path / "b.csv", "--stop", "+1 h", "--count", "2").stderr
    assert f"polhode: warning: {rotator}: frame assumed: ecliptic of J2000" in stderr


@pytest.mark.parametrize(
    "old, new, message",
    [
        ('accuracy = "1 deg"', "accuracy = 0.1", 'accuracy: found a number, a number with its unit is wanted, in quotes, as accuracy = "0.1 deg"'),
        ('accuracy = "1 deg"', 'accuracy = "0.1"', "accuracy: found '0.1' without a unit, a number with its unit is wanted"),
        ('after = "30 d"', 'after = "20"', "after: found '20' without a unit, a number with its unit is wanted, in quotes, as after = \"30 d\""),
        ('after = "30 d"', "after = 20", "after: found a number, a number with its unit is wanted"),
        (f'body = "{ROOT}/data/scenes/bodies/envisat-2013.toml"', 'body = ""', "body: found '', the name of a file is wanted"),
    ],
)
def test_quantities_of_scenes_need_their_units(tmp_path, old, new, message):
    path, line = scene(tmp_path, old, new)
    assert f"{path}:{line}: {message}" in refused("plan", path)


def test_a_date_may_have_a_blank_before_its_z():
    dates = [run("convert-time", "--to", "TT", input=f"2029-04-13T21:46:00{z}\n").stdout for z in ("Z", " Z", " z", " UTC")]
    assert len(set(dates)) == 1


def test_lengths_of_quaternions_that_overflow_are_said(tmp_path):
    table = tmp_path / "a.csv"
    table.write_text((ROOT / "data/samples/attitude/spinner.csv").read_text().replace(",0,0,0,1,", ",1e308,1e308,0,1,"))
    stderr = refused("info", table)
    assert "the quaternion has length 1.41421e+308, it must be 1" in stderr


@pytest.mark.parametrize(
    "command, message",
    [
        (("propagate", TOUTATIS, "-o", "a.csv", *SPAN, "--frame", "TEME"), "--frame: 'TEME' is not an inertial frame; allowed: "),
        (("propagate", TOUTATIS, "-o", "a.csv", *SPAN, "--scale", "XYZ"), "--scale: 'XYZ' is not a time scale; allowed: "),
        (("propagate", TOUTATIS, "-o", "a.fits", *SPAN, "--scale", "GPS"), "--scale: readers of FITS do not know the time scale GPS"),
        (("propagate", TOUTATIS, "-o", "a.ecsv", *SPAN, "--scale", "ET"), "--scale: astropy knows no time scale ET"),
        (("propagate", TOUTATIS, "-o", "a.aem", *SPAN, "--scale", "ET"), "--scale: CCSDS knows no time scale ET"),
        (("propagate", TOUTATIS, "-o", "a.csv", *SPAN, "--method", "kind"), "--method: unknown method 'kind', allowed are "),
        (("propagate", TOUTATIS, "-o", "a.csv", *SPAN, "--max-evaluations", "9"), f"{TOUTATIS}: is no scene: --max-evaluations"),
        (("propagate", ROOT / "data/samples/attitude/spinner.csv", "-o", "a.csv", "--frame", "TEME"), "--frame: 'TEME'"),
        (("eval", CASE, "--method", "kind"), "--method: unknown method 'kind'"),
        (("eval", CASE, "--max-evaluations", "9"), f"{CASE}: --max-evaluations is for torques"),
        (("eval", TORQUED, "--method", "kind"), "--method: "),
        (("bench", CASE, "9", "--method", "kind"), "--method: unknown method 'kind'"),
        (("convert-time", "--to", "XYZ"), "--to: 'XYZ' is not a time scale"),
        (("convert-time", "--to", "TT", "--from", "XYZ"), "--from: 'XYZ' is not a time scale"),
        (("convert-frame", "--from", "XYZ", "--to", "ICRF"), "--from: 'XYZ' is not a frame"),
        (("convert-frame", "--to", "XYZ", "--from", "ICRF"), "--to: 'XYZ' is not a frame"),
        (("convert-frame", "--to", "ICRF", "--from", "ITRF", "--scale", "XYZ"), "--scale: 'XYZ' is not a time scale"),
    ],
)
def test_messages_about_values_name_their_option(tmp_path, command, message):
    assert f"polhode: {message}" in refused(*command, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_messages_of_eval_name_the_case_file(tmp_path):
    case = tmp_path / "a.case"
    lines = ["I 1 2 3", "q 1 0 0 0", "m 0.1 0.2 0.3", "t 10"]
    for number, line, message in [
        (0, "I 1e-320 2 3", "the principal moments are 1e-320, 2, 3"),
        (0, "I 1e-100 2 3", "the largest may be 1e+100 times the smallest"),
        (2, "m 1e-320 0 0", "the angular momentum is 1e-320, 0, 0"),
        (2, "m 1e308 0 0", "the angular momentum is 1e+308, 0, 0"),
    ]:
        case.write_text("\n".join([*lines[:number], line, *lines[number + 1 :]]) + "\n")
        stderr = refused("eval", case)
        assert stderr.startswith(f"polhode: {case}:{number + 1}: ") and message in stderr
    assert f"polhode: {TORQUED}: stopped: 0 s to " in refused("eval", TORQUED, "--max-evaluations", "100", status=1)
    stderr = refused("eval", ROOT / "data/truth/torqued/envisat-slow-01.case", "--tolerance", "1e-15", status=1)
    assert f"polhode: {ROOT}/data/truth/torqued/envisat-slow-01.case: tolerance not reachable: the estimated error" in stderr


def test_messages_about_histories_name_their_file(tmp_path):
    overlapping = CCSDS / "valid/AEMExample14.txt"
    other = ROOT / "data/samples/attitude/spinner.csv"
    for command in (("compare", overlapping, other), ("compare", other, overlapping), ("propagate", overlapping, "-o", tmp_path / "a.aem")):
        assert f"polhode: {overlapping}: segments 1 and 2" in refused(*command)
    later = propagate(TOUTATIS, tmp_path / "later.aem", "--start", "+3 d", *SPAN)
    assert f"polhode: {other} and {later}: the two attitudes have no time in common" in refused("compare", other, later)
    unusable = CCSDS / "valid/AEMExample05.txt"
    assert f"polhode: {unusable}: no row of the attitude history" in refused("propagate", unusable, "-o", tmp_path / "b.aem")
    body = CCSDS / "valid/APMExample02.txt"
    assert f"neither {body} nor {TOUTATIS} is an attitude ephemeris" in refused("compare", body, TOUTATIS)
    assert f"polhode: {other}: is taken as an attitude history, and --momentum" in refused("propagate", other, "-o", tmp_path / "c.fits", "--momentum")
    rotator = ROOT / "data/samples/asteroid/spin.txt"
    assert f"polhode: {rotator}: " in refused("propagate", rotator, "-o", tmp_path / "c.csv", *SPAN, "--momentum")


def test_a_mesh_that_is_no_surface_is_traced_to_the_line_of_the_scene(tmp_path):
    facets = 'unit_m = 1.0\ncentre_of_mass = "mesh origin"\nspecular = 0.1\ndiffuse = 0.1\norbit = "earth"\n'
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
    path, line = scene(tmp_path, "[[torque]]", '[[torque]]\nkind = "sunlight"\nmesh = "open.obj"\n' + facets + "[[torque]]")
    assert f"{path}:{line + 2}: torque.mesh: 3 facets" in refused("plan", path)


def test_a_scene_too_short_for_its_rows_is_named(tmp_path):
    path, _ = scene(tmp_path, 'after = "30 d"', 'after = "1e-154 s"')
    assert f"polhode: {path}: stop is not after start" in refused("propagate", path, "-o", tmp_path / "a.csv", "--count", "3")


def test_every_message_names_a_file_or_an_option(tmp_path):
    still = tmp_path / "still.toml"
    still.write_text(SPINNER.replace("[0.0, 0.0, 9.0]", "[0, 0, 0]"))
    history = ROOT / "data/samples/attitude/spinner.csv"
    out = ("-o", tmp_path / "a.aem")
    for command, origin in [
        (("chart", "speed-accuracy", still, *out), f"{still}: the body is at rest"),
        (("chart", "torqued", TOUTATIS, *out), f"{TOUTATIS}: "),
        (("eval", TORQUED, "--step", "1"), "--step is for methods of fixed step"),
        (("bench", CASE, "9", "--tolerance", "1e-9"), f"{CASE}: --tolerance is for motion under torques"),
        (("propagate", TOUTATIS, *out, "--stop", "-1 d", "--count", "3"), "--stop: stop is not after start"),
        (("propagate", TOUTATIS, *out, "--times", "2000-01-01 TDB,tomorrow"), "--times: 'tomorrow' is not a date"),
        (("propagate", TOUTATIS, *out, "--times", "now", "--count", "3"), "--times stands alone"),
        (("propagate", TOUTATIS, *out, *SPAN, "--attitude-type", "SPIN"), "--attitude-type: attitude type 'SPIN' is not one"),
        (("propagate", TOUTATIS, *out, *SPAN, "--adm", "3.0"), "--adm: ADM version '3.0' is not one"),
        (("propagate", TOUTATIS, *out, "--stop", "+1 d", "--tolerance", "1e-15"), f"{TOUTATIS}: a tolerance of 1e-15 rad cannot be kept"),
        (("compare", history, TOUTATIS, "--tolerance", "1 x"), "--tolerance: '1 x' is no angle"),
    ]:
        assert refused(*command).startswith(f"polhode: {origin}")
