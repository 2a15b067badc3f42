import importlib.util
import json
import os
import tempfile
import unittest
from unittest import mock

import matplotlib.pyplot as plt
import numpy as np
import synthetic
from test_report import Page, run_main

from berm import report, solid
from berm.body import cut_rings, loading_direction, make_bodies, make_sections, refine, section_axes
from berm.figures import AXISYMMETRIC_MAPS, Colours, level_field, level_limits, map_figure
from berm.raster import paint, smooth
from berm.results import Run, read_points
from berm.scene import make_scenes

PYVISTA = importlib.util.find_spec("pyvista") is not None
FRAMES = ("elastic_stress_zz", "peak_stress_zz", "peak_damage", "last_damage")


def edges_of(triangles):
    """{edge: number of its triangles}"""
    ends = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(ends, axis=0, return_counts=True)


def enclosed(ring):
    x, y = ring.T
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


class Surfaces(unittest.TestCase):
    def test_refined_surface_stays_closed(self):
        points, triangles = synthetic.cylinder_surface()
        points, triangles = refine(points, triangles, 0.004)
        edges, counts = edges_of(triangles)
        self.assertTrue((counts == 2).all())
        self.assertLessEqual(np.linalg.norm(np.diff(points[edges], axis=1), axis=2).max(), 0.004)

    def test_section_of_a_box_through_its_corners_and_with_a_hole(self):
        points, triangles = synthetic.box_surface((0.0, 0.0, 0.0), (2.0, 3.0, 4.0))
        for height, area in ((-0.5, 0.0), (0.0, 12.0), (1.0, 12.0), (2.0, 12.0)):  # a height of 0 counts as above
            rings = cut_rings(points, triangles, points[:, 0] - height)
            self.assertAlmostEqual(sum(enclosed(ring[:, 1:]) for ring in rings), area if 0.0 < height else 0.0)
        hole, more = synthetic.box_surface((0.5, 1.0, 1.0), (1.5, 2.0, 2.0))
        points, triangles = np.vstack([points, hole]), np.vstack([triangles, more + len(points)])
        areas = sorted(enclosed(ring[:, 1:]) for ring in cut_rings(points, triangles, points[:, 0] - 1.0))
        np.testing.assert_allclose(areas, [1.0, 12.0])

    def test_smooth_keeps_constants_and_reaches_everywhere(self):
        points = np.stack(np.meshgrid(*3 * [np.arange(5.0)]), axis=-1).reshape(-1, 3)
        places = np.array([[2.0, 2.0, 2.0], [0.3, 4.2, 1.7], [9.0, 9.0, 9.0]])
        np.testing.assert_allclose(smooth(points, np.full(125, 3.5), places, 1.0), 3.5)
        linear = smooth(points, points @ [1.0, 2.0, 3.0], places, 1.0)
        np.testing.assert_allclose(linear[0], 12.0, atol=1e-6)
        self.assertEqual(linear[2], 24.0)


class Sections(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.runs = [
            Run(synthetic.write_cylinder(os.path.join(cls.folder.name, method), method, spacing=0.005))
            for method in ("mpm", "fem")
        ]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_sections_show_the_known_stress_without_holes(self):
        bodies = make_bodies(self.runs, ["mpm", "fem"], [2, 2], 1.0)
        for normal, across, up in section_axes(2):
            for section in make_sections(bodies, normal, across, up):
                with self.subTest(section.label, normal=normal):
                    rows, columns = section.picture.shape
                    x = section.extent[0] + section.pixel * (np.arange(columns) + 0.5)
                    z = section.extent[2] + section.pixel * (np.arange(rows) + 0.5)
                    x, z = np.meshgrid(x, z)
                    inside = (np.abs(x) < 0.024) & (z > 0.001) & (z < 0.099)
                    self.assertTrue((section.picture[inside] >= 0).all())
                    outside = (np.abs(x) > 0.0262) | (z < -0.001) | (z > 0.101)
                    self.assertTrue((section.picture[outside] < 0).all())
                    places = np.zeros((inside.sum(), 3))
                    places[:, across], places[:, up] = x[inside], z[inside]
                    shown = paint(section.picture, section.frame["stress"][:, 2])[inside]
                    exact = synthetic.cylinder_fields(places, 0.55 * synthetic.PUSH, 2)["stress"][:, 2]
                    self.assertLess(np.abs(shown - exact).max(), 0.13 * np.abs(exact).max())
                    self.assertLess(np.abs(shown - exact).mean(), 0.025 * np.abs(exact).max())

    def test_opened_body_stays_white_there(self):
        frame = self.runs[0].frame(2)
        gap = np.where((frame["position"] - frame["displacement"])[:, 2] > 0.05, 0.02, 0.0)
        for name in ("position", "displacement"):
            frame[name] = frame[name] + gap[:, None] * [0.0, 0.0, 1.0]
        with mock.patch.object(Run, "frame", lambda run, index: dict(frame)):
            bodies = make_bodies(self.runs[:1], ["mpm"], [2], 1.0)
        section = make_sections(bodies, 1, 0, 2)[0]
        column = section.picture[:, section.picture.shape[1] // 2] >= 0
        z = section.extent[2] + section.pixel * (np.arange(len(column)) + 0.5)
        self.assertFalse(column[(z > 0.055) & (z < 0.065)].any())
        self.assertTrue(column[(z > 0.001) & (z < 0.049)].all())
        self.assertTrue(column[(z > 0.072) & (z < 0.118)].all())

    def test_rigid_body_is_drawn_where_it_is(self):
        section = make_sections(make_bodies(self.runs[:1], ["mpm"], [3], 10.0), 0, 1, 2)[0]
        heights = section.rigid[0][0][:, 1]
        self.assertAlmostEqual(heights.min(), synthetic.LENGTH - 10.0 * synthetic.PUSH)

    def test_loading_direction(self):
        self.assertEqual(loading_direction(self.runs[0], -1), 2)
        self.assertEqual(loading_direction(self.runs[0], 0), 2)  # nothing has moved
        for axis in (0, 1):
            run = Run(synthetic.write_cylinder(os.path.join(self.folder.name, str(axis)), axis=axis, spacing=0.01))
            self.assertEqual(loading_direction(run, -1), axis)
            self.assertEqual({normal for normal, *_ in section_axes(axis)}, {0, 1, 2} - {axis})
        self.assertEqual(section_axes(1), [(0, 2, 1), (2, 0, 1)])

    def test_elastic_frame_is_the_last_before_half_the_peak(self):
        self.assertEqual(report.elastic_frames(self.runs), [1, 1])
        body = make_bodies(self.runs[:1], ["mpm"], [1], 1.0)[0]
        load = np.interp(0.25, self.runs[0].history["time"], self.runs[0].history["reaction"])
        self.assertEqual(report.load_note(body), f"t = 0.25 s, u = 0.1 mm\nF = {load / 1e3:.1f} kN, 45 % of peak")

    def test_limits_of_a_stress(self):
        self.assertEqual(level_limits([np.array([-1e6, 1e6])])[2], "signed")
        low, high, kind = level_limits([np.linspace(-30e6, -10e6, 1001), np.linspace(-40e6, -20e6, 1001)])
        self.assertEqual(kind, "compression")
        self.assertAlmostEqual(low, -39.8e6)
        self.assertAlmostEqual(high, -10.2e6)
        low, high, kind = level_limits([np.array([9.99e6, 10.01e6])])  # nearly uniform: noise must not fill the bar
        self.assertEqual(kind, "tension")
        self.assertGreater(high - low, 2.9e6)

    def test_runs_share_the_colours_and_the_bar_has_a_unit(self):
        bodies = make_bodies(self.runs, ["mpm", "fem"], [1, 1], 1.0)
        figure = map_figure(make_sections(bodies, 1, 0, 2), level_field(2), "elastic range", ["a\nb", "c\nd"])
        images = [axes.images[0] for axes in figure.axes[:2]]
        self.assertEqual(images[0].get_clim(), images[1].get_clim())
        self.assertEqual(figure.axes[2].get_ylabel(), "Stress σzz [MPa]")
        self.assertTrue(figure.axes[0].get_xlabel().startswith("x [mm]"))
        self.assertEqual(figure.axes[0].get_ylabel(), "z [mm]")
        plt.close(figure)


class ReportOfSolids(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        self.addCleanup(plt.close, "all")

    def cylinder(self, method, **options):
        return synthetic.write_cylinder(os.path.join(self.root, method), method, **{"spacing": 0.01, **options})

    def report_of(self, *paths):
        code, printed, errors = run_main(*paths)
        self.assertEqual((code, errors), (0, ""))
        with open(printed.strip(), encoding="utf-8") as file:
            return Page(printed.strip()), file.read(), set(os.listdir(paths[0]))

    def test_without_pyvista_sections_appear_and_the_report_tells(self):
        with mock.patch.object(solid, "why_not", lambda: solid.INSTALL):
            page, text, files = self.report_of(self.cylinder("mpm"), self.cylinder("fem"))
        for name in FRAMES:
            self.assertLessEqual({f"{name}_x.png", f"{name}_y.png"}, files)
        self.assertFalse([name for name in files if name.endswith("_3d.png")])
        self.assertIn("stress_strain.png", files)
        self.assertEqual((page.outside, page.open), ([], []))
        self.assertEqual(text.count("pip install pyvista"), 1)
        self.assertIn("BERM_PYTHON", text)
        self.assertIn("Damage, last frame, plane x = 0 mm", page.images)

    def test_missing_module_is_what_the_sentence_is_about(self):
        solid.why_not.cache_clear()
        self.addCleanup(solid.why_not.cache_clear)
        with mock.patch.dict("sys.modules", {"pyvista": None}):
            self.assertEqual(solid.why_not(), solid.INSTALL)

    def test_pyvista_that_cannot_draw(self):
        solid.why_not.cache_clear()
        self.addCleanup(solid.why_not.cache_clear)
        failed = mock.Mock(return_value=mock.Mock(returncode=1))
        with mock.patch.dict("sys.modules", {"pyvista": mock.Mock()}), mock.patch("subprocess.run", failed):
            with mock.patch.dict(os.environ):
                self.assertIn("libegl1", solid.why_not())
        self.assertGreaterEqual(failed.call_count, 2)

    def test_run_that_wrote_its_first_frame_only(self):
        with mock.patch.object(solid, "why_not", lambda: solid.INSTALL):
            _, _, files = self.report_of(self.cylinder("mpm", times=(0.0,)))
        self.assertIn("last_damage_x.png", files)

    def test_run_without_surfaces_and_peak_in_the_last_frame(self):
        path = self.cylinder("mpm", times=(0.0, 0.25, 0.55))
        name = os.path.join(path, "summary.json")
        with open(name, encoding="utf-8") as file:
            summary = json.load(file)
        del summary["body_surfaces"]
        with open(name, "w", encoding="utf-8") as file:
            json.dump(summary, file)
        with mock.patch.object(solid, "why_not", lambda: ""):
            _, text, files = self.report_of(path)
        self.assertLessEqual({"elastic_stress_zz_x.png", "last_stress_zz_x.png", "last_damage_y.png"}, files)
        self.assertIn("names no body_surfaces: mpm", text)

    def test_plane_axisymmetric_and_solid_runs_in_one_report(self):
        flat = synthetic.write_run(os.path.join(self.root, "flat"), cell=0.05, steps=10, frames=2)
        round_ = axisymmetric_run(os.path.join(self.root, "round"))
        with mock.patch.object(solid, "why_not", lambda: solid.INSTALL):
            page, text, files = self.report_of(flat, round_, self.cylinder("mpm"))
        wanted = {"last_damage.png", "axisymmetric_last_stress_zz.png", "solid_last_damage_x.png"}
        self.assertLessEqual(wanted, files)
        self.assertIn("σθθ", text)
        self.assertEqual(page.open, [])

    @unittest.skipUnless(PYVISTA, "pyvista is not installed: pictures in space are not tested")
    def test_with_pyvista_there_are_pictures_in_space(self):
        self.assertEqual(solid.why_not(), "")
        page, text, files = self.report_of(self.cylinder("mpm"), self.cylinder("fem", pieces=2))
        self.assertLessEqual({f"{name}_3d.png" for name in FRAMES}, files)
        self.assertIn("Damage, last frame, in space", page.images)
        self.assertNotIn("pip install", text)


@unittest.skipUnless(PYVISTA, "pyvista is not installed: pictures in space are not tested")
class PicturesInSpace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def render(self, name, field, part, size=(300, 420), **options):
        """(RGB picture, view, colours) of the peak frame."""
        run = Run(synthetic.write_cylinder(os.path.join(self.folder.name, name), spacing=0.005, **options))
        body = make_bodies([run], [name], [2], 1.0)[0]
        body.rigid.clear()
        view = solid.View(*body.bounds(), 2)
        colours = Colours.of(field, [field.of(body.frame)])
        self.assertEqual(solid.why_not(), "")
        parts = solid.body_parts(body, field, view, 2)
        return solid._render(parts[part], [], view, colours, size), view, colours

    def at(self, picture, view, place):
        """Median colour of 5 x 5 pixels at a place in space."""
        x0, x1, y0, y1 = view.extent
        rows, columns, _ = picture.shape
        x, y = view.flat(place)
        column, row = int((x - x0) / (x1 - x0) * columns), int((y1 - y) / (y1 - y0) * rows)
        return np.median(picture[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3), axis=0)

    def test_colours_are_those_of_the_bar(self):
        field = level_field(2)
        # On both section faces beside the axis, and on the skin half up, seen from the front.
        section = {"face x": (0.0, -0.012, 0.06), "face y": (0.012, 0.0, 0.06)}
        for method in ("mpm", "fem"):
            picture, view, colours = self.render(method, field, "cut", method=method)
            for where, place in section.items():
                stress = synthetic.cylinder_fields(np.array([place]), 0.55 * synthetic.PUSH, 2)["stress"][0, 2]
                part = np.linspace(stress - 2.5e6, stress + 2.5e6, 101)
                norm = np.clip((part - colours.low) / (colours.high - colours.low), 0.0, 1.0)
                near = 255.0 * plt.get_cmap(colours.cmap)(norm)[:, :3]
                off = np.abs(near - self.at(picture, view, place)).max(axis=1).min()
                with self.subTest(method, where=where):
                    self.assertLess(off, 8.0)

    def test_skin_has_no_holes(self):
        for method in ("mpm", "fem"):
            picture, view, _ = self.render(f"skin_{method}", level_field(2), "surface", method=method)
            drawn = (picture < 250).any(axis=2)
            rows = np.flatnonzero(drawn.any(axis=1))
            for row in rows[2:-2]:
                columns = np.flatnonzero(drawn[row])
                self.assertEqual(len(columns), columns[-1] - columns[0] + 1, f"{method}, row {row}")

    def test_pieces_of_a_mesh_leave_no_trace(self):
        one, three = (
            self.render(f"pieces_{n}", level_field(2), "surface", method="fem", pieces=n)[0].astype(float)
            for n in (1, 3)
        )
        self.assertLess(np.abs(one - three).max(axis=2).mean(), 0.05)


def axisymmetric_run(folder):
    """A cylinder of radius and height 0.15 and 0.30 m with a hoop stress of -1 MPa / 0.15 m times the radius."""
    path = synthetic.write_run(folder, cell=0.03, steps=10, frames=2)
    name = os.path.join(path, "summary.json")
    with open(name, encoding="utf-8") as file:
        summary = json.load(file)
    summary["axisymmetric"] = True
    summary["body_rings"] = {"specimen": [[[0.0, 0.0], [0.15, 0.0], [0.15, 0.3], [0.0, 0.3]]]}
    with open(name, "w", encoding="utf-8") as file:
        json.dump(summary, file)
    for _, file in Run(path).frames:
        fields = read_points(file)
        fields["position"] = fields["position"] + [0.075, 0.0, 0.0]
        radius = fields["position"][:, 0] - fields["displacement"][:, 0]
        fields["volume"] = 2.0 * np.pi * radius * fields["volume"]
        fields["stress"][:, 2] = -1e6 * radius / 0.15
        synthetic.write_points(file, fields)
    return path


class Axisymmetric(unittest.TestCase):
    def test_map_is_mirrored_and_named_by_cylinder_coordinates(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(axisymmetric_run(os.path.join(folder, "round")))
            scene = make_scenes([run], ["round"], [-1], 1.0)[0]
        np.testing.assert_allclose(scene.side, 0.015, rtol=1e-2)
        self.assertEqual(scene.extent[0], 0.0)
        hoop = next(field for field in AXISYMMETRIC_MAPS if field.component == 2)
        figure = map_figure([scene], hoop, "last frame", ["note"])
        picture = figure.axes[0].images[0].get_array()
        np.testing.assert_array_equal(picture.filled(0.0), picture[:, ::-1].filled(0.0))
        self.assertAlmostEqual(figure.axes[0].get_xlim()[0], -figure.axes[0].get_xlim()[1])
        self.assertTrue(figure.axes[0].get_xlabel().startswith("r [mm]"))
        self.assertEqual(figure.axes[0].get_ylabel(), "z [mm]")
        self.assertIn("Hoop stress σθθ", figure.axes[1].get_ylabel())
        plt.close(figure)


if __name__ == "__main__":
    unittest.main()
