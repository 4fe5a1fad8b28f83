"""A strict reader of CCSDS attitude ephemeris messages in KVN: no key, order or row that the standard does not give."""

import re
from dataclasses import dataclass, field

import numpy as np

DATE = re.compile(r"\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}(\.\d+)?")
NUMBERS = {
    "QUATERNION": 4,
    "QUATERNION/DERIVATIVE": 8,
    "QUATERNION/ANGVEL": 7,
    "EULER_ANGLE": 3,
    "EULER_ANGLE/DERIVATIVE": 6,
    "EULER_ANGLE/ANGVEL": 6,
}
# Keys of the metadata in the standard's order; True: always there.
METADATA = {
    "1.0": {
        "OBJECT_NAME": True, "OBJECT_ID": True, "CENTER_NAME": False, "REF_FRAME_A": True, "REF_FRAME_B": True,
        "ATTITUDE_DIR": True, "TIME_SYSTEM": True, "START_TIME": True, "STOP_TIME": True, "ATTITUDE_TYPE": True,
        "QUATERNION_TYPE": False, "EULER_ROT_SEQ": False, "INTERPOLATION_METHOD": False, "INTERPOLATION_DEGREE": False,
    },
    "2.0": {
        "OBJECT_NAME": True, "OBJECT_ID": True, "CENTER_NAME": False, "REF_FRAME_A": True, "REF_FRAME_B": True,
        "TIME_SYSTEM": True, "START_TIME": True, "STOP_TIME": True, "ATTITUDE_TYPE": True, "EULER_ROT_SEQ": False,
        "ANGVEL_FRAME": False, "INTERPOLATION_METHOD": False, "INTERPOLATION_DEGREE": False,
    },
}  # fmt: skip


@dataclass
class Segment:
    meta: dict
    dates: list = field(default_factory=list)
    rows: np.ndarray | None = None


def read(path):
    """The version and the segments of a message; AssertionError where it is not as the standard has it."""
    text = path.read_text(encoding="ascii")
    assert text.endswith("\n") and max(map(len, text.splitlines())) <= 254
    lines = [line for line in text.splitlines() if line]

    def key_value(line):
        key, equals, value = line.partition(" = ")
        assert equals and re.fullmatch(r"[A-Z][A-Z0-9_]*", key) and value == value.strip() != "", line
        return key, value

    at = 0

    def pairs_until(mark):
        nonlocal at
        found = {}
        comments_allowed = True
        while lines[at] != mark:
            if lines[at].startswith("COMMENT "):
                assert comments_allowed, "comments stand at the head of their block"
            else:
                comments_allowed = False
                key, value = key_value(lines[at])
                assert key not in found
                found[key] = value
            at += 1
        at += 1
        return found

    assert key_value(lines[0])[0] == "CCSDS_AEM_VERS"
    version = key_value(lines[0])[1]
    at = 1
    header = pairs_until("META_START")
    assert list(header) == ["CREATION_DATE", "ORIGINATOR"] and DATE.fullmatch(header["CREATION_DATE"])
    segments = []
    while True:
        meta = pairs_until("META_STOP")
        allowed = METADATA[version]
        assert list(meta) == [key for key in allowed if key in meta], "unknown keys or another order"
        assert all(key in meta for key, always in allowed.items() if always)
        kind = meta["ATTITUDE_TYPE"]
        assert ("EULER_ROT_SEQ" in meta) == kind.startswith("EULER")
        assert ("ANGVEL_FRAME" in meta) == kind.endswith("/ANGVEL")
        assert meta.get("ANGVEL_FRAME", meta["REF_FRAME_B"]) in (meta["REF_FRAME_A"], meta["REF_FRAME_B"])
        if version == "1.0":
            assert meta["ATTITUDE_DIR"] == "A2B"
            assert meta.get("QUATERNION_TYPE") == ("LAST" if kind.startswith("QUATERNION") else None)
        assert lines[at] == "DATA_START"
        at += 1
        segment = Segment(meta)
        rows = []
        while lines[at] != "DATA_STOP":
            date, *numbers = lines[at].split(" ")
            assert DATE.fullmatch(date) and len(numbers) == NUMBERS[kind], lines[at]
            segment.dates.append(date)
            rows.append([float(number) for number in numbers])
            at += 1
        at += 1
        segment.rows = np.array(rows)
        assert np.all(np.isfinite(segment.rows))
        assert segment.dates == sorted(set(segment.dates)), "times increase"
        assert (segment.dates[0], segment.dates[-1]) == (meta["START_TIME"], meta["STOP_TIME"])
        segments.append(segment)
        if at == len(lines):
            return version, segments
        assert lines[at] == "META_START"
        at += 1
