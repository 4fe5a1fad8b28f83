"""What is mutated: the sample files of data/, some more of our making, and the command lines that read them."""

import dataclasses
import math
import pathlib
import re

FORMATS = ("x.csv", "x.fits", "x.aem", "x.ecsv", "x.xml")
TYPES = ("QUATERNION", "QUATERNION/DERIVATIVE", "EULER_ANGLE", "EULER_ANGLE/DERIVATIVE", "EULER_ANGLE/ANGVEL")


@dataclasses.dataclass
class Seed:
    kind: str
    target: str  # the file that is mutated, one of `files`; empty: the arguments are
    files: dict  # contents by path, below the folder where the program runs
    commands: list  # lists of arguments
    standard_input: str = ""  # one of `files`
    motion: bool = True  # the files written are motions, which promise an error

    @property
    def name(self):
        return f"{self.kind} {self.target or self.commands[0][0]}"

    @property
    def content(self):
        return self.files[self.target]


def propagations(file, span, more=()):
    """A propagation to every format, now and then with other rates or more columns."""
    base = ["propagate", file, "--count", "3"] + (["--stop", span] if span else []) + list(more)
    runs = [base + ["-o", out] for out in FORMATS]
    runs += [base + ["-o", "x.aem", "--attitude-type", kind] for kind in TYPES]
    return runs + [base + ["-o", "x.fits", "--momentum"], base + ["-o", "x.aem", "--frame", "ICRF"]]


def body_commands(file, span="+1 d"):
    return [["info", file], ["info", "--json", file]] + propagations(file, span)


def history_commands(file):
    return [["info", file], ["info", "--json", file], ["compare", file, file]] + [
        ["propagate", file, "--history", "--count", "3", "-o", out] for out in FORMATS
    ]


def scene_commands(file):
    return [["plan", file], ["plan", file], *propagations(file, None)[:5], ["info", file]]


def orbit_rows(step_s, rows, with_velocity):
    """A circle of 7000 km in a day, x and y in km: t, x, y, z and, when wanted, the velocity."""
    table = []
    rate = 2.0 * math.pi / 86400.0
    for i in range(rows):
        t = i * step_s
        c, s = math.cos(rate * t), math.sin(rate * t)
        row = [t, 7000.0 * c, 7000.0 * s, 0.0]
        if with_velocity:
            row += [-7000.0 * rate * s, 7000.0 * rate * c, 0.0]
        table.append(row)
    return table


def trajectories():
    """Small ones in every form that is read."""
    with_v, without = orbit_rows(3600.0, 12, True), orbit_rows(3600.0, 12, False)

    def date(t):
        return f"2000-01-01T{int(t) // 3600 + 1:02d}:00:00"

    def rows(table, first=date, separator=" "):
        return "".join(separator.join([str(first(r[0]))] + [f"{v:.9g}" for v in r[1:]]) + "\n" for r in table)

    def oem(table, method):
        return (
            "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-24T00:00:00\nORIGINATOR = POLHODE\nMETA_START\nOBJECT_NAME = A\n"
            "OBJECT_ID = 1\nCENTER_NAME = EARTH\nREF_FRAME = ICRF\nTIME_SYSTEM = TDB\nSTART_TIME = 2000-01-01T01:00:00\n"
            f"USEABLE_START_TIME = 2000-01-01T01:00:00\nSTOP_TIME = 2000-01-01T12:00:00\n{method}META_STOP\n" + rows(table)
        )

    csv = "t_s,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n" + rows(with_v, lambda t: t, ",")
    ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n" + "".join(
        f"# - {{name: {n}, unit: km, datatype: float64}}\n" for n in "xyz"
    )
    return {
        "hermite.oem": oem(with_v, "INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n"),
        "lagrange.oem": oem(with_v, "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 5\n"),
        "linear.oem": oem(with_v, "INTERPOLATION = LINEAR\n"),
        "seconds.csv": csv,
        "dates.ecsv": ecsv + "date_tdb x y z\n" + rows(without),
        "dates.csv": "date_tdb,x_m,y_m,z_m\n" + rows(without, date, ","),
    }


SATELLITE = """name = "A satellite"
source = "of our making"
[inertia]
moments = [2.0, 3.5, 5.0]
products = [0.1, -0.05, 0.02]
products_are = "tensor elements"
unit = "kg m2"
[state]
epoch = "2000-01-01T01:00:00 TDB"
frame = "EME2000"
[state.attitude]
q_frame_from_body_scalar_first = [0.5, -0.5, 0.5, 0.5]
[state.angular_velocity]
components = [0.1, 0.02, -0.3]
axes = "body"
unit = "deg/s"
"""
SCENE = """name = "A scene of our making"
source = "none"
body = "satellite.toml"
frame = "ICRF"
before = "1 min"
after = "{after}"
accuracy = "1e-4 deg"
"""
KEPLER = """[orbit.earth]
mu_m3_s2 = 3.986004418e14
periapsis_m = 7.0e6
eccentricity = 0.1
periapsis_after_epoch_s = 100.0
to_periapsis = [1.0, 0.0, 0.0]
normal = [0.0, 0.3, 1.0]
"""
TORQUES = {
    "aerodynamic": '[[torque]]\nkind = "aerodynamic"\nmesh = "box.obj"\nunit_m = 0.5\ncentre_of_mass = [0.1, 0.2, 0.3]\naccommodation = 0.9\nrebound_speed = 0.1\norbit = "earth"\ndensity_kg_m3 = 1e-13\ndistance_m = 7.1e6\nscale_height_m = 9e4\nturn_rad_s = 7.3e-5\nturn_axis = [0, 0, 1]\n',
    "sunlight": '[[torque]]\nkind = "sunlight"\nmesh = "box.obj"\nunit_m = 0.5\ncentre_of_mass = "mesh centroid"\nspecular = 0.3\ndiffuse = 0.2\norbit = "earth"\n',
    "pulses": '[[torque]]\nkind = "thruster pulse"\ntorque_n_m = [1e-4, -2e-4, 3e-4]\nstart_s = 60.0\nduration_s = 20.0\n'
    '[[torque]]\nkind = "constant"\ntorque_n_m = [1e-7, 2e-7, 3e-7]\naxes = "frame"\n',
    "many": '[[torque]]\nkind = "gravity gradient"\norbit = "earth"\n[[torque]]\nkind = "linear damping"\ncoefficient_n_m_s = 1e-6\n'
    '[[torque]]\nkind = "eddy currents"\nmagnetic_tensor_s_m4 = [[900.0, 1.0, 0.0], [1.0, 1000.0, 0.0], [0.0, 0.0, 1100.0]]\n'
    'dipole_t_m3 = 7.8e12\ndipole_axis = [0.0, 0.1, -1.0]\norbit = "earth"\n'
    '[[torque]]\nkind = "internal dissipation"\nquality_factor = 100.0\n',
}

BODIES = {
    "mesh.toml": SATELLITE.replace(
        SATELLITE[SATELLITE.index("moments") : SATELLITE.index("[state]")],
        'mesh = "box.obj"\ndensity_kg_m3 = 1200.0\nlength_unit = "mm"\n',
    ),
    "ellipsoid.toml": SATELLITE.replace(
        SATELLITE[SATELLITE.index("moments") : SATELLITE.index("[state]")],
        'semi_axes = [2.0, 1.5, 1.0]\nmass_kg = 30.0\nlength_unit = "m"\n',
    ),
    "tensor.toml": SATELLITE.replace(
        SATELLITE[SATELLITE.index("moments") : SATELLITE.index("[state]")],
        'tensor = [[2.0, 0.1, 0.0], [0.1, 3.5, 0.2], [0.0, 0.2, 5.0]]\nunit = "kg m2"\n',
    ).replace(SATELLITE[SATELLITE.index("[state.angular_velocity]") :],
        '[state.angular_momentum]\ncomponents = [0.1, 0.2, 0.3]\naxes = "frame"\nunit = "N m s"\n'),
    "spin.toml": """name = "A spin"
[inertia]
moments = [0.64, 0.97, 1.0]
unit = "ratios"
[spin]
epoch = "2012-12-23T00:00:00 TDB"
frame = "ECLIPJ2000"
unit = "deg"
lambda = 275.0
beta = -85.0
phi0 = 152.0
psi0 = 14.0
convention = "long-axis"
mode = "short-axis"
period_unit = "h"
P_phi = 27.38547
P_psi = 264.178
""",
    "rotator.toml": """name = "A rotator"
[spin]
epoch = "2012-12-23T00:00:00 TDB"
frame = "ECLIPJ2000"
unit = "deg"
lambda = 275.0
beta = -85.0
phi0 = 152.0
period_unit = "h"
period = 5.0
""",
}  # fmt: skip


def argument_seeds(files):
    """Command lines with every option that takes a number; only the arguments are mutated."""
    body, scene, case = "bodies/toutatis.toml", "scenes/spin-up.toml", "truth/dev/sam-01.case"
    torqued, history = "truth/torqued/combined-01.case", "samples/attitude/spinner.csv"
    start = ["--start", "1993-01-01T00:00:00.5 TDB", "--stop", "1993-01-02T12:30:00 TDB"]
    commands = [
        ["propagate", body, *start, "--count", "3", "-o", "x.csv"],
        ["propagate", body, *start, "--count", "3", "-o", "x.fits", "--scale", "UTC"],
        ["propagate", body, "--start", "+1.5 h", "--stop", "+2 d", "--step", "600 s", "-o", "x.fits"],
        ["propagate", body, "--stop", "+2 d", "--tolerance", "1e-6 rad", "-o", "x.fits"],
        ["propagate", body, "--stop", "+2 d", "--tolerance", "0.1 arcsec", "-o", "x.aem"],
        ["propagate", body, "--stop", "+1 h", "--step", "10 min", "-o", "x.ecsv", "--method", "rk4"],
        ["propagate", body, "--times", "1993-01-01T00:00:00 TDB,1993-01-01T00:00:01 TDB", "-o", "x.csv"],
        ["propagate", body, "--times", "JD 2449000.5 TDB,MJD 49000.0 0.25 TDB", "-o", "x.csv"],
        ["propagate", body, "--start", "+1 d", "--stop", "+2 d", "--start", "+3 d", "--stop", "+1 d", "--count", "4",
         "-o", "x.aem", "--adm", "1.0", "--attitude-type", "QUATERNION"],
        ["propagate", body, "--stop", "+1 d", "--count", "3", "-o", "x.aem", "--attitude-type", "EULER_ANGLE",
         "--euler-sequence", "313"],
        ["propagate", scene, "--count", "3", "-o", "x.fits"],
        ["propagate", scene, "--start", "+1 min", "--stop", "+2 min", "--step", "1 s", "-o", "x.csv"],
        ["propagate", scene, "--tolerance", "1e-3 rad", "-o", "x.fits"],
        ["propagate", history, "--start", "+2 s", "--stop", "+3 s", "--step", "0.5 s", "-o", "x.csv"],
        ["propagate", history, "--count", "5", "-o", "x.fits"],
        ["eval", case, "--tolerance", "1e-9"],
        ["eval", case, "--method", "rk4", "--step", "0.1"],
        ["eval", case, "--method", "dop853", "--tolerance", "1e-6"],
        ["eval", torqued, "--tolerance", "1e-8"],
        ["compare", history, history, "--tolerance", "1e-6 rad"],
        ["compare", history, history, "--tolerance", "2 arcsec"],
        ["bench", case, "100"],
        ["bench", case, "50", "--method", "theta"],
        ["plan", scene], ["plan", "--full", scene], ["methods"],
        ["chart", "speed-accuracy", "bodies/t-handle.toml@1s", "-o", "chart", "--size", "0.01"],
        ["info", "samples/asteroid/tumblers.csv#7"],
    ]  # fmt: skip
    seeds = [Seed("arguments", "", files, [command], motion=command[1:2] != [history]) for command in commands]
    for command in (
        ["convert-time", "--to", "UTC", "--decimals", "9"],
        ["convert-time", "--from", "TDB", "--to", "TT", "--mjd"],
        ["convert-frame", "--from", "ICRF", "--to", "ITRF", "--ut1-utc", "0.1", "--pole-x", "0.2", "--pole-y", "-0.3"],
        ["convert-frame", "--from", "TEME", "--to", "ECLIPIAU2006", "--scale", "UTC"],
    ):
        seeds.append(Seed("arguments", "", {**files, "dates.txt": b"2001-01-01T00:00:00 UTC\n"}, [command], "dates.txt"))
    return seeds


def all_seeds(data):
    """Every sample below the folder data/, and those of our making."""
    data = pathlib.Path(data)

    def read(*patterns):
        found = [path for pattern in patterns for path in sorted(data.glob(pattern)) if path.is_file()]
        return {str(path.relative_to(data)): path.read_bytes() for path in found}

    seeds = []
    for name, content in read("bodies/*.toml", "bodies/incomplete/*.toml").items():
        seeds.append(Seed("body", name, {name: content}, body_commands(name)))
    box = (data / "samples/mesh/box.obj").read_bytes()
    for name, text in BODIES.items():
        seeds.append(Seed("body", name, {name: text.encode(), "box.obj": box}, body_commands(name)))
    of_their_own = {"attitude", "ccsds", "mesh", "time"}  # below
    folders = sorted(folder.name for folder in (data / "samples").iterdir() if folder.name not in of_their_own)
    for folder in folders:
        for name, content in read(f"samples/{folder}/*").items():
            file = name + "#7" if name.endswith("tumblers.csv") else name
            seeds.append(Seed(folder, name, {name: content}, body_commands(file)))
    for name, content in read("samples/mesh/*").items():
        files = {name: content, "mesh.toml": BODIES["mesh.toml"].replace("box.obj", name).encode()}
        seeds.append(Seed("mesh", name, files, [["info", name], *body_commands("mesh.toml", "+1 h")]))

    for name in read("scenes/*.toml"):
        text = (data / name).read_text()
        body = re.search('^body = "(.*)"', text, re.M)[1]
        body = f"scenes/{body}" if not body.startswith("../") else body[3:]
        orbits = [f"scenes/{orbit}" for orbit in re.findall('^trajectory = "(.*)"', text, re.M)]
        files = read(name, body, *orbits)
        for target in (name, body, *orbits):
            kind = "trajectory" if target in orbits else "scene"
            seeds.append(Seed(kind, target, files, scene_commands(name)))
    box_files = {"satellite.toml": SATELLITE.encode(), "box.obj": box}
    for name, torques in TORQUES.items():
        scene = SCENE.format(after="2 h") + KEPLER + torques
        for target in ["scene.toml", "satellite.toml"] + (["box.obj"] if name == "sunlight" else []):
            files = {**box_files, "scene.toml": scene.encode()}
            seeds.append(Seed("scene", target, files, scene_commands("scene.toml")))
    for name, text in trajectories().items():
        scene = SCENE.format(after="10 h").replace('before = "1 min"\n', "")
        scene += f'[orbit.earth]\nmu_m3_s2 = 3.986e14\ntrajectory = "{name}"\n[[torque]]\nkind = "gravity gradient"\norbit = "earth"\n'
        files = {**box_files, "scene.toml": scene.encode(), name: text.encode()}
        seeds.append(Seed("trajectory", name, files, scene_commands("scene.toml")))

    for name, content in read("truth/dev/*.case", "truth/torqued/*.case").items():
        commands = [["eval", name]]
        if "/dev/" in name:  # rk4 takes seconds, so it is rare
            methods = ("auto", "legendre", "theta")
            commands = 5 * [["eval", "--method", method, name] for method in methods] + [["eval", "--method", "rk4", name]]
        seeds.append(Seed("case", name, {name: content}, commands))
    ccsds = read("samples/ccsds/valid/*", "samples/ccsds/invalid/*")
    for name, content in {**read("samples/attitude/*"), **ccsds}.items():
        commands = history_commands(name) + (propagations(name, "+10 s") if "AEM" not in name.upper() else [])
        seeds.append(Seed("history", name, {name: content}, commands, motion=False))

    toutatis = read("bodies/toutatis.toml", "samples/time/leap-seconds.tls")
    times = read("samples/time/times.txt")["samples/time/times.txt"]
    dates = b"1993-01-02T03:04:05.678 UTC\nJD 2449000.25 TT\nMJD 49000.0 0.25 TDB\n1993-104T00:00:00Z\n2016-12-31T23:59:60.5Z\n"
    files = {**toutatis, "times.txt": times, "dates.txt": dates}
    lists = [["propagate", "bodies/toutatis.toml", "--times", "times.txt", "-o", out] for out in FORMATS]
    seeds.append(Seed("times", "times.txt", files, lists))
    conversions = [["convert-time", "--to", scale] for scale in ("UTC", "TDB", "ET", "GPS", "TAI", "TT")]
    conversions += [["convert-time", "--to", "UTC", "--mjd"], ["convert-frame", "--from", "ICRF", "--to", "ITRF"]]
    seeds.append(Seed("dates", "dates.txt", files, conversions, "dates.txt"))
    kernel = "samples/time/leap-seconds.tls"
    early = {**files, "dates.txt": b"1972-01-01T00:00:00 UTC\n1972-06-30T23:59:60.5Z\n1975-01-01 TT\n"}
    leap = [["convert-time", "--to", scale, "--leap-seconds", kernel] for scale in ("TT", "UTC", "TDB")]
    seeds.append(Seed("leap seconds", kernel, early, leap, "dates.txt"))
    seeds += argument_seeds(read("bodies/t*.toml", "scenes/spin-up.toml", "scenes/bodies/long*.toml",
                                 "truth/dev/sam-01.case", "truth/torqued/combined-01.case", "samples/attitude/spinner.csv",
                                 "samples/asteroid/tumblers.csv"))  # fmt: skip
    return seeds
