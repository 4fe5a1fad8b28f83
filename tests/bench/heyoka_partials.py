"""The partial derivatives of the free motion beside heyoka's variational equations, in the same run.

    pip install numpy heyoka==7.13.2
    python tests/bench/heyoka_partials.py build/bin/polhode data/truth/dev/*.case

heyoka integrates Euler's equations and the quaternion's with their variational equations of first order, by the initial
state and the moments, along 1000 sorted times, ten a turn; compilation is not timed. Its tolerance is 1e-15. For each
case: the time of an instant of both, in the same run, and the largest difference of d(m)/d(m0, I), free of units, over
the size of the column. (Its derivatives by the four numbers of a quaternion are those by a turn in another form.) Bodies
at rest, or of which a case has them exactly about an axis, are left out.
"""

import subprocess
import sys
import tempfile
import time

import heyoka
import numpy as np
from heyoka_times import read_case

COUNT, PER_TURN = 1000, 10


def integrator():
    q = heyoka.make_vars("w", "x", "y", "z")
    m = heyoka.make_vars("a", "b", "c")
    moments = [heyoka.par[i] for i in range(3)]
    omega = [m[i] / moments[i] for i in range(3)]
    w, x, y, z = q
    turning = [
        (-x * omega[0] - y * omega[1] - z * omega[2]) / 2,
        (w * omega[0] + y * omega[2] - z * omega[1]) / 2,
        (w * omega[1] + z * omega[0] - x * omega[2]) / 2,
        (w * omega[2] + x * omega[1] - y * omega[0]) / 2,
    ]
    rates = [m[(i + 1) % 3] * omega[(i + 2) % 3] - m[(i + 2) % 3] * omega[(i + 1) % 3] for i in range(3)]
    equations = heyoka.var_ode_sys(
        list(zip([*q, *m], [*turning, *rates])), heyoka.var_args.vars | heyoka.var_args.params, order=1
    )
    return heyoka.taylor_adaptive(equations, [1.0, 0, 0, 0, 0, 0, 0], pars=[1.0, 2.0, 3.0], tol=1e-15, compact_mode=True)


def main():
    program, cases = sys.argv[1], sys.argv[2:]
    made = integrator()
    first = made.state.copy()[7:]
    for path in cases:
        case = read_case(path)
        unit = np.linalg.norm(case["m"])
        if not unit or np.count_nonzero(case["m"]) < 2:
            continue
        moments, m = case["I"] / case["I"][1], case["m"] / unit
        rate = np.linalg.norm(m / moments)
        times = np.linspace(0, 2 * np.pi / rate * COUNT / PER_TURN, COUNT)
        theirs = float("inf")
        for _ in range(3):
            made.time = 0.0
            made.state[:7] = [*(case["q"] / np.linalg.norm(case["q"])), *m]
            made.state[7:] = first
            made.pars[:] = moments
            begin = time.process_time()
            rows = made.propagate_grid(times)[5]
            theirs = min(theirs, (time.process_time() - begin) / COUNT)
        with tempfile.NamedTemporaryFile("w", suffix=".case") as file:
            numbers = lambda v: " ".join(float(x).hex() for x in v)
            file.write(f"I {numbers(moments)}\nq {numbers(case['q'])}\nm {numbers(m)}\n")
            file.writelines(f"t {float(t).hex()}\n" for t in times)
            file.flush()
            out = subprocess.run([program, "eval", "--partials", file.name], capture_output=True, text=True, check=True).stdout
            bench = subprocess.run([program, "bench", file.name, str(COUNT)], capture_output=True, text=True, check=True).stdout
        ours = np.loadtxt(out.splitlines())[:, 7:].reshape(-1, 6, 9)
        ns = {k: float(v) for k, v in (line.split("=") for line in bench.split()) if k.endswith("_ns")}
        # Rows of heyoka: the state, then the derivatives of each component by w, x, y, z, a, b, c, I1, I2, I3.
        var = rows[:, 7:].reshape(-1, 7, 10)
        off = np.linalg.norm(var[:, 4:, 4:] - ours[:, 3:, 3:], axis=1)
        size = np.maximum(1.0, np.linalg.norm(ours[:, 3:, 3:], axis=1))
        print(
            f"{path.rsplit('/', 1)[-1]}: heyoka {1e9 * theirs:.0f} ns, polhode {ns['single_partials_ns']:.0f} ns one by one, "
            f"{ns['batch_partials_ns']:.0f} ns in batches; they differ by {np.max(off / size):.1e}"
        )


main()
