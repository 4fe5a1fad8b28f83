"""`polhode eval --partials` on random bodies of many kinds against central differences of Leroy's formulas,
at twice the digits that these need and with steps of half of them.

The error of a row is that of its worst column, free of units (momenta in G, moments in I_k), over the larger of 1 and
the column's size. 5e-15 is what is seen; beside the separatrix the constants' 2^-104, over what cancels, adds up with every
flip, to 1e-12 there.
"""

import math

import mpmath as mp
import pytest
from free_motion_reference import FreeMotionReference, _conjugate, _multiply
from support import run
from test_free_motion import KINDS, problem


def columns(i, q, m, digits, times):
    """Of each time: the derivatives (theta, m) by m0 and I, six columns of six; the norm of m, as a unit."""
    step = mp.mpf(10) ** -(digits // 2 + 10)
    digits = 2 * digits + 30

    def displaced(k, side):
        mp.mp.dps = digits
        x = [mp.mpf(v) for v in (*m, *i)]
        unit = mp.sqrt(sum(v * v for v in x[:3])) if k < 3 else x[k]
        x[k] += side * step * unit
        return FreeMotionReference(x[3:], q, x[:3], digits)

    bodies = [(displaced(k, 1), displaced(k, -1)) for k in range(6)]
    middle = FreeMotionReference(i, q, m, digits)
    result = []
    for t in times:
        at_t, row = middle.at(t), []
        for plus, minus in bodies:
            (q_plus, m_plus), (q_minus, m_minus) = plus.at(t), minus.at(t)
            turn = _multiply(_conjugate(at_t[0]), [(a - b) / (2 * step) for a, b in zip(q_plus, q_minus)])
            row.append([2 * x for x in turn[1:]] + [(a - b) / (2 * step) / middle.g for a, b in zip(m_plus, m_minus)])
        result.append(row)
    return result, float(middle.g)


def error_of_row(answer, true, g, i):
    """`true` is free of units already."""
    units = [g, g, g, *i]
    worst = 0.0
    for k, column in enumerate(true):
        ours = [mp.mpf(answer[7 + 9 * row + 3 + k]) * units[k] / (1 if row < 3 else g) for row in range(6)]
        size = max(1, mp.sqrt(sum(x * x for x in column)))
        worst = max(worst, float(mp.sqrt(sum((a - b) ** 2 for a, b in zip(ours, column))) / size))
    return worst


@pytest.mark.parametrize("kind", KINDS)
def test_partials_are_exact(kind, tmp_path):
    errors = []
    # Not those that need more digits than can be computed in a while: closer than 1e-20 to an axis.
    drawn = [p for p in (problem(kind, seed) for seed in range(100, 130)) if p[3] < 140][:3]
    for i, q, m, digits, rnd in drawn:
        reference = FreeMotionReference(i, q, m, digits)
        turn_s = 2 * math.pi * float(reference.i2 / reference.g)
        polhode_s = float(4 * reference.k / abs(reference.lam))
        sign = rnd.choice((1, -1))
        times = [sign * turn_s * 10 ** rnd.uniform(-6, 9) for _ in range(4)]
        times += [sign * polhode_s * rnd.uniform(0, 5) for _ in range(4)]
        case = tmp_path / "case"
        lines = [("I", i), ("q", q), ("m", m)] + [("t", [t]) for t in times]
        case.write_text("".join(f"{key} {' '.join(x.hex() for x in values)}\n" for key, values in lines))
        answers = [[float(x) for x in line.split()] for line in run("eval", "--partials", case).stdout.splitlines()]
        states = [[float(x) for x in line.split()] for line in run("eval", case).stdout.splitlines()]
        assert [answer[:7] for answer in answers] == states
        assert all(len(answer) == 61 for answer in answers)
        true, g = columns(i, q, m, digits, times)
        errors += [error_of_row(answer, row, g, i) for answer, row in zip(answers, true)]
    errors.sort()
    print(f"{kind}: {len(errors)} rows, worst {errors[-1]:.1e}, second {errors[-2]:.1e}, median {errors[len(errors) // 2]:.1e}")
    assert len(errors) == 24
    assert errors[-1] <= (4e-12 if kind == "near separatrix" else 2e-14)
    assert errors[len(errors) * 3 // 4] <= 1e-14
