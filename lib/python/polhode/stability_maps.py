"""The figures of the stability table of `polhode chart`: a map of lost digits per method."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Patch, Rectangle

from ._chart_figures import FAINT, INK, save, subplots

# From white to near black, ever darker: it reads the same in grey.
DIGITS = LinearSegmentedColormap.from_list("digits", ["#ffffff", "#fbe3a4", "#f0a35c", "#b4558a", "#5b3a8c", "#161a3a"])
# Cells without a number: face, hatch and its colour, name.
OUTCOMES = {
    "failed": ("#e3001b", "white", "xxxx", "failed: NaN, exception, no convergence"),
    "too long": ("#d7dade", "white", "////", "not computed: too long"),
    "undetermined": ("#f1f3f4", "#c3c8cd", "....", "undetermined: eps kappa > 1"),
}


def power(exponent):
    """10 to the exponent, in mathematics; 1 and 10 as they are."""
    if exponent in (0, 1):
        return f"${10 ** int(exponent)}$"
    return f"$10^{{{exponent:g}}}$"


def axis_names(name, values, vertical):
    """Tick positions (indices into values) and labels."""
    step = max(1, -(-len(values) // 5))
    chosen = list(range(0, len(values), step))
    if name == "separatrix" and not vertical:
        chosen = [i for i, v in enumerate(values) if v in (-17, -9, 0, 9, 17)]
        return chosen, ["0" if values[i] == 0 else power(abs(values[i]) - 17) for i in chosen]
    if name == "near-sphere" and vertical:
        return list(range(len(values))), [power(-abs(round(v, 1))) for v in values]
    if name == "axis" and vertical:
        return list(range(len(values))), [f"axis {int(v) // 3 + 1}, {100 ** (int(v) % 3):,} turns" for v in values]
    if name == "span" and vertical:
        bodies = ["short-axis mode", "long-axis mode", "symmetric top", "needle", "near-sphere", "near separatrix"]
        return list(range(len(values))), [bodies[int(v)] for v in values]
    return chosen, [power(round(values[i], 1)) for i in chosen]


def stability(table, folder):
    described = {}
    for comment in table.meta.get("comments", []):
        head, _, rest = comment.partition(": ")
        parts = rest.split("; ")
        if len(parts) == 3 and parts[1].startswith("x: "):
            described[head] = (parts[0], parts[1][3:], parts[2][3:])
    methods = list(dict.fromkeys(table["method"]))
    for name in dict.fromkeys(table["map"]):
        part = table[table["map"] == name]
        xs, ys = np.unique(part["x"]), np.unique(part["y"])
        column, row = np.searchsorted(xs, part["x"]), np.searchsorted(ys, part["y"])
        columns = 6
        rows = -(-len(methods) // columns)
        wide = name in ("axis", "span")
        figure, grid = subplots(
            rows,
            columns,
            figsize=(15.5 if wide else 14.5, 2.2 * rows + 1.6),
            sharex=True,
            sharey=True,
            squeeze=False,
            layout="constrained",
        )
        figure.get_layout_engine().set(rect=(0, 0.075, 1, 0.87), w_pad=0.05, h_pad=0.06)
        for axes, method in zip(grid.flat, methods):
            here = part["method"] == method
            digits = np.full((len(ys), len(xs)), np.nan)
            answered = here & (part["outcome"] == "answered")
            digits[row[answered], column[answered]] = part["digits_lost"][answered]
            image = axes.pcolormesh(digits, cmap=DIGITS, vmin=0, vmax=16, rasterized=True)
            for outcome, (colour, edge, hatch, _) in OUTCOMES.items():
                for i in np.flatnonzero(here & (part["outcome"] == outcome)):
                    axes.add_patch(
                        Rectangle(
                            (column[i], row[i]),
                            1,
                            1,
                            facecolor=colour,
                            edgecolor=edge,
                            hatch=hatch,
                            linewidth=0,
                        )
                    )
            axes.set_xlim(0, len(xs))
            axes.set_ylim(0, len(ys))
            weight = "bold" if method == "theta" else "normal"
            axes.set_title(method, fontsize=9, color=INK, loc="left", pad=3, fontweight=weight)
            positions, names = axis_names(name, xs, vertical=False)
            axes.set_xticks([p + 0.5 for p in positions], names, fontsize=6.5)
            positions, names = axis_names(name, ys, vertical=True)
            axes.set_yticks([p + 0.5 for p in positions], names, fontsize=6.5)
            axes.tick_params(length=2, width=0.5)
            for side in axes.spines.values():
                side.set_linewidth(0.6)
                side.set_color(FAINT)
        for axes in list(grid.flat)[len(methods) :]:
            axes.set_visible(False)
        for k in range(len(methods) - columns, len(methods)):
            if k >= 0:
                grid.flat[k].tick_params(labelbottom=True)
        title, x_label, y_label = described.get(name, (name, "x", "y"))
        title = f"{title}: digits lost beyond what the problem costs"
        figure.suptitle(title, fontsize=13, color=INK, x=0.012, ha="left")
        figure.supxlabel(x_label, fontsize=9, y=0.05)
        figure.supylabel(y_label, fontsize=9)
        bar = figure.add_axes((0.60, 0.945, 0.25, 0.018))
        figure.colorbar(image, cax=bar, orientation="horizontal", extend="both")
        bar.set_title("log10 of error / (eps max(1, kappa))", fontsize=7.5, pad=3)
        bar.tick_params(labelsize=7)
        figure.legend(
            handles=[
                Patch(facecolor=colour, edgecolor=edge, hatch=hatch, linewidth=0, label=label)
                for colour, edge, hatch, label in OUTCOMES.values()
            ],
            loc="lower center",
            ncol=3,
            frameon=False,
            fontsize=8,
        )
        save(figure, folder, f"stability-{name}")
