"""A satellite of facets against an integration by scipy of equations that are written down once more here: named axes, the
whole inertia tensor, facet by facet, the Sun's disc covered by a ball."""

import re
import subprocess
import sys

import numpy as np
import pytest
import tomllib
from astropy.io import fits
from astropy.table import Table
from scipy.integrate import solve_ivp
from support import ROOT, angle_rad, assert_within, run

FOLDER = ROOT / "data/scenes/satellite"
MAKER = FOLDER / "envisat.py"


def scene_with(tmp_path, *changes, mesh=FOLDER / "envisat-36.obj"):
    text = (FOLDER / "satellite.toml").read_text()
    for old, new in [(r'"\.\./bodies/', f'"{FOLDER}/../bodies/'), (r'"envisat-36.obj"', f'"{mesh}"'), *changes]:
        text, count = re.subn(old, new, text)
        assert count, old
    path = tmp_path / "satellite.toml"
    path.write_text(text)
    return path


def facets_of(scene):
    """Area vectors, centres from the centre of mass, and the names of their surfaces; both sides of plates."""
    light = scene["torque"][1]
    vertices, rows, name = [], [], None
    for words in map(str.split, (FOLDER / light["mesh"]).read_text().splitlines()):
        if words[0] == "usemtl":
            name = words[1]
        elif words[0] == "v":
            vertices.append(np.array(words[1:], float) - light["centre_of_mass"])
        elif words[0] == "f":
            a, b, c = (vertices[int(w) - 1] for w in words[1:])
            area = np.cross(b - a, c - a) / 2
            for side in (1, -1)[: scene["surface"][name].get("sides", 1)]:
                rows.append((side * area, (a + b + c) / 3, name))
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), [r[2] for r in rows]


class Ellipse:
    def __init__(self, table):
        self.e, self.mu = table["eccentricity"], table["mu_m3_s2"]
        self.a = table["periapsis_m"] / (1 - self.e)
        self.start = table["periapsis_after_epoch_s"]
        w = np.array(table["normal"]) / np.linalg.norm(table["normal"])
        p = np.array(table["to_periapsis"])
        p = p - (p @ w) * w
        self.p = p / np.linalg.norm(p)
        self.q = np.cross(w, self.p)

    def __call__(self, t):
        n = np.sqrt(self.mu / self.a**3)
        mean = n * (t - self.start)
        anomaly = mean
        for _ in range(8):
            anomaly -= (anomaly - self.e * np.sin(anomaly) - mean) / (1 - self.e * np.cos(anomaly))
        c, s, root = np.cos(anomaly), np.sin(anomaly), np.sqrt(1 - self.e**2)
        rate = n / (1 - self.e * c)
        return self.a * ((c - self.e) * self.p + root * s * self.q), self.a * rate * (-s * self.p + root * c * self.q)


def seen_share(to_sun, place, radius):
    """Of the Sun's disc beside a ball, by the area of two discs' common part, as the areas of two segments."""
    a, b = np.arcsin(6.957e8 / np.linalg.norm(to_sun)), np.arcsin(radius / np.linalg.norm(place))
    d = np.arccos(np.clip(-place @ to_sun / np.linalg.norm(place) / np.linalg.norm(to_sun), -1, 1))
    if d >= a + b:
        return 1.0
    if d <= b - a:
        return 0.0
    alpha = 2 * np.arccos((d * d + a * a - b * b) / (2 * d * a))
    beta = 2 * np.arccos((d * d + b * b - a * a) / (2 * d * b))
    return 1 - (a * a * (alpha - np.sin(alpha)) + b * b * (beta - np.sin(beta))) / (2 * np.pi * a * a)


class Satellite:
    def __init__(self, scene):
        body = tomllib.loads((FOLDER / scene["body"]).read_text())
        (xx, yy, zz), (xy, xz, yz) = body["inertia"]["moments"], body["inertia"]["products"]
        self.tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self.inverse = np.linalg.inv(self.tensor)
        self.omega = np.radians(body["state"]["angular_velocity"]["components"])
        self.earth, self.sun = Ellipse(scene["orbit"]["earth"]), Ellipse(scene["orbit"]["sun"])
        self.mu = self.earth.mu
        self.light, self.air = scene["torque"][1:]
        areas, self.centres, names = facets_of(scene)
        self.sizes = np.linalg.norm(areas, axis=1)
        self.normals = areas / self.sizes[:, None]
        number = lambda key: np.array([scene["surface"][name][key] for name in names])
        self.specular, self.diffuse = number("specular"), number("diffuse")
        self.accommodation, self.rebound = number("accommodation"), number("rebound_speed")

    def pushed(self, s, pressure, along, square, linear):
        c = np.maximum(self.normals @ s, 0)
        force = -pressure * (self.sizes * c)[:, None] * (along[:, None] * s + (square * c + linear)[:, None] * self.normals)
        return np.cross(self.centres, force).sum(axis=0)

    def rate(self, t, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        a, b, c, d = q
        to_body = np.array(  # transposed: of the vectors of the frame
            [
                [a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)],
                [2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)],
                [2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d],
            ]
        )
        (place, velocity), to_sun = self.earth(t), -self.sun(t)[0]
        r = to_body @ place
        torque = 3 * self.mu / np.linalg.norm(r) ** 5 * np.cross(r, self.tensor @ r)
        pressure = 1361.0 / 299792458.0 * 149597870700.0**2 / (to_sun @ to_sun)
        share = seen_share(to_sun, place, self.light["shadow_radius_m"])
        s = to_body @ to_sun / np.linalg.norm(to_sun)
        torque += self.pushed(s, share * pressure, 1 - self.specular, 2 * self.specular, 2 / 3 * self.diffuse)
        wind = velocity - np.cross(np.array([0, 0, self.air["turn_rad_s"]]), place)
        density = self.air["density_kg_m3"] * np.exp((self.air["distance_m"] - np.linalg.norm(place)) / self.air["scale_height_m"])
        torque += self.pushed(
            to_body @ wind / np.linalg.norm(wind), density * (wind @ wind), self.accommodation, 2 * (1 - self.accommodation), self.accommodation * self.rebound
        )
        x, y_, z = w
        dq = np.array([-b * x - c * y_ - d * z, a * x + c * z - d * y_, a * y_ + d * x - b * z, a * z + b * y_ - c * x]) / 2
        return np.concatenate([dq, self.inverse @ (torque - np.cross(w, self.tensor @ w))])


def test_the_satellite_follows_the_equations_of_motion(tmp_path):
    last_s = 15000.0
    short = ('after = "30 d"', f'after = "{last_s} s"')
    satellite = Satellite(tomllib.loads((FOLDER / "satellite.toml").read_text()))
    first = np.asarray(Table.read(run_to(tmp_path, scene_with(tmp_path, short), "--stop", "+600 s", "--step", "600 s"), 1)["QPARAM"])[0, [3, 0, 1, 2]]
    times = np.arange(0.0, last_s + 1.0, 600.0)
    truth = solve_ivp(satellite.rate, (0.0, last_s), np.concatenate([first, satellite.omega]), method="DOP853", rtol=1e-11, atol=1e-13, max_step=4.0, t_eval=times)  # kinks: by 20 s it is off by 1e-5
    for accuracy in "0.01 deg", "1e-4 deg":
        scene = scene_with(tmp_path, short, ('accuracy = "1 deg"', f'accuracy = "{accuracy}"'))
        q = np.asarray(Table.read(run_to(tmp_path, scene, "--step", "600 s"), 1)["QPARAM"])[:, [3, 0, 1, 2]]
        assert_within(angle_rad(q, truth.y[:4].T), np.radians(float(accuracy.split()[0])))
    # Without light and air the body would be elsewhere.
    bare = scene_with(tmp_path, short, (r'(?s)\[\[torque\]\]\nkind = "sunlight".*', ""))
    q = np.asarray(Table.read(run_to(tmp_path, bare, "--step", "600 s"), 1)["QPARAM"])[:, [3, 0, 1, 2]]
    assert angle_rad(q, truth.y[:4].T).max() > 1e-5


def run_to(tmp_path, scene, *options):
    out = tmp_path / "out.fits"
    run("propagate", scene, "-o", out, *options)
    return out


def test_what_ran_in_place_of_the_plan_is_what_the_file_says(tmp_path):
    """Facets that come into the light keep few kicks per turn from the accuracy, which shows only when they have run."""
    scene = scene_with(tmp_path, ('after = "30 d"', 'after = "4 d"'))
    plan = run("plan", scene).stdout
    assert "model      splitting, few kicks per turn" in plan
    assert "cost       cannot be told before it runs (facets that come into the light" in plan
    result = run("propagate", scene, "-o", tmp_path / "out.fits", "--count", "3")
    header = fits.getheader(tmp_path / "out.fits", "ATTITUDE")
    assert header["METHOD"] == "dormand-prince" and header["TORQEVAL"] > 1e5
    assert f"method dormand-prince, {header['TORQEVAL']:.0f} torque evaluations" in result.stderr


def test_the_mesh_is_what_its_maker_makes(tmp_path):
    subprocess.run([sys.executable, MAKER, tmp_path / "made.obj"], check=True)
    assert (tmp_path / "made.obj").read_text() == (FOLDER / "envisat-36.obj").read_text()


@pytest.mark.parametrize(
    "old, new, message",
    [
        (r"\[surface.dish\]", "[surface.spoon]", "facet 17 has the surface 'dish', but the scene has no table [surface.dish]"),
        ("sides = 2\nspecular = 0.1", "sides = 3\nspecular = 0.1", "surface.array.sides: found 3, 1 or 2 is wanted"),
        ("specular = 0.1", "specular = 0.9", "surface.array.specular: the surface reflects 0.9 specular and 0.5 diffuse"),
        ("accommodation = 0.95", "accommodation = 1.95", "surface.array.accommodation: the accommodation is 1.95, a share from 0 to 1 is wanted"),
        ("specular = 0.2\n", "", "surface.antenna.specular"),
        ("sides = 2\nspecular = 0.3", "colour = 2\nspecular = 0.3", "surface.dish.colour"),
        ('shadow_orbit = "earth"\n', 'shadow_orbit = "moon"\n', "torque.shadow_orbit: found 'moon', but the scene has no table [orbit.moon]"),
        ('shadow_orbit = "earth"\n', "", "torque.shadow_orbit"),
        ("shadow_radius_m = 6.378137e6", "shadow_radius_m = -1.0", "torque.shadow_radius_m"),
        ("shadow_radius_m = 6.378137e6", "shadow_radius_m = 7.2e6", "and the body comes within"),
        ('shadow_orbit = "earth"', 'shadow_orbit = "sun"', "has the orbit of the Sun itself"),
        ("density_kg_m3 = 3.614e-14", "density_kg_m3 = 1.0", "thin air is meant"),
        ("scale_height_m = 88667.0", "scale_height_m = 0.0", "torque.scale_height_m"),
        ("density_kg_m3 = 3.614e-14", "density_kg_m3 = -1.0", "the density is -1, 0 or more is wanted"),
        (r"centre_of_mass = \[-3.905, -0.009, 0.003\]", "centre_of_mass = [1.0, 2.0]", "torque.centre_of_mass"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, old, new, message):
    scene = scene_with(tmp_path, (old, new))
    result = run("plan", scene, check=False)
    assert result.returncode == 2 and re.match(rf"polhode: {scene}:\d+: ", result.stderr) and message in result.stderr, result.stderr
    assert result.stderr.count(str(scene)) == 1

