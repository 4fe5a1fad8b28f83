"""eval, methods and bench as a user meets them: eval_test.py POLHODE DATA_DIR. Exit status, streams, formats."""

import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

POLHODE, DATA = sys.argv[1:3]
CASE = f"{DATA}/truth/dev/sam-01.case"
GOOD = "I 1 2 3\nq 1 0 0 0\nm 0.1 0.2 0.3\nt 0\nt 1\n"


def run(*arguments, **keywords):
    return subprocess.run([POLHODE, *arguments], capture_output=True, text=True, timeout=60, **keywords)


class Program(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.case = str(pathlib.Path(self.folder.name) / "a.case")

    def eval_text(self, text, *options):
        pathlib.Path(self.case).write_text(text)
        return run("eval", *options, self.case)

    def test_eval_prints_one_row_of_seven_numbers_per_time_and_nothing_else(self):
        done = run("eval", "--tolerance", "1e-9", CASE)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        times = [line for line in pathlib.Path(CASE).read_text().splitlines() if line.startswith("t ")]
        rows = [[float(word) for word in line.split(" ")] for line in done.stdout.splitlines()]
        self.assertEqual(len(rows), len(times))
        for row in rows:
            self.assertEqual(len(row), 7)
            self.assertAlmostEqual(math.hypot(*row[:4]), 1.0, delta=1e-15)

    def test_methods_agree(self):
        first = run("eval", "--method", "auto", CASE).stdout.split()
        second = run("eval", "--method", "legendre", CASE).stdout.split()
        self.assertEqual(len(first), len(second))
        for a, b in zip(first, second):
            self.assertAlmostEqual(float(a), float(b), delta=1e-13 * max(1.0, abs(float(b))))

    def test_partials_go_on_after_the_state(self):
        states = run("eval", CASE).stdout.splitlines()
        done = run("eval", "--partials", CASE)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = done.stdout.splitlines()
        self.assertEqual([row.split(" ")[:7] for row in rows], [state.split(" ") for state in states])
        self.assertEqual({len(row.split(" ")) for row in rows}, {61})
        first = [float(x) for x in self.eval_text(GOOD, "--partials").stdout.split()[7:16]]
        for number, expected in zip(first, [1] + 8 * [0]):
            self.assertAlmostEqual(number, expected, delta=1e-15)
        torqued = f"{DATA}/truth/torqued/combined-01.case"
        done = run("eval", "--partials", torqued)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual({len(row.split(" ")) for row in done.stdout.splitlines()}, {61})
        first = [float(x) for x in done.stdout.split()[7:16]]
        self.assertEqual(first, [1] + 8 * [0])
        for arguments, complaint in [
            (["--partials", "--method", "rk4", torqued], "--partials of motion under torques is by"),
            (["--partials", "--method", "legendre", CASE], "--method"),
            (["--partials", "--step", "1", CASE], "--step"),
        ]:
            done = run("eval", *arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertIn(complaint, done.stderr)

    def test_wrong_input_is_one_message_and_status_2(self):
        for text, complaint in [
            (GOOD.replace("I 1 2 3", "I 3 2 1"), ":1: "),
            (GOOD.replace("q 1 0 0 0", "q 0 0 0 0"), ":2: "),
            (GOOD.replace("m 0.1", "m nan"), ":3: "),
            (GOOD.replace("t 1", "t soon"), ":5: "),
            (GOOD + "colour red\n", ":6: "),
            (GOOD.replace("q 1 0 0 0\n", ""), "no 'q' line"),
            ("", "empty"),
        ]:
            done = self.eval_text(text)
            self.assertEqual((done.returncode, done.stdout), (2, ""), text)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(complaint, done.stderr)
            self.assertIn(self.case, done.stderr)

    def test_what_would_take_too_long_under_torques_ends_with_a_remedy(self):
        text = pathlib.Path(f"{DATA}/truth/torqued/combined-01.case").read_text()
        text = "".join("m 1e127 2e126 3e126\n" if line.startswith("m ") else line for line in text.splitlines(True))
        done = self.eval_text(text)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        found = re.search(r"reached after (\d+) torque evaluations .*--max-evaluations", done.stderr)
        self.assertLess(int(found[1]), 4_000_500)  # of three torques
        done = self.eval_text(text, "--max-evaluations", "10000")
        self.assertLess(int(re.search(r"after (\d+) torque evaluations", done.stderr)[1]), 10_500)

    def test_a_motion_that_stops_early_is_no_wrong_input(self):
        done = self.eval_text(GOOD.replace("t 1", "T linear-body -10 -10 -10\nt 100"))  # spun up without bound
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"stopped: 0 s to 1\.\d+ s were reached after \d+ torque evaluations")

    def test_what_a_message_quotes_is_short_and_has_no_control_characters(self):
        done = run("convert-time", "--to", "UTC", input="2000-01-01 \x1b[2J\rTT\x7f\n")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("standard input:1: ", done.stderr)
        self.assertIn("\\x1b[2J\\x0dTT\\x7f", done.stderr)
        self.assertTrue(done.stderr[:-1].isprintable(), done.stderr)
        done = run("convert-time", "--to", "UTC", input="2000-01-01 " + 5000 * "T" + "\n")
        self.assertEqual(done.returncode, 2)
        self.assertLess(len(done.stderr), 1050)
        self.assertIn("standard input:1: ", done.stderr)
        self.assertIn("allowed: TT", done.stderr)

    def test_what_a_file_says_moves_no_cursor(self):
        body = pathlib.Path(self.folder.name) / "body.toml"
        toutatis = pathlib.Path(f"{DATA}/bodies/toutatis.toml").read_text()
        body.write_text(toutatis.replace('name = "4179', 'name = "\\u001b[2J\\u009b1m\\nwarning: none'))
        done = run("info", str(body))
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stdout.splitlines()[0], "\\x1b[2J\\x9b1m\\x0awarning: none Toutatis")
        self.assertTrue(done.stdout.replace("\n", "").isprintable())
        scene = pathlib.Path(self.folder.name) / "scene.toml"
        text = pathlib.Path(f"{DATA}/scenes/spin-up.toml").read_text()
        scene.write_text(text.replace('name = "', 'name = "\\u001b[2J').replace('body = "', f'body = "{DATA}/scenes/'))
        done = run("plan", str(scene))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(done.stdout.replace("\n", "").isprintable())
        message = pathlib.Path(self.folder.name) / "a.aem"  # not UTF-8
        table = pathlib.Path(self.folder.name) / "t.aem"
        run("propagate", f"{DATA}/samples/attitude/spinner.csv", "-o", str(table))
        message.write_bytes(table.read_bytes().replace(b"OBJECT_NAME = ", b"OBJECT_NAME = \xe9"))
        for option in [], ["--json"]:
            self.assertEqual(run("info", *option, str(message), errors="replace").returncode, 0)

    def test_where_a_time_has_no_answer_nothing_is_written(self):
        done = self.eval_text(GOOD + "t 1e12\n", "--method", "rk4", "--step", "0.01")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn(f"{self.case}: 1 of 3 times have no answer by method rk4", done.stderr)

    def test_the_examples_of_eval_run(self):
        examples = [line.split()[1:] for line in run("eval", "--help").stdout.splitlines() if line.startswith("  polhode eval")]
        self.assertGreater(len(examples), 1)
        for example in examples:
            done = run(*example, cwd=f"{DATA}/..")
            self.assertEqual((done.returncode, done.stderr), (0, ""), example)
            self.assertNotIn("nan", done.stdout)

    def test_a_rotator_without_moments_is_no_sphere(self):
        rotator = f"{DATA}/samples/asteroid/spin.txt"
        text = run("info", rotator).stdout
        self.assertIn("Motion: principal-axis rotation\n", text)
        self.assertIn("the moments of inertia are not known", text)
        for untrue in ["sphere", "1, 1, 1", "1 : 1", "known as ratios"]:
            self.assertNotIn(untrue, text)
        (report,) = json.loads(run("info", "--json", rotator).stdout)
        self.assertNotIn("inertia", report)
        self.assertEqual(set(report["motion"]) & {"twice_energy_ratios_rad2_s2", "separatrix_offset"}, set())
        out = str(pathlib.Path(self.folder.name) / "a.fits")
        span = ["--stop", "+1 h", "--count", "3"]
        self.assertEqual(run("propagate", rotator, "-o", out, *span).returncode, 0)
        self.assertNotIn(b"INERTIA1", pathlib.Path(out).read_bytes())
        done = run("propagate", rotator, "-o", out, *span, "--momentum")
        self.assertEqual(done.returncode, 2)
        self.assertIn("needs an inertia", done.stderr)

    def test_a_wrong_tolerance_is_refused_before_anything_is_said(self):
        table = f"{DATA}/samples/attitude/spinner.csv"
        for tolerance in ["1 x", "-1 rad", "nan rad"]:
            done = run("compare", table, table, f"--tolerance={tolerance}")
            self.assertEqual((done.returncode, done.stdout), (2, ""), tolerance)

    def test_standard_input_that_cannot_be_read_is_status_3(self):
        for command in [("convert-time", "--to", "UTC"), ("convert-frame", "--from", "ICRF", "--to", "GCRF")]:
            with_folder = os.open(self.folder.name, os.O_RDONLY)
            self.addCleanup(os.close, with_folder)
            done = run(*command, stdin=with_folder)
            self.assertEqual((done.returncode, done.stdout), (3, ""))
            self.assertIn("cannot read standard input: Is a directory", done.stderr)
            closed = subprocess.run(["sh", "-c", '"$@" <&-', "sh", POLHODE, *command], capture_output=True, text=True)
            self.assertEqual((closed.returncode, closed.stdout), (3, ""))
            self.assertIn("cannot read standard input: ", closed.stderr)

    def test_an_output_is_none_of_the_inputs(self):
        folder = pathlib.Path(self.folder.name)
        table = pathlib.Path(f"{DATA}/samples/attitude/spinner.csv").read_bytes()
        (folder / "a.csv").write_bytes(table)
        (folder / "b.csv").symlink_to("a.csv")
        (folder / "times.csv").write_text("2000-01-01T12:00:01 TT\n")
        for arguments in [("a.csv", "-o", "a.csv"), ("a.csv", "-o", "b.csv"), ("b.csv", "-o", f"{folder}/a.csv"),
                          ("a.csv", "--times", "times.csv", "-o", "times.csv")]:
            done = run("propagate", *arguments, cwd=folder)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn("that is read; another name is wanted", done.stderr)
        self.assertEqual((folder / "a.csv").read_bytes(), table)
        self.assertEqual((folder / "times.csv").read_text(), "2000-01-01T12:00:01 TT\n")
        self.assertEqual(run("propagate", "a.csv", "-o", "c.csv", cwd=folder).returncode, 0)

    def test_a_path_is_not_cut_at_a_nul(self):
        body = pathlib.Path(self.folder.name) / "body.toml"
        body.write_text(f'name = "a"\nsource = "b"\n[inertia]\nmesh = "{DATA}/bodies/toutatis.toml\\u0000.obj"\n')
        done = run("info", str(body))
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("holds the character U+0000", done.stderr)
        self.assertIn(f"{body}:4: ", done.stderr)
        body.write_text(body.read_text().replace("\\u0000.obj", "").replace(f"{DATA}/bodies/toutatis.toml", ""))
        done = run("info", str(body))
        self.assertIn(f"{body}:4: inertia.mesh: found '', the name of a file is wanted", done.stderr)

    def test_a_lack_of_memory_names_the_file(self):
        limited = ["sh", "-c", 'ulimit -v 262144; exec "$@"', "sh", POLHODE]
        if subprocess.run([*limited, "--version"], capture_output=True, check=False).returncode != 0:
            self.skipTest("the program needs more to begin with, as sanitizers do")
        big = pathlib.Path(self.folder.name) / "big.csv"
        with big.open("w") as file:
            file.write("date_tt,q_x,q_y,q_z,q_scalar\n" + 8_000_000 * "2000-01-01T12:00:00.000,0,0,0,1\n")
        done = subprocess.run([*limited, "info", str(big)], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertIn("not enough memory", done.stderr)
        self.assertIn(str(big), done.stderr)

    def test_an_empty_list_of_dates_is_named(self):
        pathlib.Path(self.case).write_text("# none\n")
        done = run("propagate", f"{DATA}/bodies/toutatis.toml", "--times", self.case, "-o", self.case + ".csv")
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"{self.case}: the list holds no date", done.stderr)

    def test_wrong_usage_is_status_2(self):
        for arguments in [
            [],
            ["eval"],
            ["eval", "--method", "runge", CASE],
            ["eval", "--tolerance", "-1", CASE],
            ["eval", "--tolerance", "x", CASE],
            ["eval", self.folder.name],
            ["bench", CASE],
            ["bench", CASE, "0"],
            ["sing"],
        ]:
            done = run(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertNotEqual(done.stderr, "", arguments)

    def test_what_cannot_be_read_or_written_is_status_3(self):
        self.assertEqual(run("eval", self.case).returncode, 3)
        if os.path.exists("/dev/full"):
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run([POLHODE, "eval", CASE], stdout=full, stderr=subprocess.PIPE, check=False)
            self.assertEqual(done.returncode, 3)

    def test_methods_lists_each_with_its_properties(self):
        done = run("methods")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        names = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
        self.assertIn("legendre", names)
        for key in ["kind", "order", "conserves", "fails", "source"]:
            self.assertEqual(sum(line.split()[0] == key for line in done.stdout.splitlines()), len(names), key)

    def test_bench_prints_every_quantity_and_the_same_checksum_again(self):
        checksums = set()
        for _ in range(2):
            done = run("bench", "--method", "legendre", CASE, "500")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            values = dict(line.split("=") for line in done.stdout.splitlines())
            for key in ["construct", "construct_short", "single", "batch", "batch_attitude", "copy", "threads", "copy_threads"]:
                self.assertGreater(float(values[f"{key}_ns"]), 0.0)
            checksums.add(values["checksum"])
        self.assertEqual(len(checksums), 1)
        values = dict(line.split("=") for line in run("bench", CASE, "500").stdout.splitlines())
        for key in ["construct_partials", "single_partials", "batch_partials", "copy_partials"]:
            self.assertGreater(float(values[f"{key}_ns"]), 0.0)
        self.assertTrue(math.isfinite(float(values["checksum"])))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
