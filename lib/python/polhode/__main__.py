"""`python -m polhode`, and the command `polhode` where the package is installed: the program and what it has in Python."""

from __future__ import annotations

import importlib
import os
import sys

from . import _program

# Subcommands: modules of this package with a main(arguments).
IN_PYTHON = {"animate": "animate", "fit": "fitting", "look": "look", "plot": "plot", "spice": "spice"}


def main() -> None:
    """Goes on as the program, with the same arguments, unless they ask for what is written in Python."""
    if len(sys.argv) > 1 and sys.argv[1] in IN_PYTHON:
        from . import _files

        def ask() -> None:
            importlib.import_module(f"polhode.{IN_PYTHON[sys.argv[1]]}").main(sys.argv[2:])

        _files.run(ask)
        return
    os.execve(_program.PATH, [str(_program.PATH), *sys.argv[1:]], _program.environment())


if __name__ == "__main__":
    main()
