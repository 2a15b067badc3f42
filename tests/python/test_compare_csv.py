import contextlib
import importlib.util
import io
import os
import tempfile
import unittest

import synthetic

TOOL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "compare_csv.py")
spec = importlib.util.spec_from_file_location("compare_csv", TOOL)
compare_csv = importlib.util.module_from_spec(spec)
spec.loader.exec_module(compare_csv)


class CompareCsv(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.run_path = synthetic.write_run(os.path.join(cls.folder.name, "run"), cell=0.05, steps=60, frames=1)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def compare(self, *rows, header="quantity,value,tolerance,kind,source"):
        path = os.path.join(self.folder.name, "expected.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(["# a comment", header, *rows]) + "\n")
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = compare_csv.main([self.run_path, path])
        return code, out.getvalue(), err.getvalue()

    def test_all_kinds_of_quantities(self):
        code, printed, _ = self.compare(
            "peak_load,5.225e6,0.001,relative,hand",  # 0.15 m2 * 124.4e9 Pa/m * 2.8e-4 m
            "displacement_at_peak,2.8e-4,1e-9,absolute,hand",
            "history:imposed_displacement@0.125,7.5e-5,1e-9,relative,between two rows",
            "max:nominal_strain,2e-3,1e-9,relative,hand",
            "last:time,1,0,absolute,hand",
            'max_before_peak:gauge:lateral,5.6e-5,1e-9,relative,"hand, with comma"',
        )
        self.assertEqual((code, printed.count("  ok\n")), (0, 6), printed)

    def test_value_outside_is_found(self):
        code, printed, _ = self.compare("peak_load,5.225e6,0.001,relative,hand", "last:time,1.1,0.05,absolute,hand")
        self.assertEqual(code, 1)
        self.assertEqual((printed.count("  ok\n"), printed.count("OFF")), (1, 1))

    def test_undefined_metric_and_time_not_reached_are_off(self):
        self.assertEqual(self.compare("stress_noise,0,1e9,absolute,hand")[0], 1)
        self.assertEqual(self.compare("history:reaction@1.5,0,1e9,absolute,hand")[0], 1)

    def test_relative_to_zero(self):
        self.assertEqual(self.compare("points_lost,0,0,relative,hand")[0], 0)
        self.assertEqual(self.compare("max_damage,0,0.5,relative,hand")[0], 1)

    def test_wrong_files(self):
        good = "peak_load,5.2e6,0.1,relative,hand"
        for rows, message in (
            (["peak_lode,1,1,relative,hand"], "peak_lode is neither"),
            (["max:nothing,1,1,relative,hand"], "no column nothing"),
            (["history:time,1,1,relative,hand"], "history:COLUMN@TIME"),
            (["peak_load,1,1,sometimes,hand"], "relative or absolute"),
            (["peak_load,one,1,relative,hand"], "must be numbers"),
            (["peak_load,1,1,relative,"], "where the value is from"),
            (["peak_load,1,1,relative"], "needs 5 cells"),
            ([good + ", and more"], "needs 5 cells"),
            ([], "expects nothing"),
        ):
            with self.subTest(message):
                code, _, errors = self.compare(*rows)
                self.assertEqual(code, 2)
                self.assertIn(message, errors)
        self.assertEqual(self.compare(good, header="name,value")[0], 2)


if __name__ == "__main__":
    unittest.main()
