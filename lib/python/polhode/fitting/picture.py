"""Residuals over time, as a picture."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

INK, USED, REJECTED = "#22262b", "#2b6cb0", "#c53030"
MOST_CLUSTERS = 6


def clusters_of(days):
    """Indices of rows that belong together, where the gaps between them are far longer than those within."""
    order = np.argsort(days)
    gaps = np.diff(days[order])
    wide = np.flatnonzero(gaps > max(0.1 * np.ptp(days), 20 * np.median(gaps) if len(gaps) else 0)) if len(gaps) else []
    parts = np.split(order, np.asarray(wide, dtype=int) + 1)
    return parts if len(parts) <= MOST_CLUSTERS else [order]


def residual_figure(fit):
    from astropy.time import Time

    rows = fit.residuals()
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    time = Time([row["date_utc"] for row in rows], scale="utc")
    clusters = clusters_of(time.jd)
    figure = Figure(figsize=(max(7.5, 2.1 * len(clusters) + 2), 2.6 * len(kinds) + 0.9), dpi=150, facecolor="white", layout="constrained")
    grid = figure.subplots(len(kinds), len(clusters), squeeze=False, sharey="row")
    for axes, kind in zip(grid, kinds):
        for ax, cluster in zip(axes, clusters):
            mine = [k for k in cluster if rows[k]["kind"] == kind]
            start = np.floor(time.jd[cluster].min() - 0.5) + 0.5
            for used, colour in ((True, USED), (False, REJECTED)):
                some = [k for k in mine if rows[k]["used"] == used]
                if some:
                    ax.errorbar(
                        time.jd[some] - start, [rows[k]["residual"] for k in some], yerr=[rows[k]["sigma"] for k in some],
                        fmt="o", ms=4, lw=0.8, color=colour, label="used" if used else "rejected",
                    )  # fmt: skip
            ax.axhline(0, color=INK, lw=0.6)
            ax.set_xlabel(f"days from {Time(start, format='jd').isot[:10]}", fontsize=9)
            ax.tick_params(labelsize=8.5)
        unit = next(row["unit"] for row in rows if row["kind"] == kind)
        axes[0].set_ylabel(f"{kind}: residual, {unit}", fontsize=9)
    figure.suptitle(f"{fit.body.name}: chi-squared {fit.chi_squared:.4g}, {fit.dof} degrees of freedom", fontsize=11, color=INK, parse_math=False)
    return figure
