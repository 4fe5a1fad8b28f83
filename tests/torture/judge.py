"""What a run of the program may leave behind: its status, its words, its file."""

import json
import math
import re
import struct

NOT_FINITE = re.compile(r"(?<![A-Za-z_'])[-+]?(?:nan|inf|infinity)(?![A-Za-z_'])", re.I)
LONGEST_MESSAGE = 1020
MOST_SECONDS = 10.0
ROUNDING_OF_PHASE = 1e-33  # of two doubles
LEAST_ERROR_RAD = 1e-17  # smaller than the rounding of one quaternion


class Wrong(Exception):
    """What is wrong with a file that was written."""


def finite(text):
    try:
        value = float(text)
    except ValueError:
        raise Wrong(f"not a number in a row: {text[:20]}") from None
    if not math.isfinite(value):
        raise Wrong("a row is not finite")
    return value


def check_unit(quaternion):
    if abs(math.fsum(v * v for v in quaternion) - 1.0) > 2e-12:
        raise Wrong("a quaternion is not a unit one")


def check_promise(text, promised):
    """An error in rad, or None where the file says nothing; says it that nothing is promised, that is enough."""
    if promised is None:
        if "nothing is promised" not in text:
            raise Wrong("no error is promised, and the file does not say that none is")
        return
    try:
        error = float(promised)
    except ValueError:
        raise Wrong(f"the promised error is no number: {promised[:20]}") from None
    if not math.isfinite(error) or error < 0.0:
        raise Wrong("the promised error is not finite or negative")
    if error < LEAST_ERROR_RAD:
        raise Wrong("the promised error is below what doubles allow")


def check_csv(text, motion):
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    names = lines[0].split(",")
    unit = [names.index(name) for name in ("q_x", "q_y", "q_z", "q_scalar")]
    for line in lines[1:]:
        cells = line.split(",")
        if len(cells) != len(names):
            raise Wrong("a row has too few or too many cells")
        values = [0.0] + [finite(cell) for name, cell in zip(names[1:], cells[1:]) if name != "frame"]
        check_unit([values[i] for i in unit])
    if motion and text.startswith("#"):
        found = re.search(r"promised_error_rad: ([^}\s]+)", text)
        check_promise(text, found and found[1])
        found = re.search(r"interpolation_error_rad: ([^}\s]+)", text)
        if found:
            check_promise(text, found[1])
    return len(lines) - 1


def check_aem(text, motion):
    rows = 0
    kind = None
    in_data = False
    for line in text.splitlines():
        if line.startswith("ATTITUDE_TYPE"):
            kind = line.split("=")[1].strip()
        elif line in ("DATA_START", "DATA_STOP"):
            in_data = line == "DATA_START"
        elif in_data:
            rows += 1
            values = [finite(word) for word in line.split()[1:]]
            if kind.startswith("QUATERNION"):
                check_unit(values[:4])
    if rows == 0:
        raise Wrong("the message has no rows")
    check_aem_promise(text, motion)
    return rows


def check_xml(text, motion):
    rows = re.findall("<attitudeState>(.*?)</attitudeState>", text)
    if not rows or not text.rstrip().endswith("</aem>"):
        raise Wrong("the message has no rows, or no end")
    for row in rows:
        numbers = [finite(value) for value in re.findall(r"<(?!EPOCH)[A-Za-z0-9_]+>([^<]+)<", row)]
        if "<QC>" in row:
            check_unit(numbers[:4])
    check_aem_promise(text, motion)
    return len(rows)


def check_aem_promise(text, motion):
    if not motion:
        return
    found = re.search(r"romised error of the rows:? (\S+) rad", text)
    check_promise(text, found and found[1])
    found = re.search(r"Between rows, .*: within (\S+) rad", text)
    if found:
        check_promise(text, found[1])


def fits_header(content, at):
    cards = {}
    text = []
    while True:
        card = content[at : at + 80].decode("ascii")
        at += 80
        text.append(card)
        if card.startswith("END "):
            return cards, "\n".join(text), (at + 2879) // 2880 * 2880
        if len(card) < 80:
            raise Wrong("the header has no end")
        if card[8:10] == "= ":
            cards[card[:8].strip()] = card[10:].split(" /")[0].strip()


def check_fits(content, motion):
    if len(content) % 2880 != 0:
        raise Wrong("the length is not one of FITS")
    _, _, at = fits_header(content, 0)
    cards, text, at = fits_header(content, at)
    rows, width = int(cards["NAXIS2"]), int(cards["NAXIS1"])
    for key, value in cards.items():
        if NOT_FINITE.search(value) and not value.startswith("'"):
            raise Wrong(f"the header's {key} is not finite")
    if len(content) < at + rows * width:
        raise Wrong("there are less rows than the header says")
    greatest_rate = 0.0
    for row in range(rows):
        values = struct.unpack_from(f">{width // 8}d", content, at + row * width)
        if not all(map(math.isfinite, values)):
            raise Wrong("a row is not finite")
        check_unit(values[1:5])
        greatest_rate = max(greatest_rate, *map(abs, values[5:8]))
    if motion:
        phase_rad = greatest_rate * abs(float(cards["TSTOP"]) - float(cards["TSTART"]))
        if "MAXERR" in cards and float(cards["MAXERR"]) < ROUNDING_OF_PHASE * phase_rad:
            raise Wrong("the promised error is below the rounding of the phase")
        check_promise(text, cards.get("MAXERR"))
        if "INTERERR" in cards:
            check_promise(text, cards["INTERERR"])
    return rows


def check_file(name, content, motion):
    """The number of rows; raises Wrong."""
    if name.endswith(".fits"):
        return check_fits(content, motion)
    text = content.decode("utf-8", "replace")
    if name.endswith(".aem"):
        return check_aem(text, motion)
    if name.endswith(".xml"):
        return check_xml(text, motion)
    return check_csv(text, motion)


def output_of(command):
    """The file that a command line writes, if it is as the seeds have it."""
    for option in ("-o", "--output"):
        if option in command[:-1]:
            return command[command.index(option) + 1]
    return None


def check_standard_output(command, text):
    """Words for what is not finite."""
    if command[0] == "info" and "--json" in command:
        try:
            reports = json.loads(text)
        except ValueError:
            return "the JSON is malformed"
        found = []

        def look(value, path):
            if isinstance(value, dict):
                for key, item in value.items():
                    look(item, key)
            elif isinstance(value, list):
                for item in value:
                    look(item, path)
            elif value is None or (isinstance(value, float) and not math.isfinite(value)):
                found.append(path)

        look(reports, "")
        motion = reports[0].get("motion", {})
        if motion.get("separatrix_distance") == 0.0:
            found = [key for key in found if not key.endswith("period_s")]
        return f"not finite in JSON: {found[0]}" if found else None
    if command[0] == "info":
        kept = [line for line in text.split("\n")[1:] if not re.match(r"  (file|source) |note: |warning: |Attitude hist", line)]
        if re.search("infinite", "\n".join(kept)) and "distance from separatrix          0 " not in text:
            return "infinite: " + next(line for line in kept if "infinite" in line)[:20].strip()
        text = "\n".join(kept)
    if command[0] == "plan":
        text = "\n".join(text.splitlines()[1:])
    if command[0] == "methods":
        return None
    match = NOT_FINITE.search(text)
    if match:
        line = text[text.rfind("\n", 0, match.start()) + 1 : match.start()]
        return "not finite on standard output" + (f": {line.split()[0]}" if command[0] in ("plan", "info") and line.split() else "")
    return None


def check_message(text, arguments_only):
    """Words for what is wrong with the message of a refusal."""
    lines = text.removesuffix("\n").split("\n")
    if not text:
        return "no message"
    if arguments_only and "--help for more" in text:
        return None  # a wrong use of the command line
    if len(lines[-1]) > LONGEST_MESSAGE:
        return "a message of more than 1000 characters"
    if not all(line.startswith("polhode: ") for line in lines):
        return "a message of several lines"
    if "std::" in lines[-1] or "bad_alloc" in lines[-1]:
        return "a message of the C++ library"
    return None


def names_origin(text, names, command):
    """Whether a message says where the fault is: in a file that was read, or in the option of the command that it begins with."""
    last = text.removesuffix("\n").split("\n")[-1]  # a name may hold what Unicode calls the end of a line
    option = re.match(r"polhode: (--[a-z0-9-]+)", last)
    return any(name in last for name in names) or (option is not None and option[1] in command)


def judge(run):
    """What is wrong with a run, in words; an empty list if nothing is."""
    wrong = []
    if run.killed and run.command[0] == "chart" and float(run.command[-1]) > 0.1:
        return wrong  # --size asks for more work
    if run.status < 0:
        wrong.append(f"signal {-run.status}" if not run.killed else "over 10 s")
    elif run.status > 3:
        wrong.append(f"status {run.status}")
    if run.cpu_s > MOST_SECONDS and not run.killed:
        wrong.append("over 10 s")
    if any(name.startswith(".polhode-") for name in run.left):
        wrong.append("a hidden file is left")
    output = output_of(run.command)
    names = {"standard input", *run.seed.files, *(name.rsplit("/", 1)[-1] for name in run.seed.files)}
    if run.status == 0:
        found = check_standard_output(run.command, run.stdout)
        if found:
            wrong.append(found)
        if output in run.left and re.search(r"\.(csv|fits|aem|xml|ecsv)$", output):
            try:
                rows = check_file(output, run.left[output], run.seed.motion)
                counts = [run.command[i + 1] for i, word in enumerate(run.command) if word == "--count"]
                if len(counts) == 1 and run.seed.target and rows % int(counts[0]) != 0:  # a history has them by segment
                    wrong.append("another number of rows than asked for")
            except Wrong as problem:
                wrong.append(f"{problem} ({output.rsplit('.', 1)[-1]})")
            except (ValueError, KeyError, IndexError, UnicodeDecodeError, struct.error) as problem:
                wrong.append(f"the file cannot be read: {problem!r:.60}")
        elif output and run.command[0] == "propagate":
            wrong.append("status 0 and no file")
    else:
        if output in run.left and run.command[0] == "propagate":
            wrong.append(f"status {run.status} and yet a file")
        if run.status == 2 and run.stdout:
            wrong.append("status 2 and yet words on standard output")
        if run.status in (1, 2, 3):
            found = check_message(run.stderr, not run.seed.target)
            if not found and run.status == 2 and run.seed.target and not names_origin(run.stderr, names, run.command):
                found = "the message names no file and no option"
            if found:
                wrong.append(f"status {run.status}: {found}")
    return wrong
