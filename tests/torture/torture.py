#!/usr/bin/env python3
"""Runs the program on awkward input: every number of every sample replaced, files damaged, arguments mutated.

    tests/torture/torture.py --program build/bin/polhode --count 100000 --jobs 2 --seed 1 --findings findings

A run may end with status 0 to 3, within 10 s of processor time, and never rests. With status 0 every number is finite and every motion
that is written promises an error; otherwise there is one message, and no file. Whatever else happens is a finding: it is
kept in the folder of findings with its input and command line, and counted by its kind. Ends with status 1 if there are any.
"""

import argparse
import collections
import dataclasses
import hashlib
import multiprocessing
import os
import pathlib
import random
import re
import resource
import select
import shlex
import shutil
import signal
import sys
import tempfile
import time

import mutate
import seeds as samples
from judge import MOST_SECONDS, judge, output_of

MOST_BYTES_WRITTEN = 40_000_000
MOST_MEMORY = 4_000_000_000
MOST_SECONDS_AT_REST = 100.0  # without any processor time; a machine with other work gives little
KEPT_OF_EACH_KIND = 3
LONG_TABLE = 300  # numbers


@dataclasses.dataclass
class Run:
    seed: samples.Seed
    command: list
    done: str  # how the input was changed
    content: bytes  # of the file that was changed
    status: int = 0
    killed: bool = False
    cpu_s: float = 0.0
    stdout: str = ""
    stderr: str = ""
    left: dict = dataclasses.field(default_factory=dict)  # files written


def places_of(seed):
    """Where the numbers of its file are."""
    if seed.target.endswith(".fits"):
        return mutate.fits_places(seed.content)
    return mutate.stl_places(seed.content) if "binary" in seed.target else mutate.places(seed.content)


def replacement(seed):
    """What replaces a number in its file."""
    if seed.target.endswith(".fits"):
        return mutate.replace_fits_number
    return mutate.replace_stl_number if "binary" in seed.target else mutate.replace_number


class Campaign:
    """The runs 0, 1, 2, ...: each is known from the seed and its number alone."""

    def __init__(self, data, seed, count, only=()):
        self.seed = seed
        every = [s for s in samples.all_seeds(data) if not only or s.kind in only]
        self.files = [s for s in every if s.target]
        self.arguments = [s for s in every if not s.target]
        self.kinds = sorted({s.kind for s in self.files})
        # The places of all numbers, in an order that the seed shuffles; of long tables a part, unless there is time for all.
        rng = random.Random(seed)
        self.found = [places_of(s) for s in self.files]
        if sum(map(len, self.found)) > count // 2:
            short = 2 * LONG_TABLE
            self.found = [f if len(f) < short else f[:LONG_TABLE] + rng.sample(f, LONG_TABLE) for f in self.found]
        self.places = [(index, place) for index, places in enumerate(self.found) for place in places]
        rng.shuffle(self.places)
        self.argument_places = []
        for index, s in enumerate(self.arguments):
            for k, word in enumerate(s.commands[0]):
                if k > 0 and "/" not in word.split("@")[0] and not word.startswith("x."):
                    self.argument_places += [(index, k, place) for place in mutate.places(word.encode())]
        rng.shuffle(self.argument_places)

    def number(self, rng, turn):
        """One number replaced, sometimes two."""
        index, place = self.places[turn % len(self.places)]
        seed, both = self.files[index], [place]
        if rng.random() < 0.2:
            both.append(rng.choice(self.found[index]))
        content, done = seed.content, []
        for place in sorted({*both}, key=lambda place: -place[0]):
            content, words = replacement(seed)(rng, content, place)
            done.append(words)
        done = "; ".join(done)
        return Run(seed, rng.choice(seed.commands), done, content)

    def damage(self, rng):
        kind = rng.choice(self.kinds)
        seed = rng.choice([s for s in self.files if s.kind == kind])
        content, done = mutate.damage(rng, seed.content)
        while rng.random() < 0.3:
            content, more = mutate.damage(rng, content)
            done += "; " + more
        return Run(seed, rng.choice(seed.commands), done, content)

    def argument(self, rng, turn):
        index, k, place = self.argument_places[turn % len(self.argument_places)]
        seed = self.arguments[index]
        command = list(seed.commands[0])
        if rng.random() < 0.85:
            word, done = mutate.replace_number(rng, command[k].encode(), place)
        else:
            word, done = mutate.damage(rng, command[k].encode())
        command[k] = word.replace(b"\0", b"0").decode("utf-8", "surrogateescape")
        return Run(seed, command, f"{command[k - 1]}: {done}", b"")

    def make(self, number):
        rng = random.Random(f"{self.seed} {number}")
        turn, kind = divmod(number, 8)
        if not self.files or (kind == 4 and self.arguments):
            return self.argument(rng, turn if self.files else number)
        return self.number(rng, 4 * turn + kind) if kind < 4 else self.damage(rng)


def execute(program, run, folder):
    """Runs the program in a folder of its own, and notes what it does."""
    shutil.rmtree(folder, ignore_errors=True)
    names = {*run.seed.files, *([run.seed.target] if run.seed.target else [])}
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(run.content if name == run.seed.target else run.seed.files[name])
    os.chdir(folder)
    output = output_of(run.command)
    streams = [folder.parent / f"{folder.name}.{stream}" for stream in ("out", "err")]
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
    actions = [(os.POSIX_SPAWN_OPEN, 0, run.seed.standard_input or "/dev/null", os.O_RDONLY, 0)]
    actions += [(os.POSIX_SPAWN_OPEN, k + 1, str(path), flags, 0o600) for k, path in enumerate(streams)]
    process = os.posix_spawn(program, [program, *run.command], os.environ, file_actions=actions,
                             setsigdef=[signal.SIGXFSZ, signal.SIGPIPE])  # fmt: skip
    descriptor = os.pidfd_open(process)
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    last_used_s, moved = 0.0, time.monotonic()
    while not poll.poll(2000):
        fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
        used_s = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        if used_s != last_used_s:
            last_used_s, moved = used_s, time.monotonic()
        if used_s > MOST_SECONDS or time.monotonic() - moved > MOST_SECONDS_AT_REST:
            os.kill(process, signal.SIGKILL)
            run.killed = True
            poll.poll()
            break
    os.close(descriptor)
    _, status, used = os.wait4(process, 0)
    run.status = os.waitstatus_to_exitcode(status)
    run.cpu_s = used.ru_utime + used.ru_stime
    run.stdout, run.stderr = (path.read_text(errors="replace") for path in streams)
    for path in folder.iterdir():
        if path.is_file() and path.name not in names:
            wanted = path.name == output
            run.left[path.name] = path.read_bytes() if wanted else b""


def signature(run, problem):
    """The kind of a finding: what is wrong, with which command and kind of file, and the message without its numbers."""
    last = run.stderr.removesuffix("\n").split("\n")[-1] if problem.startswith(("status", "signal")) else ""
    last = re.sub(r"'[^']*'|\S*\.(toml|case|oem|csv|tls|txt|obj|stl|ply|fits|xml|aem|ecsv|mod)\b", "*", last)
    last = re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", last)[:140]
    method = " rk4" if "rk4" in run.command else ""
    return f"{problem} | {run.command[0]}{method} | {run.seed.kind}" + (f" | {last}" if last else "")


def keep(findings, run, kind):
    """Stores the input and the command line, unless there are enough of this kind."""
    folder = findings / hashlib.sha1(kind.encode()).hexdigest()[:10]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "kind").write_text(kind + "\n")
    for k in range(KEPT_OF_EACH_KIND):
        try:
            (folder / str(k)).mkdir()
        except FileExistsError:
            continue
        for name, content in run.seed.files.items():
            path = folder / str(k) / "input" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(run.content if name == run.seed.target else content)
        line = shlex.join(run.command) + (f" < {run.seed.standard_input}" if run.seed.standard_input else "")
        told = f"cd input && polhode {line}\n\n{run.seed.target}: {run.done}\nstatus {run.status}, {run.cpu_s:.1f} s\n"
        (folder / str(k) / "told").write_text(
            f"{told}\n--- standard error\n{run.stderr[-3000:]}\n--- standard output\n{run.stdout[:3000]}\n", errors="replace")
        return


state = {}


def begin_worker(options, folder):
    state.update(campaign=Campaign(options.data, options.seed, options.count, options.only), folder=pathlib.Path(folder) / f"w{os.getpid()}",
                 program=str(pathlib.Path(options.program).resolve()), findings=options.findings and options.findings.resolve())  # fmt: skip
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_BYTES_WRITTEN, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def work(number):
    run = state["campaign"].make(number)
    execute(state["program"], run, state["folder"])
    kinds = [signature(run, problem) for problem in judge(run)]
    for kind in kinds:
        if state["findings"]:
            keep(state["findings"], run, kind)
    return number, run.status, run.cpu_s, f"{run.command[0]} {run.seed.name}", kinds, run.done


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", required=True)
    parser.add_argument("--data", default=pathlib.Path(__file__).resolve().parents[2] / "data")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="number of the first run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", action="append", default=[], help="a kind of input: body, scene, case, arguments ...")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no run after this time")
    parser.add_argument("--findings", type=pathlib.Path, help="folder for what is found")
    options = parser.parse_args()
    begin = time.monotonic()
    statuses, found, slowest, first_of = collections.Counter(), collections.Counter(), [], {}
    memory = "/dev/shm" if os.path.isdir("/dev/shm") else None
    campaign = Campaign(options.data, options.seed, options.count, options.only)
    print(f"{len(campaign.files)} files, {len(campaign.places)} places of numbers, "
          f"{len(campaign.argument_places)} in arguments; seed {options.seed}", flush=True)  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="torture-", dir=memory) as folder:
        with multiprocessing.Pool(options.jobs, begin_worker, (options, folder)) as pool:
            numbers = range(options.first, options.first + options.count)
            for number, status, cpu_s, what, kinds, done in pool.imap_unordered(work, numbers, chunksize=4):
                statuses[status] += 1
                slowest = sorted([*slowest, (cpu_s, what, done, number)], reverse=True)[:5]
                for kind in kinds:
                    found[kind] += 1
                    first_of.setdefault(kind, number)
                total = sum(statuses.values())
                if total % 1000 == 0:
                    print(f"{total} runs, {sum(found.values())} findings, {time.monotonic() - begin:.0f} s", flush=True)
                if time.monotonic() - begin > options.seconds:
                    pool.terminate()
                    break
    print(f"{sum(statuses.values())} runs in {time.monotonic() - begin:.0f} s; by status: "
          + ", ".join(f"{status}: {count}" for status, count in sorted(statuses.items())))  # fmt: skip
    print("slowest, in seconds of processor time:")
    for cpu_s, what, done, number in slowest:
        print(f"  {cpu_s:6.2f}  {what}, {done} (run {number})")
    print(f"{sum(found.values())} findings of {len(found)} kinds" + (":" if found else ""))
    for kind, count in found.most_common():
        folder = f" in {hashlib.sha1(kind.encode()).hexdigest()[:10]}" if options.findings else ""
        print(f"{count:7d}  {kind}   (first: run {first_of[kind]}{folder})")
    return 1 if found else 0



if __name__ == "__main__":
    sys.exit(main())
