"""The numbers of a body that a fit may change, in the form in which its file publishes them."""

from __future__ import annotations

import copy
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .._core import Body, Inertia, read
from .._errors import InputError
from . import rotations
from .documents import read_toml, toml_text

ANGLE_UNITS = {"deg": 1.0, "rad": np.degrees(1), "arcmin": 1 / 60, "arcsec": 1 / 3600, "mas": 1 / 3.6e6, "uas": 1 / 3.6e9, "rev": 360.0}
QUATERNION_KEYS = {  # scalar first, from body to frame: order and conjugation of each
    "q_frame_from_body_scalar_first": ([0, 1, 2, 3], False),
    "q_frame_from_body_scalar_last": ([3, 0, 1, 2], False),
    "q_body_from_frame_scalar_first": ([0, 1, 2, 3], True),
    "q_body_from_frame_scalar_last": ([3, 0, 1, 2], True),
}
Q_KEY = "q_frame_from_body_scalar_first"
AXES = ("x", "y", "z")
PARTS = {
    "euler_angles": ("1", "2", "3"),
    "components": AXES,
    "moments": AXES,
    "semi_axes": AXES,
    "products": ("xy", "xz", "yz"),
}
TENSOR = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}
SPIN = ("lambda", "beta", "phi0", "psi0", "P_phi", "P_psi", "period")


@dataclass
class Parameter:
    """A number: its name in body files, where it stands, its value and what is natural for it."""

    name: str
    place: tuple  # keys and indices in the file's tables; (): the small turn of a quaternion
    value: float
    scale: float  # a change by which is a large one: a radian, the whole rate, the largest moment
    unit: str
    step: float  # for differences
    sigma: float = 0.0  # known beforehand, 0: nothing is
    free: bool = True


@dataclass
class Epoch:
    """A body at its epoch: attitude, rate and tensor in its named axes."""

    q: np.ndarray
    omega: np.ndarray
    tensor: np.ndarray


def tensor_vector(tensor):
    return np.array([tensor[i, k] for i, k in TENSOR.values()])


class Parameters:
    """All numbers of a body, by name."""

    def __init__(self, tables, folder=".", epoch=None):
        """From the tables of a body file in `folder`."""
        self.tables = copy.deepcopy(tables)
        self.folder = Path(folder)
        self.numbers: list[Parameter] = []
        self.turn_from = None  # the attitude that the small turn counts from
        self.correlated = None  # names and covariance of what is known beforehand
        self._strip()
        self.body = self._read(self.tables)
        self.epoch = self.body.epoch
        self.frame = self.body.frame
        if self.body.missing:
            raise InputError(f"{self.body.name}: {'; '.join(self.body.missing)}")
        self._gather()
        self._take_known()

    @staticmethod
    def of_body(body):
        """Of a body that has no file in TOML: quaternion, rate, moments."""
        if body.missing:
            raise InputError(f"{body.name}: {'; '.join(body.missing)}")
        return Parameters.of_state(body.name, body.epoch, body.frame, body.q, body.omega, body.inertia.tensor, body.inertia.absolute)

    @staticmethod
    def of_state(name, epoch, frame, q, omega, tensor, absolute=False, products=False):
        rate = float(np.linalg.norm(omega))
        unit, factor = ("deg/s", np.radians(1)) if rate > np.radians(1e-2) else ("deg/day", np.radians(1) / 86400)
        inertia = {"moments": [float(x) for x in np.diag(tensor)]}
        off = [float(tensor[0, 1]), float(tensor[0, 2]), float(tensor[1, 2])]
        if products or np.abs(off).max() > 1e-12 * np.trace(tensor):
            inertia |= {"products": off, "products_are": "tensor elements"}
        tables = {
            "name": name,
            "inertia": inertia | {"unit": "kg m2" if absolute else "ratios"},
            "state": {
                "epoch": epoch.text("TDB", 9) + " TDB",
                "frame": frame,
                "attitude": {Q_KEY: [float(x) for x in q]},
                "angular_velocity": {"components": [float(x) / factor for x in omega], "axes": "body", "unit": unit},
            },
        }
        return Parameters(tables)

    # --- What stands in the file ------------------------------------------------------------------------------------

    def _strip(self):
        """Takes out what is known of the numbers beforehand, and what restates them."""
        self.known_sigma = {}
        inertia, state, spin = (self.tables.get(key, {}) for key in ("inertia", "state", "spin"))
        for table in (inertia, spin, *(t for t in state.values() if isinstance(t, dict))):
            for key in [key for key in table if key.endswith("_sigma")]:
                self.known_sigma[key.removesuffix("_sigma")] = table.pop(key)
        uncertainty = self.tables.pop("uncertainty", None)
        if uncertainty is not None:
            self.correlated = (list(uncertainty.get("parameters", [])), np.array(uncertainty.get("covariance", []), dtype=float))
        self.tables.pop("period_uncertainty", None)
        self.axis_names = {key: inertia.pop(key) for key in ("long_axis", "intermediate_axis", "short_axis") if key in inertia}
        for key in ("theta0", "energy"):
            spin.pop(key, None)
        if "mesh" in inertia:
            inertia["mesh"] = str((self.folder / inertia["mesh"]).resolve())
        attitude = state.get("attitude", {})
        for key, (order, conjugated) in QUATERNION_KEYS.items():
            if key in attitude:
                q = np.array(attitude.pop(key), dtype=float)[order]
                q /= np.linalg.norm(q)
                attitude[Q_KEY] = [float(x) for x in (rotations.conjugate(q) if conjugated else q)]

    def _add(self, name, place, value, scale, unit, step=None, **more):
        self.numbers.append(Parameter(name, place, float(value), float(scale), unit, 1e-5 * scale if step is None else step, **more))

    def _add_list(self, table, path, key, scale, unit, **more):
        for k, part in enumerate(PARTS[key]):
            self._add(f"{key}.{part}", (*path, key, k), table[key][k], scale, unit, **more)

    def _gather(self):
        state = self.tables.get("state", {})
        attitude, spin = state.get("attitude", {}), self.tables.get("spin", {})
        if "euler_angles" in attitude:
            unit = attitude["unit"]
            self._add_list(attitude, ("state", "attitude"), "euler_angles", np.degrees(1) / ANGLE_UNITS.get(unit, 1.0), unit)
        elif Q_KEY in attitude:
            self.turn_from = np.array(attitude[Q_KEY])
            for k, part in enumerate(AXES):
                self._add(f"turn.{part}", ("turn", k), 0.0, np.degrees(1), "deg")
        for key in ("angular_velocity", "angular_momentum"):
            if key in state:
                components = state[key]["components"]
                self._add_list(state[key], ("state", key), "components", max(np.linalg.norm(components), 1e-300), state[key]["unit"])
        for key in SPIN:
            if key in spin:
                period = key.startswith(("P_", "period"))
                unit = spin.get("period_unit" if period else "unit", "")
                scale = abs(spin[key]) if period else np.degrees(1) / ANGLE_UNITS.get(unit, 1.0)
                self._add(key, ("spin", key), spin[key], scale, unit)
        inertia = self.tables["inertia"]
        unit = inertia.get("unit", inertia.get("length_unit", ""))
        if "moments" in inertia:
            moments = inertia["moments"]
            self._add_list(inertia, ("inertia",), "moments", max(moments), unit)
            one = [k for k in range(3) if moments[k] == 1.0]
            self.named(f"moments.{AXES[one[-1] if one else int(np.argmax(moments))]}").free = False  # the scale of inertia
            if "products" in inertia:
                self._add_list(inertia, ("inertia",), "products", max(moments), unit)
        elif "tensor" in inertia:
            largest = max(inertia["tensor"][k][k] for k in range(3))
            for part, (i, k) in TENSOR.items():
                self._add(f"tensor.{part}", ("inertia", "tensor", i, k), inertia["tensor"][i][k], largest, unit)
            top = int(np.argmax([inertia["tensor"][k][k] for k in range(3)]))
            self.named(f"tensor.{AXES[top] * 2}").free = False
        elif "semi_axes" in inertia:
            axes = inertia["semi_axes"]
            self._add_list(inertia, ("inertia",), "semi_axes", max(axes), unit)
            self.named(f"semi_axes.{AXES[int(np.argmax(axes))]}").free = False

    def _take_known(self):
        """Sigmas of the file: what has none is exact."""
        for key, sigma in self.known_sigma.items():
            if key == Q_KEY or key in QUATERNION_KEYS:
                raise InputError(f"{key}_sigma: a quaternion's sigma is given by [uncertainty] with its covariance")
            if isinstance(sigma, list) and sigma and isinstance(sigma[0], list):
                parts = {f"{key}.{part}": sigma[i][k] for part, (i, k) in TENSOR.items()}
            elif isinstance(sigma, list):
                parts = {f"{key}.{part}": value for part, value in zip(PARTS.get(key, ()), sigma)}
            else:
                parts = {key: sigma}
            for name, value in parts.items():
                if name in self.names:
                    if not value >= 0:
                        raise InputError(f"{key}_sigma: found {value}, an uncertainty of 0 or more is wanted")
                    self.named(name).sigma = float(value)
        if self.correlated is not None:
            names, covariance = self.correlated
            if covariance.shape != (len(names), len(names)):
                raise InputError(f"[uncertainty]: covariance must have {len(names)} rows and columns, as parameters has names")
            if any(name.startswith(Q_KEY) for name in names):
                names, covariance = self._turn_for_quaternion(names, covariance)
            for name in names:
                if name not in self.names:
                    raise InputError(f"[uncertainty]: '{name}' is no number of this file; allowed are {', '.join(self.names)}")
            self.correlated = (names, covariance)
            for name, variance in zip(names, np.diag(covariance)):
                self.named(name).sigma = float(np.sqrt(variance))
        if any(p.sigma > 0 for p in self.numbers):
            for p in self.numbers:
                p.free = p.sigma > 0

    def _turn_for_quaternion(self, names, covariance):
        """Components of the quaternion become the small turn."""
        parts = [names.index(f"{Q_KEY}.q{k}") for k in range(4) if f"{Q_KEY}.q{k}" in names]
        if len(parts) != 4:
            raise InputError("[uncertainty]: of a quaternion all four components are wanted")
        others = [k for k in range(len(names)) if k not in parts]
        change = np.zeros((3 + len(others), len(names)))
        change[:3, parts] = np.degrees(2 * turn_of_components(self.turn_from))
        change[3 + np.arange(len(others)), others] = 1
        return [f"turn.{a}" for a in AXES] + [names[k] for k in others], change @ covariance @ change.T

    # --- By name ----------------------------------------------------------------------------------------------------

    @property
    def names(self):
        return [p.name for p in self.numbers]

    @property
    def values(self):
        return np.array([p.value for p in self.numbers])

    @property
    def free(self):
        return np.array([p.free for p in self.numbers], dtype=bool)

    def named(self, name):
        for p in self.numbers:
            if p.name == name:
                return p
        raise InputError(f"'{name}' is no number of {self.tables['name']}; allowed are {', '.join(self.names)}")

    def choose(self, free=None, fixed=None, others=False):
        """free, fixed: names; a name without its part means all parts. `free` alone: these and no others, unless a name
        begins with +. `others`: there are numbers besides, so that all of these may be fixed."""
        if free:
            if not any(name.startswith("+") for name in free):
                for p in self.numbers:
                    p.free = False
            for name in free:
                for p in self._meant(name.removeprefix("+")):
                    p.free = True
        for name in fixed or ():
            for p in self._meant(name):
                p.free = False
        if not others and not self.free.any():
            raise InputError("no parameter is free: nothing is to be fitted")

    def _meant(self, name):
        found = [p for p in self.numbers if p.name == name or p.name.startswith(name + ".")]
        return found or [self.named(name)]

    # --- From numbers to the body -----------------------------------------------------------------------------------

    def replaced(self, values):
        """The file's tables with these values."""
        tables = copy.deepcopy(self.tables)
        turn = np.zeros(3)
        for p, value in zip(self.numbers, values):
            if p.place[0] == "turn":
                turn[p.place[1]] = np.radians(value)
                continue
            table = tables
            for key in p.place[:-1]:
                table = table[key]
            table[p.place[-1]] = float(value)
            if p.place[:2] == ("inertia", "tensor"):
                tables["inertia"]["tensor"][p.place[3]][p.place[2]] = float(value)
        if self.turn_from is not None:
            q = rotations.multiply(self.turn_from, rotations.exponential(turn))
            tables["state"]["attitude"][Q_KEY] = [float(x) for x in q]
        return tables

    def anchored(self, values):
        """The values with the small turn counted from where they have the attitude; in place of the attitude before."""
        turns = [k for k, p in enumerate(self.numbers) if p.place[0] == "turn"]
        if not turns or any(self.numbers[k].sigma > 0 for k in turns):
            return np.array(values, dtype=float)
        self.turn_from = self.at(values).q
        self.tables["state"]["attitude"][Q_KEY] = [float(x) for x in self.turn_from]
        values = np.array(values, dtype=float)
        values[turns] = 0.0
        return values

    def _read(self, tables):
        handle, path = tempfile.mkstemp(suffix=".toml", dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
        try:
            with open(handle, "w") as file:
                file.write(toml_text(tables))
            return read(path)
        except InputError as error:
            raise InputError(f"{tables.get('name', 'the body')}: {error.message}") from None
        finally:
            os.unlink(path)

    def at(self, values):
        """The body at its epoch. Raises InputError where no body has these numbers."""
        direct = self._direct(values)
        if direct is not None:
            return direct
        body = self._read(self.replaced(values))
        return Epoch(np.array(body.q), np.array(body.omega), np.array(body.inertia.tensor))

    def _direct(self, values):
        """Without a file, for the form of of_state()."""
        inertia, state = self.tables["inertia"], self.tables.get("state", {})
        velocity = state.get("angular_velocity", {})
        factor = {"deg/s": np.radians(1), "deg/day": np.radians(1) / 86400}.get(velocity.get("unit"))
        if self.turn_from is None or "moments" not in inertia or velocity.get("axes") != "body" or factor is None:
            return None
        if inertia.get("unit") not in ("ratios", "kg m2") or inertia.get("products_are", "tensor elements") != "tensor elements":
            return None
        v = np.asarray(values, dtype=float)
        tensor = np.diag(v[6:9])
        if len(v) > 9:
            tensor[[0, 1, 0, 2, 1, 2], [1, 0, 2, 0, 2, 1]] = np.repeat(v[9:12], 2)
        q = rotations.multiply(self.turn_from, rotations.exponential(np.radians(v[:3])))
        return Epoch(q, factor * v[3:6], tensor)

    def derivative(self, values):
        """At the epoch, of (small turn in body axes, rate, tensor's xx xy xz yy yz zz) by each number: (12, n), by central
        differences; columns of what is fixed are 0."""
        out = np.zeros((12, len(self.numbers)))
        values = np.array(values, dtype=float)
        for k, p in enumerate(self.numbers):
            if p.free:
                out[:, k] = self._difference(values, k, p.step)
        return out

    def _difference(self, values, k, step):
        ends = []
        for sign in (1, -1):
            moved = values.copy()
            moved[k] += sign * step
            try:
                ends.append(self.at(moved))
            except InputError:  # at the border of what bodies can be: one-sided
                ends.append(None)
        if ends[0] is None and ends[1] is None:
            raise InputError(f"{self.numbers[k].name} = {values[k]:g}: no body has numbers beside it")
        width = step * (2 if None not in ends else 1)
        a, b = (end or self.at(values) for end in ends)
        turn = rotations.logarithm(rotations.multiply(rotations.conjugate(b.q), a.q))
        return np.concatenate([turn, a.omega - b.omega, tensor_vector(a.tensor - b.tensor)]) / width

    def body_at(self, values):
        at = self.at(values)
        inertia = Inertia(np.diag(at.tensor), [at.tensor[0, 1], at.tensor[0, 2], at.tensor[1, 2]], absolute=self.body.inertia.absolute)
        return Body(self.tables["name"], inertia=inertia, epoch=self.epoch, frame=self.frame, q=at.q, omega=at.omega, source=self.tables.get("source", ""))

    # --- To a file --------------------------------------------------------------------------------------------------

    def text(self, values, covariance=None, source=None, comments=()):
        """A body file with these numbers; `covariance` of all of them, 0 where fixed."""
        tables = self.replaced(values)
        if source:
            tables["source"] = source
        without_products = not any(tables["inertia"].get("products", ()))  # axes that are no principal ones have no names
        if self.axis_names and without_products and np.array_equal(np.argsort(tables["inertia"]["moments"]), np.argsort(self.tables["inertia"]["moments"])):
            tables["inertia"] |= self.axis_names
        tables = {key: tables[key] for key in ("name", "id", "source") if key in tables} | tables
        if covariance is not None:
            names, covariance = self._published_covariance(values, np.asarray(covariance))
            sigma = np.sqrt(np.maximum(np.diag(covariance), 0))
            self._write_sigmas(tables, dict(zip(names, sigma)))
            turns = any(s > 0 and name.startswith(Q_KEY) for name, s in zip(names, sigma))
            known = [k for k in range(len(names)) if sigma[k] > 0 or (turns and names[k].startswith(Q_KEY))]
            if known:
                rows = covariance[np.ix_(known, known)]
                tables["uncertainty"] = {"parameters": [names[k] for k in known], "covariance": [[float(x) for x in row] for row in rows]}
        return toml_text(tables, comments)

    def _published_covariance(self, values, covariance):
        if self.turn_from is None:
            return self.names, covariance
        turns = [k for k, p in enumerate(self.numbers) if p.place[0] == "turn"]
        others = [k for k in range(len(self.numbers)) if k not in turns]
        change = np.zeros((4 + len(others), len(self.numbers)))
        q = np.array(self.replaced(values)["state"]["attitude"][Q_KEY])
        change[:4, turns] = np.radians(1) * turn_of_components(q).T / 2
        change[4 + np.arange(len(others)), others] = 1
        return [f"{Q_KEY}.q{k}" for k in range(4)] + [self.names[k] for k in others], change @ covariance @ change.T

    def _write_sigmas(self, tables, sigma):
        for p in self.numbers:
            if p.place[0] == "turn" or not any(s > 0 for name, s in sigma.items() if name.split(".")[0] == p.name.split(".")[0]):
                continue
            table, depth = tables, 2 if p.place[0] == "state" else 1
            for key in p.place[:depth]:
                table = table[key]
            key, rest = p.place[depth], p.place[depth + 1 :]
            if key + "_sigma" not in table:
                put_beside(table, key, [0.0] * len(table[key]) if len(rest) == 1 else [[0.0] * 3 for _ in range(3)])
            value = float(sigma[p.name])
            if not rest:
                table[key + "_sigma"] = value
            elif len(rest) == 1:
                table[key + "_sigma"][rest[0]] = value
            else:
                rows = table[key + "_sigma"]
                rows[rest[0]][rest[1]] = rows[rest[1]][rest[0]] = value


def put_beside(table, key, sigma):
    """The key's sigma behind the key."""
    items = list(table.items())
    table.clear()
    for name, value in items:
        table[name] = value
        if name == key:
            table[key + "_sigma"] = sigma


def turn_of_components(q):
    """(3, 4): half the small turn, in body axes, of a change of a unit quaternion's components."""
    w, x, y, z = q
    return np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])


def parameters_of(what, scene_path=""):
    """The Parameters of a body: of its file where it has one in TOML, which may be that of a scene."""
    path = what.path
    if not path and scene_path:
        named = (read_toml(scene_path) or {}).get("body")
        path = str(Path(scene_path).parent / named) if isinstance(named, str) else ""
    tables = read_toml(path) if path else None
    if tables is not None and "name" in tables and ("state" in tables or "spin" in tables) and "inertia" in tables:
        return Parameters(tables, Path(path).parent)
    return Parameters.of_body(what)
