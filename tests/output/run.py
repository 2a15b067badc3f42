#!/usr/bin/env python3
"""What a small run writes: run.py BERM"""

import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

from berm.report import write_report
from berm.results import Curve, ResultError, Run, read_grid

BERM = ""
CASE = """
title = "A block that is stretched"
method = "mpm"
grid = { origin = [-0.25, -0.25], cell_size = 0.25, cells = [6, 6] }
[material.m]
law = "LAW"
density = 2400.0
youngs_modulus = "30 GPa"
poisson_ratio = 0.2
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[boundary.left]
where.box = { min = [-9.0, 0.9999], max = [0.5001, 1.0001] }
uy = 1e-5
[boundary.right]
where.box = { min = [0.5001, 0.9999], max = [9.0, 1.0001] }
uy = 2e-5
[probe.middle]
at = [0.5, 0.5]
quantity = "stress_yy"
[steps]
count = 2
"""
ELASTIC = CASE.replace("LAW", "linear_elastic")
BRITTLE = CASE.replace('"LAW"', '"rankine"\ntensile_strength = "3 MPa"\nfracture_energy = 100.0')
LOADED = BRITTLE + """
[output]
references = [{ file = "lab.csv", x = "u", y = "F [kN]", label = "Lab" }, { file = "lab.csv", x = "u [mm]", y = "F" }]
nominal = { load = ["left", "right"], displacement = "left", direction = [0.0, 1.0], area = "5000 cm2" }
"""
# (names of the columns of x and y, text): the reader of cases and that of the report must both take it, or both refuse it.
CURVES = (
    ("d [mm]", "F [kN]", "d [mm];F [kN]\n1;1\n2;2\n"),
    ('a "x" [mm]', "F, max [kN]", '"a ""x"" [mm]","F, max [kN]"\n1,"1,5"\n2,2\n'),
    ("a x [mm]", "F [kN]", '"a ""x"" [mm]",F [kN]\n1,2\n'),
    ("a x [mm]", "F [kN]", 'a "x" [mm],F [kN]\n1,2\n'),
    ("d [mm]", "F [kN]", '"d [mm]\n"d [mm]\n'),
    ("d [b [mm]", "F [kN]", "d [b [mm],F [kN]\n1,2\n"),
    ("d", "F", "d[ mm ],F [k N]\n1,2\n"),
    ("d [mm]", "F [kN]", "\ufeffd [mm],F [kN]\r1,2\r"),
    ("d [mm]", "F [kN]", "d\u00a0[mm],F [kN]\n1,2\n"),
    ("d [mm]", "F [kN]", "d [mm],d [mm],F [kN]\n1,1,2\n"),
    *(
        ("d [mm]", "F [kN]", f"d [mm];F [kN]\n{number};1\n")
        for number in "1_000|1e400|1e-400|1e-310|inf|nan|NaN(1)|+1|+-1|++1|1.|.5|1 000|1.000,5|0x10|\uff11|1\u00a0".split("|")
    ),
)
# Without cohesion a wall of sand stands in no step, however small.
FALLING = """
title = "Sand that cannot stand"
method = "mpm"
model = { gravity = [0.0, "-9.81"], kinematics = "small" }
grid = { origin = [-0.25, -0.25], cell_size = 0.125, cells = [20, 24] }
[material.m]
law = "mohr_coulomb"
density = 2000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
cohesion = 1.0
friction_angle = 20.0
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 2.0] }
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[steps]
count = 1
min_fraction = 1e-15
"""


class Output(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "lab.csv").write_text("Test 7\nu [mm];F [kN]\n0,0;0\n0,01;500\n", encoding="utf-8")
        cls.elastic, cls.loaded = cls.run_case("elastic", ELASTIC), cls.run_case("loaded", LOADED)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def run_case(cls, name, text):
        (cls.path / f"{name}.toml").write_text(text, encoding="utf-8")
        subprocess.run([BERM, "run", f"{name}.toml", "--out", name, "--quiet"], cwd=cls.path, check=True)
        return Run(cls.path / name)

    def test_metrics_without_a_meaning_are_left_out(self):
        names = set(self.elastic.summary["metrics"])
        self.assertFalse({n for n in names if n.startswith(("peak", "displacement", "stiffness", "stress_", "max_damage"))})
        self.assertIn("energy_error [-]", names)
        self.assertLessEqual({"peak_load [N]", "stiffness_10_40 [Pa]", "max_damage [-]"}, set(self.loaded.summary["metrics"]))
        log = (self.path / "elastic" / "log.txt").read_text(encoding="utf-8")
        self.assertNotIn("nan", log)
        self.assertNotIn("peak_load", log)

    def test_load_of_several_boundaries_is_their_sum(self):
        history = self.loaded.history
        both = history["reaction_y:left"] + history["reaction_y:right"]
        self.assertGreater(history["reaction"][-1], 1.2 * history["reaction_y:right"][-1])
        np.testing.assert_allclose(history["reaction"], both, rtol=1e-12)
        np.testing.assert_allclose(history["nominal_stress"], both / 0.5, rtol=1e-12)

    def test_a_signal_ends_a_run_whose_attempts_fail(self):
        (self.path / "falling.toml").write_text(FALLING, encoding="utf-8")
        command = [BERM, "run", "falling.toml", "--out", "falling", "--quiet"]
        with subprocess.Popen(command, cwd=self.path, stderr=subprocess.PIPE, text=True) as process:
            log = self.path / "falling" / "log.txt"
            while process.poll() is None and not (log.is_file() and ": failed" in log.read_text(encoding="utf-8")):
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            said = process.communicate()[1]
        self.assertIn("stopped by a signal at time 0;", said)
        self.assertEqual((process.returncode, Run(self.path / "falling").summary["status"]), (1, "stopped"))

    def test_components_have_names(self):
        data = read_grid(self.loaded.frames[-1][1]).GetPointData()
        names = lambda field: [data.GetArray(field).GetComponentName(k) for k in range(data.GetArray(field).GetNumberOfComponents())]  # noqa: E731
        self.assertEqual(names("displacement"), ["X", "Y", "Z"])
        self.assertEqual(names("stress"), ["XX", "YY", "ZZ", "XY", "YZ", "XZ"])

    def test_both_readers_of_references_agree(self):
        for number, (x, y, text) in enumerate(CURVES):
            file = self.path / f"curve_{number}.csv"
            file.write_text(text, encoding="utf-8", newline="")
            reference = f"{{ file = {json.dumps(file.name)}, x = {json.dumps(x)}, y = {json.dumps(y)} }}"
            (self.path / "curve.toml").write_text(f"{ELASTIC}[output]\nreferences = [{reference}]\n", encoding="utf-8")
            checked = subprocess.run([BERM, "check", "curve.toml"], cwd=self.path, capture_output=True, text=True, check=False)
            try:
                Curve({"file": str(file), "x": x, "y": y})
                why = ""
            except ResultError as error:
                why = str(error)
            with self.subTest(text):
                self.assertEqual(checked.returncode, 2 if why else 0, f"{checked.stderr}\n{why}")

    def sweep(self, *words):
        return subprocess.run([BERM, "sweep", "sweep.toml", "--out", "swept", *words], cwd=self.path, capture_output=True, text=True, check=False)

    def test_sweep_keeps_what_is_finished_and_what_it_did_not_write(self):
        (self.path / "sweep.toml").write_text('[variant.a]\ncase = "elastic.toml"\n', encoding="utf-8")
        folder = self.path / "swept" / "a"
        folder.mkdir(parents=True)
        (folder / "note.txt").write_text("mine", encoding="utf-8")
        self.assertEqual(self.sweep().returncode, 0)
        version = (folder / "history.csv").stat().st_mtime_ns
        refused = self.sweep()
        self.assertEqual((refused.returncode, (folder / "history.csv").stat().st_mtime_ns), (1, version))
        self.assertIn("holds the results of a run that came to its end: --force", refused.stderr)
        self.assertEqual(self.sweep("--force").returncode, 0)
        self.assertGreater((folder / "history.csv").stat().st_mtime_ns, version)
        self.assertEqual((folder / "note.txt").read_text(encoding="utf-8"), "mine")

    def test_report_draws_references_and_what_is_recorded(self):
        page = pathlib.Path(write_report([str(self.path / "loaded")])).read_text(encoding="utf-8")
        self.assertNotIn("Not drawn", page)
        for words in ("Lab: no source given", "Probes over time", "Reactions over time"):
            self.assertIn(words, page)
        elastic = pathlib.Path(write_report([str(self.path / "elastic")])).read_text(encoding="utf-8")
        self.assertNotIn("Damage, last frame", elastic)
        self.assertNotIn("Peak load", elastic)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    BERM = str(pathlib.Path(sys.argv.pop()).resolve())
    unittest.main()
