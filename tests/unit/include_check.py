"""Holds the library and its rivals to their data flow: include_check.py LIB_DIR COMPILER [FLAG...]

- No folder of LIB_DIR/polhode includes upwards (ALLOWED below); LIB_DIR/rivals includes the library, the library nothing
  of it.
- lib/python, the Python package, includes the library and its own headers.
- Public headers, those of the patterns in LIB_DIR/public_headers.txt, include public ones only, and
  tools/manual/library.md lists the patterns.
- Wrapped libraries are included by .cpp files only, so that users of our headers need none of them.
- One name for each thing: what a header calls a type is no other type in LIB_DIR, no type or function hides one of a
  namespace around it, and no header of the rivals is called as one of the library.
- Every header compiles on its own. One that comes first in the .cpp of the same name has shown that in the build; the
  others are compiled here, with COMPILER FLAG....
"""

import collections
import concurrent.futures
import fnmatch
import os
import pathlib
import re
import subprocess
import sys

UPWARDS = ["base", "elliptic", "time", "frames", "body", "torque", "motion"]
BODY_AND_BELOW = UPWARDS[: UPWARDS.index("body") + 1]
# What each folder may include: whole folders, or single headers with plain structs.
ALLOWED = {folder: UPWARDS[: i + 1] for i, folder in enumerate(UPWARDS)} | {
    "ephemeris": BODY_AND_BELOW + ["ephemeris"],
    "read": BODY_AND_BELOW + ["torque", "ephemeris", "read", "motion/motion.hpp"],
    "write": BODY_AND_BELOW + ["ephemeris", "write"],
    "rivals": UPWARDS + ["rivals"],
    "rivals/survey": UPWARDS + ["rivals", "rivals/survey"],
    "observe": UPWARDS + ["ephemeris", "observe"],
    "session": UPWARDS + ["ephemeris", "observe", "read", "write", "session"],
    "python": UPWARDS + ["ephemeris", "observe", "read", "write", "session", "python"],
}
WRAPPED = re.compile(r"(erfa\w*\.h|fitsio\d?\.h|toml\+\+/.*|pugixml\.hpp|nlohmann/.*|CLI/.*|sundials/.*|boost/.*)")
NAMELESS = {("polhode/write/fits_file.hpp", "fitsio.h")}  # cfitsio's handle has no name to declare it by
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)


def folder_of(path):
    """Of polhode/FOLDER/.../NAME the FOLDER; rivals and rivals/survey go by both parts."""
    parts = pathlib.PurePosixPath(path).parts
    return parts[1] if parts[0] == "polhode" else "/".join(parts[:-1])


def faults(path, text):
    """The rules about includes that a file breaks. `path` is relative to LIB_DIR."""
    folder = folder_of(path.as_posix())
    for bracket, include in INCLUDE.findall(text):
        if include.startswith(("polhode/", "rivals/", "python/")):
            if folder not in ALLOWED:
                yield f"{path}: the folder {folder} is not in include_check.py"
            elif folder_of(include) not in ALLOWED[folder] and include.removeprefix("polhode/") not in ALLOWED[folder]:
                yield f"{path}: {folder} may not include {include}"
        elif bracket == '"':
            yield f'{path}: "{include}" is not written as "polhode/FOLDER/NAME" or "rivals/NAME"'
        elif path.suffix == ".hpp" and WRAPPED.fullmatch(include) and (str(path), include) not in NAMELESS:
            yield f"{path}: {include} belongs in a .cpp file"


def faults_of_public(patterns, includes, manual):
    """The rules about public headers that are broken; `includes` lists what each header of the library includes."""
    headers = {path for path in includes if path.endswith(".hpp")}
    public = {header for header in headers for pattern in patterns if fnmatch.fnmatchcase(header, pattern)}
    for pattern in patterns:
        if not fnmatch.filter(headers, pattern):
            yield f"public_headers.txt: there is no {pattern}"
        if f"`{pattern.removeprefix('polhode/')}`" not in manual:
            yield f"{pattern} is public and missing in tools/manual/library.md"
    for header in sorted(public):
        for include in includes[header]:
            if include.startswith("polhode/") and include not in public:
                yield f"{header} is public and includes {include}, which public_headers.txt does not have"


NAMESPACE = re.compile(r"^(?:inline )?namespace ?([\w:]*) ?\{")
TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)(?: final)?(?: : [^{;]*)? ?\{")
FUNCTION = re.compile(
    r"^(?!return|using|namespace|template|typedef|static_assert|extern template|else)(?:[\w:<>,*&\[\]]+ )+[*&]*(\w+)\("
)


def names(path, text):
    """What a file defines outside of classes: (namespace, name, whether it is a type)."""
    inside = []
    for line in text.splitlines():
        if begin := NAMESPACE.match(line):
            inside.append(begin.group(1) or f"unnamed in {path}")
        elif line.startswith("}  // namespace") and inside:
            inside.pop()
        elif found := TYPE.match(line) or FUNCTION.match(line):
            yield "::".join(inside), found.group(1), found.re is TYPE


def confusions(texts):
    """The rules about names that files, texts by their paths, break together."""
    homes = collections.defaultdict(set)  # of a type's name
    places = collections.defaultdict(set)  # of a namespace's name, in headers
    for path, text in texts.items():
        for namespace, name, is_type in names(path, text):
            if is_type:
                homes[name].add(path)
            if path.suffix == ".hpp":
                places[namespace, name].add(path)
    for name, paths in homes.items():
        if len(paths) > 1 and any(path.suffix == ".hpp" for path in paths):
            yield f"there is more than one type {name}: {', '.join(sorted(map(str, paths)))}"
    library = {path.name for path in texts if path.parts[0] == "polhode" and path.suffix == ".hpp"}
    for path in texts:
        if path.parts[0] == "rivals" and path.name in library:
            yield f"{path} is called as a header of polhode"
    for (namespace, name), paths in places.items():
        around = namespace
        while "::" in around:
            around = around.rpartition("::")[0]
            if (around, name) in places:
                yield f"{min(paths)}: {namespace}::{name} hides {around}::{name} of {min(places[around, name])}"


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
        ("polhode/motion/a.cpp", '#include "rivals/registry.hpp"', True),
        ("rivals/a.cpp", '#include "polhode/motion/theta.hpp"', False),
        ("rivals/a.cpp", '#include "polhode/read/body.hpp"', True),
        ("rivals/a.cpp", '#include "rivals/survey/measure.hpp"', True),
        ("rivals/survey/a.cpp", '#include "rivals/registry.hpp"', False),
        ("python/a.cpp", '#include "polhode/write/fits.hpp"', False),
        ("python/a.cpp", '#include "rivals/registry.hpp"', True),
        ("polhode/write/a.cpp", '#include "python/python.hpp"', True),
        ("polhode/write/a.cpp", '#include "polhode/session/body_report.hpp"', True),
        ("polhode/observe/a.cpp", '#include "polhode/motion/motion.hpp"', False),
        ("polhode/observe/a.cpp", '#include "polhode/read/body.hpp"', True),
        ("polhode/motion/a.cpp", '#include "polhode/observe/sight.hpp"', True),
    ]:
        assert bool(list(faults(pathlib.Path(path), text))) == wrong, (path, text)
    for folder, others in ALLOWED.items():
        for other in others:
            assert other == folder or folder not in ALLOWED.get(other, []), f"{folder} and {other} are a circle"

    same_name = {pathlib.Path("polhode/body/a.hpp"): "", pathlib.Path("rivals/a.hpp"): ""}
    assert list(confusions(same_name))
    a = "namespace polhode {\nstruct A {\n};\nint f(double x);\n}  // namespace polhode\n"
    for path, text, wrong in [
        ("b.hpp", "namespace polhode {\nint f(int x);\nstruct A;\nstruct B {\n  int f();\n};\n", False),
        ("b.cpp", "namespace polhode {\nnamespace {\nstruct A final : B {\n};\n", True),
        ("b.hpp", "namespace polhode::rivals {\ninline const A* f(int x) {\n", True),
        ("b.hpp", "namespace polhode {\n}  // namespace polhode\nnamespace other {\nint f();\n", False),
    ]:
        assert bool(list(confusions({pathlib.Path("a.hpp"): a, pathlib.Path(path): text}))) == wrong, (path, text)


    public = {"polhode/a.hpp": ["polhode/b.hpp", "vector"], "polhode/b.hpp": []}
    assert not list(faults_of_public(["polhode/a.hpp", "polhode/b.hpp"], public, "`a.hpp`, `b.hpp`"))
    assert not list(faults_of_public(["polhode/*.hpp"], public, "`*.hpp`"))
    for patterns, manual in [(["polhode/a.hpp"], "`a.hpp`"), (["polhode/b.hpp"], ""), (["polhode/c.hpp"], "`c.hpp`")]:
        assert list(faults_of_public(patterns, public, manual)), patterns


def shown_by_the_build(lib, header):
    """True if the .cpp of the same name includes `header` before all else."""
    source = lib / header.with_suffix(".cpp")
    first = INCLUDE.search(source.read_text()) if source.exists() else None
    return first is not None and first.group(2) == header.as_posix()


def main():
    check_the_rules()
    lib, compiler = pathlib.Path(sys.argv[1]), sys.argv[2:]
    paths = sorted(p.relative_to(lib) for p in lib.glob("*/**/*") if p.suffix in (".hpp", ".cpp"))
    texts = {path: (lib / path).read_text() for path in paths}
    found = [fault for path, text in texts.items() for fault in faults(path, text)] + list(confusions(texts))
    includes = {path.as_posix(): [name for _, name in INCLUDE.findall(text)] for path, text in texts.items()}
    public = (lib / "public_headers.txt").read_text().split()
    found += faults_of_public(public, includes, (lib.parent / "tools/manual/library.md").read_text())

    def compiles(header):
        run = subprocess.run(
            [*compiler, f"-I{lib}", "-fsyntax-only", "-x", "c++", "-include", header, "/dev/null"],
            capture_output=True, text=True,
        )
        return [] if run.returncode == 0 else [f"{header} does not compile on its own:\n{run.stderr}"]

    headers = [p for p in paths if p.suffix == ".hpp"]
    alone = [h for h in headers if h.parts[0] != "python" and not shown_by_the_build(lib, h)]  # not without nanobind
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for result in pool.map(compiles, alone):
            found += result
    print(f"{len(paths)} files, {len(headers)} headers of which {len(alone)} compiled here, {len(found)} faults")
    sys.exit("\n".join(found) if found or not headers else 0)


main()
