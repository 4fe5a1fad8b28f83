"""A tumbling body as a film (MP4 or GIF), and as a glTF file whose attitude moves in any viewer: its mesh, or the ellipsoid
of its inertia, with its principal axes and the angular momentum.

`polhode animate` is main(); movie() and gltf() write the files. They need matplotlib, and astropy for FITS; gltf() needs
pygltflib.
"""

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import _files, plot
from ._core import Mesh, read, read_mesh, version
from ._errors import InputError
from ._style import Shown, style_named

AXIS_LENGTH = 1.4  # of what is drawn, in largest radii of the body
MOMENTUM_LENGTH = 1.7
LEAST_SEMI_AXIS = 0.02  # of a flat body, which would not be seen from its edge
FPS = 25
FRAMES_PER_TURN_AT_LEAST = 24
MOST_FRAMES = 20_000
FORMATS = (".mp4", ".gif", ".glb", ".gltf")


@dataclass
class Film:
    """A body in motion; lengths are parts of its largest radius."""

    object: str
    frame: str
    begin: str
    time_s: np.ndarray  # n, from the first
    q: np.ndarray  # n x 4, v_inertial = q v_named q*, scalar first, its sign continuous
    momentum: np.ndarray  # n x 3, direction in the inertial frame
    axes: np.ndarray  # 3 x 3, rows: the principal axes in the named ones
    vertices: np.ndarray  # k x 3, named axes
    facets: np.ndarray  # m x 3
    light: np.ndarray  # m: whether a facet has the lighter of two tones

    def reach(self, direction):
        """How far the body extends along a direction in named axes."""
        return float((self.vertices @ direction).max())


def film(what, mesh=None, turns=3, count=250):
    """`what` as polhode.plot.body takes it; `mesh`, in the body's named axes, as a Mesh or its file."""
    if not 2 <= count <= MOST_FRAMES:
        raise InputError(f"{count} frames, by the turns and seconds; a film has 2 to {MOST_FRAMES}")
    rows = plot.rows_of(what, turns, count)
    time_s, q, momentum = rows.time_s, rows.q, rows.momentum
    if len(q) != count or not np.allclose(np.diff(time_s), time_s[-1] / (count - 1)):  # of a file, with rows of its own
        history = read(what)
        time_s = np.linspace(0.0, history.segments[-1].usable[1] - history.epoch, count)  # seconds of TT
        states = history(time_s)
        q = states.q
        principal = np.repeat(rows.principal * [1, -1, -1, -1], count, 0)
        momentum = rows.moments * plot.rotated(principal, states.omega)
        momentum /= np.linalg.norm(momentum, axis=1, keepdims=True)
    q = q * np.cumprod(np.append(1.0, np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)))[:, None]
    axes = np.concatenate([plot.rotated(rows.principal, one[None]) for one in np.eye(3)])
    vertices, facets, light = ellipsoid(rows.moments) if mesh is None else of_mesh(mesh, axes)
    vertices = vertices @ axes if mesh is None else vertices
    return Film(
        object=rows.object, frame=rows.frame, begin=rows.begin, time_s=time_s, q=q, axes=axes,
        momentum=plot.rotated(q, momentum @ axes),
        vertices=vertices / np.linalg.norm(vertices, axis=1).max(), facets=facets, light=light,
    )  # fmt: skip


def ellipsoid(moments):
    """That of a homogeneous body with these moments, in its principal axes; tones by octants, so that it is seen to turn."""
    square = moments.sum() / 2 - moments
    semi_axes = np.sqrt(np.maximum(square, (LEAST_SEMI_AXIS**2) * square.max()))
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    facets = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    triangles = corners[facets]
    for _ in range(4):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
        triangles /= np.linalg.norm(triangles, axis=2, keepdims=True)
    light = np.prod(triangles.mean(axis=1), axis=1) > 0
    vertices, places = np.unique(triangles.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return vertices * semi_axes, places.reshape(-1, 3), light


def of_mesh(mesh, axes):
    """About its centre of mass; tones by the octants of the principal axes."""
    if not isinstance(mesh, Mesh):
        mesh = read_mesh(mesh)
    facets = np.asarray(mesh.facets, dtype=np.int64)
    vertices = mesh.vertices - mesh.mass_properties().centre_of_mass
    return vertices, facets, np.prod(vertices[facets].mean(axis=1) @ axes.T, axis=1) > 0


def frames_for(turns, seconds):
    """As many as a film has, or as the body's turns need not to look as if it went backwards."""
    return int(max(2, round(FPS * seconds), round(FRAMES_PER_TURN_AT_LEAST * turns)))


# --- Films ------------------------------------------------------------------------------------------------------------


class Picture:
    """The figure of one frame, seen from beside the momentum, which points up."""

    def __init__(self, film, style, inches=6.4):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import LineCollection, PolyCollection
        from matplotlib.colors import to_rgb

        self.film, self.style = film, style
        up = film.momentum.mean(axis=0)
        up /= np.linalg.norm(up)
        side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
        side /= np.linalg.norm(side)
        self.w = np.cos(0.4) * side + np.sin(0.4) * up  # towards the viewer
        self.u = np.cross(up, self.w)
        self.u /= np.linalg.norm(self.u)
        self.v = np.cross(self.w, self.u)
        lamp = self.w + 0.9 * self.v - 0.7 * self.u
        self.lamp = lamp / np.linalg.norm(lamp)
        self.tones = np.where(film.light[:, None], to_rgb(style.sphere), 0.62 * np.array(to_rgb(style.sphere)))
        self.colours = [style.blue, style.green, style.red]
        self.figure = Shown(figsize=(inches, inches), facecolor=style.paper)
        FigureCanvasAgg(self.figure)
        self.ax = ax = self.figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(-1.95, 1.95), ylim=(-1.95, 1.95), aspect="equal")
        ax.axis("off")
        self.trail = LineCollection([], linewidths=1.0, colors=style.faint, zorder=1)
        self.body = PolyCollection([], linewidths=0.3, zorder=3)
        for collection in (self.trail, self.body):
            ax.add_collection(collection)
        self.lines = [ax.plot([], [], lw=2.2, color=c, solid_capstyle="round")[0] for c in np.repeat(self.colours, 2)]
        self.names = [
            ax.text(0, 0, f"$I_{k + 1}$", color=c, ha="center", va="center", fontsize=12, path_effects=style.halo, zorder=6)
            for k, c in enumerate(self.colours)
        ]
        self.momentum = ax.annotate("", (0, 1), (0, 0), arrowprops=dict(arrowstyle="-|>", color=style.ink, lw=2))
        self.momentum_name = ax.text(0, 0, "$L$", color=style.ink, ha="center", va="center", fontsize=13)
        ax.text(-1.85, 1.8, film.object, fontsize=14, weight="bold", color=style.ink, va="center", parse_math=False)
        self.date = ax.text(-1.85, 1.63, "", fontsize=9.5, color=style.pencil, va="center", parse_math=False)
        self.tips = plot.rotated(film.q, np.repeat(film.axes[:1], len(film.q), 0)) * AXIS_LENGTH

    def flat(self, points):
        return np.stack([points @ self.u, points @ self.v], axis=-1)

    def show(self, i):
        film = self.film
        q = film.q[i : i + 1]
        turn = np.stack([plot.rotated(q, one[None])[0] for one in np.eye(3)])  # rows: named axes in the frame
        corners = film.vertices @ turn
        triangles = corners[film.facets]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(length > 0, length, 1)
        seen = normals @ self.w > 0
        far_to_near = np.flatnonzero(seen)[np.argsort((triangles[seen].mean(axis=1)) @ self.w)]
        light = np.clip(0.6 + 0.45 * (normals[far_to_near] @ self.lamp), 0, 1.15)[:, None]
        colours = np.clip(self.tones[far_to_near] * light, 0, 1)
        self.body.set_verts(self.flat(triangles[far_to_near]))
        self.body.set_facecolor(colours)
        self.body.set_edgecolor(colours)
        for k, axis in enumerate(film.axes @ turn):
            for sign, line in zip((1, -1), self.lines[2 * k : 2 * k + 2]):
                ends = sign * axis * np.array([[film.reach(sign * film.axes[k])], [AXIS_LENGTH]])
                line.set_data(*self.flat(ends).T)
                line.set_zorder(4 if sign * axis @ self.w > 0 else 2)
            self.names[k].set_position(self.flat(axis * (AXIS_LENGTH + 0.12)))
        direction = film.momentum[i]
        along = film.reach(turn @ direction)
        self.momentum.set_position(self.flat(direction * along))
        self.momentum.xy = self.flat(direction * MOMENTUM_LENGTH)
        self.momentum_name.set_position(self.flat(direction * (MOMENTUM_LENGTH + 0.12)))
        path = self.flat(self.tips[max(0, i - len(film.q) // 4) : i + 1])
        self.trail.set_segments([path] if len(path) > 1 else [])
        self.date.set_text(f"{film.begin} {film.frame} + {length_of_time(film.time_s[i], film.time_s[-1])}")


def length_of_time(seconds, longest):
    for unit, length in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if longest >= 2 * length:
            return f"{seconds / length:.2f} {unit}"
    return f"{seconds:.2f} s"


def movie(what, path, *, mesh=None, turns=3, seconds=10.0, style="light"):
    """Writes a film of so many seconds, MP4 or GIF by its ending, and returns its path: MP4 needs ffmpeg, without it the
    film becomes a GIF of the same name. `what` is a FITS ephemeris (drawn whole), a file of a body or scene, a Body or a
    Scene, of which so many turns are drawn; mesh: a Mesh in the body's named axes, or its file, else the ellipsoid of the
    body's inertia; style: "light" or "dark". Raises InputError, FileError."""
    from matplotlib import animation

    path = Path(path)
    ending = ending_of(path, FORMATS[:2])
    if ending == ".mp4" and not animation.writers.is_available("ffmpeg"):
        path, ending = path.with_suffix(".gif"), ".gif"
    of_gif = ending == ".gif"
    count = frames_for(turns, seconds)
    picture = Picture(film(what, mesh, turns, count), style_named(style))
    fps = count / seconds
    writer = animation.PillowWriter(fps=fps) if of_gif else animation.FFMpegWriter(fps=fps, codec="h264")
    with tempfile.TemporaryDirectory(prefix="polhode-") as work:
        made = os.path.join(work, "film" + ending)
        with writer.saving(picture.figure, made, 100):
            for i in range(count):
                picture.show(i)
                writer.grab_frame()
        with _files.whole_file(path) as out, open(made, "rb") as content:
            shutil.copyfileobj(content, out)
    return path


def still(what, *, at=0.0, mesh=None, turns=3, style="light"):
    """The figure of one frame: at 0 the first, at 1 the last."""
    whole = film(what, mesh, turns, 250)
    picture = Picture(whole, style_named(style))
    picture.show(round(at * (len(whole.q) - 1)))
    return picture.figure


# --- glTF -------------------------------------------------------------------------------------------------------------


def arrow(length, radius=0.018, sides=12):
    """Along z, from 0 to `length`: vertices and facets of a rod with a tip."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    neck = length - 6 * radius
    rings = [ring * radius, ring * radius + [0, 0, neck], ring * 2.6 * radius + [0, 0, neck]]
    vertices = np.concatenate([*rings, [[0, 0, length], [0, 0, 0]]])
    tip, foot = 3 * sides, 3 * sides + 1
    facets = []
    for i in range(sides):
        j = (i + 1) % sides
        facets += [[i, j, sides + j], [i, sides + j, sides + i], [foot, j, i]]
        facets += [[sides + i, sides + j, 2 * sides + j], [sides + i, 2 * sides + j, 2 * sides + i]]
        facets.append([2 * sides + i, 2 * sides + j, tip])
    return vertices, np.array(facets)


def turn_of_z(direction):
    """The shortest rotation of z to a direction, as a quaternion, scalar first."""
    q = np.append(1 + direction[2], np.cross([0, 0, 1], direction))
    return q / np.linalg.norm(q) if direction[2] > -1 + 1e-12 else np.array([0.0, 1.0, 0.0, 0.0])


class Scribe:
    """Puts arrays into the buffer of a glTF file."""

    def __init__(self):
        import pygltflib as kinds

        self.kinds = kinds
        self.file = kinds.GLTF2(asset=kinds.Asset(version="2.0", generator=f"polhode {version}"))
        self.bytes = bytearray()

    def array(self, values, kind, *, target=None):
        """The number of its accessor; of float32, or of uint32 if they are integers."""
        integer = np.issubdtype(values.dtype, np.integer)
        values = np.ascontiguousarray(values, dtype=np.uint32 if integer else np.float32)
        view = self.kinds.BufferView(buffer=0, byteOffset=len(self.bytes), byteLength=values.nbytes, target=target)
        self.bytes += values.tobytes()
        rows = values.reshape(len(values), -1)
        self.file.bufferViews.append(view)
        self.file.accessors.append(
            self.kinds.Accessor(
                bufferView=len(self.file.bufferViews) - 1, componentType=5125 if integer else 5126, count=len(values),
                type=kind, min=rows.min(axis=0).tolist(), max=rows.max(axis=0).tolist(),
            )
        )  # fmt: skip
        return len(self.file.accessors) - 1

    def material(self, name, colour):
        from matplotlib.colors import to_rgb

        linear = np.array(to_rgb(colour)) ** 2.2
        look = self.kinds.PbrMetallicRoughness(baseColorFactor=[*linear, 1.0], metallicFactor=0.0, roughnessFactor=0.8)
        self.file.materials.append(self.kinds.Material(name=name, pbrMetallicRoughness=look))
        return len(self.file.materials) - 1

    def mesh(self, name, parts):
        """Of parts (vertices, facets, material): every facet has its own corners, so that viewers shade it flat."""
        primitives = []
        for vertices, facets, material in parts:
            if len(facets) == 0:
                continue
            corners = vertices[facets].reshape(-1, 3)
            normals = np.cross(*(vertices[facets[:, k]] - vertices[facets[:, 0]] for k in (1, 2)))
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.where(length > 0, normals / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])
            attributes = self.kinds.Attributes(
                POSITION=self.array(corners, "VEC3", target=34962), NORMAL=self.array(np.repeat(normals, 3, 0), "VEC3", target=34962)
            )
            indices = self.array(np.arange(len(corners)), "SCALAR", target=34963)
            primitives.append(self.kinds.Primitive(attributes=attributes, indices=indices, material=material))
        self.file.meshes.append(self.kinds.Mesh(name=name, primitives=primitives))
        return len(self.file.meshes) - 1

    def node(self, name, *, mesh=None, q=None, children=()):
        """q, scalar first, maps components from the node to its parent."""
        rotation = None if q is None else [float(x) for x in np.roll(q, -1)]
        self.file.nodes.append(self.kinds.Node(name=name, mesh=mesh, rotation=rotation, children=list(children)))
        return len(self.file.nodes) - 1


def gltf(what, path, *, mesh=None, turns=3, seconds=10.0):
    """Writes the same as a glTF file, .glb (one binary file) or .gltf (text), whose animation turns the node "body" for so
    many seconds; its nodes are the body with its principal axes, and the momentum. The frame's z axis is up. Returns its
    path. Raises InputError, FileError."""
    path = Path(path)
    ending = ending_of(path, FORMATS[2:])
    count = 2 * frames_for(turns, seconds)  # viewers turn at a steady rate from one to the next
    whole = film(what, mesh, turns, count)
    style = style_named("light")
    scribe = Scribe()
    kinds, file = scribe.kinds, scribe.file
    two_tones = [scribe.material(f"body {n}", np.array(style.sphere) * n) for n in (1.0, 0.62)]
    parts = [(whole.vertices, whole.facets[whole.light == tone], two_tones[0 if tone else 1]) for tone in (True, False)]
    colours = [style.blue, style.green, style.red]
    axes = []
    for k, axis in enumerate(whole.axes):
        rod = scribe.mesh(f"axis {k + 1}", [(*arrow(AXIS_LENGTH), scribe.material(f"axis {k + 1}", colours[k]))])
        axes.append(scribe.node(f"principal axis {k + 1}", mesh=rod, q=turn_of_z(axis)))
    body = scribe.node("body", mesh=scribe.mesh("body", parts), q=whole.q[0], children=axes)
    momentum_q = np.array([turn_of_z(one) for one in whole.momentum])
    rod = scribe.mesh("momentum", [(*arrow(MOMENTUM_LENGTH), scribe.material("momentum", style.ink))])
    momentum = scribe.node("angular momentum", mesh=rod, q=momentum_q[0])
    half = np.sqrt(0.5)
    root = scribe.node(f"frame {whole.frame}", q=[half, -half, 0.0, 0.0], children=[body, momentum])
    times = scribe.array(np.linspace(0.0, seconds, count), "SCALAR")
    moving = kinds.Animation(name=f"{whole.object} from {whole.begin}", samplers=[], channels=[])
    for node, q in ((body, whole.q), (momentum, momentum_q)):
        q = np.roll(q, -1, axis=1) / np.linalg.norm(q, axis=1, keepdims=True)
        moving.samplers.append(kinds.AnimationSampler(input=times, output=scribe.array(q, "VEC4"), interpolation="LINEAR"))
        target = kinds.AnimationChannelTarget(node=node, path="rotation")
        moving.channels.append(kinds.AnimationChannel(sampler=len(moving.samplers) - 1, target=target))
    file.animations.append(moving)
    file.scenes.append(kinds.Scene(name=whole.object, nodes=[root]))
    file.scene = 0
    file.extras = {"frame": whole.frame, "begin": whole.begin, "length_s": float(whole.time_s[-1])}
    file.buffers.append(kinds.Buffer(byteLength=len(scribe.bytes)))
    file.set_binary_blob(bytes(scribe.bytes))
    with _files.whole_file(path) as out:
        if ending == ".glb":
            out.write(b"".join(file.save_to_bytes()))
        else:
            file.convert_buffers(kinds.BufferFormat.DATAURI)
            out.write(file.gltf_to_json().encode())
    return path


def ending_of(path, allowed):
    ending = path.suffix.lower()
    if ending not in allowed:
        raise InputError(f"{path} does not end in {', '.join(allowed[:-1])} or {allowed[-1]}")
    return ending


def main(arguments):
    parser = _files.Parser(prog="polhode animate", description="A film of a tumbling body, or a glTF file that turns")
    parser.add_argument("file", help="FITS ephemeris, body file or scene")
    parser.add_argument("-o", "--output", help=f"one of {', '.join(FORMATS)}; MP4 needs ffmpeg (default: a GIF beside FILE)")
    parser.add_argument("--mesh", help="mesh of the body, in the axes of its file (default: the ellipsoid of its inertia)")
    parser.add_argument("--turns", type=_files.positive, default=3.0, help="of a body, how many turns (default: 3); an ephemeris is shown whole")
    parser.add_argument("--seconds", type=_files.positive, default=10.0, help="length of the film (default: 10)")
    parser.add_argument("--style", choices=("light", "dark"), default="light", help="of a film (default: light)")
    options = parser.parse_args(arguments)
    out = Path(options.output or Path(options.file.removesuffix(".gz")).with_suffix(".gif"))
    if ending_of(out, FORMATS) in FORMATS[2:]:
        made = gltf(options.file, out, mesh=options.mesh, turns=options.turns, seconds=options.seconds)
    else:
        made = movie(options.file, out, mesh=options.mesh, turns=options.turns, seconds=options.seconds, style=options.style)
    if made != out:
        print(f"there is no ffmpeg for {out.name}: it is {made}")
    else:
        print(made)
