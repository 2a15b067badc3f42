import contextlib
import csv
import io
import math
import os
import re
import tempfile
import unittest

from berm import factor_of_safety as safety
from berm.results import ResultError

FAKE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fake_slope.py")


class FactorOfSafety(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.case, self.out = os.path.join(folder.name, "slope.toml"), os.path.join(folder.name, "out")
        with open(self.case, "w", encoding="utf-8"):
            pass

    def find(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = safety.main([self.case, "--berm", FAKE, "--out", self.out, *arguments])
        return code, out.getvalue(), err.getvalue()

    def rows(self):
        with open(os.path.join(self.out, "factor_of_safety.csv"), newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def answer(self, printed):
        factor, within = re.search(r"factor of safety ([0-9.]+) \+- ([0-9.]+)", printed).groups()
        return float(factor), float(within)

    def test_bisection(self):
        code, printed, errors = self.find("--tolerance", "0.005")
        self.assertEqual(code, 0)
        self.assertRegex(errors, r"^the run that stands at F = 1\.3\d*: warning: strains of 0\.2 in small strain\n$")
        factor, within = self.answer(printed)
        self.assertLessEqual(within, 0.005)
        self.assertLessEqual(abs(factor - 1.37), within + 5e-4)
        rows = self.rows()
        factors = [float(row["factor [-]"]) for row in rows]
        self.assertEqual(factors, sorted(factors))
        self.assertEqual(factors[0], 1.0)
        for row in rows:
            self.assertEqual(row["stands [-]"], str(int(float(row["factor [-]"]) < 1.37)))
            self.assertEqual(float(row["share_of_run [-]"]), 0.5)  # the synthetic run ends at 1 s of 2 s
        self.assertTrue(os.path.getsize(os.path.join(self.out, "factor_of_safety.png")) > 5000)

    def test_below_one(self):
        code, printed, _ = self.find("--set", "falls_at=0.71")
        self.assertEqual(code, 0)
        factor, within = self.answer(printed)
        self.assertLessEqual(abs(factor - 0.71), within + 5e-4)
        self.assertLessEqual(within, 0.02)

    def test_jump_of_displacement_is_failure(self):
        code, printed, _ = self.find("--set", "runs_out=true")
        self.assertEqual(code, 0)
        factor, within = self.answer(printed)
        self.assertLessEqual(abs(factor - 1.37), within + 5e-4)
        self.assertTrue(any("times that of F = 1" in row["reason"] for row in self.rows()))
        self.assertEqual(self.find("--set", "runs_out=true", "--jump", "100")[0], 1)

    def test_slope_that_has_come_down_has_failed(self):
        """The first runs find equilibrium, all of them at the foot: there is none with a displacement to compare with."""
        code, printed, _ = self.find("--set", "comes_down=true", "--set", "falls_at=0.71")
        self.assertEqual(code, 0)
        factor, within = self.answer(printed)
        self.assertLessEqual(abs(factor - 0.71), within + 5e-4)
        self.assertTrue(any("times the height of the bodies" in row["reason"] for row in self.rows()))

    def test_trials_of_a_search_that_ends_early_are_kept(self):
        self.assertEqual(self.find("--set", "falls_at=1e9", "--most", "3")[0], 1)
        self.assertEqual(float(self.rows()[-1]["factor [-]"]), 3.0)

    def test_search_in_the_folder_of_an_earlier_one(self):
        first = self.find()
        note = os.path.join(self.out, "F_1.0000", "note.txt")
        with open(note, "w", encoding="utf-8") as file:
            file.write("mine")
        self.assertEqual(self.find(), first)
        self.assertTrue(os.path.isfile(note))
        # What is there from before is not the answer of a run that came to nothing.
        code, printed, errors = self.find("--set", "breaks=1")
        self.assertEqual((code, printed), (1, ""))
        self.assertRegex(errors, r"error: no results in .*F_1\.0000: the disk is full\n")

    def test_no_answer(self):
        code, _, errors = self.find("--set", "falls_at=1e9", "--most", "3")
        self.assertEqual(code, 1)
        self.assertIn("still stands at F = 3;", errors)
        code, _, errors = self.find("--set", "reason=a point left the grid")
        self.assertEqual(code, 1)
        self.assertIn("a point left the grid", errors)

    def test_answer_close_to_the_end_of_the_search(self):
        code, printed, _ = self.find("--set", "falls_at=1.005", "--most", "1.01", "--tolerance", "0.02")
        self.assertEqual(code, 0)
        factor, within = self.answer(printed)
        self.assertLessEqual(abs(factor - 1.005), within + 5e-4)
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
            self.find("--most", "1")

    def test_wrong_input(self):
        for arguments, message in (
            (("--set", "nonsense=1"), "exit code 2"),
            (("--set", "law=rankine"), "no material with one of the laws"),
            (("--material", "rock"), "no material rock with"),
            (("--berm", "/no/such/berm"), "cannot find the program"),
        ):
            with self.subTest(message):
                code, _, errors = self.find(*arguments)
                self.assertEqual(code, 2)
                self.assertIn(message, errors)


class Reduced(unittest.TestCase):
    def changes(self, factor, **material):
        pairs = (text.split("=") for text in safety.reduced("s", material, factor))
        return {key.removeprefix("material.s."): float(value) for key, value in pairs}

    def test_strength(self):
        changes = self.changes(2.0, cohesion="10 kPa", friction_angle=30.0)
        self.assertEqual(changes["cohesion"], 5e3)
        self.assertAlmostEqual(math.tan(math.radians(changes["friction_angle"])), 0.5 / math.sqrt(3.0))
        self.assertEqual(set(changes), {"cohesion", "friction_angle", "dilatancy_angle"})

    def test_cut_off_and_residual_strength(self):
        changes = self.changes(
            2.0,
            cohesion=1e4,
            friction_angle="0.5 rad",
            dilatancy_angle=25.0,
            tensile_strength="4 kPa",
            residual_cohesion=1e3,
            residual_friction_angle=20.0,
        )
        self.assertEqual(changes["tensile_strength"], 2e3)
        self.assertEqual(changes["residual_cohesion"], 5e2)
        # The dilatancy angle lasts, so it may not exceed the residual friction angle.
        self.assertEqual(changes["dilatancy_angle"], changes["residual_friction_angle"])
        self.assertLess(changes["residual_friction_angle"], changes["friction_angle"])

    def test_no_friction(self):
        self.assertEqual(self.changes(1.5, cohesion=3e4, friction_angle=0.0)["friction_angle"], 0.0)

    def test_units(self):
        for cohesion in ("1 psi", [1.0, 2.0]):
            with self.assertRaisesRegex(ResultError, "cannot read material.s.cohesion = "):
                self.changes(2.0, cohesion=cohesion, friction_angle=30.0)


if __name__ == "__main__":
    unittest.main()
