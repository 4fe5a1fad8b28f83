#!/usr/bin/env python3
"""Turn an attitude ephemeris that `polhode propagate` wrote as FITS into SPICE kernels.

    tools/spice_kernels.py FILE.fits [-o FOLDER] [--id ID] [--name NAME] [--tolerance RADIANS]

After furnsh of FOLDER/NAME.tm, pxform and sxform know the frame NAME_AXES (and NAME_AXES_PCK):

    NAME_ck5.bc   CK type 5: Hermite interpolation, degree 11, between the rows; the accurate one, which NAME.tm loads
    NAME_ck3.bc   CK type 3: rotation at a constant rate between the rows; for programs that know no type 5
    NAME.bpc      binary PCK type 2: Chebyshev polynomials of the Euler angles ZXZ, for SPICE, ANISE and jplephem; only
                  where rows are equally spaced and the body's z axis keeps clear of the inertial one's line
    NAME.tsc      the clock that a CK needs: counts ET
    NAME.tf       the frames
    NAME.tm       all of these but NAME_ck3.bc, to load at once (paths in it are absolute)

Each says in its comments the largest error found between the rows, or for the PCK the promised one.

The quaternion that SPICE wants is (QC, -Q1, -Q2, -Q3) of ours, its angular velocities are in the inertial frame, and its
ET is SPICE's own TDB (up to 0.03 ms from that of FITS): each row keeps its instant.
"""

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import spiceypy
from astropy.table import Table

# SPICE's TDB, from its leap-seconds kernels: ET = TT + K sin(M + EB sin M), M = M0 + M1 t.
DELTET_K, DELTET_EB, DELTET_M0, DELTET_M1 = 1.657e-3, 1.671e-2, 6.239996, 1.99096871e-7

SPICE_FRAMES = {"ICRF": "J2000", "GCRF": "J2000", "ECLIPJ2000": "ECLIPJ2000"}
HERMITE_ROWS = 6  # of a window: degree 11
CHEBYSHEV_DEGREE = 15


def fail(message):
    sys.exit(f"spice_kernels: {message}")


@dataclass
class Rows:
    object: str
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
    def q_dot(self):
        """dq/dt = q (0, omega_body) / 2."""
        s, v, w = self.q[:, :1], self.q[:, 1:], self.omega_body
        return 0.5 * np.concatenate([-np.sum(v * w, axis=1, keepdims=True), s * w + np.cross(v, w)], axis=1)


def read_rows(path):
    table = Table.read(path, hdu="ATTITUDE", astropy_native=True)
    frame = table.meta["REFFRAMA"]
    if frame not in SPICE_FRAMES:
        fail(f"{path}: SPICE has no frame {frame}; write the FITS with --frame ICRF or ECLIPJ2000")
    if table.meta.get("QORDER") != "XYZS" or table.meta.get("QDIR") != "A2B":
        fail(f"{path}: QORDER, QDIR are not XYZS, A2B")
    if len(table) < 2:
        fail(f"{path}: kernels need two rows or more")
    # TT seconds from J2000 in two parts, so that nothing is lost on the way.
    tt = table["TIME"].tt
    days = tt.jd1 - 2451545.0
    coarse = (days + tt.jd2) * 86400
    anomaly = DELTET_M0 + DELTET_M1 * coarse
    et = days * 86400 + (tt.jd2 * 86400 + DELTET_K * np.sin(anomaly + DELTET_EB * np.sin(anomaly)))
    step = np.diff(et)
    return Rows(
        object=table.meta["OBJECT"],
        frame=SPICE_FRAMES[frame],
        et=et,
        q=np.asarray(table["QPARAM"])[:, [3, 0, 1, 2]],
        omega_body=np.asarray(table["OMEGA"]),
        uniform=len(table) >= HERMITE_ROWS and bool(np.all(np.abs(step - step.mean()) < 1e-4)),
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
    return Rows(rows.object, rows.frame, rows.et[::2], rows.q[::2], rows.omega_body[::2], rows.uniform)


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


def chebyshev_pieces(rows, tolerance):
    """The fewest equal pieces (within a fifth) whose polynomials of the angles stay within the tolerance: coefficients
    (pieces x 3 x terms) and the error found at the rows and half-way between them."""
    begin, end = rows.et[0], rows.et[-1]
    terms = CHEBYSHEV_DEGREE + 1
    nodes = np.cos(np.pi * (np.arange(terms) + 0.5) / terms)[::-1]
    polynomials = np.polynomial.chebyshev.chebvander(nodes, CHEBYSHEV_DEGREE)
    weights = 2.0 / terms * polynomials.T
    weights[0] /= 2
    check_et = np.sort(np.concatenate([rows.et, (rows.et[1:] + rows.et[:-1]) / 2]))
    truth = interpolated(rows, check_et)
    pieces = max(1, int(len(rows.et) / 60))
    while pieces * terms < 16 * len(rows.et) + 64:
        length = (end - begin) / pieces
        centres = begin + length * (np.arange(pieces) + 0.5)
        et = (centres[:, None] + nodes * length / 2).ravel()
        angles = euler_zxz(interpolated(rows, et)).reshape(pieces, terms, 3)
        coefficients = np.einsum("kn,pnj->pjk", weights, angles)
        piece = np.clip(((check_et - begin) / length).astype(int), 0, pieces - 1)
        x = (check_et - centres[piece]) / (length / 2)
        found = np.einsum("tk,tjk->tj", np.polynomial.chebyshev.chebvander(x, CHEBYSHEV_DEGREE), coefficients[piece])
        error = angle(from_euler_zxz(found), truth).max()
        if error <= tolerance:
            return coefficients, length, error
        pieces = int(pieces * 1.2) + 1
    return None


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


def new_file(path):
    path.unlink(missing_ok=True)
    return str(path)


def write_text(path, kind, text, data):
    path.write_text(f"{kind}\n\n{text}\n\n\\begindata\n\n{data}\n\\begintext\n", encoding="ascii")


def split_path(path):
    """A path as the strings of a meta-kernel, at most 78 characters each, joined by '+'."""
    text = str(path)
    parts = [text[i : i + 70] for i in range(0, len(text), 70)]
    return "\n".join(f"    '{part}{'+' if i + 1 < len(parts) else ''}'" for i, part in enumerate(parts))


def write_kernels(rows, folder, name, body_id, tolerance):
    ck_id = -abs(body_id)
    frame, pck_frame, pck_frame_id = f"{name}_AXES", f"{name}_AXES_PCK", 1400000 + abs(body_id) % 500000
    paths = {ending: folder / f"{name.lower()}{ending}" for ending in ("_ck3.bc", "_ck5.bc", ".bpc", ".tsc", ".tf", ".tm")}
    zero = np.floor(rows.et[0]) - 86400  # the clock starts a day early
    clock = abs(ck_id)
    write_text(
        paths[".tsc"], "KPL/SCLK", f"The clock of the attitude of {rows.object}: microseconds of ET (TDB) from {zero:.0f} s.",
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
    write_text(
        paths[".tf"], "KPL/FK", f"Frames of the attitude of {rows.object}: the axes that its body file names.",
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

    spiceypy.kclear()
    spiceypy.furnsh(str(paths[".tsc"]))
    ticks = np.array([spiceypy.sce2c(ck_id, t) for t in rows.et])
    segment = f"{rows.object} by polhode"[:40]
    handle = spiceypy.ckopn(new_file(paths["_ck3.bc"]), segment, 0)
    quaternions = spice_quaternion(rows.q)
    spiceypy.ckw03(
        handle, ticks[0], ticks[-1], ck_id, rows.frame, True, segment, len(ticks), ticks, quaternions, rows.omega_inertial, 1, ticks[:1]
    )
    spiceypy.ckcls(handle)
    handle = spiceypy.ckopn(new_file(paths["_ck5.bc"]), segment, 0)
    packets = np.ascontiguousarray(np.concatenate([quaternions, spice_quaternion(rows.q_dot)], axis=1))
    hermite_with_derivatives, degree = 0, 2 * HERMITE_ROWS - 1
    seconds_per_tick = 1e-6
    spiceypy.ckw05(
        handle, hermite_with_derivatives, degree, ticks[0], ticks[-1], ck_id, rows.frame, True, segment, ticks, packets,
        seconds_per_tick, 1, ticks[:1],
    )  # fmt: skip
    spiceypy.ckcls(handle)
    errors = ""
    if rows.uniform:
        type_3, type_5 = errors_between(rows, str(paths["_ck5.bc"]), ck_id)
        for ending, error in (("_ck3.bc", type_3), ("_ck5.bc", type_5)):
            what = f"Attitude of {rows.object} in {rows.frame}, by polhode."
            add_comments(paths[ending], [what, f"Largest error found between the rows: {error:.3e} rad."])
        errors = f", error found {type_3:.2g} and {type_5:.2g} rad"
    spiceypy.kclear()
    loaded = [paths["_ck5.bc"], paths[".tsc"], paths[".tf"]]
    print(f"{paths['_ck3.bc']}, {paths['_ck5.bc']}: {len(ticks)} rows{errors}, frame {frame} in {rows.frame}")

    paths[".bpc"].unlink(missing_ok=True)
    smallest_sine = np.sin(euler_zxz(rows.q)[:, 1]).min()
    pieces = None
    if not rows.uniform:
        print("no binary PCK: its rows must be equally spaced, six or more")
    elif smallest_sine < 1e-2:
        print(f"no binary PCK: the body's z axis comes within {np.arcsin(smallest_sine):.2g} rad of the inertial one's line")
    else:
        spacing_error = 0.0
        half = every_other(rows)
        if len(half.et) >= HERMITE_ROWS:  # what the rows between the rows say of a spacing twice as wide
            inside = slice(1, 2 * len(half.et) - 2, 2)
            spacing_error = angle(interpolated(half, rows.et[inside]), rows.q[inside]).max() / 2**12
        pieces = chebyshev_pieces(rows, max(tolerance - spacing_error, 0))
        if pieces is None:
            print(f"no binary PCK: the rows are too far apart for {tolerance:.2g} rad; give more rows or a larger --tolerance")
    if pieces is not None:
        coefficients, length, error = pieces
        handle = spiceypy.pckopn(new_file(paths[".bpc"]), segment, 1000)
        spiceypy.dafac(handle, [f"Attitude of {rows.object} in {rows.frame}, angles ZXZ, by polhode.",
                                f"Promised error everywhere: {tolerance:.3e} rad."])  # fmt: skip
        spiceypy.pckw02(
            handle, abs(body_id), rows.frame, rows.et[0], rows.et[-1], segment, length, len(coefficients), CHEBYSHEV_DEGREE,
            np.ascontiguousarray(coefficients).ravel(), rows.et[0],
        )  # fmt: skip
        spiceypy.pckcls(handle)
        loaded.append(paths[".bpc"])
        print(f"{paths['.bpc']}: {len(coefficients)} pieces of {length:.6g} s, error found {error:.2g} rad, frame {pck_frame}")
    names = "\n".join(split_path(path.resolve()) for path in loaded)
    write_text(paths[".tm"], "KPL/MK", f"Attitude of {rows.object}.", f"KERNELS_TO_LOAD = (\n{names}\n)\n")
    print(f"{paths['.tm']}: load this one")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("file", help="FITS ephemeris")
    parser.add_argument("-o", "--output", default=".", help="folder of the kernels (default: here)")
    parser.add_argument("--id", type=int, help="NAIF id of the body (default: 2000000 + the number at the head of its name)")
    parser.add_argument("--name", help="name for files and frames (default: from the object's name)")
    parser.add_argument("--tolerance", type=float, default=1e-9, help="promised error of the binary PCK in rad (%(default)s)")
    arguments = parser.parse_args()
    rows = read_rows(arguments.file)
    number = re.match(r"\d+", rows.object)
    body_id = arguments.id if arguments.id is not None else 2000000 + int(number[0]) if number else None
    if not body_id:
        fail(f"'{rows.object}' has no number in front; give its NAIF id by --id")
    name = (arguments.name or re.sub(r"^\d+\s*", "", rows.object)).upper()
    name = re.sub(r"[^A-Z0-9]+", "_", name).strip("_")[:20]
    folder = Path(arguments.output)
    if not folder.is_dir():
        fail(f"there is no folder {folder}")
    write_kernels(rows, folder, name, body_id, arguments.tolerance)


if __name__ == "__main__":
    main()
