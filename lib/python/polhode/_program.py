"""The program that comes with the package, for what it alone can do: charts, benchmarks, rival methods."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ._errors import ComputationError, Error, FileError, InputError

if TYPE_CHECKING:
    import subprocess

PATH = Path(__file__).parent / "bin" / "polhode"
_BY_STATUS = {1: ComputationError, 2: InputError, 3: FileError}


def environment() -> dict[str, str]:
    """For the program, which asks this Python for `plot`, `animate` and `spice`."""
    return {**os.environ, "POLHODE_PYTHON": sys.executable}


def completed(*arguments: object, input: str | None = None) -> subprocess.CompletedProcess[str]:
    """The program `polhode`, run with these arguments, with `input` on its standard input, and what it printed. Raises
    InputError, FileError or ComputationError with what it says on standard error where it fails."""
    import subprocess

    try:
        done = subprocess.run(
            [PATH, *map(str, arguments)], input=input or "", capture_output=True, text=True, env=environment()
        )
    except FileNotFoundError:
        raise FileError(f"the program {PATH} is not there; the installed package brings it") from None
    if done.returncode != 0:
        text = done.stderr.strip().removeprefix("polhode: ") or f"polhode ended with the status {done.returncode}"
        raise _BY_STATUS.get(done.returncode, Error)(text)
    return done


def program(*arguments: object, input: str | None = None) -> str:
    """Runs the program `polhode` with these arguments, `input` on its standard input, and returns what it prints:
    `program("bench", "a.case")`. What it says on standard error is shown on this process's, unless it fails: then
    InputError, FileError or ComputationError is raised with that text."""
    done = completed(*arguments, input=input)
    sys.stderr.write(done.stderr)
    return done.stdout
