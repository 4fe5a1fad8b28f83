"""The figures of the tables of `polhode chart`.

A speed-accuracy or torqued table gives figures of all its bodies, by time and by evaluations, and one of its first body
alone; a stability table gives a figure per map (stability_maps.py).
"""

from pathlib import Path

import matplotlib
import matplotlib.patheffects as effects
import numpy as np
from astropy.table import Table
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from ._chart_figures import FAINT, INK, save, subplots
from ._errors import InputError
from .stability_maps import stability

FRONT = "#f2c14e"
INTEGRATORS = "#e3e6ea"

# Families by hue, luminance and dash, so that grey print still tells them apart; every curve also has its name.
STYLES = {
    "exact": dict(color="#111418", linestyle="-", marker="*", markersize=11),
    "splitting": dict(color="#0b5fa5", linestyle="-", marker="o", markersize=3.6),
    "moser-veselov": dict(color="#c2452d", linestyle="-", marker="s", markersize=3.4),
    "lie group": dict(color="#5f8f1f", linestyle=(0, (5, 1.5)), marker="^", markersize=4),
    "adaptive": dict(color="#7a4bb0", linestyle=(0, (3, 1, 1, 1)), marker="D", markersize=3),
    "quaternion": dict(color="#7f8790", linestyle=(0, (1.2, 1.2)), marker="v", markersize=3.8),
}
# Of families that nobody has given a style yet.
OTHER_STYLE = dict(color="#a3791c", linestyle=(0, (6, 1, 1, 1)), marker="P", markersize=4)

TORQUED_STYLES = {
    "to an accuracy": STYLES["exact"],
    "exact kernel": STYLES["splitting"],
    "other kernel": STYLES["moser-veselov"],
    "general": STYLES["adaptive"],
}


def styles_of(kinds, styles):
    """`styles`, and one for every other kind among those of a table's rows."""
    return styles | {str(kind): OTHER_STYLE for kind in dict.fromkeys(kinds) if kind not in styles}


# --- Speed against accuracy -------------------------------------------------------------------------------------------


def improving(error, cost):
    """Indices of the points that are more accurate than every cheaper one, from cheap to dear."""
    order = np.lexsort((error, cost))
    best, kept = np.inf, []
    for i in order:
        if error[i] < 0.8 * best:
            kept.append(i)
            best = error[i]
    return np.array(kept, dtype=int)


def curves(table):
    """Each method's errors and costs, only where more cost bought more accuracy."""
    for method in dict.fromkeys(table["method"]):
        rows = table[table["method"] == method]
        yield method, np.maximum(np.asarray(rows["attitude_error"]), 1e-17), rows


def place_labels(axes, labels, gap, widen=1.0):
    """Names at the accurate ends of their curves, moved up or down until none covers another. `labels`: (x, y, text,
    colour); `gap` in decades of y, `widen` of their widths for wide panels."""
    placed: list[tuple[float, float, float]] = []
    span = 0.33 * gap * 6.2  # decades of x that one character takes, about
    for x, y, text, color in sorted(labels, key=lambda label: label[1]):
        width = span * len(text) * 0.42 * widen
        start = np.log10(x)
        height = np.log10(y)
        for _ in range(200):
            clash = [p for p in placed if abs(p[2] - height) < gap and start - width < p[0] and p[0] - p[1] < start]
            if not clash:
                break
            height = max(p[2] for p in clash) + gap * 1.001
        placed.append((start, width, height))
        moved = abs(height - np.log10(y)) > 0.6 * gap
        axes.annotate(
            text,
            (x, y),
            (x / 10 ** (0.3 * span * 1.6), 10**height),
            fontsize=6.4,
            color=color,
            va="center",
            ha="left",
            arrowprops=dict(arrowstyle="-", color=color, linewidth=0.4, alpha=0.6) if moved else None,
            path_effects=[effects.withStroke(linewidth=2, foreground="white")],
            zorder=6,
        )


def draw_speed_accuracy(axes, table, cost_name, kind_of, styles, rivals, gap=0.17, headroom=4.5, widen=1.0):
    """`kind_of(method)` is a key of `styles`; the grey front is that of the kinds `rivals` alone."""
    front_error, front_cost, labels = [], [], []
    integrator_error, integrator_cost = [], []
    for method, error, rows in curves(table):
        cost = np.asarray(rows[cost_name])
        kept = improving(error, cost)
        style = styles[kind_of(method)]
        axes.plot(error[kept], cost[kept], linewidth=1.1, markeredgewidth=0, zorder=4, **style)
        front_error.extend(error[kept])
        front_cost.extend(cost[kept])
        if kind_of(method) in rivals:
            integrator_error.extend(error[kept])
            integrator_cost.extend(cost[kept])
        if error[kept[-1]] < 1:
            labels.append((error[kept[-1]], cost[kept[-1]], method, style["color"]))
    errors, costs = np.array(front_error), np.array(front_cost)
    front = improving(errors, costs)
    x, y = errors[front], costs[front]
    x = np.concatenate(([4.0], x))
    y = np.concatenate(([y[0]], y))
    axes.step(x, y, where="post", color=FRONT, linewidth=5, alpha=0.75, zorder=2, solid_capstyle="round")
    integrators = improving(np.array(integrator_error), np.array(integrator_cost))
    axes.plot(
        np.array(integrator_error)[integrators],
        np.array(integrator_cost)[integrators],
        color=INTEGRATORS,
        linewidth=5,
        zorder=1,
        solid_capstyle="round",
        solid_joinstyle="round",
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(4, 1e-17)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * 10 ** (headroom * gap))
    place_labels(axes, labels, gap, widen)
    axes.xaxis.set_major_locator(LogLocator(10, numticks=10))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="#e5e8eb", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def title_of(table, body):
    rows = table[table["body"] == body]
    seconds, turns = abs(rows["span"][0]), rows["turns"][0]
    for unit, length in (("years", 365.25 * 86400), ("days", 86400), ("h", 3600), ("min", 60), ("s", 1)):
        if seconds >= 1.5 * length or unit == "s":
            break
    return f"{body}: {seconds / length:.3g} {unit}, {turns:,.0f} turns"


def family_legend(figure, styles, rivals, **where):
    handles = [Line2D([], [], linewidth=1.1, markeredgewidth=0, **style) for style in styles.values()]
    handles.append(Line2D([], [], color=FRONT, linewidth=5, alpha=0.75))
    handles.append(Line2D([], [], color=INTEGRATORS, linewidth=5))
    names = [*styles, "Pareto front", rivals]
    figure.legend(handles, names, frameon=False, fontsize=8, **where)


COSTS = {
    "time": ("time per instant, ns", "time"),
    "evaluations": ("evaluations per instant", "evaluations"),
}


def check_whole(table, rows, what):
    """Every body must have some of the rows, by one instant and by many."""
    for body in dict.fromkeys(table["body"]):
        for instants in (max(table["instants"]), 1):
            if not np.any(rows & (table["body"] == body) & (table["instants"] == instants)):
                raise InputError(f"the table is not whole: it has no rows of {what} for {body} at {instants} instants")


def speed_accuracy(table, folder):
    check_whole(table, table["method"] == "theta", "theta")
    bodies = list(dict.fromkeys(table["body"]))
    many = max(table["instants"])
    comments = table.meta.get("comments", [])
    note = "   ".join(comments[1:3])
    styles = styles_of(table["family"], STYLES)
    look = dict(
        kind_of=dict(zip(table["method"], table["family"])).get,
        styles=styles,
        rivals=[kind for kind in styles if kind != "exact"],
    )

    def legend(figure, columns):
        family_legend(figure, styles, "front of the integrators", loc="lower center", ncol=columns)

    for instants in (many, 1):
        when = f"{many} instants over the span" if instants == many else "the last instant alone"
        for cost_name, (cost_label, tag) in COSTS.items():
            suffix = ("" if instants == many else "-last") + ("" if tag == "time" else f"-{tag}")
            columns = min(3, len(bodies))
            rows = -(-len(bodies) // columns)
            figure, grid = subplots(
                rows, columns, figsize=(5.4 * columns, 4.9 * rows + 0.8), squeeze=False, layout="constrained"
            )
            figure.get_layout_engine().set(rect=(0, 0.055, 1, 0.915), w_pad=0.1, h_pad=0.12)
            for axes, body in zip(grid.flat, bodies):
                part = table[(table["body"] == body) & (table["instants"] == instants)]
                draw_speed_accuracy(axes, part, cost_name, gap=0.21, **look)
                axes.set_title(title_of(table, body), fontsize=10, color=INK, loc="left")
                axes.set_xlabel("greatest attitude error, rad (better to the right)", fontsize=8)
                axes.set_ylabel(cost_label, fontsize=8)
                axes.tick_params(labelsize=7.5)
            for axes in grid.flat[len(bodies) :]:
                axes.set_visible(False)
            title = f"Free rigid body: cost against accuracy, {when}"
            figure.suptitle(title, fontsize=13, color=INK, x=0.012, ha="left")
            legend(figure, 8)
            figure.text(0.012, 0.004, note, fontsize=6, color=FAINT)
            save(figure, folder, f"speed-accuracy{suffix}")
    figure, axes = subplots(figsize=(9, 6.2), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0.07, 1, 0.93))
    part = table[(table["body"] == bodies[0]) & (table["instants"] == many)]
    draw_speed_accuracy(axes, part, "time", gap=0.145, **look)
    axes.set_title(f"{title_of(table, bodies[0])}, {many} instants", fontsize=11, color=INK, loc="left")
    axes.set_xlabel("greatest attitude error, rad (better to the right)")
    axes.set_ylabel("time per instant, ns")
    legend(figure, 4)
    figure.text(0.99, 0.985, note, fontsize=5.5, color=FAINT, ha="right", va="top")
    save(figure, folder, "speed-accuracy-main")
    print(accuracy_table(table, bodies, many))


def accuracy_table(table, bodies, instants):
    """How many times longer than theta the fastest other method, exact ones apart, takes to reach an accuracy."""
    lines = ["| body | " + " | ".join(f"{a:g} rad" for a in (1e-3, 1e-6, 1e-9, 1e-12)) + " |", "|---|---|---|---|---|"]
    for body in bodies:
        part = table[(table["body"] == body) & (table["instants"] == instants)]
        theta = part["time"][part["method"] == "theta"][0]
        cells = []
        for accuracy in (1e-3, 1e-6, 1e-9, 1e-12):
            good = part[(part["attitude_error"] <= accuracy) & (part["step"] + part["tolerance"] > 0)]
            if len(good) == 0:
                cells.append("not reached")
                continue
            best = good[np.argmin(good["time"])]
            cells.append(f"{best['time'] / theta:,.0f} ({best['method']})")
        lines.append(f"| {body} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


# --- Under torques ----------------------------------------------------------------------------------------------------

TORQUED_COSTS = {
    "evaluations_per_turn": ("torque evaluations per turn", "-evaluations"),
    "us_per_turn": ("time per turn, \N{GREEK SMALL LETTER MU}s", ""),
}


def torqued(table, folder):
    check_whole(table, table["attitude_error"] < 0.3, "a method that is not lost")
    table["us_per_turn"] = table["time_per_turn"] / 1e3
    kinds = dict(zip(table["method"], table["kind"]))
    bodies = list(dict.fromkeys(table["body"]))
    many = max(table["instants"])
    comments = table.meta.get("comments", [])
    styles = styles_of(table["kind"], TORQUED_STYLES)
    look = dict(kind_of=kinds.get, styles=styles, rivals=["general"])

    # What is lost is no answer, and no error can be told below that of the reference.
    table = table[table["attitude_error"] < 0.3]
    table["attitude_error"] = np.maximum(table["attitude_error"], table["reference_error"])

    def draw(axes, body, instants, cost_name):
        part = table[(table["body"] == body) & (table["instants"] == instants)]
        draw_speed_accuracy(axes, part, cost_name, gap=0.1, headroom=7, widen=1.5, **look)
        axes.set_xlim(1, 1e-17)
        axes.set_title(title_of(table, body), fontsize=10, color=INK, loc="left")
        axes.set_xlabel("greatest attitude error, rad (better to the right)", fontsize=8)
        axes.set_ylabel(TORQUED_COSTS[cost_name][0], fontsize=8)
        axes.tick_params(labelsize=7.5)

    def legend(figure):
        family_legend(figure, styles, "front of the general-purpose", loc="lower center", ncol=6)

    for instants in dict.fromkeys((many, 1)):
        when = "the last instant alone" if instants == 1 else f"{instants} instants over the span"
        for cost_name, (_, tag) in TORQUED_COSTS.items():
            columns = min(2, len(bodies))
            rows = -(-len(bodies) // columns)
            figure, grid = subplots(
                rows, columns, figsize=(7.5 * columns, 6.6 * rows + 0.8), squeeze=False, layout="constrained"
            )
            figure.get_layout_engine().set(rect=(0, 0.12 / (rows + 1), 1, 1 - 0.2 / (rows + 1)), w_pad=0.1, h_pad=0.12)
            for axes, body in zip(grid.flat, bodies):
                draw(axes, body, instants, cost_name)
            for axes in grid.flat[len(bodies) :]:
                axes.set_visible(False)
            figure.suptitle(f"Torques: cost against accuracy, {when}", fontsize=13, color=INK, x=0.012, ha="left")
            legend(figure)
            figure.text(0.012, 0.004, "   ".join(comments[1:3]), fontsize=6, color=FAINT)
            save(figure, folder, f"torqued{'' if instants == many else '-last'}{tag}")
    figure, grid = subplots(1, 2, figsize=(15, 7.2), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0.05, 1, 0.94), w_pad=0.1)
    for axes, cost_name in zip(grid, TORQUED_COSTS):
        draw(axes, bodies[0], 1, cost_name)
    legend(figure)
    figure.text(0.99, 0.985, "   ".join(comments[1:3]), fontsize=5.5, color=FAINT, ha="right", va="top")
    save(figure, folder, "torqued-main")
    for instants in dict.fromkeys((1, many)):
        print(torqued_table(table, bodies, instants))


def torqued_table(table, bodies, instants):
    """Of each kind the cheapest that reaches an accuracy, by evaluations and by time."""
    accuracies = (1e-3, 1e-6, 1e-9)
    lines = [
        f"| {instants} instants: evaluations; \N{GREEK SMALL LETTER MU}s per turn | kind | "
        + " | ".join(f"{a:g} rad" for a in accuracies)
        + " |",
        "|---" * (len(accuracies) + 2) + "|",
    ]
    for body in bodies:
        part = table[(table["body"] == body) & (table["instants"] == instants)]
        for kind in ("general", "other kernel", "exact kernel", "to an accuracy"):
            cells = []
            for accuracy in accuracies:
                good = part[(part["attitude_error"] <= accuracy) & (part["kind"] == kind)]
                if len(good) == 0:
                    cells.append("not reached")
                    continue
                best = [(cost, good[np.argmin(good[cost])]) for cost in TORQUED_COSTS]
                cells.append("; ".join(f"{row[cost]:.3g} ({row['method']})" for cost, row in best))
            lines.append(f"| {body} | {kind} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


TEXTS = ("body", "family", "kind", "map", "method", "outcome")
DRAWINGS = {  # by a column that only this table has: what draws it, and what else it needs
    "outcome": (stability, "map x y method digits_lost"),
    "evaluations_per_turn": (
        torqued, "body kind method instants span turns attitude_error reference_error time_per_turn"
    ),
    "attitude_error": (speed_accuracy, "body family method instants span turns step tolerance time evaluations"),
}  # fmt: skip


def read_table(path):
    try:
        with open(path, encoding="utf-8") as file:
            return Table.read(file.read().splitlines(), format="ascii.ecsv")
    except OSError:
        raise
    except Exception as error:  # astropy has many
        raise InputError(f"{path} is not a table of polhode chart: {error}") from None


def is_chart(path):
    """Whether a file is a table of text that is none of attitudes: what polhode.read() takes for none of its own."""
    try:
        with open(path, "rb") as file:
            head = file.read(4096).decode(errors="replace")
    except OSError:
        return False
    return head.startswith("# %ECSV") and any(f"name: {column}" in head for column in DRAWINGS)


def draw_file(path, folder=None):
    """The figures of a table, as SVG and PNG beside it or in the folder, which is made. Raises InputError, FileError."""
    table = read_table(path)
    draw, others = next((DRAWINGS[name] for name in DRAWINGS if name in table.colnames), (None, ""))
    if draw is None:
        raise InputError(f"{path} is not a table of polhode chart: it has no column of {', '.join(DRAWINGS)}")
    for name in others.split():
        if name not in table.colnames:
            raise InputError(f"{path} is not a whole table of polhode chart: it has no column {name}")
        if (table[name].dtype.kind in "US") != (name in TEXTS):
            raise InputError(f"{path}: column {name} holds {'numbers' if name in TEXTS else 'no numbers'}")
    if len(table) == 0:
        raise InputError(f"{path} has no rows")
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "hatch.linewidth": 0.6, "svg.hashsalt": "polhode"}):
        draw(table, folder or Path(path).parent)
