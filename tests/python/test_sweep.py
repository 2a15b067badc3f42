import contextlib
import csv
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
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

    def test_finished_runs_are_kept_without_force(self):
        note, history = (os.path.join(self.out, "low", name) for name in ("note.txt", "history.csv"))
        self.assertEqual(self.run_sweep(SWEEP)[0], 0)
        with open(note, "w", encoding="utf-8") as file:
            file.write("mine")
        with open(history, encoding="utf-8") as file:
            before = file.read()
        code, _, errors = self.run_sweep(SWEEP, "--short")
        self.assertEqual(code, 1)
        self.assertIn("low: holds the results of a run that came to its end: --force", errors)
        with open(history, encoding="utf-8") as file:
            self.assertEqual(file.read(), before)
        self.assertEqual(self.run_sweep(SWEEP, "--short", "--force")[0], 0)
        with open(history, encoding="utf-8") as file:
            self.assertLess(len(file.read()), len(before))
        self.assertTrue(os.path.isfile(note))

    def test_names_that_are_no_folders_of_the_sweep(self):
        victim = os.path.join(self.folder, "victim")
        os.makedirs(victim)
        self.write(os.path.join("victim", "thesis.txt"), "")
        for name in ("../victim", victim, "", "a/b", ".", "..", ".hidden", "a b,c", "a\\nb", "sweep.csv", "report.html", "peak_damage.png"):
            with self.subTest(name):
                code, printed, errors = self.run_sweep(f'{SWEEP}[variant."{name}"]\ncase = "case.toml"\n')
                self.assertEqual((code, printed), (2, ""))
                self.assertRegex(errors, r'^error: .*sweep\.toml: the name ".*" of a variant must .*\n$')
        self.assertEqual(os.listdir(victim), ["thesis.txt"])
        self.assertEqual(sorted(os.listdir(self.folder)), ["case.toml", "sweep.toml", "victim"])
        self.assertEqual(self.run_sweep('[variant."-a_1.5"]\ncase = "case.toml"\n')[0], 0)

    def test_interrupt_ends_the_sweep(self):
        marks = os.path.join(self.folder, "marks")
        os.makedirs(marks)
        slow = self.write("slow", f'#!/bin/sh\ntouch "{marks}/$(basename "$4")"\nsleep 1\nexit 1\n')
        os.chmod(slow, 0o755)
        command = [sys.executable, "-m", "berm.sweep", self.write("sweep.toml", SWEEP), "--berm", slow, "--out", self.out]
        with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            while process.poll() is None and not os.listdir(marks):
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            errors = process.communicate(timeout=60)[1]
        self.assertEqual((process.returncode, errors, os.listdir(marks)), (1, "berm sweep: interrupted\n", ["low"]))

    def test_wrong_input(self):
        for text, arguments, message in (
            ("variant = 3", (), "variants must be tables with names: [variant.NAME]"),
            ('[[variant]]\ncase = "case.toml"\n', (), "variants must be tables with names"),
            ("[variant]\nA = 3\n", (), "the variant A must be a table: [variant.A]"),
            ('title = ["a"]\n[variant.a]\ncase = "case.toml"\n', (), "title must be a string"),
            ("x = " + 5000 * "[", (), "cannot read"),
            (SWEEP, ("--only", ","), "no variant "),
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
        self.assertFalse(os.path.exists(self.out))


if __name__ == "__main__":
    unittest.main()
