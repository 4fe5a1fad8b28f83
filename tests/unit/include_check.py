"""Holds the library to its data flow: include_check.py LIB_DIR COMPILER [FLAG...]

- No folder of LIB_DIR/polhode includes upwards (ALLOWED below).
- Wrapped libraries are included by .cpp files only, so that users of our headers need none of them.
- Every header compiles on its own. One that comes first in the .cpp of the same name has shown that in the build; the
  others are compiled here, with COMPILER FLAG....
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

UPWARDS = ["base", "elliptic", "time", "frames", "body", "torque", "motion"]
BODY_AND_BELOW = UPWARDS[: UPWARDS.index("body") + 1]
# What each folder may include: whole folders, or single headers with plain structs.
ALLOWED = {folder: UPWARDS[: i + 1] for i, folder in enumerate(UPWARDS)} | {
    "survey": UPWARDS + ["survey"],
    "ephemeris": BODY_AND_BELOW + ["ephemeris"],
    "read": BODY_AND_BELOW + ["torque", "ephemeris", "read", "motion/motion.hpp"],
    "write": BODY_AND_BELOW + ["ephemeris", "write"],
}
WRAPPED = re.compile(r"(erfa\w*\.h|fitsio\d?\.h|toml\+\+/.*|pugixml\.hpp|nlohmann/.*|CLI/.*|sundials/.*)")
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)


def faults(path, text):
    """The rules that a file breaks. `path` is relative to LIB_DIR: polhode/FOLDER/NAME."""
    folder = path.parts[1]
    for bracket, include in INCLUDE.findall(text):
        if include.startswith("polhode/"):
            other = include.removeprefix("polhode/")
            if folder not in ALLOWED:
                yield f"{path}: the folder {folder} is not in include_check.py"
            elif other.split("/")[0] not in ALLOWED[folder] and other not in ALLOWED[folder]:
                yield f"{path}: {folder} may not include {include}"
        elif bracket == '"':
            yield f'{path}: "{include}" is not written as "polhode/FOLDER/NAME"'
        elif path.suffix == ".hpp" and WRAPPED.fullmatch(include):
            yield f"{path}: {include} belongs in a .cpp file"


def check_the_rules():
    """Each rule finds the fault that it is for."""
    for path, text, wrong in [
        ("polhode/motion/a.cpp", '#include "polhode/body/body.hpp"', False),
        ("polhode/body/a.hpp", '#include "polhode/motion/motion.hpp"', True),
        ("polhode/read/a.hpp", '#include "polhode/motion/motion.hpp"', False),
        ("polhode/read/a.cpp", '#include "polhode/motion/methods.hpp"', True),
        ("polhode/write/a.cpp", '#  include "polhode/motion/motion.hpp"', True),
        ("polhode/time/a.cpp", "#include <erfa.h>", False),
        ("polhode/time/a.hpp", "#include <erfa.h>", True),
        ("polhode/read/a.hpp", "#include <toml++/toml.h>", True),
        ("polhode/base/a.cpp", '#include "error.hpp"', True),
        ("polhode/nowhere/a.cpp", '#include "polhode/base/error.hpp"', True),
    ]:
        assert bool(list(faults(pathlib.Path(path), text))) == wrong, (path, text)


def shown_by_the_build(lib, header):
    """True if the .cpp of the same name includes `header` before all else."""
    source = lib / header.with_suffix(".cpp")
    first = INCLUDE.search(source.read_text()) if source.exists() else None
    return first is not None and first.group(2) == header.as_posix()


def main():
    check_the_rules()
    lib, compiler = pathlib.Path(sys.argv[1]), sys.argv[2:]
    paths = sorted(p.relative_to(lib) for p in lib.glob("polhode/*/**/*") if p.suffix in (".hpp", ".cpp"))
    found = [fault for path in paths for fault in faults(path, (lib / path).read_text())]

    def compiles(header):
        run = subprocess.run(
            [*compiler, f"-I{lib}", "-fsyntax-only", "-x", "c++", "-include", header, "/dev/null"],
            capture_output=True, text=True,
        )
        return [] if run.returncode == 0 else [f"{header} does not compile on its own:\n{run.stderr}"]

    headers = [p for p in paths if p.suffix == ".hpp"]
    alone = [h for h in headers if not shown_by_the_build(lib, h)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for result in pool.map(compiles, alone):
            found += result
    print(f"{len(paths)} files, {len(headers)} headers of which {len(alone)} compiled here, {len(found)} faults")
    sys.exit("\n".join(found) if found or not headers else 0)


main()
