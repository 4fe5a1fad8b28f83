"""`python -m polhode`, and the command `polhode` where the package is installed: the program and what it has in Python."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "polhode"
IN_PYTHON = ("look", "plot", "spice")  # modules of this package with a main(arguments)


def main() -> None:
    """Goes on as the program, with the same arguments, unless they ask for what is written in Python."""
    if len(sys.argv) > 1 and sys.argv[1] in IN_PYTHON:
        from . import _files

        def ask() -> None:
            importlib.import_module(f"polhode.{sys.argv[1]}").main(sys.argv[2:])

        _files.run(ask)
        return
    os.environ["POLHODE_PYTHON"] = sys.executable  # which the program asks for them
    os.execv(PROGRAM, [str(PROGRAM), *sys.argv[1:]])


if __name__ == "__main__":
    main()
