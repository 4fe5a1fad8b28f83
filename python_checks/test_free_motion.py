"""`polhode eval` on random bodies of many kinds against Leroy's formulas at 70 digits and more.

The outputs are compared as the doubles they are. Wherever the inputs determine the answer (condition number below 1e14),
theta promises 8 units of 2^-52 outright; 2.5 is what is seen.
"""

import math
import random

import mpmath as mp
import pytest
from free_motion_reference import FreeMotionReference
from support import run

EPS = 2.0**-52
KINDS = ["generic", "needle", "disc", "near sphere", "near top 12", "near top 23", "near separatrix"]
KINDS += ["axis 1", "axis 2", "axis 3", "zero component", "units"]


def moments(kind, uniform):
    while True:
        a = uniform(1, 10)
        match kind:
            case "needle":
                i = [a * 10 ** uniform(-9, -1), a * (1 - 10 ** uniform(-7, -1)), a]
            case "disc":
                b = a * (1 + 10 ** uniform(-9, 0))
                i = [a, b, (a + b) * (1 - 10 ** uniform(-12, -2))]
            case "near sphere":
                d = 10 ** uniform(-15.5, -1)
                b = a * (1 + d * uniform(0.05, 1))
                i = [a, b, b * (1 + d * uniform(0.05, 1))]
            case "near top 12":
                b = a * (1 + 10 ** uniform(-15.6, -1))
                i = [a, b, b * uniform(1.01, 1.9)]
            case "near top 23":
                i = [a * uniform(0.05, 0.95), a, a * (1 + 10 ** uniform(-15.6, -1))]
            case _:
                i = [a, uniform(1, 10), uniform(1, 10)]
        i.sort()
        if i[0] < i[1] < i[2] and i[0] + i[1] >= i[2]:
            return i


def problem(kind, seed):
    """Moments, attitude, momentum, the digits that the reference needs, and the random numbers to go on with."""
    rnd = random.Random(f"{kind} {seed}")
    i = moments(kind, rnd.uniform)
    m = [rnd.gauss(0, 1) for _ in range(3)]
    digits = 70
    if kind == "near separatrix":
        on_it = abs(m[0]) * math.sqrt((i[1] - i[0]) * i[2] / (i[0] * (i[2] - i[1])))
        m[2] = math.copysign(on_it * (1 + rnd.choice((1, -1)) * 10 ** rnd.uniform(-16, -1)), m[2])
        digits = 90
    elif kind.startswith("axis"):
        exponent = rnd.uniform(0, rnd.choice((12, 160)))
        m = [x if k == int(kind[-1]) - 1 else x * 10**-exponent for k, x in enumerate(m)]
        digits = int(90 + 2.3 * exponent)
    elif kind == "zero component":
        m[rnd.randrange(3)] = 0.0
    elif kind == "units":
        inertia, momentum = 10 ** rnd.uniform(-150, 150), 10 ** rnd.uniform(-150, 150)
        i, m = [x * inertia for x in i], [x * momentum for x in m]
    return i, [rnd.gauss(0, 3) for _ in range(4)], m, digits, rnd


@pytest.mark.parametrize("kind", KINDS)
def test_theta_is_exact_to_the_last_digits(kind, tmp_path):
    worst = {"attitude": 0.0, "momentum": 0.0, "norm": 0.0}
    rows = 0
    for seed in range(4):
        i, q, m, digits, rnd = problem(kind, seed)
        reference = FreeMotionReference(i, q, m, digits)
        turn_s = 2 * math.pi * float(reference.i2 / reference.g)
        polhode_s = float(4 * reference.k / abs(reference.lam))
        sign = rnd.choice((1, -1))
        times = [0.0] + [sign * turn_s * 10 ** rnd.uniform(-6, 9) for _ in range(5)]
        times += [sign * polhode_s * rnd.uniform(0, 5) for _ in range(5)]
        case = tmp_path / "case"
        lines = [("I", i), ("q", q), ("m", m)] + [("t", [t]) for t in times]
        case.write_text("".join(f"{key} {' '.join(x.hex() for x in values)}\n" for key, values in lines))
        answers = [[float(x) for x in line.split()] for line in run("eval", case).stdout.splitlines()]
        assert len(answers) == len(times)
        for t, answer in zip(times, answers):
            # How often the period's uncertainty, one part in 2^53 / m_c, has been added up.
            condition = abs(t) / turn_s * 6.3 + abs(t) / polhode_s / float(reference.mc)
            if condition > 1e14:
                continue
            true_q, true_m = reference.at(t)
            norm = mp.sqrt(sum(mp.mpf(x) ** 2 for x in answer[:4]))
            side = 1 if sum(x * y for x, y in zip(answer, true_q)) > 0 else -1
            attitude = 2 * mp.sqrt(sum((side * mp.mpf(x) / norm - y) ** 2 for x, y in zip(answer, true_q)))
            momentum = mp.sqrt(sum((mp.mpf(x) - y) ** 2 for x, y in zip(answer[4:], true_m))) / reference.g
            for name, error in ("attitude", attitude), ("momentum", momentum), ("norm", abs(norm - 1)):
                assert mp.isfinite(error)
                worst[name] = max(worst[name], float(error) / EPS)
            rows += 1
    print(f"{kind}: {rows} rows, worst", {name: f"{value:.2f} eps" for name, value in worst.items()})
    assert rows >= 20
    assert worst["attitude"] <= 4 and worst["momentum"] <= 4 and worst["norm"] <= 2
