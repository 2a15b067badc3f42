import contextlib
import importlib.util
import io
import os
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

HERE = pathlib.Path(__file__).resolve().parent
spec = importlib.util.spec_from_file_location("examples", HERE.parent / "examples.py")
examples = importlib.util.module_from_spec(spec)
spec.loader.exec_module(examples)

# Stands in for the program: refuses cases with the word "bad", else runs as fake_berm.py does.
BERM = f"""#!/bin/bash
grep -q bad "$2" && exit 2
[ "$1" = check ] && exit 0
shift 2
exec /usr/bin/python3 {HERE}/fake_berm.py run {__file__} "${{@:3}}"
"""


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.berm = self.root / "berm"
        self.berm.write_text(BERM, encoding="utf-8")
        self.berm.chmod(0o755)
        self.write("01_a/mpm.toml", 'title = "a"')
        self.write("ci.txt", "# comment\n01_a/mpm.toml steps=60  # shorter\n")
        # 0.15 m2 * 124.4e9 Pa/m * 2.8e-4 m of the synthetic run
        self.write("01_a/expected_mpm.csv", self.expected(5.225e6))

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")

    @staticmethod
    def expected(load):
        return f"quantity,value,tolerance,kind,source\npeak_load,{load},0.01,relative,hand\n"

    def run_main(self, *arguments):
        out = io.StringIO()
        with mock.patch.object(examples, "EXAMPLES", self.root), contextlib.redirect_stdout(out):
            with mock.patch.object(sys, "argv", ["examples.py", str(self.berm), *arguments]):
                with mock.patch.dict(os.environ):
                    code = examples.main()
        return code, out.getvalue()

    def test_listed_case_is_run_and_compared(self):
        code, printed = self.run_main()
        self.assertEqual((code, printed), (0, "ok 01_a/mpm.toml\n1 passed, 0 failed\n"))

    def test_wrong_value_is_found(self):
        self.write("01_a/expected_mpm.csv", self.expected(5.0e6))
        code, printed = self.run_main("--out", str(self.root / "out"), "01_a/mpm.toml")
        self.assertEqual(code, 1)
        self.assertIn("OFF", printed)
        self.assertTrue((self.root / "out/01_a/mpm/history.csv").is_file())

    def test_other_cases_are_checked_only(self):
        self.write("02_b/fem.toml", 'title = "b"')
        self.write("02_b/broken.toml", 'title = "bad"')
        code, printed = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn("FAILED 02_b/broken.toml", printed)
        self.assertTrue(printed.endswith("2 passed, 1 failed\n"), printed)

    def test_variants_of_sweeps_are_checked(self):
        self.write("02_b/broken.toml", 'title = "bad"')
        self.write("01_a/sweep.toml", '[variant.one]\ncase = "mpm.toml"\n[variant.two]\ncase = "../02_b/broken.toml"\n')
        code, printed = self.run_main("01_a/sweep.toml")
        self.assertEqual(code, 1)
        self.assertIn("variant two", printed)

    def test_list_fits_files(self):
        self.assertEqual(self.run_main("--check-list"), (0, "1 cases listed\n"))
        self.write("ci.txt", "01_a/mpm.toml\n01_a/gone.toml\n")
        self.write("01_a/fem.toml", "")
        self.write("01_a/expected_old.csv", "")
        code, printed = self.run_main("--check-list")
        self.assertEqual((code, printed.count("\n")), (1, 2), printed)
        self.write("ci.txt", "01_a/fem.toml\n")
        self.assertIn("there is no expected_fem.csv", self.run_main("--check-list")[1])


if __name__ == "__main__":
    unittest.main()
