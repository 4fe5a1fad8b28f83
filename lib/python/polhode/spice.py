"""SPICE kernels of an attitude ephemeris: CK of types 3 and 5, and a binary PCK, with the clock and the frames they need.

`polhode spice` is main(); kernels() writes them. It needs spiceypy, and astropy for FITS.
"""

import os
import re
import shutil
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import spiceypy

from . import _files
from ._core import Instant, Orbit, frame_rotation
from ._errors import FileError, InputError

# SPICE's TDB, from its leap-seconds kernels: ET = TT + K sin(M + EB sin M), M = M0 + M1 t.
DELTET_K, DELTET_EB, DELTET_M0, DELTET_M1 = 1.657e-3, 1.671e-2, 6.239996, 1.99096871e-7

OBLIQUITY_RAD = np.radians(84381.448 / 3600)  # of ECLIPJ2000: J2000 turned about x
SPICE_FRAMES = {"ICRF": "J2000", "GCRF": "J2000", "EME2000": "J2000", "ECLIPJ2000": "ECLIPJ2000"}
HERMITE_ROWS = 6  # of a window: degree 11
CHEBYSHEV_DEGREE = 15
LONGEST_NAME = 17  # FRAME_<name>_AXES_PCK is a variable, of 32 characters at most
LONGEST_PATH = 255


@dataclass
class Rows:
    object: str  # in ASCII, as SPICE wants it
    frame: str  # SPICE's name
    et: np.ndarray
    q: np.ndarray  # n x 4, scalar first, v_inertial = q v_body q*, continuous in sign
    omega_body: np.ndarray
    uniform: bool

    @property
    def omega_inertial(self):
        t = 2 * np.cross(self.q[:, 1:], self.omega_body)
        return np.ascontiguousarray(self.omega_body + self.q[:, :1] * t + np.cross(self.q[:, 1:], t))

    @property
    def resolution_rad(self):
        """What the body turns by from one double of ET to the next."""
        return float(np.linalg.norm(self.omega_body, axis=1).max() * np.spacing(np.abs(self.et).max()))

    @property
    def q_dot(self):
        """dq/dt = q (0, omega_body) / 2."""
        s, v, w = self.q[:, :1], self.q[:, 1:], self.omega_body
        return 0.5 * np.concatenate([-np.sum(v * w, axis=1, keepdims=True), s * w + np.cross(v, w)], axis=1)


def turned_by(a, q):
    """The product of a quaternion and those of an array (n, 4), scalar first."""
    s, v = a[0], np.asarray(a[1:])
    vectors = s * q[:, 1:] + q[:, :1] * v + np.cross(v, q[:, 1:])
    return np.concatenate([s * q[:, :1] - q[:, 1:] @ v[:, None], vectors], axis=1)


def read_rows(path):
    ephemeris = _files.read_ephemeris(path)
    frame = ephemeris.text("REFFRAMA")
    if frame not in SPICE_FRAMES:
        raise InputError(f"{path}: SPICE has no frame {frame}; write the FITS in the frame ICRF, EME2000 or ECLIPJ2000")
    if len(ephemeris.q) < 2:
        raise InputError(f"{path} has one row; kernels need two or more")
    # TT seconds from J2000 in two parts, so that nothing is lost on the way.
    tt = ephemeris.time.tt
    days = tt.jd1 - 2451545.0
    coarse = (days + tt.jd2) * 86400
    anomaly = DELTET_M0 + DELTET_M1 * coarse
    et = days * 86400 + (tt.jd2 * 86400 + DELTET_K * np.sin(anomaly + DELTET_EB * np.sin(anomaly)))
    step = np.diff(et)
    q = ephemeris.q
    if frame == "EME2000":  # what SPICE calls J2000 is ICRF, 0.02 arcsec away
        q = turned_by(frame_rotation(frame, "ICRF"), q)
    return Rows(
        object=re.sub(r"[^ -~]", "?", ephemeris.text("OBJECT")),
        frame=SPICE_FRAMES[frame],
        et=et,
        q=q,
        omega_body=ephemeris.omega_body,
        uniform=len(et) >= HERMITE_ROWS and bool(np.all(np.abs(step - step.mean()) < 1e-4)),
    )


def spice_quaternion(q):
    return np.ascontiguousarray(q * [1, -1, -1, -1])


def interpolated(rows, et):
    """Attitude between equally spaced rows by Hermite interpolation, degree 11, and unit length."""
    count = len(rows.et)
    # Position in rows; the rows' spacing in ET breathes by microseconds a month, which np.interp follows.
    position = np.interp(et, rows.et, np.arange(count))
    first = np.clip(np.floor(position).astype(int) - (HERMITE_ROWS // 2 - 1), 0, count - HERMITE_ROWS)
    x = (position - first)[:, None]
    nodes = np.arange(HERMITE_ROWS)
    step = (rows.et[-1] - rows.et[0]) / (count - 1)
    q_dot = rows.q_dot * step
    q = np.zeros((len(et), 4))
    for i in nodes:
        others = nodes[nodes != i]
        lagrange_squared = np.prod((x - others) / (i - others), axis=1, keepdims=True) ** 2
        slope = np.sum(1.0 / (i - others))
        q += lagrange_squared * ((1 - 2 * slope * (x - i)) * rows.q[first + i] + (x - i) * q_dot[first + i])
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def every_other(rows):
    return replace(rows, et=rows.et[::2], q=rows.q[::2], omega_body=rows.omega_body[::2])


def error_by_spacing(rows):
    """Error of the interpolation between the rows as they show it themselves: that between every other row, at the rows
    left out, falls by 2^12 when the spacing is halved. None where there are too few."""
    half = every_other(rows)
    if len(half.et) < HERMITE_ROWS:
        return None
    inside = slice(1, 2 * len(half.et) - 2, 2)
    at_twice = angle(interpolated(half, rows.et[inside]), rows.q[inside]).max()
    if at_twice > 0.1:
        raise InputError("the rows are too far apart to interpolate between them; give more rows")
    return at_twice / 2**12


def angle(p, q):
    scalar = np.sum(p * q, axis=1)
    vector = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
    return 2 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(scalar))


def euler_zxz(q):
    """The three angles, each continuous in time: components from the inertial frame to the body."""
    half_sum = np.unwrap(np.arctan2(q[:, 3], q[:, 0]))
    half_difference = np.unwrap(np.arctan2(q[:, 2], q[:, 1]))
    second = 2 * np.arctan2(np.hypot(q[:, 1], q[:, 2]), np.hypot(q[:, 0], q[:, 3]))
    return np.stack([half_sum + half_difference, second, half_sum - half_difference], axis=1)


def from_euler_zxz(angles):
    first, second, third = angles.T / 2
    cos, sin = np.cos, np.sin
    return np.stack(
        [
            cos(second) * cos(first + third),
            sin(second) * cos(first - third),
            sin(second) * sin(first - third),
            cos(second) * sin(first + third),
        ],
        axis=1,
    )


def in_frame(rows, frame):
    """The same attitudes referred to J2000 or ECLIPJ2000."""
    if frame == rows.frame:
        return rows
    half = (-OBLIQUITY_RAD if frame == "ECLIPJ2000" else OBLIQUITY_RAD) / 2
    return replace(rows, frame=frame, q=turned_by([np.cos(half), np.sin(half), 0.0, 0.0], rows.q))


def pole_distance(rows):
    """Least angle between the body's z axis and the line of the frame's poles, at the rows."""
    return np.arcsin(min(1.0, np.abs(np.sin(euler_zxz(rows.q)[:, 1])).min()))


def chebyshev_pieces(rows, tolerance):
    """The fewest equal pieces (within a fifth) whose polynomials of the angles stay within the tolerance, or where four
    a row do not, the best: coefficients (pieces x 3 x terms), length, and the error found at the rows and in three places
    between them."""
    begin, end = rows.et[0], rows.et[-1]
    terms = CHEBYSHEV_DEGREE + 1
    nodes = np.cos(np.pi * (np.arange(terms) + 0.5) / terms)[::-1]
    polynomials = np.polynomial.chebyshev.chebvander(nodes, CHEBYSHEV_DEGREE)
    weights = 2.0 / terms * polynomials.T
    weights[0] /= 2
    check_et = np.interp(np.arange(4 * len(rows.et) - 3) / 4, np.arange(len(rows.et)), rows.et)
    truth = interpolated(rows, check_et)
    pieces = max(1, int(len(rows.et) / 60))
    best = None
    while pieces < 4 * len(rows.et):
        length = (end - begin) / pieces
        centres = begin + length * (np.arange(pieces) + 0.5)
        et = (centres[:, None] + nodes * length / 2).ravel()
        angles = euler_zxz(interpolated(rows, et)).reshape(pieces, terms, 3)
        coefficients = np.einsum("kn,pnj->pjk", weights, angles)
        piece = np.clip(((check_et - begin) / length).astype(int), 0, pieces - 1)
        x = (check_et - centres[piece]) / (length / 2)
        found = np.einsum("tk,tjk->tj", np.polynomial.chebyshev.chebvander(x, CHEBYSHEV_DEGREE), coefficients[piece])
        error = angle(from_euler_zxz(found), truth).max()
        if best is None or error < best[2]:
            best = coefficients, length, error
        if error <= tolerance:
            break
        pieces = int(pieces * 1.2) + 1
    return best


def errors_between(rows, ck_path, ck_id):
    """Largest errors of the two CK types as their readers interpolate: type 3 in the middle of each gap; type 5 by the
    toolkit, in the gaps at the ends, where its windows are cut short, and in a thousand others."""
    middle = (rows.et[1:] + rows.et[:-1]) / 2
    truth = interpolated(rows, middle)
    chord = rows.q[1:] + rows.q[:-1]
    type_3 = angle(chord / np.linalg.norm(chord, axis=1, keepdims=True), truth).max()
    gaps = np.arange(len(middle))
    gaps = np.union1d(np.concatenate([gaps[:HERMITE_ROWS], gaps[-HERMITE_ROWS:]]), np.linspace(0, gaps[-1], 1000).astype(int))
    spiceypy.furnsh(ck_path)
    type_5 = 0.0
    for place in (0.3, 0.5, 0.7):
        et = rows.et[gaps] + place * (rows.et[gaps + 1] - rows.et[gaps])
        matrices = [spiceypy.ckgp(ck_id, spiceypy.sce2c(ck_id, t), 0, rows.frame)[0] for t in et]
        found = spice_quaternion(np.array([spiceypy.m2q(matrix) for matrix in matrices]))
        type_5 = max(type_5, angle(found, interpolated(rows, et)).max())
    spiceypy.unload(ck_path)
    return type_3, type_5


def add_comments(path, lines):
    handle = spiceypy.dafopw(str(path))
    spiceypy.dafac(handle, lines)
    spiceypy.dafcls(handle)


def write_text(path, kind, text, data):
    Path(path).write_text(f"{kind}\n\n{text}\n\n\\begindata\n\n{data}\n\\begintext\n", encoding="utf-8")


def write_clock(path, rows, clock):
    zero = np.floor(rows.et[0]) - 86400  # the clock starts a day early
    write_text(
        path, "KPL/SCLK", f"The clock of the attitude of {rows.object}: microseconds of ET (TDB) from {zero:.0f} s.",
        f"""SCLK_KERNEL_ID = ( @2000-JAN-01 )
SCLK_DATA_TYPE_{clock} = ( 1 )
SCLK01_TIME_SYSTEM_{clock} = ( 1 )
SCLK01_N_FIELDS_{clock} = ( 2 )
SCLK01_MODULI_{clock} = ( 10000000000 1000000 )
SCLK01_OFFSETS_{clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{clock} = ( 1 )
SCLK_PARTITION_START_{clock} = ( 0.0000000000000E+00 )
SCLK_PARTITION_END_{clock} = ( 1.0000000000000E+16 )
SCLK01_COEFFICIENTS_{clock} = ( 0.0 {zero:.1f} 1.0 )
""",
    )  # fmt: skip


def write_frames(path, rows, name, body_id):
    ck_id, pck_frame_id = -abs(body_id), 1400000 + abs(body_id) % 500000
    frame, pck_frame = f"{name}_AXES", f"{name}_AXES_PCK"
    write_text(
        path, "KPL/FK", f"Frames of the attitude of {rows.object}: the axes that its body file names.",
        f"""NAIF_BODY_NAME += ( '{name}' )
NAIF_BODY_CODE += ( {body_id} )
FRAME_{frame} = {ck_id}
FRAME_{ck_id}_NAME = '{frame}'
FRAME_{ck_id}_CLASS = 3
FRAME_{ck_id}_CLASS_ID = {ck_id}
FRAME_{ck_id}_CENTER = {body_id}
CK_{ck_id}_SCLK = {ck_id}
CK_{ck_id}_SPK = {body_id}
OBJECT_{body_id}_FRAME = '{frame}'
FRAME_{pck_frame} = {pck_frame_id}
FRAME_{pck_frame_id}_NAME = '{pck_frame}'
FRAME_{pck_frame_id}_CLASS = 2
FRAME_{pck_frame_id}_CLASS_ID = {abs(body_id)}
FRAME_{pck_frame_id}_CENTER = {body_id}
""",
    )  # fmt: skip


def write_cks(type_3, type_5, clock, rows, ck_id, segment, spacing_error):
    """Writes both; what there is to say of their errors."""
    spiceypy.furnsh(clock)
    ticks = np.array([spiceypy.sce2c(ck_id, t) for t in rows.et])
    handle = spiceypy.ckopn(type_3, segment, 0)
    quaternions = spice_quaternion(rows.q)
    spiceypy.ckw03(
        handle, ticks[0], ticks[-1], ck_id, rows.frame, True, segment, len(ticks), ticks, quaternions, rows.omega_inertial, 1, ticks[:1]
    )
    spiceypy.ckcls(handle)
    handle = spiceypy.ckopn(type_5, segment, 0)
    packets = np.ascontiguousarray(np.concatenate([quaternions, spice_quaternion(rows.q_dot)], axis=1))
    hermite_with_derivatives, degree = 0, 2 * HERMITE_ROWS - 1
    seconds_per_tick = 1e-6
    spiceypy.ckw05(
        handle, hermite_with_derivatives, degree, ticks[0], ticks[-1], ck_id, rows.frame, True, segment, ticks, packets,
        seconds_per_tick, 1, ticks[:1],
    )  # fmt: skip
    spiceypy.ckcls(handle)
    if spacing_error is None:
        return ""
    errors = [max(error, spacing_error, rows.resolution_rad / 2) for error in errors_between(rows, type_5, ck_id)]
    for path, error in zip((type_3, type_5), errors):
        what = f"Attitude of {rows.object} in {rows.frame}, by polhode."
        add_comments(path, [what, f"Largest error found between the rows: {error:.3e} rad."])
    return f", error found {errors[0]:.2g} and {errors[1]:.2g} rad"


def write_pck(path, rows, body_id, segment, spacing_error, tolerance):
    """Whether it was written, and what there is to say of it. The tolerance, if it is None, is 1e-9 rad, or for a fast
    body what ET in doubles can tell."""
    if tolerance is None:
        tolerance = max(1e-9, 4 * rows.resolution_rad)
    if spacing_error is None:
        return False, f"no binary PCK: its rows must be equally spaced, {2 * HERMITE_ROWS - 1} or more"
    if spacing_error >= tolerance:
        return False, (f"no binary PCK: the rows are too far apart for {tolerance:.2g} rad, {spacing_error:.2g} rad would "
                       "do; give more rows or a larger `tolerance`")  # fmt: skip
    # The angles are singular where the z axis points to a pole of their frame.
    others = [in_frame(rows, frame) for frame in SPICE_FRAMES.values() if frame != rows.frame]
    if pole_distance(rows) < 0.1:
        rows = max([rows, *others], key=pole_distance)
    distance = pole_distance(rows)
    of_pole = f"the body's z axis comes within {distance:.2g} rad of the line of the poles of {rows.frame}"
    if distance < 1e-2:
        return False, f"no binary PCK: {of_pole}, where its angles are singular; the CK holds everywhere"
    other_errors = spacing_error + rows.resolution_rad  # SPICE rounds ET on its way
    coefficients, length, error = chebyshev_pieces(rows, tolerance - other_errors)
    if error > tolerance - other_errors:
        return False, (f"no binary PCK: its polynomials reach {error + other_errors:.2g} rad, not {tolerance:.2g} rad "
                       f"({of_pole}, and turns by {rows.resolution_rad:.2g} rad from one double of ET to the next); "
                       "give a larger `tolerance`, or use the CK")  # fmt: skip
    handle = spiceypy.pckopn(path, segment, 1000)
    spiceypy.dafac(handle, [f"Attitude of {rows.object} in {rows.frame}, angles ZXZ, by polhode.",
                            f"Promised error everywhere: {tolerance:.3e} rad."])  # fmt: skip
    spiceypy.pckw02(
        handle, abs(body_id), rows.frame, rows.et[0], rows.et[-1], segment, length, len(coefficients), CHEBYSHEV_DEGREE,
        np.ascontiguousarray(coefficients).ravel(), rows.et[0],
    )  # fmt: skip
    spiceypy.pckcls(handle)
    return True, f"{len(coefficients)} pieces of {length:.6g} s, error found {error:.2g} rad of {tolerance:.2g} rad promised"


def write_meta(path, rows, folder, names):
    """SPICE looks for a relative path from where its user is: the folder is given whole, in strings of at most 80
    characters, joined by '+'."""
    text = str(folder.resolve())
    if text.endswith("+"):
        text += "/."
    if len(os.fsencode(text)) > LONGEST_PATH - max(map(len, names)) - 1:
        raise InputError(f"{text} is too long a path: SPICE takes {LONGEST_PATH} characters, the kernel's name included")
    text = text.replace("'", "''")
    parts = re.findall(r"(?:''|[^']){1,35}", text)  # no quote is torn from its twin
    lines = "\n".join(f"    '{part}{'+' if i + 1 < len(parts) else ''}'" for i, part in enumerate(parts))
    kernels = "\n".join(f"    '$KERNELS/{name}'" for name in names)
    write_text(
        path, "KPL/MK", f"Attitude of {rows.object}. PATH_VALUES is the folder of the kernels: change it if they are moved.",
        f"PATH_SYMBOLS = ( 'KERNELS' )\nPATH_VALUES = (\n{lines}\n)\nKERNELS_TO_LOAD = (\n{kernels}\n)\n",
    )  # fmt: skip


def write_kernels(rows, work, folder, name, body_id, tolerance):
    """Into the folder `work`; `folder` is where they will be. Their names, and what there is to say of them."""
    ck_id, segment = -abs(body_id), f"{rows.object} by polhode"[:40]
    names = {ending: f"{name.lower()}{ending}" for ending in ("_ck3.bc", "_ck5.bc", ".bpc", ".tsc", ".tf", ".tm")}
    path = {ending: str(work / file) for ending, file in names.items()}
    spacing_error = error_by_spacing(rows) if rows.uniform else None
    write_clock(path[".tsc"], rows, abs(ck_id))
    write_frames(path[".tf"], rows, name, body_id)
    errors = write_cks(path["_ck3.bc"], path["_ck5.bc"], path[".tsc"], rows, ck_id, segment, spacing_error)
    cks = f"{folder / names['_ck3.bc']}, {folder / names['_ck5.bc']}"
    loaded = [names["_ck5.bc"], names[".tsc"], names[".tf"]]
    written, of_pck = write_pck(path[".bpc"], rows, body_id, segment, spacing_error, tolerance)
    if written:
        loaded.append(names[".bpc"])
        of_pck = f"{folder / names['.bpc']}: {of_pck}, frame {name}_AXES_PCK"
    write_meta(path[".tm"], rows, folder, loaded)
    return names.values(), [
        f"{cks}: {len(rows.et)} rows{errors}, frame {name}_AXES in {rows.frame}",
        of_pck,
        f"{folder / names['.tm']}: load this one",
    ]


def number_and_name(object_name):
    """Of a minor planet, as in 4179 Toutatis and 214869 2007 PA8; not so 2007 PA8, 1P/Halley or an unnumbered one."""
    found = re.match(r"(\d{1,6})\s+(?![A-Z]{2}\d*$)(.+)", object_name)
    return (int(found[1]), found[2]) if found else (None, object_name)


def kernels(file, folder=".", *, id=None, name=None, tolerance=None):
    """Writes the kernels of a FITS ephemeris into a folder, which is made; lines that say what was written.

    id: NAIF's number of the body (2000000 + a minor planet's number before its name, unless given); name: of files and
    frames, the object's unless given; tolerance: rad promised for the binary PCK (1e-9, more for a fast body). Raises
    InputError, FileError.
    """
    rows = read_rows(file)
    number, object_name = number_and_name(rows.object)
    if id is None and number is None:
        raise InputError(
            f"'{rows.object}' does not begin with a minor planet's number: give its NAIF id by `id`, for a satellite a "
            "negative number, as `id` -999123"
        )
    body_id = id if id is not None else 2000000 + number
    if not 0 < abs(body_id) < 2**31:
        raise InputError(f"`id` is {body_id}; it must be between 1 and 2147483647, or the negative of that")
    name = re.sub(r"[^A-Z0-9]+", "_", (name or object_name).upper()).strip("_")
    if not 1 <= len(name) <= LONGEST_NAME:
        raise InputError(
            f"SPICE's frames would begin with '{name}', which has {len(name)} characters; give 1 to {LONGEST_NAME} letters, "
            "digits and _ by `name`"
        )
    folder = Path(folder)
    with tempfile.TemporaryDirectory(prefix="polhode-") as work:
        try:
            made, said = write_kernels(rows, Path(work), folder, name, body_id, tolerance)
        except spiceypy.exceptions.SpiceyError as error:
            raise FileError(f"the kernels cannot be written: {error.short} {error.long}") from None
        _files.made_folder(folder)
        for kernel in made:
            source, target = Path(work, kernel), folder / kernel
            if source.exists():
                with _files.whole_file(target) as file, open(source, "rb") as content:
                    shutil.copyfileobj(content, file)
            else:
                target.unlink(missing_ok=True)  # of an earlier run, which this one's .tm does not load
    return said


def orbit(target, motion, start, stop, step, *, centre="SUN", kernels=()):
    """The way of a target of SPICE's about a centre, for `motion.observe(…, target=…)`: an Orbit of geometric states, each
    `step` seconds from start to stop (dates with their scale, Instants or astropy Times), in the motion's frame and on its
    clock. SPK kernels are loaded already, or named by `kernels`. Raises InputError.
    """
    start, stop = Instant.of(start), Instant.of(stop)
    if motion.frame not in SPICE_FRAMES:
        raise InputError(f"the motion is in {motion.frame}; SPICE has {', '.join(SPICE_FRAMES)}")
    if not (stop - start > 0 and step > 0):
        raise InputError("stop must be after start, and the step positive")
    t = np.append(np.arange(start - motion.epoch, stop - motion.epoch, step), stop - motion.epoch)
    try:
        for kernel in kernels:
            spiceypy.furnsh(os.fspath(kernel))
        et = [sum((motion.epoch + float(s)).since_j2000("ET")) for s in t]
        states = np.array([spiceypy.spkezr(str(target), s, SPICE_FRAMES[motion.frame], "NONE", str(centre))[0] for s in et])
    except spiceypy.exceptions.SpiceyError as error:
        raise InputError(f"SPICE: {error.short} {error.long}") from None
    finally:
        for kernel in kernels:
            spiceypy.unload(os.fspath(kernel))
    return Orbit.table(t, 1e3 * states[:, :3], 1e3 * states[:, 3:], degree=min(7, 2 * len(t) - 1))


def as_options(text):
    """What is said of `arguments`, as the command line knows them."""
    return re.sub(r"`(id|name|tolerance)`", r"--\1", text)


def main(arguments):
    parser = _files.Parser(prog="polhode spice", description="SPICE kernels of an attitude ephemeris that polhode propagate wrote as FITS")
    parser.add_argument("file", help="FITS ephemeris")
    parser.add_argument("-o", "--output", default=".", help="folder of the kernels, made if it is not there (default: here)")
    parser.add_argument("--id", type=int, help="NAIF id of the body (default: 2000000 + the minor planet's number before its name)")
    parser.add_argument("--name", help=f"name for files and frames, at most {LONGEST_NAME} characters (default: the object's name)")
    parser.add_argument(
        "--tolerance", type=_files.positive, help="promised error of the binary PCK in rad (default: 1e-9, more for a fast body)"
    )
    options = parser.parse_args(arguments)
    try:
        said = kernels(options.file, options.output, id=options.id, name=options.name, tolerance=options.tolerance)
    except InputError as error:
        raise InputError(as_options(str(error))) from None
    print(as_options("\n".join(said)))
