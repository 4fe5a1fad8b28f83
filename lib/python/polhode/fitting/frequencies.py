"""The frequencies of a light curve, and pairs of precession and polhode that would make them."""

from __future__ import annotations

import numpy as np

LINES = 8  # that are looked for
FINENESS = 8  # trial frequencies for each turn more over the span
# Lines of an ellipsoid are at m f_phi + k 2 f_psi: it looks the same when the polhode has been run through by half. Those
# that may be the strong ones:
STRONG = ((2, 0), (2, 1), (2, -1), (0, 1), (1, 0), (1, 1), (1, -1), (2, 2), (2, -2))
SERIES = [(m, k) for m in range(0, 5) for k in range(-2, 3) if (m > 0 or k > 0) and m + 2 * abs(k) <= 6]


def waves(t, frequencies):
    angle = 2 * np.pi * np.outer(t, frequencies)
    return np.concatenate([np.cos(angle), np.sin(angle)], axis=1)


def left_over(design, y, weight):
    """Sum of squares that a linear model leaves, and the residuals."""
    solution, *_ = np.linalg.lstsq(design * weight[:, None], y * weight, rcond=1e-8)
    rest = y - design @ solution
    return float(np.sum((rest * weight) ** 2)), rest


def lines(t, y, weight, base, highest, count=LINES):
    """The strongest frequencies (1/s), one taken away after the other; `base` (n, k) is fitted along with them."""
    span = np.ptp(t)
    trial = np.arange(1, int(highest * span * FINENESS) + 1) / (span * FINENESS)
    found = []
    for _ in range(count):
        design = np.concatenate([base, waves(t, found)], axis=1) if found else base
        _, rest = left_over(design, y, weight)
        power = periodogram(t, rest, weight, trial)
        k = int(np.argmax(power))
        fine = np.linspace(trial[max(k - 1, 0)], trial[min(k + 1, len(trial) - 1)], 31)
        best = float(fine[np.argmax(periodogram(t, rest, weight, fine))])
        if any(abs(best - f) < 0.3 / span for f in found):
            break
        found.append(best)
    return found


def periodogram(t, y, weight, frequencies):
    """What a cosine and a sine take away, least squares."""
    w = weight**2
    out = np.empty(len(frequencies))
    for begin in range(0, len(frequencies), 4096):
        f = frequencies[begin : begin + 4096]
        wave = np.exp(2j * np.pi * np.outer(f, t))
        sums = wave @ (w * y)
        square = (wave**2) @ w
        total = w.sum()
        cc, ss, cs = (total + square.real) / 2, (total - square.real) / 2, square.imag / 2
        c, s = sums.real, sums.imag
        det = np.maximum(cc * ss - cs * cs, 1e-9 * total**2)
        out[begin : begin + 4096] = (ss * c * c - 2 * cs * c * s + cc * s * s) / det
    return out


def pairs(t, y, weight, base, found, highest, most):
    """Pairs (f_phi, 2 f_psi) whose series leaves least, the best first: two lines, each taken for each of those that may be
    the strong ones."""
    span = np.ptp(t)
    candidates = []
    for i, a in enumerate(found):
        for b in found[i + 1 :]:
            for one in STRONG:
                for two in STRONG:
                    matrix = np.array([one, two], dtype=float)
                    if abs(np.linalg.det(matrix)) < 0.5:
                        continue
                    for sign in (1, -1):  # a line at a difference may be of either sign
                        phi, psi = np.abs(np.linalg.solve(matrix, [a, sign * b]))
                        if 0.5 / span < min(phi, psi) and max(phi, psi) < highest:
                            candidates.append((phi, psi))
    if not candidates:
        return []
    candidates = np.array(candidates)
    cells = np.unique(np.round(candidates * span * 8), axis=0, return_index=True)[1]
    phi, psi = candidates[np.sort(cells)].T
    cost = np.array([series_cost(t, y, weight, base, f, g) for f, g in zip(phi, psi)])
    kept = []
    for k in np.argsort(cost):
        if all(abs(phi[k] - phi[j]) > 0.2 / span or abs(psi[k] - psi[j]) > 0.2 / span for j in kept):
            kept.append(k)
            if len(kept) == most:
                break
    return [(float(phi[k]), float(psi[k])) for k in kept]


def series_cost(t, y, weight, base, phi, psi):
    """What the series of a pair leaves, for each degree of freedom."""
    kept = []
    for f in sorted(abs(m * phi + k * psi) for m, k in SERIES):
        if f > 0.3 / np.ptp(t) and (not kept or f - kept[-1] > 0.3 / np.ptp(t)):
            kept.append(f)
    left, _ = left_over(np.concatenate([base, waves(t, kept)], axis=1), y, weight)
    return left / max(len(t) - base.shape[1] - 2 * len(kept), 1)
