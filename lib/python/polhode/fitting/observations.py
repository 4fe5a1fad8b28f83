"""Measurements: attitudes, rates, directions of an axis, magnitudes, from tables, histories and arrays."""

from __future__ import annotations

import csv
import gzip
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .._core import AttitudeHistory, Instant, frame_rotation, q_from_euler, read
from .._errors import FileError, InputError
from . import rotations

SCALES = ("utc", "tdb", "tt", "tai", "gps", "et")
ATTITUDE, RATE, AXIS, MAGNITUDE = "attitude", "rate", "axis", "magnitude"
WIDTH = {ATTITUDE: 3, RATE: 3, AXIS: 2, MAGNITUDE: 1}  # numbers in a residual
RATE_UNIT = np.radians(1) / 86400  # of the columns omega_x_deg_day ...
ANGLES = ("alpha_deg", "beta_deg", "gamma_deg")
RATES = ("omega_x_deg_day", "omega_y_deg_day", "omega_z_deg_day")
OUR_Q = ("q_scalar", "q_x", "q_y", "q_z")
OUR_RATES = ("omega_body_x_rad_s", "omega_body_y_rad_s", "omega_body_z_rad_s")
GEOMETRY = ("ra_deg", "dec_deg", "delta_au", "r_au")


@dataclass
class Rows:
    """Measurements of one kind from one source."""

    kind: str
    source: str
    lines: np.ndarray  # in the source: from 1
    instants: list
    values: np.ndarray  # attitude (n, 4); rate (n, 3), rad/s; axis (n, 3), unit vectors; magnitude (n,)
    sigma: np.ndarray | None  # rad, rad/s, mag; None: not stated
    frame: str | None = None  # of attitudes and directions
    axis: np.ndarray | None = None  # of directions: in body axes
    towards: np.ndarray | None = None  # of magnitudes (n, 2, 3): from the body to observer and Sun, ICRF
    distances_au: np.ndarray | None = None  # (n, 2): the same

    def __len__(self):
        return len(self.instants)

    def name(self, row):
        return f"{self.source}:{self.lines[row]}: {self.kind} of {self.instants[row].text('UTC', 0)} UTC"

    def part(self, rows):
        def of(array):
            return None if array is None else array[rows]

        instants = [self.instants[k] for k in np.arange(len(self))[rows]]
        return replace(
            self, lines=self.lines[rows], instants=instants, values=self.values[rows], sigma=of(self.sigma),
            towards=of(self.towards), distances_au=of(self.distances_au),
        )  # fmt: skip

    def in_frame(self, frame):
        """The same with attitudes and directions in another inertial frame."""
        if self.kind == MAGNITUDE:
            turn = rotations.matrix(frame_rotation("ICRF", frame))
            return replace(self, towards=self.towards @ turn.T)
        if self.frame is None or self.frame == frame:
            return self
        q = frame_rotation(self.frame, frame)
        values = rotations.multiply(q, self.values) if self.kind == ATTITUDE else self.values @ rotations.matrix(q).T
        return replace(self, values=values, frame=frame)


@dataclass
class Table:
    """A CSV or ECSV as text: the lines of its rows are known."""

    path: str
    names: list
    names_line: int
    columns: dict
    lines: np.ndarray
    said: dict = field(default_factory=dict)  # `# key: value`

    def error(self, line, message):
        return InputError(f"{self.path}:{line}: {message}", self.path, int(line), message)

    def has(self, names):
        found = [name for name in names if name in self.columns]
        if found and len(found) < len(names):
            lacking = ", ".join(name for name in names if name not in self.columns)
            raise self.error(self.names_line, f"found the column {found[0]}, but not {lacking}")
        return bool(found)

    def numbers(self, name, positive=False):
        out = np.empty(len(self.lines))
        for k, text in enumerate(self.columns[name]):
            try:
                out[k] = float(text)
            except ValueError:
                out[k] = np.nan
            if not np.isfinite(out[k]) or (positive and out[k] <= 0):
                wanted = "a positive number" if positive else "a number"
                raise self.error(self.lines[k], f"column {name}: found '{text}', {wanted} is wanted")
        return out

    def vectors(self, names):
        return np.stack([self.numbers(name) for name in names], axis=-1)

    def instants(self):
        dates = [f"{form}_{scale}" for form in ("date", "jd", "mjd") for scale in SCALES]
        found = [name for name in self.names if name in dates]
        if len(found) != 1:
            raise self.error(self.names_line, f"found {len(found)} columns of dates, one is wanted: date_utc, jd_tdb, mjd_tt or similar")
        form, scale = found[0].split("_")
        before = "" if form == "date" else form.upper() + " "
        out = []
        for line, text in zip(self.lines, self.columns[found[0]]):
            try:
                out.append(Instant(before + text.strip(), scale.upper()))
            except InputError as error:
                raise self.error(line, f"column {found[0]}: {error.message}") from None
        return out

    def frame(self):
        if "frame" in self.columns:
            frames = set(self.columns["frame"])
            if len(frames) > 1:
                raise self.error(self.lines[0], "rows of different frames: one frame in a table is wanted")
            return frames.pop()
        if "frame" not in self.said:
            raise self.error(self.names_line, "the frame is not said: a line '# frame: ECLIPJ2000' or similar is wanted")
        return self.said["frame"]


def text_of(path):
    try:
        data = Path(path).read_bytes()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        return data.decode()
    except UnicodeDecodeError:
        return None
    except (EOFError, gzip.BadGzipFile) as error:
        raise InputError(f"{path} cannot be unpacked: {error}", str(path)) from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None


def table_of(path, text):
    """The table in a text, or None where it is none of measurements."""
    known = {*ANGLES, *RATES, "magnitude", "axis_lon_deg", "sigma_angles_deg", "sigma_omega_deg_day"}
    said, names, delimiter, rows, lines = {}, None, ",", [], []
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("#"):
            key, colon, value = line[1:].strip().removeprefix("- ").partition(":")
            if colon and key.strip() in ("sequence", "frame", "axis"):
                said[key.strip()] = value.strip().strip("'\"")
        elif line.strip():
            if names is None:
                delimiter = "," if "," in line else " "
            cells = next(csv.reader([line.strip()], delimiter=delimiter, skipinitialspace=True))
            cells = [cell.strip() for cell in cells]
            if names is None:
                names, names_line = cells, number
                if not known & set(names):
                    return None
                continue
            if len(cells) != len(names):
                raise InputError(
                    f"{path}:{number}: found {len(cells)} cells, {len(names)} are wanted as in line {names_line}", str(path), number
                )
            rows.append(cells)
            lines.append(number)
    if names is None:
        return None
    columns = {name: [row[k] for row in rows] for k, name in enumerate(names)}
    table = Table(str(path), names, names_line, columns, np.array(lines, dtype=int), said)
    if not rows:
        raise table.error(names_line, "the table has no rows")
    return table


def sigma_of(table, name, unit):
    return unit * table.numbers(name, positive=True) if name in table.columns else None


def rows_of_table(table):
    instants = table.instants()
    found = []

    def add(kind, values, sigma, **more):
        found.append(Rows(kind, table.path, table.lines, instants, values, sigma, **more))

    if table.has(ANGLES):
        if "sequence" not in table.said:
            raise table.error(table.names_line, "the sequence of the angles is not said: a line '# sequence: ZXZ' or similar is wanted")
        angles = np.radians(table.vectors(ANGLES))
        try:
            q = np.array([q_from_euler(table.said["sequence"], row) for row in angles])
        except InputError as error:
            raise table.error(table.names_line, f"sequence: {error.message}") from None
        add(ATTITUDE, q, sigma_of(table, "sigma_angles_deg", np.radians(1)), frame=checked_frame(table))
    if table.has(OUR_Q):
        q = table.vectors(OUR_Q)
        length = np.linalg.norm(q, axis=1)
        for k in np.flatnonzero(abs(length - 1) > 1e-3):
            raise table.error(table.lines[k], f"found a quaternion of length {length[k]:.4g}, 1 is wanted")
        add(ATTITUDE, q / length[:, None], sigma_of(table, "sigma_angles_deg", np.radians(1)), frame=checked_frame(table))
    if table.has(RATES):
        add(RATE, RATE_UNIT * table.vectors(RATES), sigma_of(table, "sigma_omega_deg_day", RATE_UNIT))
    if table.has(OUR_RATES):
        add(RATE, table.vectors(OUR_RATES), sigma_of(table, "sigma_omega_deg_day", RATE_UNIT))
    if table.has(("axis_lon_deg", "axis_lat_deg")):
        axis = table.said.get("axis", "")
        if axis not in ("x", "y", "z"):
            raise table.error(table.names_line, f"axis: found '{axis}'; a line '# axis: x' (or y, z) must say which axis of the body is meant")
        direction = unit_vectors(table.numbers("axis_lon_deg"), table.numbers("axis_lat_deg"))
        sigma = sigma_of(table, "sigma_axis_deg", np.radians(1))
        add(AXIS, direction, sigma, frame=checked_frame(table), axis=np.eye(3)["xyz".index(axis)])
    if "magnitude" in table.columns:
        found.append(magnitudes_of(table, instants))
    return found


def magnitudes_of(table, instants):
    for name in GEOMETRY:
        if name not in table.columns:
            raise table.error(table.names_line, f"magnitudes need the geometry, and the column {name} is missing: {', '.join(GEOMETRY)} are wanted (geocentric)")
    sigma = None
    if "error_mag" in table.columns:
        sigma = table.numbers("error_mag")
        for k in np.flatnonzero(sigma < 0):
            raise table.error(table.lines[k], f"column error_mag: found {sigma[k]:g}, 0 (not known) or more is wanted")
    delta, r = table.numbers("delta_au", positive=True), table.numbers("r_au", positive=True)
    ra, dec = table.numbers("ra_deg"), table.numbers("dec_deg")
    from_earth = delta[:, None] * unit_vectors(ra, dec)
    # The Sun lies where both distances allow it: the Earth's own place, from ERFA as astropy has it.
    import erfa

    tdb = [instant.since_j2000("TDB")[0] / 86400 + 2451545.0 for instant in instants]
    earth = np.asarray(erfa.epv00(np.array(tdb), 0.0)[0]["p"])
    from_sun = earth + from_earth
    length = np.linalg.norm(from_sun, axis=1)
    for k in np.flatnonzero(abs(length - r) > 0.02 * r):
        raise table.error(table.lines[k], f"r_au: found {r[k]:g}; the Earth's place, ra_deg, dec_deg and delta_au give {length[k]:.4f}")
    towards = np.stack([-from_earth / delta[:, None], -from_sun / length[:, None]], axis=1)
    # Light that arrives then has left the body earlier.
    left = [instant + -499.004784 * d for instant, d in zip(instants, delta)]
    magnitude = table.numbers("magnitude")
    return Rows(MAGNITUDE, table.path, table.lines, left, magnitude, sigma, towards=towards, distances_au=np.stack([delta, r], 1))


def checked_frame(table):
    frame = table.frame()
    try:
        frame_rotation(frame, "ICRF")
    except InputError as error:
        raise table.error(table.names_line, f"frame: {error.message}") from None
    return frame


def unit_vectors(longitude_deg, latitude_deg):
    lon, lat = np.radians(longitude_deg), np.radians(latitude_deg)
    return np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)


def rows_of_history(history, source):
    found = []
    for segment in history.segments:
        n = len(segment)
        instants = [segment.epoch + float(t) for t in segment.t]
        lines = np.arange(1, n + 1)
        found.append(Rows(ATTITUDE, source, lines, instants, np.array(segment.q), None, frame=segment.frame))
        if segment.omega is not None:
            found.append(Rows(RATE, source, lines, instants, np.array(segment.omega), None))
    return found


def read_observations(source):
    """The Rows of a path, an AttitudeHistory, Rows, or a list of these. Raises InputError, FileError."""
    if isinstance(source, Rows):
        return [source]
    if isinstance(source, AttitudeHistory):
        return rows_of_history(source, source.path or source.object)
    if isinstance(source, (list, tuple)):
        return [rows for one in source for rows in read_observations(one)]
    text = text_of(source)
    table = table_of(source, text) if text is not None else None
    if table is not None:
        return rows_of_table(table)
    what = read(source)
    history = what if isinstance(what, AttitudeHistory) else getattr(what, "history", None)
    if history is None:
        raise InputError(f"{source}: found no measurements; a table of attitudes, rates, directions or magnitudes is wanted, or an attitude history", str(source))
    return rows_of_history(history, str(source))
