"""`python -m polhode`, and the command `polhode` where the package is installed: the program."""

from __future__ import annotations

import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "polhode"


def main() -> None:
    """Goes on as the program, with the same arguments."""
    os.execv(PROGRAM, [str(PROGRAM), *sys.argv[1:]])


if __name__ == "__main__":
    main()
