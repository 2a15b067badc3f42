import os
import tempfile
import unittest

import numpy as np
import synthetic

from berm.results import Curve, ResultError, Run, read_table


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.run_path = synthetic.write_run(os.path.join(cls.folder.name, "mpm"), cell=0.03, steps=100)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def write(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def test_history_by_bare_name(self):
        run = Run(self.run_path)
        self.assertEqual(run.units["nominal_stress"], "Pa")
        self.assertEqual(run.units["gauge:lateral"], "m")
        self.assertEqual(len(run.history["time"]), 101)
        self.assertAlmostEqual(run.history["imposed_displacement"][-1], synthetic.TRAVEL)

    def test_metrics_with_and_without_unit(self):
        run = Run(self.run_path)
        self.assertEqual(run.metric("peak_load"), run.metric("peak_load [N]"))
        self.assertGreater(run.metric("peak_load"), 5e6)
        self.assertIsNone(run.metric("stress_noise"))

    def test_peak_and_frames(self):
        run = Run(self.run_path)
        peak = run.peak_row()
        self.assertAlmostEqual(
            run.history["imposed_displacement"][peak], synthetic.PEAK_AT, delta=synthetic.TRAVEL / 100
        )
        self.assertEqual(run.frame_at(run.history["time"][peak]), 1)  # frames at 0, 1/3, 2/3, 1; the peak is at 0.47
        last = run.last()
        self.assertEqual(last["time"], 1.0)
        self.assertEqual(last["stress"].shape, (200, 6))
        self.assertEqual(last["position"].shape, (200, 3))
        np.testing.assert_array_equal(run.frame(3)["damage"], last["damage"])

    def test_row_cut_short_is_dropped(self):
        columns, _, _ = read_table(self.write("cut.csv", "a [m],b [-]\n1,2\n3,nan\n4"))
        np.testing.assert_array_equal(columns["a"], [1.0, 3.0])
        self.assertTrue(np.isnan(columns["b"][1]))

    def test_quoted_names(self):
        columns, units, _ = read_table(self.write("quoted.csv", '"probe:a,b [Pa]"\n5\n'))
        self.assertEqual((columns["probe:a,b"][0], units["probe:a,b"]), (5.0, "Pa"))

    def test_bad_files_are_named(self):
        for name, text in (("empty.csv", ""), ("words.csv", "a [m]\nx\ny\n"), ("ragged.csv", "a [m],b [m]\n1\n1,2\n")):
            with self.subTest(name), self.assertRaisesRegex(ResultError, name):
                read_table(self.write(name, text))
        with self.assertRaisesRegex(ResultError, "holds no history.csv"):
            Run(self.folder.name)

    def test_reference_in_si(self):
        curve = Curve(synthetic.write_reference(os.path.join(self.folder.name, "reference.csv")))
        self.assertEqual((curve.label, curve.source), ("Experiment", "a made-up test, figure 3"))
        np.testing.assert_allclose(curve.columns["nominal_stress"], [0, 16e6, 28e6, 34e6, 30e6])
        np.testing.assert_allclose(curve.columns["nominal_strain"][-1], 2e-3)

    def test_reference_errors(self):
        with self.assertRaisesRegex(ResultError, "two of the columns"):
            Curve(self.write("one.csv", "nominal_stress [Pa]\n1\n"))
        with self.assertRaisesRegex(ResultError, 'unit "psi"'):
            Curve(self.write("psi.csv", "nominal_stress [psi],nominal_strain [-]\n1,2\n"))


if __name__ == "__main__":
    unittest.main()
