"""Bodies in space at one frame of a run: points, displaced surfaces and where planes cut them."""

import numpy as np

from berm.raster import nearest, section_picture
from berm.scene import Drawing


def refine(points, triangles, length):
    """(points, triangles) of the same surface with edges of at most that length [m]."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersModeling import vtkAdaptiveSubdivisionFilter

    places, cells, surface = vtkPoints(), vtkCellArray(), vtkPolyData()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    connectivity = numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles, dtype=np.int64).ravel(), deep=True)
    cells.SetData(3, connectivity)
    surface.SetPoints(places)
    surface.SetPolys(cells)
    divide = vtkAdaptiveSubdivisionFilter()
    divide.SetInputData(surface)
    divide.SetMaximumEdgeLength(length)
    divide.SetMaximumTriangleArea(1e30)  # only edges decide: neighbours agree on theirs, so the surface stays closed
    divide.SetMaximumNumberOfPasses(12)
    divide.SetOutputPointsPrecision(1)  # double
    divide.Update()
    out = divide.GetOutput()
    return (
        vtk_to_numpy(out.GetPoints().GetData()).astype(float),
        vtk_to_numpy(out.GetPolys().GetConnectivityArray()).reshape(-1, 3),
    )


def area(points, triangles):
    """Area of a surface [m2]."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def cut_rings(points, triangles, heights):
    """Closed rings [(k, 3)] where the surface has height 0; heights (n,) of its points [m]."""
    above = heights >= 0.0
    neighbours, places = {}, {}
    for triangle in triangles[np.ptp(above[triangles].astype(int), axis=1) > 0]:
        ends = []
        for a, b in zip(triangle, np.roll(triangle, -1)):
            if above[a] != above[b]:
                edge = (min(a, b), max(a, b))
                if edge not in places:
                    part = heights[edge[0]] / (heights[edge[0]] - heights[edge[1]])
                    places[edge] = points[edge[0]] + part * (points[edge[1]] - points[edge[0]])
                ends.append(edge)
        neighbours.setdefault(ends[0], []).append(ends[1])
        neighbours.setdefault(ends[1], []).append(ends[0])
    rings = []
    while neighbours:
        edge = next(iter(neighbours))
        ring = []
        while edge is not None:
            ring.append(places[edge])
            following = None
            for other in neighbours.pop(edge):
                if other in neighbours:
                    neighbours[other].remove(edge)
                    following = following or other
            edge = following
        if len(ring) > 2:
            rings.append(np.array(ring))
    return rings


class Body:
    """The bodies of one frame of one 3D run, displacements multiplied by `scale`.

    start, position, shift (n, 3): of the points [m]; side (n,): of their cubes [m]; number (n,): of their body;
    surfaces {number of a body: [(points at the start, displaced points, triangles)]}; rigid [(displaced points,
    triangles)].
    """

    def __init__(self, run, label, frame, scale):
        self.run, self.label, self.frame, self.scale = run, label, frame, scale
        displacement = frame.get("displacement", np.zeros_like(frame["position"]))
        self.start = frame["position"] - displacement
        self.shift = scale * displacement
        self.position = self.start + self.shift
        n = len(self.start)
        if "volume" in frame:
            self.side = np.cbrt(np.maximum(frame["volume"], 0.0))
        else:
            self.side = np.full(n, np.cbrt(np.prod(np.ptp(self.start, axis=0)) / max(1, n)))
        self.number = frame.get("body", np.zeros(n, dtype=int))
        self.spacing = float(np.median(self.side))
        self.surfaces, self.rigid = {}, []
        moved = run.rigid_displacements(frame["time"])
        for name, (points, triangles) in run.surfaces().items():
            if name in moved:
                self.rigid.append((points + scale * moved[name], triangles))
                continue
            within = ((self.start >= points.min(axis=0)) & (self.start <= points.max(axis=0))).all(axis=1)
            if not within.any():
                continue
            number = int(np.bincount(self.number[within]).argmax())
            points, triangles = refine(points, triangles, max(self.spacing, np.sqrt(area(points, triangles) / 1e5)))
            of = np.flatnonzero(self.number == number)
            shift = self.shift[of[nearest(self.start[of], points)]]
            self.surfaces.setdefault(number, []).append((points, points + shift, triangles))

    def middle(self):
        """Centre of the bodies with points at the start, moved as half of the points have moved [m]."""
        return 0.5 * (self.start.min(axis=0) + self.start.max(axis=0)) + np.median(self.shift, axis=0)

    def bounds(self):
        """(lowest, highest) coordinates of everything [m]."""
        half = 0.5 * self.side[:, None]
        places = [p for group in self.surfaces.values() for _, p, _ in group] + [p for p, _ in self.rigid]
        low = [(self.position - half).min(axis=0)] + [p.min(axis=0) for p in places]
        high = [(self.position + half).max(axis=0)] + [p.max(axis=0) for p in places]
        return np.min(low, axis=0), np.max(high, axis=0)


def loading_direction(run, index):
    """0, 1 or 2: the direction in which the displacements of a frame differ most. 2 where nothing has moved."""
    displacement = run.frame(index).get("displacement")
    if displacement is None or not len(displacement) or not np.any(displacement):
        return 2
    # A few points that were torn off say nothing about the load.
    return int(np.ptp(np.percentile(displacement, (2.0, 98.0), axis=0), axis=0).argmax())


def section_axes(loading):
    """[(normal, across, up)] of the two middle planes that contain the loading direction; it is up, unless it is x."""
    if loading == 0:
        return [(1, 0, 2), (2, 0, 1)]
    rest = [d for d in (0, 1, 2) if d != loading]
    return [(rest[0], rest[1], loading), (rest[1], rest[0], loading)]


class Section(Drawing):
    """A plane through a Body as a picture."""

    def __init__(self, body, normal, across, up):
        self.body, self.normal, self.plane = body, normal, (across, up)
        self.run, self.label, self.frame = body.run, body.label, body.frame
        self.axes = ("xyz"[across], "xyz"[up])
        # Between two layers of points both would be equally near: a tenth of a point aside one of them is.
        self.height = body.middle()[normal] + 0.1 * body.spacing
        self.outlines = {n: self._cut([s[1:] for s in group]) for n, group in body.surfaces.items()}
        self.rigid = [rings for rings in (self._cut([surface]) for surface in body.rigid) if rings]
        self.picture, self.extent, self.pixel = None, None, None

    def _cut(self, surfaces):
        rings = []
        for points, triangles in surfaces:
            rings += cut_rings(points, triangles, points[:, self.normal] - self.height)
        return [ring[:, self.plane] for ring in rings]

    def render(self, low, high, pixels=700):
        """Fills picture (number of the point for every pixel or -1) over the coordinates low to high of all space."""
        a, b = self.plane
        self.extent = (low[a], high[a], low[b], high[b])
        self.pixel = pixel = max(high[a] - low[a], high[b] - low[b]) / pixels
        best = None
        for number in np.unique(self.body.number):
            of = np.flatnonzero(self.body.number == number)
            order = (a, b, self.normal)
            places = self.body.position[of][:, order] - [0.0, 0.0, self.height]
            found, distance = section_picture(
                places,
                self.body.side[of],
                self.extent,
                pixel,
                self.body.shift[of][:, order],
                self.outlines.get(int(number), ()),
            )
            found = np.where(found >= 0, of[found], -1)
            if best is None:
                self.picture, best = found, distance
            else:
                self.picture = np.where(distance < best, found, self.picture)
                best = np.minimum(distance, best)


def make_bodies(runs, labels, indices, scale):
    """Bodies of the given frames; runs without points are left out."""
    bodies = [(run, label, run.frame(i)) for run, label, i in zip(runs, labels, indices) if i is not None]
    return [Body(run, label, frame, scale) for run, label, frame in bodies if len(frame["position"])]


def common_bounds(bodies):
    """(lowest, highest) coordinates of all bodies [m]."""
    bounds = [body.bounds() for body in bodies]
    return np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)


def make_sections(bodies, normal, across, up):
    """Sections of the bodies with common bounds."""
    low, high = common_bounds(bodies)
    margin = 0.03 * max(high - low)
    sections = [Section(body, normal, across, up) for body in bodies]
    for section in sections:
        section.render(low - margin, high + margin)
    return sections
