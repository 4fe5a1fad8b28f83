"""Angles and rates as text, Quantity or number."""

from __future__ import annotations

import re

import numpy as np

from .._errors import InputError

ANGLES = {"rad": 1.0, "deg": np.radians(1), "arcmin": np.radians(1) / 60, "arcsec": np.radians(1) / 3600}
TIMES = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "day": 86400.0}


def angle_rad(value):
    return _number(value, ANGLES, "rad", "an angle as '2 deg'")


def rate_rad_s(value):
    units = {f"{a}/{t}": x / y for a, x in ANGLES.items() for t, y in TIMES.items()}
    return _number(value, units, "rad/s", "a rate as '1 deg/day'")


def _number(value, units, si, wanted):
    if hasattr(value, "to_value"):
        value = value.to_value(si)
    if isinstance(value, str):
        found = re.fullmatch(r"\s*([-+0-9.eE]+)\s*([a-z/]*)\s*", value)
        try:
            value = float(found[1]) * (units[found[2]] if found[2] else 1.0)
        except (TypeError, ValueError, KeyError):
            raise InputError(f"found '{value}'; {wanted} is wanted") from None
    value = float(value)
    if not 0 < value < np.inf:
        raise InputError(f"found {value}; a positive number is wanted: {wanted}")
    return value
