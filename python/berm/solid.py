"""Pictures of 3D bodies in space by pyvista, off-screen: the surface, and the body without its front quarter."""

import functools
import math
import os
import subprocess
import sys

import numpy as np

import berm.plotting  # noqa: F401  before the rest of matplotlib
from matplotlib.ticker import MaxNLocator

from berm.body import Section, common_bounds, section_axes
from berm.figures import BELOW, DPI, GAP, HEADING, LEFT, RIGHT, Colours, heading_text, plt, span_text, unit_for
from berm.raster import smooth

INSTALL = (
    "Pictures in space need pyvista in the Python that writes the report: `python3 -m venv --system-site-packages "
    "~/berm-python`, `~/berm-python/bin/pip install pyvista`, then set BERM_PYTHON=~/berm-python/bin/python."
)
WINDOWS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")  # what VTK can draw with without a display
CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"
PROBE = (
    "import pyvista; plotter = pyvista.Plotter(off_screen=True, window_size=(40, 40)); "
    "plotter.add_mesh(pyvista.Sphere()); "
    "raise SystemExit(0 if plotter.screenshot(return_img=True).std() > 1.0 else 3)"
)
AZIMUTH, ELEVATION = math.radians(-52.0), math.radians(20.0)
INK, GREY = "#333333", "#9a9a9a"


@functools.lru_cache(maxsize=1)
def why_not():
    """"" where pictures in space can be drawn, else a sentence that says what is missing.

    Tried in processes of their own: without a graphics library VTK ends the process, with no exception to catch. What
    works is left in the environment for VTK in this one.
    """
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return INSTALL
    choices = WINDOWS
    if os.environ.get(CHOICE) or os.environ.get("DISPLAY"):
        choices = (os.environ.get(CHOICE, ""), *WINDOWS)  # "": as VTK likes
    for choice in choices:
        environment = {**os.environ, CHOICE: choice} if choice else dict(os.environ)
        try:
            done = subprocess.run(
                [sys.executable, "-c", PROBE], capture_output=True, timeout=120, check=False, env=environment
            )
        except (OSError, subprocess.TimeoutExpired):
            continue
        if done.returncode == 0:
            os.environ.update(environment)
            return ""
    return (
        "pyvista is installed, but VTK cannot draw without a display here: install libegl1 and libgl1-mesa-dri, or "
        "libosmesa6."
    )


class View:
    """A parallel projection of all space: places [m] to the picture [m], the same for all runs of a figure."""

    def __init__(self, low, high, loading):
        self.low, self.high = low, high
        self.up = 2 if loading == 0 else loading
        self.side = ((self.up + 1) % 3, (self.up + 2) % 3)  # right-handed with up
        eye = np.zeros(3)
        eye[self.side[0]] = math.cos(ELEVATION) * math.cos(AZIMUTH)
        eye[self.side[1]] = math.cos(ELEVATION) * math.sin(AZIMUTH)
        eye[self.up] = math.sin(ELEVATION)
        self.eye, self.focus = eye, 0.5 * (low + high)
        self.right = np.cross(np.eye(3)[self.up], eye)
        self.right /= np.linalg.norm(self.right)
        self.over = np.cross(eye, self.right)
        corners = np.array([[(low, high)[k >> d & 1][d] for d in range(3)] for k in range(8)])
        flat = self.flat(corners)
        margin = 0.05 * np.ptp(flat, axis=0).max()
        # Room for the numbers left of and below the box.
        self.extent = (
            flat[:, 0].min() - 3.2 * margin,
            flat[:, 0].max() + margin,
            flat[:, 1].min() - 1.5 * margin,
            flat[:, 1].max() + 0.4 * margin,
        )

    def flat(self, places):
        """Places (..., 3) in the picture (..., 2), 0 is its focus."""
        return (np.asarray(places) - self.focus) @ np.stack([self.right, self.over], axis=1)

    def edges(self):
        """[(direction, one end, other end)] of the box that carry numbers: two below in front and one on the left."""
        front = np.where(self.eye > 0.0, self.high, self.low)
        front[self.up] = self.low[self.up]
        found = []
        for d in self.side:
            a, b = front.copy(), front.copy()
            a[d], b[d] = self.low[d], self.high[d]
            found.append((d, a, b))
        ends = [end for _, a, b in found for end in (a, b)]
        left = min(ends, key=lambda end: self.flat(end)[0])
        a, b = left.copy(), left.copy()
        b[self.up] = self.high[self.up]
        return found + [(self.up, a, b)]


def can_draw(body):
    """Whether there is a surface to draw: of a finite element mesh, or that of the body at the start."""
    return bool(body.surfaces) or body.run.summary.get("method") == "fem" and bool(body.run.mesh_frames)


def _polydata(points, triangles):
    import pyvista

    cells = np.hstack([np.full((len(triangles), 1), 3), triangles])
    return pyvista.PolyData(np.ascontiguousarray(points, dtype=float), cells.ravel())


def _mesh_parts(body, field, sections, mesh):
    """(skin, faces of the sections) of a finite element mesh, with cell data "value"."""
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    grid = pyvista.wrap(mesh).copy()
    if body.run.summary.get("processes", 1) > 1:
        grid = grid.clean()  # pieces have their own nodes where they meet: without them there is no surface between
    grid.cell_data["value"] = field.of({field.array: np.asarray(grid.cell_data[field.array])})
    displacement = np.asarray(grid.point_data["displacement"])
    grid.points = grid.points + (body.scale - 1.0) * displacement  # files hold the current places
    faces = []
    for section in sections:
        origin = np.zeros(3)
        origin[section.normal] = section.height
        faces.append(grid.slice(normal=np.eye(3)[section.normal], origin=origin))
    surface = vtkDataSetSurfaceFilter()
    surface.SetInputData(grid)
    surface.Update()
    return pyvista.wrap(surface.GetOutput()), faces


def _point_parts(body, field, sections):
    """The same of material points, with point data "value" on the skin; None without values or surface."""
    values = field.of(body.frame)
    skins = []
    for number, group in body.surfaces.items():
        of = np.flatnonzero(body.number == number)
        for start, displaced, triangles in group:
            skin = _polydata(displaced, triangles)
            skin.point_data["value"] = smooth(body.start[of], values[of], start, body.spacing)
            skins.append(skin)
    faces = [_section_face(body, values, section) for section in sections]
    return (skins[0].merge(skins[1:]) if len(skins) > 1 else skins[0]), faces


def _section_face(body, values, section):
    """The drawn pixels of a section as quadrilaterals in space with point data "value"."""
    import pyvista

    picture = section.picture
    rows, columns = picture.shape
    across, up = section.plane
    x = np.linspace(section.extent[0], section.extent[0] + columns * section.pixel, columns + 1)
    y = np.linspace(section.extent[2], section.extent[2] + rows * section.pixel, rows + 1)
    row, column = np.nonzero(picture >= 0)
    corner = row * (columns + 1) + column
    quads = corner[:, None] + [0, 1, columns + 2, columns + 1]
    used, quads = np.unique(quads, return_inverse=True)
    points = np.full((len(used), 3), section.height)
    points[:, across], points[:, up] = x[used % (columns + 1)], y[used // (columns + 1)]
    quads = quads.reshape(-1, 4)
    face = pyvista.PolyData(points, np.hstack([np.full((len(quads), 1), 4), quads]).ravel())
    value = np.empty(len(used))
    # By body: across a contact nothing is smooth.
    owner = np.empty(len(used), dtype=int)
    owner[quads] = body.number[picture[row, column]][:, None]
    for number in np.unique(owner):
        of, here = np.flatnonzero(body.number == number), np.flatnonzero(owner == number)
        value[here] = smooth(body.position[of], values[of], points[here], body.spacing)
    face.point_data["value"] = value
    return face


def _half(mesh, axis, height, upper):
    """The part of a surface on one side of a plane."""
    origin = np.zeros(3)
    origin[axis] = height
    return mesh.clip(normal=np.eye(3)[axis], origin=origin, invert=not upper)


def body_parts(body, field, view, loading):
    """{"surface": [(mesh, shaded)], "cut": [...]} to draw of a body; None if the run does not have the field."""
    sections = [Section(body, *axes) for axes in section_axes(loading)]
    mesh = body.run.mesh_at(body.frame["time"]) if body.run.summary.get("method") == "fem" else None
    if mesh is not None and mesh.GetCellData().GetArray(field.array) and mesh.GetPointData().GetArray("displacement"):
        skin, faces = _mesh_parts(body, field, sections, mesh)
    elif field.of(body.frame) is None or not body.surfaces:
        return None
    else:
        low, high = body.bounds()
        for section in sections:
            section.render(low, high, pixels=500)
        skin, faces = _point_parts(body, field, sections)
    (a, b), (face_a, face_b) = sections, faces
    front_a, front_b = (view.eye[s.normal] > 0.0 for s in sections)
    cut = [
        (_half(skin, a.normal, a.height, not front_a), True),
        (_half(_half(skin, a.normal, a.height, front_a), b.normal, b.height, not front_b), True),
        (_half(face_a, b.normal, b.height, front_b), False),
        (_half(face_b, a.normal, a.height, front_a), False),
    ]
    return {"surface": [(skin, True)], "cut": cut}


def _render(parts, rigid, view, colours, size):
    """RGB picture of that size (width, height) in pixels."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    plotter.set_background("white")
    light = pyvista.Light(light_type="headlight")
    plotter.add_light(light)
    limits = [colours.low, colours.high]
    for mesh, shaded in parts:
        if not mesh.n_cells:
            continue
        plotter.add_mesh(
            mesh,
            scalars="value",
            clim=limits,
            cmap=plt.get_cmap(colours.cmap),
            show_scalar_bar=False,
            lighting=shaded,
            # Little shade: the colours have to be those of the bar.
            ambient=0.88 if shaded else 1.0,
            diffuse=0.13 if shaded else 0.0,
            specular=0.0,
            n_colors=256,
            interpolate_before_map=True,
        )
        edges = mesh.extract_feature_edges(
            feature_angle=40.0,
            feature_edges=shaded,
            boundary_edges=not shaded,
            non_manifold_edges=False,
            manifold_edges=False,
        )
        if edges.n_cells:
            plotter.add_mesh(edges, color=INK, line_width=1.5, lighting=False)
    for points, triangles in rigid:
        edges = _polydata(points, triangles).extract_feature_edges(
            feature_angle=40.0, non_manifold_edges=False, manifold_edges=False
        )
        if edges.n_cells:
            plotter.add_mesh(edges, color=GREY, line_width=2.0, lighting=False)
    x0, x1, y0, y1 = view.extent
    focus = view.focus + 0.5 * (x0 + x1) * view.right + 0.5 * (y0 + y1) * view.over
    distance = 10.0 * np.linalg.norm(view.high - view.low)
    camera = plotter.camera
    camera.focal_point = focus
    camera.position = focus + distance * view.eye
    camera.up = view.over
    camera.enable_parallel_projection()
    camera.parallel_scale = 0.5 * (y1 - y0)
    plotter.renderer.ResetCameraClippingRange()
    plotter.enable_anti_aliasing("ssaa")
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    return picture


def _draw_box(panel, view, scale):
    """Edges of the box around everything with numbers in a readable unit. scale: inches a metre."""
    factor, unit = unit_for("m", np.abs([view.low, view.high]).max())
    centre = view.flat(0.5 * (view.low + view.high))
    for direction, a, b in view.edges():
        ends = view.flat([a, b])
        panel.plot(*ends.T, color="#777777", linewidth=0.6)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        outward = np.array([along[1], -along[0]]) / scale  # an inch
        outward *= np.sign(outward @ (ends.mean(axis=0) - centre))
        upright = direction == view.up
        align = {"ha": "right" if outward[0] < 0.0 else "left", "va": "center" if upright else "top"}
        low, high = a[direction] / factor, b[direction] / factor
        low, high = min(low, high), max(low, high)
        room = np.linalg.norm(ends[1] - ends[0]) * scale
        locator = MaxNLocator(max(2, min(5, int(room / 0.45))), steps=[1, 2, 2.5, 5, 10])
        for t in locator.tick_values(low, high):
            if not low - 1e-6 * (high - low) <= t <= high + 1e-6 * (high - low):
                continue
            place = a.copy()
            place[direction] = t * factor
            foot = view.flat(place)
            panel.plot(*np.stack([foot, foot + 0.05 * outward]).T, color="#777777", linewidth=0.6)
            panel.text(*(foot + 0.07 * outward), f"{t:g}".replace("-", "−"), fontsize=6.5, color=INK, **align)
        panel.text(
            *(ends.mean(axis=0) + 0.36 * outward),
            f"{'xyz'[direction]} [{unit}]",
            fontsize=7.5,
            color=INK,
            ha="center" if upright else align["ha"],
            va="center",
            rotation=90 if upright else 0,
        )


def solid_figure(bodies, field, heading, notes, loading):
    """Runs side by side, the surface above and the cut below, one colour scale; None if no run has the field."""
    view = View(*common_bounds(bodies), loading)
    drawn = [(body, note, body_parts(body, field, view, loading)) for body, note in zip(bodies, notes)]
    drawn = [(body, note, parts) for body, note, parts in drawn if parts]
    if not drawn:
        return None
    arrays = [values for body, _, _ in drawn if (values := field.of(body.frame)) is not None]
    colours = Colours.of(field, arrays)
    columns = min(len(drawn), 3)
    blocks = math.ceil(len(drawn) / columns)
    x0, x1, y0, y1 = view.extent
    scale = min(3.7 / (y1 - y0), 3.4 / (x1 - x0))
    across, down = scale * (x1 - x0), scale * (y1 - y0)
    cell, above = max(across, 2.3) + GAP, 0.56
    block = above + 2.0 * down + BELOW
    width, height = LEFT + columns * cell + RIGHT, HEADING + blocks * block
    figure = plt.figure(figsize=(width, height))
    size = tuple(round(2 * DPI * length) for length in (across, down))
    for k, (body, note, parts) in enumerate(drawn):
        row, column = divmod(k, columns)
        for part, name in enumerate(("surface", "cut")):
            top = HEADING + row * block + above + part * down
            left = (LEFT + column * cell) / width
            panel = figure.add_axes((left, 1.0 - (top + down) / height, across / width, down / height))
            picture = _render(parts[name], body.rigid, view, colours, size)
            panel.imshow(picture, extent=view.extent, interpolation="antialiased")
            _draw_box(panel, view, scale)
            panel.set_xlim(x0, x1)
            panel.set_ylim(y0, y1)
            panel.axis("off")
            if name == "surface":
                panel.set_title(f"{body.label}\n{note}", loc="left", fontsize=8)
            else:
                values = field.of(body.frame)
                span = "" if values is None else span_text(values, colours.factor, colours.unit)
                panel.text(0.5, -0.04, span, transform=panel.transAxes, ha="center", va="top")
    length = min(2.0 * down, 3.6)
    bar_left, bar_top = LEFT + columns * cell - GAP + 0.25, HEADING + above + down - 0.5 * length
    bar = figure.add_axes((bar_left / width, 1.0 - (bar_top + length) / height, 0.13 / width, length / height))
    norm = plt.Normalize(colours.low / colours.factor, colours.high / colours.factor)
    mappable = plt.cm.ScalarMappable(norm=norm, cmap=colours.cmap)
    colours.bar(figure, mappable, bar, field.label)
    heading_text(figure, f"{field.label}, {heading}")
    return figure
