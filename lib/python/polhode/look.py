"""Pictures of a body as an observer sees it: lit as it is, north up and east to the left, with its long axis and its
angular momentum. `polhode look` is main(); picture() gives the figure of one instant or a strip of several.
"""

from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from . import _files
from ._core import Instant, Mesh, frame_rotation, read, read_mesh
from ._errors import InputError

NIGHT, SKY_TEXT = "#0b0e13", "#c9ced6"
LONG_AXIS, MOMENTUM, SUN = "#e8a33d", "#5fb3e6", "#f2e58f"
LENGTH_UNITS = ("m", "km", "cm", "mm", "au")
MOST_INSTANTS = 48
DARK = 0.13  # of what is seen and not lit


def ellipsoid(semi_axes, rings=40, meridians=80):
    """Vertices and facets (indices) of an ellipsoid, corners counter-clockwise seen from outside."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    longitude = np.arange(meridians) * 2 * np.pi / meridians
    grid = np.stack(
        [
            np.cos(latitude)[:, None] * np.cos(longitude),
            np.cos(latitude)[:, None] * np.sin(longitude),
            np.broadcast_to(np.sin(latitude)[:, None], (rings - 1, meridians)),
        ],
        -1,
    )
    vertices = np.concatenate([grid.reshape(-1, 3), [[0, 0, -1], [0, 0, 1]]]) * semi_axes
    index = np.arange((rings - 1) * meridians).reshape(rings - 1, meridians)
    right = np.roll(index, -1, axis=1)
    lower, upper = index[:-1].ravel(), index[1:].ravel()
    lower_right, upper_right = right[:-1].ravel(), right[1:].ravel()
    south, north = len(vertices) - 2, len(vertices) - 1
    facets = np.concatenate(
        [
            np.stack([lower, lower_right, upper], 1),
            np.stack([lower_right, upper_right, upper], 1),
            np.stack([right[0], index[0], np.full(meridians, south)], 1),
            np.stack([index[-1], right[-1], np.full(meridians, north)], 1),
        ]
    )
    return vertices, facets


def surface(shape, unit=None):
    """Vertices and facets of what Motion.observe takes as a shape; of a length that does not matter."""
    if isinstance(shape, Mesh):
        return shape.vertices, shape.facets
    axes = np.asarray(shape, float) if not isinstance(shape, str) else semi_axes(shape)
    if axes is None:
        mesh = read_mesh(shape)
        return mesh.vertices, mesh.facets
    if axes.shape != (3,) or not ((axes > 0) & (axes < np.inf)).all():
        raise InputError(f"the semi-axes of the ellipsoid are {shape}; three positive numbers are wanted")
    return ellipsoid(axes)


def semi_axes(text):
    """Those that "A B C unit" names; None if it is no such text but the name of a file."""
    words = text.replace(",", " ").split()
    if len(words) != 4 or words[3] not in LENGTH_UNITS:
        return None
    try:
        return np.array([float(word) for word in words[:3]])
    except ValueError:
        return None


def direction(longitude_deg, latitude_deg):
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    return np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], -1)


class Sky:
    """The plane across the line of sight: x to the west, y to the north, z towards the observer. Vectors of ICRF in, or of
    the body with its rotation."""

    def __init__(self, towards_observer):
        z = towards_observer / np.linalg.norm(towards_observer)
        across = np.hypot(z[0], z[1])
        cosine, sine = (-z[0] / across, -z[1] / across) if across > 0 else (1.0, 0.0)
        self.axes = np.array([[sine, -cosine, 0.0], [z[2] * cosine, z[2] * sine, across], z])

    def __call__(self, vectors):
        return vectors @ self.axes.T


def draw(ax, vertices, facets, to_icrf, observer, sun, momentum, long_axis, label):
    """One view. `to_icrf` turns body vectors (n, 3); `observer`, `sun`, `momentum` and `long_axis` are directions of ICRF."""
    sky = Sky(observer)
    corners = sky(to_icrf(vertices))[facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = sky(sun) / np.linalg.norm(sun)
    seen = normals[:, 2] > 0
    order = np.argsort(corners[seen].mean(axis=1)[:, 2])  # from back to front: nearer facets cover others
    corners, normals = corners[seen][order], normals[seen][order]
    mu, mu0 = normals[:, 2], np.clip(normals @ light, 0, None)
    grey = np.clip(DARK + 1.7 * mu0 / (mu + mu0 + 1e-9) * (0.35 + 0.65 * mu0), 0, 1)
    colours = np.clip(grey[:, None] * np.array([1.0, 0.975, 0.93]), 0, 1)
    ax.add_collection(PolyCollection(corners[:, :, :2], facecolors=colours, edgecolors=colours, linewidths=0.3, zorder=3))
    size = np.linalg.norm(vertices, axis=1).max()
    for axis, colour, length in ((long_axis, LONG_AXIS, 1.35), (momentum, MOMENTUM, 1.6)):
        x, y, z = sky(axis / np.linalg.norm(axis)) * size * length
        ax.plot([-x, x], [-y, y], color=colour, lw=0.8, ls=(0, (3, 3)), zorder=2)
        ax.annotate("", (x, y), (0, 0), arrowprops=dict(arrowstyle="-|>", color=colour, lw=1.5, shrinkA=0, shrinkB=0), zorder=4 if z > 0 else 2)
    if np.hypot(light[0], light[1]) > 1e-6:
        x, y = light[:2] / np.hypot(light[0], light[1]) * size * 1.75
        ax.plot(x, y, "o", ms=6, color=SUN, zorder=5)
    reach = 1.9 * size
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.axis("off")
    ax.set_title(label, fontsize=8.5, color=SKY_TEXT, pad=3)


def picture(motion, times, target=None, *, shape, shape_unit=None, name="", scale="UTC", **options):
    """The figure of a body at times of reception (a list): what it looks like from the observer. `target` and `options` are
    those of Motion.observe. Raises InputError."""
    instants = [Instant.of(time) for time in times]
    if not 1 <= len(instants) <= MOST_INSTANTS:
        raise InputError(f"{len(instants)} instants; 1 to {MOST_INSTANTS} are drawn")
    rows = motion.observe(instants, target, **options)
    emission = np.array([instant - motion.epoch for instant in instants]) - rows["light_time_s"]
    state = motion(emission)
    q_icrf = frame_rotation(motion.frame, "ICRF")
    vertices, facets = surface(shape, shape_unit)
    vertices = vertices - 0.5 * (vertices.max(axis=0) + vertices.min(axis=0))
    columns = min(len(instants), 6)
    lines = -(-len(instants) // columns)
    side = 5.5 if len(instants) == 1 else 2.4
    height = side * lines * 1.06 + 1.1
    figure = Figure(figsize=(side * columns, height), dpi=150, facecolor=NIGHT)
    top = 1 - 0.85 / height
    grid = figure.add_gridspec(lines, columns, left=0.01, right=0.99, bottom=0.05, top=top, wspace=0.02, hspace=0.14)
    for k, instant in enumerate(instants):

        def to_icrf(v, k=k):
            return turned(q_icrf, turned(state.q[k], np.atleast_2d(v)))

        observer = to_icrf(direction(rows["sub_observer_lon_deg"][k], rows["sub_observer_lat_deg"][k]))[0]
        sun = to_icrf(direction(rows["sub_solar_lon_deg"][k], rows["sub_solar_lat_deg"][k]))[0]
        label = instant.text(scale, 0).replace("T", " ") + f" {scale}\nphase {rows['phase_deg'][k]:.1f}°"
        draw(
            figure.add_subplot(grid[k // columns, k % columns]), vertices, facets, to_icrf, observer, sun,
            direction(rows["momentum_ra_deg"][k], rows["momentum_dec_deg"][k]),
            direction(rows["long_axis_ra_deg"][k], rows["long_axis_dec_deg"][k]), label,
        )  # fmt: skip
    figure.text(0.015, 1 - 0.3 / height, name, fontsize=12, color="white", weight="bold", parse_math=False)
    figure.text(
        0.985, 0.012, "north up, east left;  orange: long axis;  blue: angular momentum;  yellow: towards the Sun",
        fontsize=7, color=SKY_TEXT, ha="right",
    )  # fmt: skip
    return figure


def turned(q, v):
    """q v q*, one q (scalar first), v (n, 3)."""
    t = 2 * np.cross(q[1:], v)
    return v + q[0] * t + np.cross(q[1:], t)


def main(arguments):
    from . import plot

    parser = _files.Parser(prog="polhode look", description="A picture of a body as an observer sees it, or a strip of several")
    parser.add_argument("file", help="body or scene")
    parser.add_argument("-o", "--output", required=True, help="picture, .png, .pdf or .svg")
    parser.add_argument("--target", required=True, help="trajectory of the body, as polhode observe takes it")
    parser.add_argument("--shape", required=True, help='"A B C unit" (semi-axes along x, y, z) or a mesh')
    parser.add_argument("--start", required=True, help="first time of reception, a date with its scale")
    parser.add_argument("--step", type=_files.duration_s, default="1 h", help='from one picture to the next, in s, or with unit as "10 min" (default: 1 h)')
    parser.add_argument("--count", type=int, default=1, help=f"pictures, 1 to {MOST_INSTANTS} (default: 1)")
    parser.add_argument("--observer", default="geocentre", help="geocentre, sun, or a trajectory (default: geocentre)")
    parser.add_argument("--shape-unit", help="unit of a mesh's coordinates: m, km ...")
    parser.add_argument("--centre", default="Sun", help="what trajectories are about whose files do not say it (default: Sun)")
    parser.add_argument("--trajectory-frame", help="frame of trajectories in tables of text (default: ICRF)")
    parser.add_argument("--site", help='"LONGITUDE LATITUDE HEIGHT" in deg, deg, m, instead of an observer')
    options = parser.parse_args(arguments)
    out = Path(options.output)
    format = plot.picture_format(out)
    what = read(options.file)
    body = getattr(what, "body", what)
    start = Instant(options.start)
    site = {}
    if options.site:
        try:
            longitude, latitude, height = (float(word) for word in options.site.replace(",", " ").split())
        except ValueError:
            raise InputError(f"--site: '{options.site}' is no LONGITUDE LATITUDE HEIGHT") from None
        site = {"site": (longitude, latitude, height)}
    times = [start + k * options.step for k in range(max(options.count, 0))]
    figure = picture(
        what.motion(), times, options.target, shape=options.shape, shape_unit=options.shape_unit, name=body.name,
        observer=options.observer, centre=options.centre, trajectory_frame=options.trajectory_frame, **site,
    )
    with _files.whole_file(out) as file:
        figure.savefig(file, format=format, facecolor=NIGHT)
