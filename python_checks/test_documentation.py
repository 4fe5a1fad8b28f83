"""README and manual do what they say: commands print what stands there, files are read, links lead somewhere.

How a page is written, so that it can be run:

    ```console    `$ COMMAND` lines, each followed by what it prints, standard error included. A line `...` stands for
                  any lines, `…` within a line for any text; the rest must match letter by letter. A command with
                  nothing below it may print anything. A line that ends in a backslash goes on in the next. A command
                  must succeed, unless the next one is `echo $?`.
    ```toml       a whole body or scene, or orbital elements; its first line is a comment with the name of the file
    ```python     runs as it stands; a comment after `print(…)` is what that prints
    ```cpp        a program of tests/install/consumer, which the test `install` compiles
    ```text, or indented by four columns: patterns of commands, formulas, pieces of files; commands and options in them
                  must exist

The blocks of a page are run in order, in one folder that has `data`, `tools` and `build/bin` of the source tree.
"""

import functools
import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from support import PROGRAM, ROOT

MANUAL = ROOT / "tools/manual"
PAGES = [ROOT / "README.md", *sorted(MANUAL.glob("*.md"))]
DERIVATIONS = sorted((ROOT / "lib").rglob("*.md"))
LANGUAGES = {"console", "toml", "python", "cpp", "text", "cmake", "mermaid"}

# Commands that are not run as they stand, because they take longer than ten seconds or change the machine. What is run
# instead, or None where only the existence of the command and its options is checked.
BUILDS = "builds the project"
CHART = "measures for minutes"
LONG = {
    "tools/setup": (BUILDS, None),
    "tools/demo": (BUILDS, None),
    "tools/test": (BUILDS, None),
    "tools/test --all": (BUILDS, None),
    "tools/docs": (BUILDS, None),
    "tests/systems/bare_system.sh trixie": ("installs a system", None),
    "cmake --preset dev": (BUILDS, "cmake --list-presets -S {root} | grep -w dev"),
    "cmake --build --preset dev": (BUILDS, None),
    "ctest --preset dev": (BUILDS, None),
    "ctest --preset dev -R InputFormats": (BUILDS, "grep -r 'TEST(InputFormats,' {root}/tests"),
    "build/venv/bin/python -m pytest -q -p no:cacheprovider python_checks/test_info.py": ("is a test of its own", None),
    "polhode chart speed-accuracy data/bodies/toutatis.toml@7305d data/bodies/t-handle.toml@166s -o charts": (
        CHART + "; numerical-analysis.md has a smaller one",
        None,
    ),
    "polhode chart torqued data/scenes/envisat-month.toml@3d -o charts": (
        CHART + "; the page has a smaller one",
        None,
    ),
    "polhode chart stability -o charts": (CHART, "polhode chart stability --help"),
    "polhode fit data/scenes/toutatis-1992-2008.toml data/observations/toutatis-radar-attitudes.csv -o fitted.toml --residuals residuals.csv": (
        "takes seconds of many propagations; test_fit.py fits it",
        None,
    ),
    "polhode plot charts/torqued.ecsv": ("takes seconds; test_chart.py draws one", None),
    "polhode plot charts/stability.ecsv": ("needs the table of a long command; test_chart.py draws one", None),
    "polhode plot toutatis.fits -o toutatis.png": ("takes seconds; test_plot.py draws it", None),
}
OTHER_OPTIONS = {"cmake": {"--preset", "--build", "--install", "--list-presets"}, "ctest": {"--preset"}}


@dataclass
class Block:
    """A block of code of a page; `line` is the number of its first line."""

    page: Path
    line: int
    language: str
    lines: list = field(default_factory=list)

    def where(self, offset=0):
        return f"{self.page.relative_to(ROOT)}:{self.line + offset}"


@dataclass
class Command:
    text: str
    where: str
    output: list = field(default_factory=list)


def blocks_of(page):
    """The fenced blocks and, as `text`, those indented by four columns."""
    blocks, block, before = [], None, ""
    for number, line in enumerate(page.read_text().splitlines(), 1):
        fence = re.match(r"\s*```(\w*)$", line)
        if block and block.language != "indented":
            if fence:
                blocks.append(block)
                block = None
            else:
                block.lines.append(line)
        elif fence:
            if block:
                blocks.append(block)
            block = Block(page, number + 1, fence[1])
        elif line.startswith("    ") and (block or not before.strip()):
            block = block or Block(page, number, "indented")
            block.lines.append(line[4:])
        elif block and line.strip():
            blocks.append(block)
            block = None
        before = line
    assert block is None or block.language == "indented", f"{page}: a block without an end"
    return blocks + ([block] if block else [])


def commands_of(block):
    commands = []
    for offset, line in enumerate(block.lines):
        if line.startswith("$ "):
            commands.append(Command(line[2:], block.where(offset)))
        else:
            assert commands, f"{block.where(offset)}: a console block begins with a command"
            if commands[-1].text.endswith("\\") and not commands[-1].output:
                commands[-1].text = commands[-1].text[:-1].rstrip() + " " + line.strip()
            else:
                commands[-1].output.append(line)
    for command in commands:
        command.text = re.sub(r"\s+#\s.*", "", command.text)
        while command.output and not command.output[-1].strip():
            command.output.pop()
    return commands


def expected_text(lines):
    """A pattern of what is printed: whole lines, `...` for any number of them, `…` for a part of one."""
    return "".join(
        r"(?:.*\n)*?" if line.strip() == "..." else ".*?".join(map(re.escape, line.rstrip().split("…"))) + r"\n"
        for line in lines
    )


@functools.cache
def help_of(*command):
    result = subprocess.run([*command, "--help"], capture_output=True, text=True, env=environment(ROOT))
    assert result.returncode == 0, f"{command}: {result.stderr}"
    return result.stdout


def options_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", text))


@functools.cache
def subcommands(*command):
    """The names of the subcommands with the options of each, those of their own subcommands included."""
    listed = re.search(r"^Subcommands:\n((?:  .*\n)+)", help_of(PROGRAM, *command), re.M)
    names = re.findall(r"^  (\S+)  ", listed[1], re.M) if listed else []
    return {
        name: options_in(help_of(PROGRAM, *command, name)).union(*subcommands(*command, name).values())
        for name in names
    }


def scripts():
    """The programs of the source tree that are not `polhode`, each with its options."""
    options = {}
    for name in ("tools/test", "tools/setup", "tools/demo", "tools/docs", "tests/systems/bare_system.sh"):
        options[name] = options_in((ROOT / name).read_text())
    return options


def environment(folder):
    here = {**os.environ, "POLHODE": str(PROGRAM), "MPLBACKEND": "Agg"}
    here["PATH"] = f"{folder}/build/bin:{Path(sys.executable).parent}:{os.environ['PATH']}"
    return here


@pytest.fixture
def folder(tmp_path):
    """Where the commands of a page are typed."""
    (tmp_path / "build/bin").mkdir(parents=True)
    (tmp_path / "build/bin/polhode").symlink_to(PROGRAM)
    for name in ("data", "tools"):
        (tmp_path / name).symlink_to(ROOT / name)
    return tmp_path


def shell(command, folder, status=0):
    """The command in a shell in which the last one ended with this status."""
    return subprocess.run(
        ["bash", "-c", f"(exit {status})\n{command}"],
        cwd=folder,
        env=environment(folder),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def run_console(block, folder):
    commands = commands_of(block)
    status = 0
    for command, following in zip(commands, [*commands[1:], None]):
        if command.text in LONG:
            instead = LONG[command.text][1]
            if instead is not None:
                result = shell(instead.format(root=ROOT), folder)
                assert result.returncode == 0, f"{command.where}: {instead}\n{result.stdout}"
            continue
        result = shell(command.text, folder, status)
        status = result.returncode
        if following is None or following.text != "echo $?":
            assert status == 0, f"{command.where}: $ {command.text}\nends with status {status}:\n{result.stdout}"
        if not command.output:
            continue
        printed = "".join(line.rstrip() + "\n" for line in result.stdout.splitlines())
        assert re.fullmatch(expected_text(command.output), printed), (
            f"{command.where}: $ {command.text}\nprints\n{printed}\nwhere the page has\n" + "\n".join(command.output)
        )


def run_toml(block, folder):
    name = re.fullmatch(r"# ([\w-]+\.toml)", block.lines[0])
    assert name, f"{block.where()}: the first line of a file is a comment with its name"
    (folder / name[1]).write_text("\n".join(block.lines) + "\n")
    is_scene = any(line.startswith("body = ") for line in block.lines)
    command = f"polhode {'plan' if is_scene else 'info'} {name[1]}"
    if not is_scene and any(line.startswith("eccentricity = ") for line in block.lines):
        command = f"polhode observe data/bodies/toutatis.toml --target {name[1]} --start '2013-01-01 TDB' --count 1 -o -"
    result = shell(command, folder)
    assert result.returncode == 0, f"{block.where()}: {result.stdout}"


def run_python(block, folder):
    result = subprocess.run(
        [sys.executable, "-c", "\n".join(block.lines)],
        cwd=folder,
        env=environment(folder),
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, f"{block.where()}: {result.stderr}"
    printed = [line.partition("  # ")[2] for line in block.lines if line.startswith("print(")]
    if any(printed):
        assert re.fullmatch(expected_text(printed), result.stdout), f"{block.where()} prints\n{result.stdout}"


def check_cpp(block, _):
    """The programs of tests/install/consumer are compiled and run by the test `install`."""
    programs = [path.read_text().splitlines() for path in (ROOT / "tests/install/consumer").glob("*.cpp")]
    assert block.lines in programs, f"{block.where()}: no program of tests/install/consumer"


RUN = {"console": run_console, "toml": run_toml, "python": run_python, "cpp": check_cpp}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_does_what_it_says(page, folder):
    for block in blocks_of(page):
        if block.language in RUN:
            RUN[block.language](block, folder)
        else:
            assert block.language in LANGUAGES | {"indented"}, f"{block.where()}: a block of '{block.language}'"


def test_every_long_command_stands_somewhere():
    printed = {c.text for page in PAGES for b in blocks_of(page) if b.language == "console" for c in commands_of(b)}
    assert set(LONG) <= printed, set(LONG) - printed


def code_of(page):
    """Lines of code that a reader might type: of blocks, and spans in backquotes; with their places."""
    for block in blocks_of(page):
        if block.language == "console":
            yield from ((command.where, command.text) for command in commands_of(block))
        elif block.language in ("text", "indented"):
            yield from ((block.where(offset), line) for offset, line in enumerate(block.lines))
    prose = re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), page.read_text(), flags=re.M | re.S)
    for span in re.finditer(r"`([^`]+)`", prose):
        yield f"{page.relative_to(ROOT)}:{prose[: span.start()].count(chr(10)) + 1}", span[1]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_subcommands_and_options_exist(page):
    known = subcommands()
    programs = {**scripts(), **OTHER_OPTIONS}
    all_options = options_in(help_of(PROGRAM)).union(*known.values(), *programs.values())
    for where, line in code_of(page):
        for part in re.split(r"[|;&]", line):
            call = re.match(r"\s*polhode ([a-z][a-z-]*)(.*)", part)
            script = re.match(r"\s*(\S+)(.*)", part)
            if call:
                assert call[1] in known, f"{where}: no subcommand {call[1]}"
                assert options_in(call[2]) <= known[call[1]], f"{where}: {options_in(call[2]) - known[call[1]]}"
                if subcommands(call[1]) and (kind := re.match(r" ([a-z][a-z-]+)", call[2])):
                    assert kind[1] in subcommands(call[1]), f"{where}: no subcommand {call[1]} {kind[1]}"
            elif script and script[1] in programs:
                assert options_in(script[2]) <= programs[script[1]], f"{where}: {options_in(script[2])}"
    assert options_in(page.read_text()) <= all_options, options_in(page.read_text()) - all_options


def test_the_examples_of_help_run(folder):
    """Where the files that they read are those of the source tree; charts take minutes."""
    ran = 0
    for name, options in subcommands().items():
        for command in re.findall(r"^  (.*polhode .*)$", help_of(PROGRAM, name).partition("Examples:\n")[2], re.M):
            assert options_in(command) <= options, f"{name}: {command}"
            read = re.findall(r"(?<!-o )(?<!\S)\S+\.(?:toml|case|aem|fits|csv|txt|part)\b", command)
            if name != "chart" and all(list(folder.glob(file)) for file in read):
                result = shell(command, folder)
                assert result.returncode == 0, f"{command}\n{result.stdout}"
                ran += 1
    assert ran >= 8


def test_the_readme_lists_every_subcommand():
    listed = {name for _, line in code_of(PAGES[0]) for name in re.findall(r"^polhode ([a-z-]+)", line)}
    assert listed == set(subcommands())


def prose_of(page):
    return re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)


def anchors_of(page):
    """As GitHub names headings: lower case, without punctuation, blanks as hyphens."""
    headings = re.findall(r"^#+ (.+)$", prose_of(page), re.M)
    texts = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings]
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in texts}


def links_of(page):
    """Pages, pictures and files that a page links to, with their anchors."""
    for target in re.findall(r"\]\(([^)\s]+)\)", prose_of(page)):
        if not re.match(r"\w+://", target):
            path, _, anchor = target.partition("#")
            yield target, (page.parent / path).resolve() if path else page, anchor


@pytest.mark.parametrize("page", [*PAGES, *DERIVATIONS], ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target, path, anchor in links_of(page):
        assert path.exists(), f"{page.name} links to {target}"
        assert not anchor or anchor in anchors_of(path), f"{page.name} links to {target}; there are {anchors_of(path)}"


@pytest.mark.parametrize("page", [*PAGES, *DERIVATIONS], ids=lambda page: page.name)
def test_files_that_are_named_exist(page):
    for name in re.findall(r"(?<![\w./-])(?:lib|tests|tools|data|python_checks)/[\w./*-]*[\w*/]", page.read_text()):
        assert list(ROOT.glob(name.rstrip("/"))), f"{page.name} names {name}"


def test_every_page_is_reached_from_the_index():
    reached, ahead = set(), [MANUAL / "index.md"]
    while ahead:
        page = ahead.pop()
        if page not in reached:
            reached.add(page)
            ahead += [path for _, path, _ in links_of(page) if path.suffix == ".md"]
    wanted = {*PAGES[1:], *DERIVATIONS}
    assert wanted <= reached, wanted - reached
