import contextlib
import csv
import io
import os
import tempfile
import unittest

from berm import sweep

FAKE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fake_berm.py")
SWEEP = """
title = "Two loads"
[variant.low]
case = "case.toml"
set = ["factor=1.0"]
short = ["steps=5"]
[variant.high]
case = "case.toml"
set = ["factor=2.0"]
"""
BROKEN = """
[variant.broken]
case = "case.toml"
set = ["fail=the dam broke"]
"""


class Sweep(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.out = folder.name, os.path.join(folder.name, "out")
        self.write("case.toml", "")

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def run_sweep(self, text, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = sweep.main([self.write("sweep.toml", text), "--berm", FAKE, "--out", self.out, *arguments])
        return code, out.getvalue(), err.getvalue()

    def rows(self):
        with open(os.path.join(self.out, "sweep.csv"), newline="", encoding="utf-8") as file:
            return {row["variant"]: row for row in csv.DictReader(file)}

    def test_table_csv_and_report(self):
        code, printed, errors = self.run_sweep(SWEEP, "--jobs", "2")
        self.assertEqual((code, errors), (0, ""))
        self.assertIn("peak_load [N]", printed)
        rows = self.rows()
        self.assertEqual(list(rows), ["low", "high"])
        self.assertAlmostEqual(float(rows["high"]["peak_load [N]"]) / float(rows["low"]["peak_load [N]"]), 2.0)
        self.assertEqual(rows["low"]["stress_noise [-]"], "nan")
        with open(os.path.join(self.out, "report.html"), encoding="utf-8") as file:
            self.assertIn("<h1>Two loads</h1>", file.read())

    def test_short_and_only(self):
        self.assertEqual(self.run_sweep(SWEEP, "--short", "--only", "low")[0], 0)
        self.assertEqual({name: row["newton_iterations [-]"] for name, row in self.rows().items()}, {"low": "15"})

    def test_failure_is_reported_and_the_rest_is_kept(self):
        code, _, errors = self.run_sweep(SWEEP + BROKEN)
        self.assertEqual(code, 1)
        self.assertIn("broken failed: exit code 1: the dam broke", errors)
        self.assertEqual(list(self.rows()), ["low", "high"])

    def test_wrong_input(self):
        for text, arguments, message in (
            (SWEEP, ("--only", "middle"), "no variant middle"),
            ("[variant.a]\nset = []\n", (), "has no case"),
            ("[variant.a]\ncase = 3\n", (), "must be a string"),
            ('[variant.a]\ncase = "c"\nsets = []\n', (), "unknown key sets"),
            ("title = 3 3", (), "cannot read"),
            (SWEEP, ("--berm", "/no/such/berm"), "cannot find the program"),
        ):
            with self.subTest(message):
                code, _, errors = self.run_sweep(text, *arguments)
                self.assertEqual(code, 2)
                self.assertIn(message, errors)


if __name__ == "__main__":
    unittest.main()
