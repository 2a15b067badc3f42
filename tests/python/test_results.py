import contextlib
import os
import re
import shutil
import tempfile
import unittest

import numpy as np
import synthetic

from berm.results import (
    Curve,
    ResultError,
    Run,
    find_number,
    read_mesh,
    read_points,
    read_series,
    read_table,
    split_cells,
    split_unit,
)


@contextlib.contextmanager
def standard_error():
    """[what was written to the file descriptor 2], also by libraries."""
    said, kept = [], os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield said
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            said.append(file.read())


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

    def test_pieces_are_the_whole(self):
        whole = Run(synthetic.write_run(os.path.join(self.folder.name, "whole"), cell=0.05, steps=5, frames=2))
        parts = synthetic.write_run(os.path.join(self.folder.name, "parts"), cell=0.05, steps=5, frames=2)
        synthetic.split_frames(parts, 2)
        self.assertTrue(os.path.isfile(os.path.join(parts, "points_0001_1.vtu")))
        parts = Run(parts)
        for index in (0, 1):
            one, other = whole.frame(index), parts.frame(index)
            self.assertEqual(set(one), set(other))
            for name in one:
                np.testing.assert_array_equal(one[name], other[name])

    def test_missing_piece_is_named(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "lost"), cell=0.05, steps=5, frames=2)
        synthetic.split_frames(path, 2)
        os.remove(os.path.join(path, "points_0001_1.vtu"))
        with self.assertRaisesRegex(ResultError, r"points_0001\.pvtu names the piece .*points_0001_1\.vtu, which"):
            Run(path).last()

    def test_empty_piece_and_repeated_id(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "odd"), cell=0.05, steps=5, frames=1)
        source = os.path.join(path, "points_0000.vtu")
        synthetic.write_points(os.path.join(path, "empty.vtu"), {"position": np.zeros((0, 3))})
        pieces = os.path.join(path, "p.pvtu")
        synthetic.write_pieces(pieces, ["empty.vtu", "points_0000.vtu"])
        np.testing.assert_array_equal(read_points(pieces)["stress"], read_points(source)["stress"])
        synthetic.write_pieces(pieces, ["points_0000.vtu", "points_0000.vtu"])
        with self.assertRaisesRegex(ResultError, "same id"):
            read_points(pieces)

    def test_mesh_of_pieces(self):
        folder = self.folder.name
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
        for rank in (0, 1):
            synthetic.write_grid(
                os.path.join(folder, f"m_{rank}.vtu"),
                corners + rank,
                10,
                [[0, 1, 2, 3]],
                {"displacement": 0.1 * corners},
                {"damage": np.array([0.5 * rank])},
            )
        synthetic.write_pieces(os.path.join(folder, "m.pvtu"), ["m_0.vtu", "m_1.vtu"])
        mesh = read_mesh(os.path.join(folder, "m.pvtu"))
        self.assertEqual((mesh.GetNumberOfPoints(), mesh.GetNumberOfCells()), (8, 2))
        self.assertEqual(mesh.GetCellData().GetArray("damage").GetValue(1), 0.5)

    def test_row_cut_short_is_dropped(self):
        columns, _, _ = read_table(self.write("cut.csv", "a [m],b [-]\n1,2\n3,nan\n4"))
        np.testing.assert_array_equal(columns["a"], [1.0, 3.0])
        self.assertTrue(np.isnan(columns["b"][1]))

    def test_quoted_names(self):
        columns, units, _ = read_table(self.write("quoted.csv", '"probe:a,b [Pa]"\n5\n'))
        self.assertEqual((columns["probe:a,b"][0], units["probe:a,b"]), (5.0, "Pa"))

    def test_damaged_summary_is_named(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "damaged"), cell=0.05, steps=5, frames=1)
        for text, words in (
            ("[]", "must hold a table, not \\[\\]"),
            ("null", "must hold a table, not null"),
            ('{"metrics": [1]}', '"metrics" must be a table of numbers, not \\[1\\]'),
            ('{"metrics": {"a": "b"}}', '"metrics" must be a table of numbers'),
            ('{"dimension": "two"}', '"dimension" must be 2 or 3, not "two"'),
            ('{"dimension": true}', '"dimension" must be 2 or 3'),
            ('{"title": 7}', '"title" must be a text, not 7'),
            ('{"references": [3]}', '"references" must be a list of files'),
            ('{"references": [{"x": "u"}]}', '"references" must be a list of files'),
            ('{"body_rings": {"a": [[[1, "x"]]]}}', '"body_rings" must be'),
            ('{"rigid_motion": {"a": [[1, 2, 3]]}}', '"rigid_motion" must be'),
            ('{"title": "a"', "Expecting"),
            (100000 * "[", "recursion"),
        ):
            with self.subTest(text[:40]):
                self.write(os.path.join("damaged", "summary.json"), text)
                with self.assertRaisesRegex(ResultError, r"^\S*/summary\.json is damaged: .*" + words + ".*remove the file") as caught:
                    Run(path)
                self.assertNotIn("\n", str(caught.exception))
        self.write(os.path.join("damaged", "summary.json"), '{"title": null, "metrics": {"stress_noise [-]": null}}')
        self.assertNotIn("title", Run(path).summary)

    def test_paths_that_are_no_utf8(self):
        path = os.path.join(self.folder.name, os.fsdecode(b"d\xe9j\xe0"))
        shutil.copytree(self.run_path, path)
        with open(os.path.join(path, "summary.json"), "wb") as file:
            file.write(b'{"command": "berm run d\xe9j\xe0/case.toml", "title": "d\xe9j\xe0"}')
        run = Run(path)
        self.assertEqual((run.name, run.summary["title"]), ("d\ufffdj\ufffd", "d\ufffdj\ufffd"))
        np.testing.assert_array_equal(run.last()["stress"], Run(self.run_path).last()["stress"])

    def test_cut_off_points_are_refused_without_words_of_vtk(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "cut"), cell=0.05, steps=5, frames=1)
        file_name = os.path.join(path, "points_0000.vtu")
        with open(file_name, "rb") as file:
            whole = file.read()
        for part in (0.0, 0.1, 0.5, 0.9):
            with open(file_name, "wb") as file:
                file.write(whole[: int(part * len(whole))])
            with self.subTest(part), standard_error() as said:
                with self.assertRaisesRegex(ResultError, f"VTK cannot read {file_name}: it is damaged or cut off"):
                    read_points(file_name)
            self.assertEqual(said, [b""])

    def test_more_points_than_a_file_can_hold(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "many"), cell=0.05, steps=5, frames=1)
        file_name = os.path.join(path, "points_0000.vtu")
        with open(file_name, "rb") as file:
            whole = file.read()
        with open(file_name, "wb") as file:
            file.write(re.sub(rb'NumberOfPoints="\d+"', b'NumberOfPoints="400000000000"', whole))
        with self.assertRaisesRegex(ResultError, f"{file_name}: names more points or cells than it can hold"):
            read_points(file_name)

    def test_series_without_times_or_files(self):
        for entry in ('<DataSet file="a.vtu"/>', '<DataSet timestep="x" file="a.vtu"/>'):
            with self.subTest(entry), self.assertRaisesRegex(ResultError, "cannot read .*odd.pvd"):
                read_series(self.write("odd.pvd", f"<VTKFile><Collection>{entry}</Collection></VTKFile>"))

    def test_bad_files_are_named(self):
        with self.assertRaisesRegex(ResultError, "cannot read .*long.csv: field larger"):
            read_table(self.write("long.csv", "a [m]\n" + 200000 * "1"))
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

    def test_cells_and_numbers_as_in_cases(self):
        for line, cells in (
            ('"a ""x"" [mm]",b', ['a "x" [mm]', "b"]),
            ('a "x" [mm],"F, max [kN]"', ["a x [mm]", "F, max [kN]"]),
            ('"",""""', ["", '"']),
            ('"d [mm],F', ["d [mm],F"]),
            ('a""b,', ["ab", ""]),
        ):
            self.assertEqual(split_cells(line, ","), cells, line)
        self.assertEqual(split_unit(" a [b[c ] "), ("a [b", "c"))
        self.assertEqual(split_unit("a [x] [mm]"), ("a [x]", "mm"))
        self.assertEqual(split_unit("one\ntwo [m]"), ("one\ntwo", "m"))
        for text, value in (("1,5", 1.5), (" +1e3\t", 1e3), ("+-1", -1.0), (".5", 0.5), ("1.", 1.0), ("0e-999", 0.0), ("1e-310", 1e-310)):
            self.assertEqual(find_number(text), value, text)
        for text in ("", " ", "nan", "-NaN", "+nan", "nan(1)"):
            self.assertTrue(np.isnan(find_number(text)), text)
        refused = "1_000|inf|-Infinity|1e400|1e-400|\uff11|0x10|1 000|1.000,5|++1|+|.|1e|nan(a b)|1\u00a0"
        for text in refused.split("|"):
            with self.subTest(text), self.assertRaises(ValueError):
                find_number(text)

    def test_quotes_in_a_header(self):
        path = self.write("quotes.csv", '"a ""x"" [mm]","F, max [kN]"\n1,"1,5"\n2,2\n')
        curve = Curve({"file": path, "x": 'a "x" [mm]', "y": "F, max [kN]"})
        np.testing.assert_allclose(curve.columns["reaction"], [1500.0, 2000.0])
        path = self.write("bare.csv", 'a "x" [mm],F [kN]\n1,2\n')
        self.assertEqual(Curve({"file": path, "x": "a x", "y": "F"}).columns["imposed_displacement"][0], 1e-3)

    def test_mark_of_utf8_before_latin_1(self):
        path = self.write("mark.csv", "")
        with open(path, "wb") as file:
            file.write(b"\xef\xbb\xbfu [\xb5m],F [kN]\n1,2\n")
        self.assertAlmostEqual(Curve({"file": path, "x": "u", "y": "F"}).columns["imposed_displacement"][0], 1e-6)

    def test_pipe_is_no_reference(self):
        path = os.path.join(self.folder.name, "pipe.csv")
        os.mkfifo(path)
        for odd in (path, self.folder.name, "/dev/null"):
            with self.subTest(odd), self.assertRaisesRegex(ResultError, f"cannot read {odd}: it is no regular file"):
                Curve(odd)

    def test_reference_errors(self):
        with self.assertRaisesRegex(ResultError, 'one.csv:1: no column "nominal_strain".*there are "nominal_stress .Pa."'):
            Curve(self.write("one.csv", "nominal_stress [Pa]\n1\n"))
        with self.assertRaisesRegex(ResultError, 'twice.csv:1: more than one column is "nominal_stress"'):
            Curve(self.write("twice.csv", "nominal_strain [-],nominal_stress [Pa],nominal_stress [Pa]\n1,2,3\n"))
        with self.assertRaisesRegex(ResultError, 'unit "psi"'):
            Curve(self.write("psi.csv", "nominal_stress [psi],nominal_strain [-]\n1,2\n"))

    def test_named_columns_of_a_testing_machine(self):
        path = self.write("lab.csv", "")
        with open(path, "wb") as file:  # Latin-1, a preamble, decimal commas, a gap
            file.write("Prüfung 7\r\n\r\nZeit [s];Weg [µm];Kraft [kN]\r\n0;0,5;1,25\r\n1;;2\r\n2;2;3\r\n".encode("latin-1"))
        curve = Curve({"file": path, "x": "Weg", "y": "Kraft [kN]", "label": "Lab"})
        np.testing.assert_allclose(curve.columns["imposed_displacement"], [0.5e-6, 2e-6])
        np.testing.assert_allclose(curve.columns["reaction"], [1250.0, 3000.0])
        self.assertEqual(curve.label, "Lab")
        over_time = Curve({"file": path, "x": "Zeit [s]", "y": "Kraft"})
        np.testing.assert_allclose(over_time.columns["time"], [0.0, 1.0, 2.0])

    def test_unit_of_a_column_without_one(self):
        path = self.write("iso.csv", 'F / kN,"s, mm"\n1,"0,1"\n')
        curve = Curve({"file": path, "x": "s, mm [mm]", "y": "F / kN [kN]"})
        self.assertEqual((curve.columns["imposed_displacement"][0], curve.columns["reaction"][0]), (1e-4, 1e3))

    def test_errors_of_named_columns(self):
        names = {"x": "u [mm]", "y": "F [kN]"}
        for text, words in (
            ("u [mm],F [N]\n1,2\n", 'csv:1: no column "F .kN."; there are "u .mm.", "F .N."'),
            ("u [mm],F [kN]\n1,2\n1,x\n", 'csv:3: "x" in column "F" is no number'),
            ("u [mm],F [kN]\n0,1,0,2\n0,2,0,4\n", "csv:2: 4 cells, where the header has 2"),
            ("u [mm];F [kN]\n0,1;0.2\n", "commas and decimal points"),
            ("u [mm];F [kN]\n;1\n", "csv:1: no row"),
            ("u [mm];F [kN]\n1\n1;1\n", "csv:2: 1 cells"),
        ):
            with self.subTest(text), self.assertRaisesRegex(ResultError, words):
                Curve({"file": self.write("bad.csv", text), **names})
        with self.assertRaisesRegex(ResultError, 'has the unit "kN"; x may have'):
            Curve({"file": self.write("swapped.csv", "u [mm],F [kN]\n1,2\n"), "x": "F", "y": "u"})


if __name__ == "__main__":
    unittest.main()
