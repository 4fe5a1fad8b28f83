"""Partial derivatives of motions under torques, by heyoka's variational equations in long double: references for
tests/golden/torqued_partials_test.cpp, by a method and a program that are not ours.

    pip install numpy heyoka==7.13.2
    python tests/bench/heyoka_torqued_partials.py data/truth/torqued/ecc-01.case > data/truth/torqued/ecc-01.partials

A line for each time: T, then 6 x 9 numbers row by row, d(theta, m)/d(theta0, m0, I), as in data/truth/dev. The true anomaly
of the orbit is integrated along. Digits: about 16, less what the motion makes of roundings.
"""

import sys

import heyoka
import numpy as np

REAL = np.longdouble


def read(path):
    body, torques, times = {}, [], []
    for line in open(path):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "T":
            torques.append((words[1], [REAL(float.fromhex(w)) for w in words[2:]]))
        elif words[0] == "t":
            times.append((words[1], float.fromhex(words[1])))
        else:
            body[words[0]] = np.array([REAL(float.fromhex(w)) for w in words[1:]])
    return body, torques, times


def anomaly_at_start(n, e, since):
    """True anomaly `since` after periapsis: f' = n (1 + e cos f)^2, by small steps of a Taylor integration."""
    f = heyoka.make_vars("f")
    made = heyoka.taylor_adaptive(
        [(f, n * (1 + e * heyoka.cos(f)) ** 2)], np.array([0], dtype=REAL), fp_type=REAL, tol=REAL(1e-19)
    )
    made.propagate_until(REAL(since))
    return made.state[0]


def product(a, b):
    """Of quaternions, scalar first."""
    w, v = a[0], a[1:]
    return np.concatenate([[w * b[0] - v @ b[1:]], w * b[1:] + b[0] * v + np.cross(v, b[1:])])


def main(path):
    body, torques, times = read(path)
    q = heyoka.make_vars("w", "x", "y", "z")
    m = heyoka.make_vars("a", "b", "c")
    moments = [heyoka.par[i] for i in range(3)]
    omega = [m[i] / moments[i] for i in range(3)]
    w, x, y, z = q
    turning = [
        (-x * omega[0] - y * omega[1] - z * omega[2]) / REAL(2),
        (w * omega[0] + y * omega[2] - z * omega[1]) / REAL(2),
        (w * omega[1] + z * omega[0] - x * omega[2]) / REAL(2),
        (w * omega[2] + x * omega[1] - y * omega[0]) / REAL(2),
    ]
    rates = [m[(i + 1) % 3] * omega[(i + 2) % 3] - m[(i + 2) % 3] * omega[(i + 1) % 3] for i in range(3)]
    columns = [
        [w * w + x * x - y * y - z * z, REAL(2) * (x * y - w * z), REAL(2) * (x * z + w * y)],
        [REAL(2) * (x * y + w * z), w * w - x * x + y * y - z * z, REAL(2) * (y * z - w * x)],
        [REAL(2) * (x * z - w * y), REAL(2) * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]  # [inertial][body]
    unknowns, more, start = [], [], []
    for k, (kind, numbers) in enumerate(torques):
        if kind == "constant-body":
            rates = [rates[i] + numbers[i] for i in range(3)]
        elif kind == "linear-body":
            rates = [rates[i] - numbers[i] * omega[i] for i in range(3)]
        else:
            mu, periapsis, e, t_periapsis = numbers[:4]
            p, normal = np.array(numbers[4:7]), np.array(numbers[7:10])
            p = p / np.sqrt(p @ p)
            normal = normal - (normal @ p) * p
            ahead = np.cross(normal / np.sqrt(normal @ normal), p)
            parameter = periapsis * (1 + e)
            n = np.sqrt(mu / parameter) / parameter
            f = heyoka.make_vars(f"f{k}")
            per_r = (REAL(1) + e * heyoka.cos(f)) / parameter
            inertial = [p[i] * heyoka.cos(f) + ahead[i] * heyoka.sin(f) for i in range(3)]
            u = [sum(columns[i][j] * inertial[i] for i in range(3)) for j in range(3)]
            strength = REAL(3) * mu * per_r**3
            rates = [
                rates[i] + strength * (moments[(i + 2) % 3] - moments[(i + 1) % 3]) * u[(i + 1) % 3] * u[(i + 2) % 3]
                for i in range(3)
            ]
            unknowns.append(f)
            more.append(n * (REAL(1) + e * heyoka.cos(f)) ** 2)
            start.append(anomaly_at_start(n, e, -t_periapsis))
    equations = heyoka.var_ode_sys(
        list(zip([*q, *m, *unknowns], [*turning, *rates, *more])), [*q, *m, *moments], order=1
    )
    size = 7 + len(unknowns)
    q0 = body["q"] / np.sqrt(body["q"] @ body["q"])
    made = heyoka.taylor_adaptive(
        equations,
        np.array([*q0, *body["m"], *start], dtype=REAL),
        pars=np.array(body["I"], dtype=REAL),
        fp_type=REAL,
        tol=REAL(1e-19),
        compact_mode=True,
    )
    first = made.state.copy()
    print("# T, then 6 x 9 row by row: d(theta_body, m)/d(theta0_body, m0, I); heyoka 7.13.2 in long double")
    for text, t in times:
        made.time = REAL(0)
        made.state[:] = first
        made.propagate_until(REAL(t))
        now = made.state
        var = now[size:].reshape(size, 10)  # by w, x, y, z, a, b, c, I1, I2, I3
        back = now[:4] * np.array([1, -1, -1, -1]) / np.sqrt(now[:4] @ now[:4])
        by = np.zeros((7, 9), dtype=REAL)
        for k in range(3):
            by[:, k] = var[:7, :4] @ (product(q0, np.eye(4, dtype=REAL)[k + 1]) / 2)
        by[:, 3:] = var[:7, 4:]
        rows = np.zeros((6, 9), dtype=REAL)
        for k in range(9):
            rows[:3, k] = 2 * product(back, by[:4, k])[1:]
        rows[3:] = by[4:]
        print(text, *(f"{x:.18e}" for x in rows.reshape(-1)))


if __name__ == "__main__":
    main(sys.argv[1])
