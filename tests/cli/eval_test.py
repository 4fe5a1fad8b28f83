"""eval, methods and bench as a user meets them: eval_test.py POLHODE DATA_DIR. Exit status, streams, formats."""

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

    def test_a_wrong_tolerance_is_refused_before_anything_is_said(self):
        table = f"{DATA}/samples/attitude/spinner.csv"
        for tolerance in ["1 x", "-1 rad", "nan rad"]:
            done = run("compare", table, table, f"--tolerance={tolerance}")
            self.assertEqual((done.returncode, done.stdout), (2, ""), tolerance)

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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
