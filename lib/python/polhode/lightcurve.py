"""Light curves: tables of `polhode observe` with magnitudes, drawn over time or folded, beside what was measured."""

import csv
import gzip
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ._core import Instant
from ._errors import InputError

INK, MODEL, MEASURED = "#1b1f24", "#0b5fa5", "#c2452d"
UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
MOST_POINTS = 400  # of a model that is drawn as points of its own


def lines_of(path):
    path = Path(path)
    if not path.is_file():
        return []
    with open(path, "rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    try:
        with (gzip.open if packed else open)(path, "rt", encoding="utf-8") as file:
            return [line for line in file if not line.startswith("#")]
    except (OSError, EOFError, UnicodeDecodeError):
        return []


def is_light_curve(path):
    """Whether a file is a table with dates first and magnitudes."""
    if Path(path).suffix.lower() not in (".csv", ".ecsv"):
        return False
    names = next(iter(lines_of(path)), "").strip().split(",")
    return names[0].startswith("date_") and "magnitude" in names


def read(path):
    """Columns by name as texts, and the time scale."""
    rows = list(csv.reader(lines_of(path)))
    names, rows = rows[0], rows[1:]
    if not rows or any(len(row) != len(names) for row in rows):
        raise InputError(f"{path} has no rows, or rows of other lengths than its names")
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}, names[0].removeprefix("date_").upper()


def numbers(table, name, path):
    try:
        return np.array([float(cell) for cell in table[name]])
    except ValueError:
        raise InputError(f"{path}: column {name} holds what is no number") from None


def period_s(text):
    number, _, unit = text.strip().partition(" ")
    try:
        value = float(number) * UNITS_S[unit.strip() or "s"]
    except (ValueError, KeyError):
        value = float("nan")
    if not 0 < value < float("inf"):
        raise InputError(f"--fold: '{text}' is no period, as '30.56 h' (s, min, h, d)")
    return value


def picture(path, fold=None):
    """The figure of a table. `fold` is a period as text. Raises InputError."""
    table, scale = read(path)
    first = Instant(min(table[f"date_{scale.lower()}"]), scale)
    seconds = np.array([Instant(date, scale) - first for date in table[f"date_{scale.lower()}"]])
    model = numbers(table, "magnitude", path)
    order = np.argsort(seconds)
    measured = numbers(table, "given_magnitude", path)[order] if "given_magnitude" in table else None
    error = numbers(table, "error_mag", path)[order] if measured is not None and "error_mag" in table else None
    seconds, model = seconds[order], model[order]
    if fold is None:
        unit = "d" if seconds[-1] > 3 * 86400 else "h" if seconds[-1] > 3 * 3600 else "min"
        x, label = seconds / UNITS_S[unit], f"{unit} from {first.text(scale, 0).replace('T', ' ')} {scale}"
    else:
        x, label = seconds / period_s(fold) % 1.0, f"phase of {fold} from {first.text(scale, 0).replace('T', ' ')} {scale}"
    figure = Figure(figsize=(10, 5.2 if measured is None else 6.6), dpi=150, facecolor="white")
    rows = figure.subplots(1 if measured is None else 2, 1, sharex=True, squeeze=False, height_ratios=[1] if measured is None else [3, 1])
    ax = rows[0, 0]
    many = measured is None and fold is None and len(model) > 20
    style = dict(color=MODEL, lw=1.3) if many else dict(color=MODEL, ls="", marker="o", ms=3.5 if len(model) < MOST_POINTS else 1.5)
    if measured is None:
        ax.plot(x, model, label="model", **style)
    else:
        shift = np.nanmean(measured - model)
        ax.errorbar(x, measured, error, color=MEASURED, ls="", marker="s", ms=3, elinewidth=0.8, label="measured")
        ax.plot(x, model + shift, label=f"model {shift:+.2f} mag", zorder=3, **style)
        left = measured - model - shift
        rows[1, 0].axhline(0, color="#9aa0a6", lw=0.8)
        rows[1, 0].plot(x, left, "s", ms=3, color=MEASURED)
        rows[1, 0].invert_yaxis()
        rows[1, 0].set_ylabel(f"measured less model\n(rms {np.sqrt(np.nanmean(left**2)):.3f} mag)", fontsize=9)
        ax.legend(frameon=False, fontsize=9)
    ax.invert_yaxis()
    ax.set_ylabel("magnitude", color=INK)
    rows[-1, 0].set_xlabel(label, color=INK)
    for one in rows[:, 0]:
        one.grid(color="#e3e5e8", lw=0.6)
        one.xaxis.set_major_locator(MaxNLocator(10))
        one.spines[["top", "right"]].set_visible(False)
    ax.set_title(Path(path).stem, loc="left", fontsize=12, color=INK, parse_math=False)
    figure.tight_layout()
    return figure
