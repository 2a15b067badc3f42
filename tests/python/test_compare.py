import contextlib
import io
import os
import shutil
import tempfile
import unittest

import numpy as np
import synthetic

from berm import compare
from berm.results import read_points


class Compare(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.a = synthetic.write_run(os.path.join(folder.name, "a"), cell=0.05, steps=20, frames=3)
        self.b = os.path.join(folder.name, "b")
        shutil.copytree(self.a, self.b)

    def run_main(self, *options):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = compare.main([self.a, self.b, *options])
        return code, out.getvalue(), err.getvalue()

    def change_history(self, change):
        """`change` gets the cells of the rows, as text, and the names of the columns."""
        path = os.path.join(self.b, "history.csv")
        with open(path, encoding="utf-8") as file:
            header, *rows = [line.split(",") for line in file.read().splitlines()]
        change(rows, [name.split(" [")[0] for name in header])
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(",".join(row) for row in [header, *rows]) + "\n")

    def scale_cell(self, row, column, factor):
        def change(rows, names):
            rows[row][names.index(column)] = repr(float(rows[row][names.index(column)]) * factor)

        self.change_history(change)

    def line(self, printed, name):
        return next(line for line in printed.splitlines() if line.split()[:1] == [name])

    def test_pieces_in_any_order_are_the_same_run(self):
        synthetic.split_frames(self.b, 4)
        code, printed, errors = self.run_main("--history", "0")
        self.assertEqual((code, errors), (0, ""), printed)
        self.assertIn("the runs agree", printed)
        self.assertIn("stress", printed)

    def test_difference_is_relative_to_the_largest_of_the_column(self):
        self.scale_cell(5, "reaction", 1.0 + 1e-4)  # at half the peak, which is in row 9 or 10
        code, printed, _ = self.run_main()
        self.assertEqual(code, 1)
        line = self.line(printed, "reaction")
        self.assertIn("OFF", line)
        self.assertIn("row 5,", line)
        self.assertAlmostEqual(float(line.split()[1]), 1e-4 * 5 / 9, delta=2e-6)
        self.assertEqual(self.run_main("--history", "1e-4")[0], 0)

    def add_columns(self, folder, columns):
        """`columns`: {header: value of every row}."""
        path = os.path.join(folder, "history.csv")
        with open(path, encoding="utf-8") as file:
            header, *rows = file.read().splitlines()
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join([",".join([header, *columns]), *(",".join([r, *map(repr, columns.values())]) for r in rows)]) + "\n")

    def test_rounding_of_a_reaction_of_nothing_is_measured_by_the_others(self):
        self.add_columns(self.a, {"reaction_y:wall [N]": 2e6, "reaction_y:idle [N]": 3e-7})
        self.add_columns(self.b, {"reaction_y:wall [N]": 2e6, "reaction_y:idle [N]": -1e-7})
        code, printed, _ = self.run_main()
        self.assertEqual(code, 0, printed)
        self.assertEqual(float(self.line(printed, "reaction_y:idle").split()[3]), 2.0)

    def test_a_small_reaction_of_its_own_is_judged(self):
        self.add_columns(self.a, {"reaction_y:wall [N]": 2e6, "reaction_y:small [N]": 10.0})
        self.add_columns(self.b, {"reaction_y:wall [N]": 2e6, "reaction_y:small [N]": 10.1})
        self.assertEqual(self.run_main()[0], 1)

    def test_only_before_the_peak(self):
        self.scale_cell(15, "reaction", 1.5)
        self.assertEqual(self.run_main()[0], 1)
        code, printed, _ = self.run_main("--before", "0.5")
        self.assertEqual(code, 0)
        self.assertIn("points at t = 0 s", printed)  # the frame at 0.5 s is later

    def test_rounding_of_solvers_is_not_judged(self):
        self.scale_cell(3, "residual", 100.0)
        code, printed, _ = self.run_main()
        self.assertEqual(code, 0)
        self.assertIn("not judged", self.line(printed, "residual"))

    def test_fields_of_points_are_compared(self):
        path = os.path.join(self.b, "points_0002.vtu")
        fields = read_points(path)
        fields["damage"] = fields["damage"] + np.where(fields["id"] == 7, 0.01, 0.0)
        synthetic.write_points(path, fields)
        code, printed, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn("id 7", self.line(printed, "damage"))
        self.assertEqual(self.run_main("--points", "0.02")[0], 0)

    def test_missing_points(self):
        path = os.path.join(self.b, "points_0002.vtu")
        synthetic.write_points(path, {name: values[1:] for name, values in read_points(path).items()})
        code, printed, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn(f"1 points are only in {self.a}, 0 only in {self.b}", printed)

    def test_other_steps(self):
        self.change_history(lambda rows, names: rows[4].__setitem__(names.index("time"), "0.21"))
        code, printed, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn("the steps differ from row 4 on", printed)

    def test_shorter_run(self):
        def change(rows, names):
            del rows[-3:]

        self.change_history(change)
        code, printed, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn("has 21 rows", printed)
        self.assertEqual(self.run_main("--before", "0.9")[0], 0)

    def test_nan(self):
        a, b = np.array([1.0, np.nan]), np.array([1.0, np.nan])
        self.assertEqual(compare.largest_difference(a, b, 1.0), (0.0, 0))
        self.assertEqual(compare.largest_difference(a, np.array([1.0, 2.0]), 1.0), (np.inf, 1))

    def test_parts_of_a_reaction_share_their_scale(self):
        self.assertEqual(compare.quantity("reaction_x:platen"), compare.quantity("reaction_z:platen"))
        self.assertNotEqual(compare.quantity("reaction_x:platen"), compare.quantity("reaction_x:base"))

    def test_tolerances_that_are_none(self):
        for words in (("--history", "nan"), ("--points", "-1"), ("--before", "0")):
            with self.subTest(words), self.assertRaises(SystemExit):
                self.run_main(*words)

    def test_unusable_folder(self):
        shutil.rmtree(self.b)
        code, _, errors = self.run_main()
        self.assertEqual(code, 2)
        self.assertIn(self.b, errors)


if __name__ == "__main__":
    unittest.main()
