"""Body files and scenes as TOML: read with their numbers as published, and written."""

from __future__ import annotations

import math
import re
from pathlib import Path

from .._errors import FileError, InputError


def read_toml(path):
    """The tables of a TOML file, or None where the file is none."""
    try:
        import tomllib
    except ModuleNotFoundError:  # before Python 3.11
        import tomli as tomllib
    try:
        return tomllib.loads(Path(path).read_bytes().decode())
    except (UnicodeDecodeError, tomllib.TOMLDecodeError):
        return None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None


def plain_text(text):
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + re.sub(r"[\x00-\x1f\x7f]", lambda c: f"\\u{ord(c[0]):04x}", escaped) + '"'


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return plain_text(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise InputError(f"a body file holds no {value}")
        return repr(float(value))
    if isinstance(value, (list, tuple)):
        if value and isinstance(value[0], (list, tuple)):
            return "[\n" + "".join(f"  {toml_value(row)},\n" for row in value) + "]"
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    return repr(value)


def toml_key(key):
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else plain_text(key)


def toml_text(tables, comments=(), prefix=""):
    """`comments` are lines that stand at the top."""
    lines = [f"# {comment}" for comment in comments]
    for key, value in tables.items():
        if not isinstance(value, dict) and not (isinstance(value, list) and value and isinstance(value[0], dict)):
            lines.append(f"{toml_key(key)} = {toml_value(value)}")
    for key, value in tables.items():
        name = prefix + toml_key(key)
        if isinstance(value, dict):
            if any(not isinstance(item, dict) for item in value.values()):
                lines += ["", f"[{name}]"]
            lines.append(toml_text(value, prefix=name + ".").rstrip("\n"))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for item in value:
                lines += ["", f"[[{name}]]", toml_text(item, prefix=name + ".").rstrip("\n")]
    return "\n".join(lines) + "\n"
