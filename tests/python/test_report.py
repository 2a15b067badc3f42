import base64
import contextlib
import html.parser
import io
import json
import os
import subprocess
import sys
import tempfile
import unittest

import matplotlib.pyplot as plt
import numpy as np
import synthetic

from berm import report
from berm.figures import (
    MAPS,
    STRESS_STRAIN,
    colour_limits,
    curve_figure,
    map_figure,
    time_figure,
    time_groups,
    unit_for,
)
from berm.raster import Grid, body_picture, inside_rings, paint
from berm.results import Run, read_points, read_series
from berm.scene import make_scenes


class Page(html.parser.HTMLParser):
    """Collects what the tests ask about a report."""

    def __init__(self, path):
        super().__init__()
        self.images, self.cells, self.outside, self.open = {}, [], [], []
        with open(path, encoding="utf-8") as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        if tag == "img":
            self.images[attrs["alt"]] = attrs["src"]
        self.outside += [v for k, v in attrs.items() if k in ("src", "href") and not v.startswith("data:")]
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open.pop() != tag:
            raise AssertionError(f"misplaced </{tag}>")

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.cells.append(data)


def run_main(*arguments):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = report.main(list(arguments))
    return code, out.getvalue(), err.getvalue()


def run_program(*arguments, **more):
    """As a process of its own, with a terminal that knows UTF-8 alone."""
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8:strict"}
    return subprocess.run(
        [sys.executable, "-m", "berm.report", *arguments], capture_output=True, timeout=120, env=environment, check=False, **more
    )


class ReportOfTwoRuns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        reference = synthetic.write_reference(os.path.join(cls.folder.name, "reference.csv"))
        cls.mpm = synthetic.write_run(os.path.join(cls.folder.name, "mpm"), cell=0.03, steps=50, references=[reference])
        cls.fem = synthetic.write_run(os.path.join(cls.folder.name, "second"), "fem", 1.02, cell=0.03, steps=50)
        with open(os.path.join(cls.mpm, "log.txt"), "w", encoding="utf-8") as file:
            file.write("step 1\nwarning: 3 cells are <barely> filled\n")
        cls.code, cls.printed, cls.errors = run_main(cls.mpm, cls.fem)
        cls.page = Page(os.path.join(cls.mpm, "report.html"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_succeeds_and_prints_the_path(self):
        self.assertEqual((self.code, self.errors), (0, ""))
        self.assertEqual(self.printed.strip(), os.path.join(self.mpm, "report.html"))

    def test_is_self_contained_and_well_formed(self):
        self.assertEqual(self.page.outside, [])
        self.assertEqual(self.page.open, [])

    def test_every_picture_is_there_and_saved(self):
        maps = [f"{frame}_{field.name}.png" for frame in ("peak", "last") for field in MAPS]
        for name in ["stress_strain.png", "load_displacement.png", "gauges.png", "energies.png", *maps]:
            with self.subTest(name), open(os.path.join(self.mpm, name), "rb") as file:
                embedded = "data:image/png;base64," + base64.b64encode(file.read()).decode()
                self.assertIn(embedded, self.page.images.values())
        self.assertEqual(len(self.page.images), 16)

    def test_table_compares(self):
        cells = self.page.cells
        self.assertIn("mpm", cells)
        self.assertIn("second (FEM)", cells)
        row = cells.index("Peak load")
        self.assertTrue(cells[row + 1].endswith(" MN"))
        self.assertEqual(cells[row + 3], "+2.00 %")
        self.assertNotIn("Stress noise", cells)  # has no value in either run

    def test_text_is_escaped_and_sourced(self):
        with open(os.path.join(self.mpm, "report.html"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("&lt;0.15 x 0.30 m&gt;", text)
        self.assertIn("a made-up test, figure 3", text)
        self.assertIn("warning: 3 cells are &lt;barely&gt; filled", text)
        self.assertNotIn("step 1", text)


class ReportCorners(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "run")

    def test_folder_without_history(self):
        code, _, errors = run_main(self.folder.name)
        self.assertEqual(code, 2)
        self.assertIn("holds no history.csv", errors)
        self.assertIn(self.folder.name, errors)

    def test_missing_reference(self):
        synthetic.write_run(self.path, cell=0.05, steps=10)
        code, _, errors = run_main(self.path, "--reference", "nowhere.csv")
        self.assertEqual(code, 2)
        self.assertIn("nowhere.csv", errors)

    def test_bad_curve_of_a_case_costs_that_curve(self):
        bad = os.path.join(self.folder.name, "bad.csv")
        with open(bad, "w", encoding="utf-8") as file:
            file.write("Time [s],CMOD [mm],Load [kN]\n0,0,0\n1.5,0.005,4.656\n")
        good = {"file": bad, "x": "CMOD [mm]", "y": "Load [kN]", "delimiter": "", "label": "Lab"}
        over_time = {**good, "x": "Time [s]"}
        synthetic.write_run(self.path, cell=0.05, steps=10, references=[bad, good, over_time, "/nowhere.csv"])
        code, _, errors = run_main(self.path)
        self.assertEqual((code, errors.count("warning: ")), (0, 2))
        self.assertIn(f"{bad}:1: no column", errors)
        with open(os.path.join(self.path, "report.html"), encoding="utf-8") as file:
            text = file.read()
        self.assertEqual(text.count("Not drawn: reference curve"), 2)
        self.assertIn("Lab: no source given", text)
        self.assertIn("Load over time", Page(os.path.join(self.path, "report.html")).images)

    def test_elastic_run_has_no_maps_of_damage(self):
        synthetic.write_run(self.path, cell=0.05, steps=10)
        file_name = os.path.join(self.path, "summary.json")
        with open(file_name, encoding="utf-8") as file:
            summary = json.load(file)
        del summary["metrics"]["max_damage [-]"]
        with open(file_name, "w", encoding="utf-8") as file:
            json.dump(summary, file)
        self.assertEqual(run_main(self.path)[0], 0)
        images = Page(os.path.join(self.path, "report.html")).images
        self.assertNotIn("Damage, last frame", images)
        self.assertIn("Stress σxx, last frame", images)

    def test_gauges_probes_and_reactions_over_time(self):
        os.makedirs(self.path)
        names = "gauge:cmod [m],probe:deep [Pa],probe:far [m],reaction_x:wall [N],reaction_y:wall [N],reaction_x:still [N]"
        with open(os.path.join(self.path, "history.csv"), "w", encoding="utf-8") as file:
            file.write(f"step [-],time [s],{names}\n0,0,0,0,0,0,0,0\n1,1,1e-3,2e6,3,1e-9,5e3,0\n")
        run = Run(self.path)
        groups = time_groups([run])
        self.assertEqual([g[0] for g in groups], ["gauges", "probes_Pa", "probes_m", "reactions"])
        self.assertEqual(groups[3][2], ["reaction_y:wall"])  # what is round-off is not drawn
        figure = time_figure([run, run], ["one", "two"], *groups[1][1:])
        self.assertEqual(figure.axes[0].get_ylabel(), "Probes [MPa]")
        np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), [0.0, 2.0])
        self.assertEqual(len(figure.axes[0].get_legend_handles_labels()[0]), 2)
        plt.close(figure)
        self.assertEqual(run_main(self.path)[0], 0)
        images = Page(os.path.join(self.path, "report.html")).images
        self.assertEqual(set(images), {"Gauges over time", "Probes over time", "Reactions over time"})

    def test_killed_run_without_summary_points_and_load(self):
        os.makedirs(self.path)
        with open(os.path.join(self.path, "history.csv"), "w", encoding="utf-8") as file:
            file.write("step [-],time [s],nominal_stress [Pa],nominal_strain [-]\n0,0,0,0\n1,0.1,0,0\n2,0.")
        code, _, errors = run_main(self.path)
        self.assertEqual((code, errors), (0, ""))
        self.assertEqual(Page(os.path.join(self.path, "report.html")).images, {})

    def test_plastic_strain_in_place_of_damage(self):
        synthetic.write_run(self.path, cell=0.05, steps=10)
        for _, file in read_series(os.path.join(self.path, "points.pvd")):
            fields = read_points(file)
            fields["plastic_strain"] = 0.1 * fields["damage"]
            fields["damage"] *= 0.0
            synthetic.write_points(file, fields)
        self.assertEqual(run_main(self.path)[0], 0)
        images = Page(os.path.join(self.path, "report.html")).images
        self.assertIn("Plastic strain, last frame", images)
        self.assertNotIn("Damage, last frame", images)
        self.assertNotIn("Crack opening, last frame", images)
        self.assertIn("Stress σxx, last frame", images)

    def test_history_without_rows(self):
        os.makedirs(self.path)
        with open(os.path.join(self.path, "history.csv"), "w", encoding="utf-8") as file:
            file.write("step [-],time [s]\n")
        code, _, errors = run_main(self.path)
        self.assertEqual(code, 2)
        self.assertIn("no rows", errors)

    def test_failed_run_shows_its_reason(self):
        synthetic.write_run(self.path, cell=0.05, steps=10, frames=2)
        file_name = os.path.join(self.path, "summary.json")
        with open(file_name, encoding="utf-8") as file:
            summary = json.load(file)
        summary.update(status="failed", reason="step cut to nothing")
        with open(file_name, "w", encoding="utf-8") as file:
            json.dump(summary, file)
        out = os.path.join(self.folder.name, "elsewhere", "r.html")
        os.makedirs(os.path.dirname(out))
        self.assertEqual(run_main(self.path, "--out", out, "--scale", "20")[0], 0)
        self.assertIn("failed: step cut to nothing", Page(out).cells)
        self.assertTrue(os.path.isfile(os.path.join(self.folder.name, "elsewhere", "last_damage.png")))


    def test_report_goes_where_there_is_a_folder(self):
        synthetic.write_run(self.path, cell=0.05, steps=10, frames=2)
        missing = os.path.join(self.folder.name, "no", "such")
        case, page = os.path.join(self.path, "case.toml"), os.path.join(self.path, "notes.html")
        with open(page, "w", encoding="utf-8") as file:
            file.write("mine")
        before = sorted(os.listdir(self.path))
        for out, words in ((os.path.join(missing, "x.html"), f"there is no folder {missing} (create it"), (self.path, "it is a folder (name"),
                           (case, "a report is a page of HTML"), (page, "it holds something that is not a report")):
            with self.subTest(out):
                code, printed, errors = run_main(self.path, "--out", out)
                self.assertEqual((code, printed, errors.count("\n")), (2, "", 1))
                self.assertIn(f"error: cannot write {out}: {words}", errors)
        self.assertEqual((os.listdir(self.folder.name), sorted(os.listdir(self.path))), (["run"], before))

    def test_words_that_mean_nothing(self):
        for words in (("--scale", "nan"), ("--scale", "inf"), ("--scale", "0"), ("--scale", "-1"), ("--scale", "wide"), ("--out", "")):
            with self.subTest(words), self.assertRaises(SystemExit) as end, contextlib.redirect_stderr(io.StringIO()) as errors:
                report.main([self.path, *words])
            self.assertEqual(end.exception.code, 2)
            self.assertRegex(errors.getvalue(), "is not a finite positive number|is empty: a variable that is not set")

    def test_dollars_are_no_mathematics(self):
        path = synthetic.write_run(os.path.join(self.folder.name, "$x_$"), cell=0.05, steps=10, frames=2)
        self.assertEqual(run_main(path)[0], 0)

    def test_paths_that_are_no_utf8(self):
        path = synthetic.write_run(self.path, cell=0.05, steps=10, frames=2)
        odd = os.path.join(self.folder.name, os.fsdecode(b"d\xe9j\xe0"))
        os.rename(path, odd)
        synthetic.write_reference(os.path.join(odd, os.fsdecode(b"r\xe9f.csv")))
        done = run_program(odd, "--reference", os.path.join(odd, os.fsdecode(b"r\xe9f.csv")), "--title", os.fsdecode(b"t\xe9st"))
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        self.assertEqual(done.stdout, os.fsencode(odd) + b"/report.html\n")
        with open(os.path.join(odd, "report.html"), encoding="utf-8") as file:
            self.assertIn("<h1>t\ufffdst</h1>", file.read())
        done = run_program(os.path.join(odd, "nowhere"))
        self.assertEqual((done.returncode, done.stderr[:8 + len(os.fsencode(odd))]), (2, b"error: " + os.fsencode(odd) + b"/"))

    def test_pipe_is_refused(self):
        synthetic.write_run(self.path, cell=0.05, steps=10, frames=2)
        pipe = os.path.join(self.folder.name, "pipe.csv")
        os.mkfifo(pipe)
        done = run_program(self.path, "--reference", pipe, text=True)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
        self.assertIn(f"error: cannot read {pipe}: it is no regular file", done.stderr)


class Maps(unittest.TestCase):
    def test_outliers_do_not_set_the_colours(self):
        values = np.concatenate([np.linspace(-2e6, 1e6, 1000), [1e9]])
        low, high = colour_limits("signed", [values])
        self.assertEqual(low, -high)
        self.assertAlmostEqual(high, 2e6, delta=0.05e6)

    def test_colours_are_common_to_the_runs(self):
        self.assertEqual(colour_limits("magnitude", [np.array([0.1]), np.array([0.4])]), (0.0, 0.4))
        self.assertEqual(colour_limits("fraction", [np.array([0.1])]), (0.0, 1.0))
        self.assertEqual(colour_limits("opening", [np.zeros(5)]), (0.0, 0.0))

    def test_a_crack_sets_the_colours_of_its_opening(self):
        faint, crack = np.full(20000, 1e-9), np.linspace(0.8e-4, 1e-4, 50)  # a quarter of a per cent of the points
        low, high = colour_limits("opening", [np.concatenate([faint, crack])])
        self.assertEqual(low, 0.0)
        self.assertTrue(0.9e-4 < high <= 1e-4, high)

    def test_units(self):
        self.assertEqual(unit_for("Pa", 35e6), (1e6, "MPa"))
        self.assertEqual(unit_for("m", 2.85e-4), (1e-3, "mm"))
        self.assertEqual(unit_for("N", 5.3e6), (1e6, "MN"))

    def test_gauss_points_leave_no_seams(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(synthetic.write_run(os.path.join(folder, "mpm"), cell=0.01, steps=10, frames=2))
            scene = make_scenes([run], ["mpm"], [0], 1.0)[0]
        x0, x1, y0, y1 = scene.extent
        rows, cols = scene.picture.shape
        x = x0 + (np.arange(cols) + 0.5) * (x1 - x0) / cols
        y = y0 + (np.arange(rows) + 0.5) * (y1 - y0) / rows
        inside = np.logical_and.outer((y > 0.001) & (y < 0.299), np.abs(x) < 0.074)
        self.assertTrue((scene.picture[inside] >= 0).all())
        outside = np.logical_or.outer((y < -0.002) | (y > 0.302), np.abs(x) > 0.077)
        self.assertTrue((scene.picture[outside] == -1).all())

    def test_pixel_takes_its_nearest_point(self):
        x, y = np.array([0.5, 1.5, 9.5]), np.array([0.5, 0.5, 0.5])
        picture, distance = body_picture(x, y, np.ones(3), (0.0, 4.0, 0.0, 1.0), 0.25)
        np.testing.assert_array_equal(picture[0], [0, 0, 0, 0, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1, -1])
        self.assertAlmostEqual(distance[0, 0], np.hypot(0.375, 0.375))
        self.assertTrue(np.isinf(distance[0, 8:]).all())
        painted = paint(picture, np.array([5.0, 7.0, 0.0]))
        self.assertEqual((painted[0, 0], painted[0, 5]), (5.0, 7.0))
        self.assertTrue(painted.mask[0, 10])

    def test_outline_with_a_hole(self):
        square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        mask = inside_rings([4.0 * square, 1.0 + 2.0 * square], Grid.over((-1.0, 5.0, 0.0, 4.0), 0.5))
        self.assertEqual(mask.sum(), 8 * 8 - 4 * 4)
        np.testing.assert_array_equal(np.flatnonzero(mask[3]), [2, 3, 8, 9])

    def test_uneven_points_fill_their_outline_and_no_more(self):
        x, y = (np.indices((20, 20)).reshape(2, 400) + np.random.default_rng(1).random((2, 400))) / 20.0
        ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        shift = np.tile([0.3, 0.0], (400, 1))
        picture, _ = body_picture(x + 0.3, y, np.full(400, 0.05), (0.0, 1.5, -0.2, 1.2), 0.01, shift, [ring])
        self.assertTrue((picture[20:120, 30:130] >= 0).all())
        self.assertEqual((picture >= 0).sum(), 100 * 100)

    def test_opened_gap_stays_white(self):
        x, y = (a.ravel() + 0.5 for a in np.meshgrid(np.arange(10.0), np.arange(4.0)))
        ring = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [0.0, 4.0]])

        def widths(opening):
            shift = np.stack([np.where(x > 5.0, opening, 0.0), 0.0 * x], axis=1)
            picture, _ = body_picture(x + shift[:, 0], y, np.ones(40), (0.0, 14.0, 0.0, 4.0), 0.1, shift, [ring])
            return 0.1 * (picture >= 0).sum(axis=1)

        np.testing.assert_allclose(widths(0.8), 10.8)  # below a side: the body is whole
        np.testing.assert_allclose(widths(3.0), 10.0, atol=0.25)

    def test_rigid_bodies_are_drawn_where_they_are(self):
        with tempfile.TemporaryDirectory() as folder:
            path = synthetic.write_run(os.path.join(folder, "mpm"), cell=0.03, steps=10, frames=2)
            file_name = os.path.join(path, "summary.json")
            with open(file_name, encoding="utf-8") as file:
                summary = json.load(file)
            summary["body_rings"]["platen"] = [[[-0.1, 0.3], [0.1, 0.3], [0.1, 0.4], [-0.1, 0.4]]]
            summary["rigid_motion"] = {"platen": [[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, -0.02, 0.0]]}
            with open(file_name, "w", encoding="utf-8") as file:
                json.dump(summary, file)
            run = Run(path)
            scene = make_scenes([run], ["mpm"], [-1], 2.0)[0]
        self.assertEqual(list(scene.outlines), [0])
        factor = run.frames[-1][0]
        self.assertGreater(factor, 0.0)
        self.assertAlmostEqual(scene.rigid[0][0][0, 1], 0.3 - 2.0 * 0.01 * factor)
        figure = map_figure([scene], MAPS[0], "last frame", ["note"])
        corners = figure.axes[0].patches[0].get_path().vertices
        self.assertAlmostEqual(corners[:, 1].min(), 1e3 * (0.3 - 2.0 * 0.01 * factor))
        plt.close(figure)

    def test_note_of_a_frame_tells_its_load(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(synthetic.write_run(os.path.join(folder, "mpm"), cell=0.03, steps=10, frames=2))
            last = make_scenes([run], ["mpm"], [-1], 1.0)[0]
        stress = run.history["nominal_stress"]
        share = 100.0 * stress[-1] / stress.max()
        self.assertEqual(report.frame_note(last), f"t = 1 s, u = 0.6 mm, {share:.0f} % of peak")

    def test_six_runs_stand_in_rows_of_three_with_the_legend_below(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(synthetic.write_run(os.path.join(folder, "mpm"), cell=0.03, steps=10, frames=2))
            names = [f"variant {k}" for k in range(6)]
            figure = map_figure(make_scenes([run] * 6, names, [-1] * 6, 1.0), MAPS[0], "last frame", names)
        corners = {tuple(np.round(axes.get_position().p0, 6)) for axes in figure.axes[:6]}
        self.assertEqual((len({c[0] for c in corners}), len({c[1] for c in corners})), (3, 2))
        curves = curve_figure([run] * 6, names, [], STRESS_STRAIN)
        curves.canvas.draw()
        legend = curves.axes[0].get_legend().get_window_extent()
        self.assertLess(legend.y1, curves.axes[0].xaxis.get_tightbbox(curves.canvas.get_renderer()).y0)
        self.assertTrue(0.0 <= legend.x0 and legend.y0 >= 0.0 and legend.x1 <= curves.bbox.x1)
        for each in (figure, curves):
            plt.close(each)

    def test_scale_moves_the_points(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(synthetic.write_run(os.path.join(folder, "mpm"), cell=0.03, steps=10, frames=2))
            once, scaled = (make_scenes([run], ["mpm"], [-1], s)[0] for s in (1.0, 101.0))
        np.testing.assert_allclose(scaled.y - once.y, 100.0 * once.frame["displacement"][:, 1])


if __name__ == "__main__":
    unittest.main()
