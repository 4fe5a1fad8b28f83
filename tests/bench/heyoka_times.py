"""Times of polhode beside heyoka (https://github.com/bluescarni/heyoka), a Taylor integrator that compiles code for the
equations it is given, in the same run, on cases with torques and a .truth file beside them.

    pip install numpy heyoka==7.13.2
    python tests/bench/heyoka_times.py build/bin/polhode data/truth/torqued/*.case

heyoka gets its fastest form known to us: the quaternion relative to the orbit's axes, and the cosine and sine of the true
anomaly integrated along (no orbit to solve); on a circular orbit without these. Compilation is not timed. Its tolerance
is the largest, of two per decade, whose states at the first and last times are within the wanted accuracy of the truth, and its time is
that of two runs, since one alone says nothing of its error; polhode is told the wanted accuracy, and its own check is in
its time. Processor time, the least of several runs, microseconds per turn at the initial rate. Cases of one point mass,
constant torques in body axes and linear damping are served.
"""

import math
import subprocess
import sys
import time

import heyoka
import numpy as np

WANTED = (1e-3, 1e-6, 1e-9, 1e-11)


def number(text):
    return float.fromhex(text) if "0x" in text else float(text)


def read_case(path):
    case = {"T": []}
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            words = line.split("#")[0].split()
            if words and words[0] == "T":
                case["T"].append((words[1], np.array([number(w) for w in words[2:]])))
            elif words and words[0] in "Iqm":
                case[words[0]] = np.array([number(w) for w in words[1:]])
    return case


def truth_at_ends(path):
    """The first and the last row: time and quaternion."""
    rows = []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                rows.append([number(w) for w in line.split()[:5]])
    return [(row[0], np.array(row[1:])) for row in (min(rows), max(rows))]


def product(a, b):
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def matrix(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(rotation):
    """Of a rotation matrix: the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)."""
    r = rotation
    k = np.array(
        [
            [np.trace(r), r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [0, r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [0, 0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [0, 0, 0, r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    return np.linalg.eigh(k, UPLO="U")[1][:, 3]


class Orbit:
    def __init__(self, values):
        self.mu, self.periapsis, self.eccentricity, self.time = values[:4]
        self.x = values[4:7] / np.linalg.norm(values[4:7])
        normal = values[7:10] - self.x * (self.x @ values[7:10])
        self.normal = normal / np.linalg.norm(normal)
        self.parameter = self.periapsis * (1 + self.eccentricity)

    def anomaly(self, t):
        """Cosine and sine of the true anomaly."""
        e = self.eccentricity
        a = self.periapsis / abs(1 - e)
        mean = math.sqrt(self.mu / a**3) * (t - self.time)
        if e < 1:
            mean = math.fmod(mean, 2 * math.pi)
            u = mean
            for _ in range(60):
                u -= (u - e * math.sin(u) - mean) / (1 - e * math.cos(u))
            r = 1 - e * math.cos(u)
            return (math.cos(u) - e) / r, math.sqrt(1 - e * e) * math.sin(u) / r
        u = math.asinh(mean / e)
        for _ in range(100):
            u -= (e * math.sinh(u) - u - mean) / (e * math.cosh(u) - 1)
        r = e * math.cosh(u) - 1
        return (e - math.cosh(u)) / r, math.sqrt(e * e - 1) * math.sinh(u) / r

    def axes(self, t):
        c, s = self.anomaly(t)
        up = c * self.x + s * np.cross(self.normal, self.x)
        return np.column_stack([up, np.cross(self.normal, up), self.normal])


def equations(case, unit_s):
    """The right-hand sides, the start, and the orbit or None."""
    moments, q = case["I"], case["q"] / np.linalg.norm(case["q"])
    orbits = [Orbit(v) for kind, v in case["T"] if kind == "gravity-gradient"]
    constant = sum((v for kind, v in case["T"] if kind == "constant-body"), np.zeros(3))
    damping = sum((v for kind, v in case["T"] if kind == "linear-body"), np.zeros(3))
    omega = heyoka.make_vars("wx", "wy", "wz")
    q0, q1, q2, q3 = heyoka.make_vars("q0", "q1", "q2", "q3")
    start = list(case["m"] / moments * unit_s)
    extra, pull, rate, orbit = [], None, list(omega), None
    if orbits:
        orbit = orbits[0]
        mean = math.sqrt(orbit.mu / orbit.parameter**3) * unit_s
        q = quaternion(orbit.axes(0.0).T @ matrix(q))
        up = [1.0 - 2.0 * (q2 * q2 + q3 * q3), 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)]
        normal = [2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), 1.0 - 2.0 * (q1 * q1 + q2 * q2)]
        if orbit.eccentricity == 0.0:
            turning, cube = mean, 1.0
        else:
            c, s = heyoka.make_vars("c", "s")
            g = 1.0 + orbit.eccentricity * c
            turning, cube = mean * (g * g), g * g * g
            extra = [(c, -turning * s), (s, turning * c)]
        pull = [3 * mean * mean * (cube * up[(i + 1) % 3] * up[(i + 2) % 3]) for i in range(3)]
        rate = [omega[i] - turning * normal[i] for i in range(3)]
    system = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        weight = (moments[j] - moments[k]) / moments[i]
        right = weight * (omega[j] * omega[k] - pull[i]) if pull else weight * (omega[j] * omega[k])
        if constant.any():
            right = right + constant[i] / moments[i] * unit_s**2
        if damping.any():
            right = right - damping[i] / moments[i] * unit_s * omega[i]
        system.append((omega[i], right))
    x, y, z = rate
    system += [
        (q0, -0.5 * (q1 * x + q2 * y + q3 * z)),
        (q1, 0.5 * (q0 * x + q2 * z - q3 * y)),
        (q2, 0.5 * (q0 * y + q3 * x - q1 * z)),
        (q3, 0.5 * (q0 * z + q1 * y - q2 * x)),
    ]
    start += list(q)
    if extra:
        start += list(orbit.anomaly(0.0))
    return system + extra, start, orbit


def heyoka_runs(case, ends, unit_s):
    """Error and time of runs from 0 to both ends, from loose to tight tolerances."""
    system, start, orbit = equations(case, unit_s)
    for half_decades in range(4, 34):
        integrator = heyoka.taylor_adaptive(system, start, tol=10.0 ** (-0.5 * half_decades))
        total, worst = 0.0, 0.0
        for end_s, truth in ends:
            if end_s == 0.0:
                continue
            best, spent = math.inf, 0.0
            while spent < 0.1:
                integrator.time, integrator.state[:] = 0.0, start
                begin = time.process_time()
                integrator.propagate_until(end_s / unit_s)
                taken = time.process_time() - begin
                spent, best = spent + taken, min(best, taken)
            q = integrator.state[3:7] / np.linalg.norm(integrator.state[3:7])
            if orbit:
                q = quaternion(orbit.axes(end_s) @ matrix(q))
            off = product(q * np.array([1, -1, -1, -1]), truth)
            worst = max(worst, 2 * math.atan2(np.linalg.norm(off[1:]), abs(off[0])))
            total += best
        yield worst, total


def polhode_time_s(program, path, tolerance):
    least = math.inf
    for _ in range(3):
        run = subprocess.run(
            [program, "bench", "--tolerance", str(tolerance), path, "100"], capture_output=True, text=True, check=False
        )
        if run.returncode != 0:
            return math.nan
        values = dict(line.split("=") for line in run.stdout.splitlines())
        least = min(least, float(values["solve_ns"]) * 1e-9)
    return least


def main():
    program, *paths = sys.argv[1:]
    print("| case | " + " | ".join(f"{w:g}" for w in WANTED) + " |\n|---|" + "---|" * len(WANTED))
    for path in paths:
        case = read_case(path)
        unit_s = 1 / np.linalg.norm(case["m"] / case["I"])
        ends = truth_at_ends(path.removesuffix("case") + "truth")
        turns = (max(0.0, ends[1][0]) - min(0.0, ends[0][0])) / unit_s / (2 * math.pi)
        needed = {}
        for error, seconds in heyoka_runs(case, ends, unit_s):
            for wanted in WANTED:
                if error <= wanted and wanted not in needed:
                    needed[wanted] = 2 * seconds
            if len(needed) == len(WANTED):
                break
        cells = []
        for wanted in WANTED:
            ours = polhode_time_s(program, path, wanted)
            theirs = needed.get(wanted, math.nan)
            cells.append(f"{ours / turns * 1e6:.1f}; {theirs / turns * 1e6:.1f} ({theirs / ours:.1f})")
        name = path.rsplit("/", 1)[-1].removesuffix(".case")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
