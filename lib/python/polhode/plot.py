"""Pictures of a tumbling body: its polhode on the momentum sphere with the planes of the separatrix, the same on its energy
ellipsoid, and the path of its long axis on the sky. And the figures of `polhode chart` (charts.py).

`polhode plot` is main(); body() gives the figure. They need matplotlib, and astropy for FITS.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection

from . import _files
from ._core import Body, Scene, read
from ._errors import FileError, InputError
from ._style import Shown, style_named

BLUE, RED, GREEN = "blue", "red", "green"  # the cases of a motion, as colours of a Style
FARTHEST = 1.9  # of an energy ellipsoid that is drawn, in radii of the sphere: a needle's reaches out to hundreds


@dataclass
class Rows:
    """Of an ephemeris, with the body's principal axes."""

    object: str
    method: str
    frame: str
    begin: str
    end: str
    moments: np.ndarray  # I1 <= I2 <= I3
    time_s: np.ndarray
    momentum: np.ndarray  # n x 3, principal axes, of length 1
    long_axis: np.ndarray  # n x 3, direction of principal axis 1 in the inertial frame
    momentum_direction: np.ndarray  # of the first row, in the inertial frame
    q: np.ndarray  # n x 4, v_inertial = q v_named q*, scalar first
    principal: np.ndarray  # 1 x 4, v_named = q v_principal q*


def rotated(q, v):
    """q v q*, q scalar first (n x 4), v (n x 3)."""
    t = 2 * np.cross(q[:, 1:], v)
    return v + q[:, :1] * t + np.cross(q[:, 1:], t)


def rows_of_file(path):
    """Of a FITS file that `polhode propagate` wrote of a body."""
    ephemeris = _files.read_ephemeris(path)
    if len(ephemeris.q) < 2:
        raise InputError(f"{path} has one row; a picture needs two or more")
    moments = np.array([ephemeris.number(f"INERTIA{k}") for k in (1, 2, 3)])
    if not 0 < moments[0] <= moments[1] <= moments[2]:
        raise InputError(f"{path}: INERTIA1 to 3 are {moments}; they must be positive and ascend")
    time = ephemeris.time
    length_s = (time[-1] - time[0]).to_value("s")
    return rows_from(
        path, ephemeris.q, ephemeris.omega_body, moments, np.array([[ephemeris.number(f"QPRINC{k}") for k in range(4)]]),
        object=ephemeris.text("OBJECT"), method=ephemeris.text("METHOD"), frame=ephemeris.text("REFFRAMA"),
        begin=time[0].isot[: characters(length_s)].replace("T", " "),
        end=f"{time[-1].isot[: characters(length_s)].replace('T', ' ')} {ephemeris.text('TIMESYS')}",
        time_s=(time - time[0]).to_value("s"),
    )  # fmt: skip


def rows_of_motion(motion, inertia, name, turns=20, count=6000):
    """Of a motion over so many turns, or as long as a scene lasts."""
    start = motion.epoch
    state = motion(0.0)
    rate = np.linalg.norm(state.omega)
    if rate == 0:
        raise InputError(f"{name}: the body is at rest, there is nothing to draw")
    last_s = turns * 2 * np.pi / rate
    first_s = 0.0
    if motion.span:
        first_s = motion.span[0] if last_s > motion.span[1] else 0.0
        last_s = min(last_s, motion.span[1])
    t = np.linspace(first_s, last_s, count)
    states = motion(t)
    decimals = 0 if last_s - first_s > 10 else 3
    axes = inertia.named_from_principal
    scalar_first = quaternion_of(axes)
    return rows_from(
        name, states.q, states.omega, inertia.principal_moments, scalar_first,
        object=name, method=motion.account(first_s, last_s).method, frame=motion.frame,
        begin=(start + first_s).text("TDB", decimals).replace("T", " "),
        end=f"{(start + last_s).text('TDB', decimals).replace('T', ' ')} TDB",
        time_s=t - t[0],
    )  # fmt: skip


def quaternion_of(matrix):
    """1 x 4, scalar first, of a rotation matrix."""
    K = np.array([
        [np.trace(matrix), 0, 0, 0],
        [matrix[2, 1] - matrix[1, 2], matrix[0, 0] - matrix[1, 1] - matrix[2, 2], 0, 0],
        [matrix[0, 2] - matrix[2, 0], matrix[0, 1] + matrix[1, 0], matrix[1, 1] - matrix[0, 0] - matrix[2, 2], 0],
        [matrix[1, 0] - matrix[0, 1], matrix[0, 2] + matrix[2, 0], matrix[1, 2] + matrix[2, 1], matrix[2, 2] - matrix[0, 0] - matrix[1, 1]],
    ])  # fmt: skip
    return np.linalg.eigh(K)[1][:, -1][None]


def characters(length_s):
    return 19 if length_s > 10 else 23  # of a date: to seconds, or milliseconds


def rows_from(path, q, omega, moments, principal, **described):
    to_principal = principal * [1, -1, -1, -1]
    count = len(q)
    momentum = moments * rotated(np.repeat(to_principal, count, 0), omega)
    length = np.linalg.norm(momentum, axis=1, keepdims=True)
    if not np.all(length > 0):
        raise InputError(f"{path}: the body is at rest, there is nothing to draw")
    momentum = momentum / length
    axes = [rotated(principal, np.eye(3)[k : k + 1]) for k in range(3)]
    in_body = sum(momentum[:1, k : k + 1] * axes[k] for k in range(3))
    return Rows(
        moments=moments,
        momentum=momentum,
        long_axis=rotated(q, np.repeat(axes[0], count, 0)),
        momentum_direction=rotated(q[:1], in_body)[0],
        q=q,
        principal=principal,
        **described,
    )


def rows_of(what, turns=20, count=6000):
    """Of a FITS ephemeris, or of the motion of a body, a scene or a file of one."""
    if isinstance(what, (str, os.PathLike)):
        if not Path(str(what).partition("#")[0]).is_file() and not Path(what).is_file():
            raise FileError(f"there is no file {what}" if not Path(what).exists() else f"{what} is not a file")
        if Path(what).is_file() and _files.is_fits(what):
            return rows_of_file(what)
        what = read(what)
    if isinstance(what, Scene):
        return rows_of_motion(what.motion(), what.body.inertia, what.body.name, turns, count)
    if isinstance(what, Body):
        return rows_of_motion(what.motion(), what.inertia, what.name, turns, count)
    raise InputError("a body, a scene or a FITS ephemeris of one is wanted")


class View:
    """An orthographic look at the unit sphere from a direction, axis 3 upwards."""

    pixels = 900

    def __init__(self, towards, style, extent=1.5):
        self.style = style
        self.extent = extent
        self.w = towards / np.linalg.norm(towards)
        self.u = np.cross([0, 0, 1], self.w)
        self.u /= np.linalg.norm(self.u)
        self.v = np.cross(self.w, self.u)
        side = np.linspace(-self.extent, self.extent, self.pixels)
        self.x, self.y = np.meshgrid(side, side)

    def blank(self):
        """An image of the paper."""
        return np.ones((self.pixels, self.pixels, 3)) * matplotlib.colors.to_rgb(self.style.paper)

    def flat(self, points):
        return points @ self.u, points @ self.v

    def depth(self, points):
        return points @ self.w

    def hit(self, quadratic):
        """Nearest depth at which a ray through each pixel meets x^T diag(quadratic) x = 1, NaN where it does not, and the
        points."""
        base = self.x[..., None] * self.u + self.y[..., None] * self.v
        a = np.sum(quadratic * self.w**2)
        b = np.sum(quadratic * base * self.w, axis=-1)
        c = np.sum(quadratic * base**2, axis=-1) - 1
        square = b * b - a * c
        with np.errstate(invalid="ignore"):
            depth = (-b + np.sqrt(square)) / a
        return depth, base + depth[..., None] * self.w

    def shaded(self, normal, colour):
        """Colour of a surface under a lamp above the left shoulder."""
        lamp = self.w + 0.9 * self.v - 0.7 * self.u
        lamp /= np.linalg.norm(lamp)
        with np.errstate(invalid="ignore"):
            n = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        light = np.clip(0.66 + 0.36 * (n @ lamp), 0, 1)[..., None]
        return np.clip(np.asarray(colour) * light, 0, 1)


def mode(motion):
    """Case of the motion, and its colour in a Style: a rotation about a fixed axis, or the sign of 2 T I2 / G^2 - 1."""
    low, middle, high = motion.moments
    symmetric = is_equal(low, middle) or is_equal(middle, high)
    omega = motion.momentum / motion.moments
    drift = np.linalg.norm(np.cross(motion.momentum, omega), axis=1) / np.linalg.norm(omega, axis=1)
    if is_equal(low, high):
        return "rotation of a sphere", BLUE
    if drift.max() < 1e-9:
        along = int(np.argmax(np.abs(motion.momentum[0])))
        if not symmetric:
            return f"rotation about the {('long', 'intermediate', 'short')[along]} axis", (BLUE, GREEN, RED)[along]
        own = 2 if is_equal(low, middle) else 0
        return f"rotation {'about' if along == own else 'across'} the axis of symmetry", (RED if own == 2 else BLUE)
    excess = np.mean(np.sum(motion.momentum**2 / motion.moments, axis=1)) * middle - 1
    of = " of a symmetric body" if symmetric else ""
    if abs(excess) < 1e-14:
        return "separatrix" + of, GREEN
    return ("long-axis mode" + of, BLUE) if excess > 0 else ("short-axis mode" + of, RED)


def is_equal(a, b):
    return b <= a * (1 + 1e-12)


def separatrix_slope(moments):
    """m3/m1 on the separatrix planes, Delta_2 = 0; None where a symmetric top has none."""
    i1, i2, i3 = moments
    if is_equal(i1, i2) or is_equal(i2, i3):
        return None
    return np.sqrt((i2 - i1) * i3 / ((i3 - i2) * i1))


def blended(image, mask, colour, opacity):
    image[mask] = (1 - opacity) * image[mask] + opacity * (colour[mask] if np.ndim(colour) == 3 else np.asarray(colour))


def draw_axes_labels(ax, view, reach):
    for k in range(3):
        tip = np.eye(3)[k] * np.sign(view.w[k] if abs(view.w[k]) > 0.05 else 1)
        start, end = tip * reach[k], tip * (reach[k] + 0.28)
        ax.annotate(
            "", view_xy(view, end), view_xy(view, start), arrowprops=dict(arrowstyle="-|>", color=view.style.ink, lw=1.1), zorder=9
        )
        sign = "" if tip[k] > 0 else "\N{MINUS SIGN}"
        x, y = view_xy(view, tip * (reach[k] + 0.28))
        away = np.array([x, y]) / max(np.hypot(x, y), 1e-9) * 0.13
        label = f"${sign}m_{k + 1}$"
        ax.text(x + away[0], y + away[1], label, ha="center", va="center", fontsize=12.5, color=view.style.ink, path_effects=view.style.halo, zorder=9)


def view_xy(view, point):
    x, y = view.flat(point)
    return float(x), float(y)


def finish(ax, view, title):
    ax.set_title(title, fontsize=11.5, color=view.style.ink, pad=4)
    ax.set(xlim=(-view.extent, view.extent), ylim=(-view.extent, view.extent), aspect="equal")
    ax.axis("off")


def draw_curve(ax, view, points, hidden_by, **style):
    """A curve, broken where a depth map stands before it."""
    x, y = view.flat(points)
    column = np.clip(np.round((x + view.extent) / (2 * view.extent) * (view.pixels - 1)).astype(int), 0, view.pixels - 1)
    row = np.clip(np.round((y + view.extent) / (2 * view.extent) * (view.pixels - 1)).astype(int), 0, view.pixels - 1)
    with np.errstate(invalid="ignore"):
        hidden = view.depth(points) < hidden_by[row, column] - 0.03
    ax.plot(np.where(hidden, np.nan, x), np.where(hidden, np.nan, y), **style)


def draw_polhode(ax, view, momentum, hidden_by, colour):
    """The polhode, faint where it is behind, and a dot where it is no larger than one."""
    ax.plot(*view.flat(momentum), color=colour, lw=1, alpha=0.3)
    draw_curve(ax, view, momentum, hidden_by, color=colour, lw=2.6, solid_capstyle="round")
    if np.ptp(momentum, axis=0).max() < 0.03:
        ax.plot(*view_xy(view, momentum[0]), "o", ms=8, color=colour, mec=view.style.paper, mew=1, zorder=8)


def momentum_sphere(ax, view, motion):
    depth, point = view.hit(np.ones(3))
    on_sphere = np.isfinite(depth)
    image = view.blank()
    slope = separatrix_slope(motion.moments)
    green = 0.5 * np.array(matplotlib.colors.to_rgb(view.style.green)) + 0.5 * np.array(view.style.sphere)
    planes = []  # (depth, colour) of the two planes through axis 2, clipped to a disc
    if slope is not None:
        for sign in (1, -1):
            normal = np.array([-sign * slope, 0.0, 1.0])
            normal /= np.linalg.norm(normal)
            base = view.x[..., None] * view.u + view.y[..., None] * view.v
            at = -(base @ normal) / (view.w @ normal)
            where = base + at[..., None] * view.w
            inside = np.linalg.norm(where, axis=-1) < 1.22
            planes.append((np.where(inside, at, np.nan), green))
    # From back to front: planes behind the sphere, the sphere, planes before it.
    for at, colour in sorted(planes, key=lambda plane: -np.nanmean(plane[0])):
        blended(image, np.isfinite(at), colour, 0.42)
    sphere = view.shaded(point, view.style.sphere)
    image[on_sphere] = sphere[on_sphere]
    for at, colour in planes:
        with np.errstate(invalid="ignore"):
            blended(image, on_sphere & (at > depth), colour, 0.42)
    ax.imshow(image, origin="lower", extent=[-view.extent, view.extent] * 2, interpolation="bilinear")
    # Neighbouring polhodes: curves of equal energy over the visible half.
    energy = np.where(on_sphere, np.sum(point**2 / motion.moments, axis=-1), np.nan)
    low, middle, high = 1 / motion.moments[::-1]
    levels = np.concatenate([low + (middle - low) * np.array([0.1, 0.35, 0.7]), middle + (high - middle) * np.array([0.12, 0.38, 0.7])])
    levels = levels[np.diff(levels, prepend=low) > 1e-12 * high]  # none on the side where a symmetric body has none
    if len(levels):
        ax.contour(view.x, view.y, energy, levels=levels, colors=[view.style.faint], linewidths=0.7)
    colour = getattr(view.style, mode(motion)[1])
    own = np.mean(np.sum(motion.momentum**2 / motion.moments, axis=1))
    if low < own < high:  # the whole polhode, of which the rows may be a part
        ax.contour(view.x, view.y, energy, levels=[own], colors=[colour], linewidths=0.9)
    if slope is not None:
        angle = np.linspace(0, 2 * np.pi, 721)
        for sign in (1, -1):
            along = np.array([1.0, 0.0, sign * slope])
            along /= np.linalg.norm(along)
            circle = np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * np.array([0.0, 1.0, 0.0])
            draw_curve(ax, view, circle, depth, color=view.style.green, lw=1.6, ls=(0, (5, 2)))
    draw_polhode(ax, view, motion.momentum, depth, colour)
    draw_axes_labels(ax, view, [1.0, 1.0, 1.0])
    finish(ax, view, "Polhode on the momentum sphere" + ("" if slope is None else ", separatrix dashed"))


def energy_ellipsoid(ax, towards, motion, style):
    inverse = 1 / motion.moments
    twice_energy = np.mean(np.sum(motion.momentum**2 * inverse, axis=1))
    semi_axes = np.sqrt(twice_energy / inverse)
    view = View(towards, style, extent=np.clip(semi_axes.max() + 0.45, 1.5, FARTHEST + 0.5))
    sphere_depth, sphere_point = view.hit(np.ones(3))
    depth, point = view.hit(inverse / twice_energy)
    with np.errstate(invalid="ignore"):
        depth[np.linalg.norm(point, axis=-1) > FARTHEST] = np.nan
    case = mode(motion)[1]
    colour = getattr(style, case)
    image = view.blank()
    before = np.where(np.isfinite(depth), depth, -np.inf)
    sphere_before = np.where(np.isfinite(sphere_depth), sphere_depth, -np.inf)
    tint = (1 - style.tint) * np.array(matplotlib.colors.to_rgb(colour)) + style.tint
    ellipsoid = view.shaded(point * inverse, tint)
    sphere = view.shaded(sphere_point, view.style.sphere)
    np.copyto(image, ellipsoid, where=((before > sphere_before) & np.isfinite(depth))[..., None])
    np.copyto(image, sphere, where=((sphere_before >= before) & np.isfinite(sphere_depth))[..., None])
    ax.imshow(image, origin="lower", extent=[-view.extent, view.extent] * 2, interpolation="bilinear")
    front = np.fmax(sphere_depth, depth)
    draw_polhode(ax, view, motion.momentum, front, colour)
    mirrored = motion.momentum * np.where(np.arange(3) == (0 if case == BLUE else 2), -1, 1)
    draw_curve(ax, view, mirrored, front, color=colour, lw=1.2, ls=(0, (1, 1.5)))
    draw_axes_labels(ax, view, np.clip(semi_axes, 1.0, FARTHEST))
    cut = f" (cut off at {FARTHEST})" if semi_axes.max() > FARTHEST else ""
    finish(ax, view, f"The same where the energy ellipsoid{cut} cuts the sphere")


def sky(ax, motion, style):
    ecliptic = motion.frame.upper().startswith("ECLIP")
    along, across = ("ecliptic longitude", "latitude") if ecliptic else ("right ascension", "declination")
    centre = np.arctan2(motion.momentum_direction[1], motion.momentum_direction[0])
    centre = np.radians(np.round(np.degrees(centre) / 30) * 30)

    def flat(direction):
        lon = np.arctan2(direction[..., 1], direction[..., 0]) - centre
        return -((lon + np.pi) % (2 * np.pi) - np.pi), np.arcsin(np.clip(direction[..., 2], -1, 1))  # east to the left

    x, y = flat(motion.long_axis)
    segments = np.stack([np.stack([x[:-1], y[:-1]], -1), np.stack([x[1:], y[1:]], -1)], 1)
    whole = np.abs(np.diff(x)) < np.pi  # not across the edge of the map
    days = (motion.time_s - motion.time_s[0]) / 86400
    span, unit = (days, "days") if days[-1] >= 2 else (days * 24, "hours") if days[-1] * 24 >= 2 else (days * 86400, "s")
    shades = matplotlib.colormaps["cividis"].resampled(256)(np.linspace(style.map_ends[0], style.map_ends[1], 256))
    lines = LineCollection(
        segments[whole], cmap=matplotlib.colors.ListedColormap(shades), array=span[:-1][whole], linewidths=1.3
    )
    ax.add_collection(lines)
    ax.plot(x[0], y[0], "o", ms=12, mfc=style.paper, mec=style.ink, mew=1.5, label="first row", zorder=5, clip_on=False)
    ax.plot(x[-1], y[-1], "s", ms=8, mfc=style.ink, mec=style.paper, mew=1.2, label="last row", zorder=5, clip_on=False)
    lx, ly = flat(motion.momentum_direction)
    ax.plot(lx, ly, "*", ms=15, mfc=style.paper, mec=style.ink, mew=1.2, label="angular momentum", zorder=6, clip_on=False)
    ticks = np.arange(-150, 151, 30)
    ax.set_xticks(np.radians(ticks), [])
    for t in ticks:
        label = f"{np.round(np.degrees(centre) - t) % 360:.0f}°"
        ax.text(np.radians(t), 0.04, label, fontsize=8.5, color=style.pencil, ha="center", va="bottom", path_effects=style.halo, zorder=4)
    ax.tick_params(axis="y", labelsize=8.5, labelcolor=style.pencil)
    ax.set_facecolor(style.paper)
    ax.spines["geo"].set_color(style.ink)
    ax.grid(color=style.grid, lw=0.6)
    ax.set_title(f"Path of the long axis on the sky ({along} and {across}, {motion.frame})", fontsize=11.5, color=style.ink, pad=12, parse_math=False)
    ax.legend(loc="lower left", bbox_to_anchor=(-0.075, -0.09), frameon=False, fontsize=9.5, labelspacing=0.7, labelcolor=style.ink)
    bar = ax.figure.colorbar(lines, ax=ax, shrink=0.62, pad=0.04, aspect=22)
    bar.set_label(f"{unit} from the first row", fontsize=9.5, color=style.ink)
    bar.outline.set_visible(False)
    bar.ax.tick_params(colors=style.pencil)


def body(what, turns=20, style="light"):
    """The figure of a motion: `what` is a FITS ephemeris, a file of a body or scene, a Body or a Scene; of bodies so many
    turns are drawn, of scenes no more than they last. `style` is "light" or "dark". Raises InputError, FileError."""
    return draw(rows_of(what, turns), style_named(style))


def draw(motion, style):
    figure = Shown(figsize=(11.5, 11.2), dpi=150, facecolor=style.paper)
    grid = figure.add_gridspec(2, 2, height_ratios=[1.05, 1], hspace=0.1, wspace=0.02, left=0.06, right=0.97, top=0.885, bottom=0.04)
    # Looked at from the side where the momentum is, a little off the axis it goes about.
    middle = motion.momentum.mean(axis=0)
    name, case = mode(motion)
    side = np.sign(middle) + (middle == 0)
    towards = side * (np.array([1.0, 0.62, 0.5]) if case == BLUE else np.array([0.62, 0.62, 0.75]))
    view = View(towards, style)
    momentum_sphere(figure.add_subplot(grid[0, 0]), view, motion)
    energy_ellipsoid(figure.add_subplot(grid[0, 1]), towards, motion, style)
    sky(figure.add_subplot(grid[1, :], projection="mollweide"), motion, style)
    ratios = " : ".join(f"{m:.4g}" for m in motion.moments / motion.moments[-1])
    figure.text(0.06, 0.968, motion.object, fontsize=19, weight="bold", color=style.ink, va="center", parse_math=False)
    of_body, of_rows = f"{name}, moments {ratios}", f"{motion.begin} to {motion.end}, method {motion.method}"
    for height, line in ((0.94, of_body), (0.922, of_rows)):
        figure.text(0.06, height, line, fontsize=10.5, color=style.pencil, va="center", parse_math=False)
    return figure


FORMATS = (".png", ".pdf", ".svg")


def picture_format(path):
    """By the ending; what is no regular file, as /dev/stdout, gets PNG."""
    ending = path.suffix.lower()
    if ending in FORMATS:
        return ending[1:]
    if path.exists() and not path.is_file():
        return "png"
    raise InputError(f"{path}: a picture ends in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")


def main(arguments):
    parser = _files.Parser(prog="polhode plot", description="Draw a tumbling body, or a table of polhode chart")
    parser.add_argument("file", help="FITS ephemeris, body file or scene; table of polhode chart, or of polhode observe")
    parser.add_argument("-o", "--output", help="picture, .png, .pdf or .svg; of a table the folder (default: beside FILE)")
    parser.add_argument("--style", choices=("light", "dark"), default="light", help="of a body's picture (default: light)")
    parser.add_argument("--fold", help="of a light curve: fold it with this period, as '30.56 h'")
    options = parser.parse_args(arguments)
    from . import charts, lightcurve

    if lightcurve.is_light_curve(options.file):
        out = Path(options.output or Path(options.file).with_suffix(".png"))
        format = picture_format(out)
        figure = lightcurve.picture(options.file, options.fold)
        with _files.whole_file(out) as file:
            figure.savefig(file, format=format)
        return
    if options.fold:
        raise InputError(f"--fold is for light curves; {options.file} is no table of polhode observe with magnitudes")
    if charts.is_chart(options.file):
        charts.draw_file(Path(options.file), options.output)
        return
    figure = body(options.file, style=options.style)
    out = Path(options.output or Path(options.file.removesuffix(".gz")).with_suffix(".png"))
    format = picture_format(out)
    with _files.whole_file(out) as file:
        figure.savefig(file, format=format)
