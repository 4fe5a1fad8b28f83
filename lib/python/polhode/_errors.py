"""The exceptions of the package."""

from __future__ import annotations

import re
from typing import NamedTuple


class Error(Exception):
    """Every exception of polhode."""


class InputError(Error, ValueError):
    """What was given breaks a rule. The text says what was found and what is allowed.

    file, line: where in the input it stands, or None; message: the text without them.
    """

    def __init__(self, text: str, file: str | None = None, line: int | None = None, message: str | None = None):
        super().__init__(text)
        self.file = file
        self.line = line
        self.message = text if message is None else message


class FileError(Error, OSError):
    """A file cannot be read or written."""


class ComputationError(Error, ArithmeticError):
    """A computation gave no usable answer for input that breaks no rule."""


def of_call(text: str) -> str:
    """What is wrong with a call, from what the binding says of it: signatures, and the types that were given. Any other text
    is returned as it is."""
    found = re.match(r"(\w+)\(\): incompatible function arguments\..*?\n(.*)\nInvoked with types: (.*)", text, re.S)
    if not found:
        return text
    name, listed, given = found.groups()
    given = given.replace("polhode._core.", "")
    names = {key: kind.strip() for key, kind in re.findall(r"(\w+): ([^,}]+)", given.partition("kwargs = { ")[2])}
    by_place = [one for one in given.partition("kwargs = { ")[0].split(", ") if one]
    signatures = re.findall(r"^ +\d+\. (?:def )?\w+\((.*?)\)(?: -> .*)?$", listed.replace("polhode._core.", ""), re.M)
    if not signatures:
        return text
    parameters = _parameters(signatures[-1])  # of several the last is the widest
    if parameters and parameters[0].name == "self":
        if name in ("__init__", "__call__"):
            name = by_place[0]
        parameters, by_place = parameters[1:], by_place[1:]
    allowed = re.sub(r"^self(, )?", "", signatures[-1])
    return f"{name}(): {_fault(parameters, by_place, names)}; the arguments are ({allowed})"


class _Parameter(NamedTuple):
    name: str
    type: str
    needed: bool
    by_place: bool


def _parameters(signature: str) -> list[_Parameter]:
    parts, depth, start = [], 0, 0
    for i, letter in enumerate(signature + ","):
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            parts.append(signature[start:i].strip())
            start = i + 1
    parameters, by_place = [], True
    for part in parts:
        if part in ("*", "/", ""):
            by_place = by_place and part != "*"
            continue
        name, _, rest = part.partition(":")
        kind, equals, _ = rest.partition("=")
        parameters.append(_Parameter(name.strip(), kind.strip(), not equals, by_place))
    return parameters


def _fault(parameters: list[_Parameter], places: list[str], names: dict[str, str]) -> str:
    import difflib

    by_name = {one.name: one for one in parameters}
    for name in names:
        if name not in by_name:
            near = difflib.get_close_matches(name, by_name, 1)
            return f"there is no argument '{name}'" + (f", but '{near[0]}'" if near else "")
    in_order = [one for one in parameters if one.by_place]
    if len(places) > len(in_order):
        return f"{len(places)} arguments are given by place, {len(in_order)} may be"
    given = {one.name: kind for one, kind in zip(in_order, places)}
    for name in names:
        if name in given:
            return f"'{name}' is given twice"
    given |= names
    missing = [one.name for one in parameters if one.needed and one.name not in given]
    if missing:
        return "missing: " + ", ".join(missing)
    wrong = [f"'{name}' is of type {kind}" for name, kind in given.items() if not _may_be(kind, by_name[name].type)]
    return ", ".join(wrong) or "given are " + ", ".join(f"{name}: {kind}" for name, kind in given.items())


def _may_be(kind: str, wanted: str) -> bool:
    """Whether an argument of this type may be right, roughly: what can be converted is known to the binding alone."""
    if kind in ("None", "NoneType"):
        return "None" in wanted or not wanted
    if not wanted or any(word in wanted for word in ("Any", "object", "ArrayLike", "Sequence")):
        return True
    kinds = [one.strip().split("[")[0].rpartition(".")[2] for one in wanted.split("|")]
    return kind.rpartition(".")[2] in kinds or (kind in ("int", "bool") and "float" in kinds)
