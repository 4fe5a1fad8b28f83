"""Numbers in files and arguments, found by a pattern and replaced by awkward ones; and damage that knows no format."""

import re
import struct

# A number, also one in a date or beside a unit, but not the digits of a name such as mu_m3_s2.
NUMBER = re.compile(
    rb"(?:(?<![A-Za-z_0-9.])[+-]|(?<![A-Za-z_0-9.])|(?<=[0-9]T)|(?<=[0-9]-)|(?<=[0-9],)|(?<=[0-9]:))"
    rb"(?:0[xX][0-9a-fA-F]+(?:\.[0-9a-fA-F]*)?(?:[pP][+-]?\d+)?|(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?)"
)

AWKWARD = (
    "nan", "-nan", "inf", "-inf", "infinity", "1e308", "-1e308", "1e-308", "1.7976931348623157e308", "5e-324",
    "-5e-324", "0", "-0", "-0.0", "1e300", "-1e300", "1e200", "1e154", "-1e154", "1e100", "1e-100", "1e-154", "1e-162",
    "1e-200", "1e-300", "1e38", "1e20", "-1e20", "1e16", "1e10", "1e-10", "1e-16", "1e-20", "-1", "1", "2", "0.5",
    "4294967295", "-2147483649", "9223372036854775807", "9223372036854775808", "18446744073709551615",
    "18446744073709551616", "1e400", "-1e400", "1e-400", "0x1p1023", "1_000", "010", "1.5e", "9" * 400,
)  # fmt: skip

WORDS = (
    b"nan", b"inf", b"1e308", b"5e-324", b"0", b"-1", b"", b"[", b"]", b"\"", b"'", b"#", b"=", b",", b"\n", b"\0",
    b"\xff\xfe", b"\xc2\x85", b"true", b"a" * 300, b"<", b"&", b"1970-01-01T00:00:00 UTC", b"9999-12-31T23:59:60 UTC",
    b"TDB", b"UTC", b"deg", b"rad", b"m", b"-", b"+", b"..", b"/dev/null", b"{}", b"%s%n", b"\xe2\x80\xa8",
)  # fmt: skip


def places(content):
    """Where numbers stand in a text: pairs of begin and end."""
    return [match.span() for match in NUMBER.finditer(content)]


def is_label(content, begin):
    """Whether a place is in a name, a source or a comment, which are repeated as they are and may say anything."""
    line = content[content.rfind(b"\n", 0, begin) + 1 : begin].strip()
    return bool(re.match(rb"#|COMMENT|<COMMENT|\S*name|source|\S*OBJECT|ORIGINATOR|MESSAGE_ID|solid|body\b", line, re.I))


def random_number(rng):
    kind = rng.randrange(4)
    if kind == 0:
        return repr(rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-3.0, 6.0))
    if kind == 1:
        return repr(rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-323.0, 308.0))
    if kind == 2:
        return str(rng.randrange(-(10**6), 10**6))
    return f"{rng.uniform(-100.0, 100.0):.3f}"


def near(rng, old):
    """The number that stands there, changed a little or much: sign, last digit, power of ten."""
    try:
        value = float.fromhex(old) if "x" in old.lower() else float(old)
    except (ValueError, OverflowError):
        return random_number(rng)
    return repr(rng.choice((-value, value * (1.0 + 2.0**-52), value * (1.0 + 1e-9), value * 10.0 ** rng.uniform(-12, 12))))


def number(rng, old):
    choice = rng.random()
    return rng.choice(AWKWARD) if choice < 0.6 else random_number(rng) if choice < 0.8 else near(rng, old)


def line_of(content, position):
    return content.count(b"\n", 0, position) + 1


def replace_number(rng, content, place, value=None):
    """The content with another number at a place, and what was done in words."""
    begin, end = place
    old = content[begin:end].decode()
    new = value if value is not None else number(rng, old)
    if is_label(content, begin) and re.search("nan|inf", new):
        new = "1e308"
    done = f"line {line_of(content, begin)}: {old} -> {new if len(new) < 40 else new[:20] + '...'}"
    return content[:begin] + new.encode() + content[end:], done


def damage(rng, content):
    """One change without any knowledge of the format, and its name."""
    lines = content.splitlines(keepends=True) or [b""]
    at = rng.randrange(len(lines))
    kind = rng.randrange(12)
    words = []
    if kind in (4, 5):  # those near some place, for a long file has many
        window = rng.randrange(len(content) // 2000 + 1) * 2000
        found = re.finditer(rb"[^\s=\[\],<>\"']+", content[window : window + 2000])
        words = [(window + match.start(), window + match.end()) for match in found]
    if kind == 0:
        del lines[at]
        return b"".join(lines), "line deleted"
    if kind == 1:
        return b"".join(lines[:at] + [lines[at]] * rng.choice((1, 1, 2, 50)) + lines[at:]), "line repeated"
    if kind == 2:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
        return b"".join(lines), "lines swapped"
    if kind == 3:
        return content[: rng.randrange(len(content) + 1)], "truncated"
    if words:
        begin, end = rng.choice(words)
        if rng.random() < 0.5:
            new = rng.choice(WORDS)
        else:
            other = rng.choice(words)
            new = content[other[0] : other[1]]
        if is_label(content, begin) and new in (b"nan", b"inf"):
            new = b"-"
        return content[:begin] + new + content[end:], "word replaced"
    if kind == 6:
        begin = rng.randrange(len(content) + 1)
        return content[:begin] + bytes(rng.randrange(256) for _ in range(rng.randint(1, 4))) + content[begin:], "bytes put in"
    if kind == 7 and content:
        begin = rng.randrange(len(content))
        return content[:begin] + content[begin + rng.randint(1, 20) :], "bytes taken out"
    if kind == 8 and content:
        begin = rng.randrange(len(content))
        return content[:begin] + bytes([content[begin] ^ 1 << rng.randrange(8)]) + content[begin + 1 :], "bit turned"
    if kind == 9:
        begin = rng.randrange(len(lines))
        return b"".join(lines[:at]) + b"".join(lines[begin : begin + rng.randint(1, 10)]) + b"".join(lines[at:]), "lines copied"
    if kind == 10:
        return content.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b" "))), "line ends changed"
    begin = rng.randrange(len(content) + 1)
    return content[:begin] + rng.choice(WORDS) + content[begin:], "word put in"


# --- Binary files ---------------------------------------------------------------------------------------------------

DOUBLES = (float("nan"), float("inf"), -float("inf"), 1e308, 5e-324, 0.0, -0.0, -1.0, 1e-308, 1e200, 1e-200, 1e20)
FLOATS = (float("nan"), float("inf"), -float("inf"), 3e38, 1e-45, 0.0, -0.0, -1.0, 1e30, 1e-30)
BLOCK, CARD = 2880, 80


def fits_places(content):
    """Numbers in the cards of a FITS file, and in its table: (begin, end) of a card's number, (begin, None) of a double."""
    found, in_header, data = [], True, 0
    for card in range(0, len(content), CARD):
        text = content[card : card + CARD]
        if text.startswith((b"SIMPLE  ", b"XTENSION")):
            in_header = True
        if not in_header:
            continue
        found += [(card + a, card + b) for a, b in places(text) if a >= 10]
        if text.startswith(b"END     "):
            in_header, data = False, (card // BLOCK + 1) * BLOCK
    return found + [(at, None) for at in range(data, len(content) - 7, 8)]


def replace_fits_number(rng, content, place):
    begin, end = place
    if end is None:
        value = rng.choice(DOUBLES)
        return content[:begin] + struct.pack(">d", value) + content[begin + 8 :], f"double at byte {begin} -> {value!r}"
    card = begin // CARD * CARD
    new = number(rng, content[begin:end].decode())
    text = content[card:begin] + new.encode() + content[end : card + CARD]
    return content[:card] + text[:CARD].ljust(CARD) + content[card + CARD :], f"{text[:8].decode().strip()} -> {new[:20]}"


def stl_places(content):
    return [(at, None) for at in range(80, len(content) - 3, 2)]


def replace_stl_number(rng, content, place):
    value = rng.choice(FLOATS)
    return content[: place[0]] + struct.pack("<f", value) + content[place[0] + 4 :], f"float at byte {place[0]} -> {value!r}"
