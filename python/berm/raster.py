"""Pictures from material points: every pixel of a body takes the value of its nearest point."""

from dataclasses import dataclass

import numpy as np

# Without an outline a point reaches over its pixels up to this many of its own sides from its centre: half a side where
# points tile the body evenly; the rest closes the seams between unevenly placed ones (Gauss points stand up to 0.577
# cells apart). Inside an outline points that stand apart may reach further, up to LIMIT sides.
REACH = 0.6
LIMIT = 2.5
# Neighbours whose displacements differ by more than this many sides have a gap between them.
GAP = 1.0


@dataclass
class Grid:
    """The pixels of a picture. Row 0 is the bottom."""

    x0: float  # lower left corner [m]
    y0: float
    pixel: float  # size of a pixel [m]
    columns: int
    rows: int

    @classmethod
    def over(cls, extent, pixel):
        """Pixels of that size [m] over extent (x0, x1, y0, y1) [m]."""
        x0, x1, y0, y1 = extent
        # A remainder of rounding makes no pixel.
        count = [max(1, int(np.ceil(length / pixel - 1e-9))) for length in (x1 - x0, y1 - y0)]
        return cls(x0, y0, pixel, *count)

    def centres(self):
        """Centres of the columns and of the rows [m]."""
        return (
            self.x0 + self.pixel * (np.arange(self.columns) + 0.5),
            self.y0 + self.pixel * (np.arange(self.rows) + 0.5),
        )

    def find(self, x, y):
        """Row and column of places, moved to the rim where they are outside, and whether they are in the picture."""
        column = np.floor((x - self.x0) / self.pixel).astype(np.int64)
        row = np.floor((y - self.y0) / self.pixel).astype(np.int64)
        known = (column >= 0) & (column < self.columns) & (row >= 0) & (row < self.rows)
        return np.clip(row, 0, self.rows - 1), np.clip(column, 0, self.columns - 1), known


def _cloud(places):
    """vtkPolyData of places (n, 3)."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=float), deep=True))
    cloud = vtkPolyData()
    cloud.SetPoints(points)
    return cloud


def _interpolate(target, places, values, kernel):
    """`values` of points at `places`, brought to the points of the VTK data set `target` by a VTK kernel."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkFiltersPoints import vtkPointInterpolator

    cloud = _cloud(places)
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    array.SetName("values")
    cloud.GetPointData().AddArray(array)
    interpolator = vtkPointInterpolator()
    interpolator.SetInputData(target)
    interpolator.SetSourceData(cloud)
    interpolator.SetKernel(kernel)
    interpolator.SetNullPointsStrategyToClosestPoint()
    interpolator.Update()
    return vtk_to_numpy(interpolator.GetOutput().GetPointData().GetArray("values"))


def closest(x, y, grid, z=None):
    """Number of the closest of at least one point for every pixel, however far it is.

    z: heights of the points over the picture [m]; without them they lie in it.
    """
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersPoints import vtkVoronoiKernel

    # Lengths in pixels: the locator works with single precision and tolerances.
    z = np.zeros(len(x)) if z is None else z
    places = np.stack([(x - grid.x0) / grid.pixel, (y - grid.y0) / grid.pixel, z / grid.pixel], axis=1)
    image = vtkImageData()
    image.SetDimensions(grid.columns, grid.rows, 1)
    image.SetOrigin(0.5, 0.5, 0.0)
    found = _interpolate(image, places, np.arange(len(x)), vtkVoronoiKernel())
    return np.rint(found).astype(np.int64).reshape(grid.rows, grid.columns)


def nearest(points, places):
    """Number of the nearest of the points (n, 3) [m] for every place (m, 3) [m]."""
    from vtkmodules.vtkFiltersPoints import vtkVoronoiKernel

    low = points.min(axis=0)
    unit = max(np.ptp(points, axis=0).max(), 1e-300) / 1000.0
    target = _cloud((places - low) / unit)
    return np.rint(_interpolate(target, (points - low) / unit, np.arange(len(points)), vtkVoronoiKernel())).astype(
        np.int64
    )


def smooth(points, values, places, spacing):
    """Values (n,) of points (n, 3) [m] at places (m, 3) [m]: means weighted by exp(-(2 d / spacing)^2) over the points
    within 1.5 spacings [m]; where there are none, the value of the nearest point.
    """
    from vtkmodules.vtkFiltersPoints import vtkGaussianKernel

    low = points.min(axis=0)
    kernel = vtkGaussianKernel()
    kernel.SetRadius(1.5)
    kernel.SetSharpness(3.0)
    return _interpolate(_cloud((places - low) / spacing), (points - low) / spacing, values, kernel)


def inside_rings(rings, grid):
    """Mask of the pixels whose centre is inside the rings (even-odd rule: rings inside rings are holes)."""
    _, centre_y = grid.centres()
    toggles = np.zeros((grid.rows, grid.columns + 1), dtype=np.int64)
    for ring in rings:
        for (xa, ya), (xb, yb) in zip(ring, np.roll(ring, -1, axis=0)):
            first, last = np.searchsorted(centre_y, (min(ya, yb), max(ya, yb)))
            if first == last:
                continue
            rows = np.arange(first, last)
            cross = xa + (centre_y[rows] - ya) * (xb - xa) / (yb - ya)
            column = np.ceil((cross - grid.x0) / grid.pixel - 0.5)
            toggles[rows, np.clip(column, 0, grid.columns).astype(np.int64)] += 1
    return np.cumsum(toggles, axis=1)[:, : grid.columns] % 2 == 1


def body_picture(x, y, side, extent, pixel, shift=None, rings=()):
    """Points of one body: (number of the point for every pixel, -1 where there is none; its distance [m]).

    x, y, side: centres and sides of the square points [m]; extent: (x0, x1, y0, y1) [m]; pixel: its size [m];
    shift: displacements (n, 2) drawn [m]; rings: outlines of the undisplaced body [m]. A pixel belongs to the body if
    the displacement of its nearest point takes it back into the outline. Where that is a place whose nearest point was
    displaced otherwise, the body has opened, and only the points' own reach is drawn.
    """
    grid = Grid.over(extent, pixel)
    if not len(x):
        return np.full((grid.rows, grid.columns), -1), np.full((grid.rows, grid.columns), np.inf)
    picture = closest(x, y, grid)
    centre_x, centre_y = grid.centres()
    dx, dy = centre_x[None, :] - x[picture], centre_y[:, None] - y[picture]
    distance = np.hypot(dx, dy)
    drawn = np.maximum(np.abs(dx), np.abs(dy)) <= np.maximum(REACH * side, 0.5 * pixel)[picture]
    if len(rings):
        shift = np.zeros((len(x), 2)) if shift is None else shift
        back_x, back_y = centre_x[None, :] - shift[picture, 0], centre_y[:, None] - shift[picture, 1]
        low, high = np.vstack(rings).min(axis=0), np.vstack(rings).max(axis=0)
        start = Grid.over((low[0], high[0], low[1], high[1]), pixel)
        row, column, known = start.find(back_x, back_y)
        neighbour = closest(x - shift[:, 0], y - shift[:, 1], start)[row, column]
        # Slivers cut off at an outline have sides far below the distance between points.
        size = np.maximum(side, np.median(side))
        jump = np.hypot(*(shift[neighbour] - shift[picture]).transpose(2, 0, 1))
        whole = (distance <= LIMIT * size[picture]) & (jump <= GAP * size[picture])
        drawn = known & inside_rings(rings, start)[row, column] & (drawn | whole)
    return np.where(drawn, picture, -1), np.where(drawn, distance, np.inf)


def section_picture(points, side, extent, pixel, shift, rings=()):
    """As body_picture, for points (n, 3) [m] of one body in space: the third coordinate is the height over the picture.

    side: sides of the cubes of the points [m]; shift: displacements (n, 3) drawn [m]; rings: where the picture cuts the
    *displaced* surface of the body [m]. A pixel takes the nearest point in space, not the nearest projected one.
    """
    grid = Grid.over(extent, pixel)
    x, y, z = points.T
    picture = closest(x, y, grid, z)
    centre_x, centre_y = grid.centres()
    dx, dy, dz = centre_x[None, :] - x[picture], centre_y[:, None] - y[picture], z[picture]
    distance = np.sqrt(dx**2 + dy**2 + dz**2)
    reach = np.maximum(REACH * side, 0.5 * pixel)[picture]
    drawn = np.maximum(np.maximum(np.abs(dx), np.abs(dy)), np.abs(dz)) <= reach
    if len(rings):
        inside = inside_rings(rings, grid)
        size = np.maximum(side, np.median(side))[picture]
        whole = inside & (distance <= LIMIT * size)
        rows, columns = np.nonzero(whole)
        # Where the displacement takes a place back to a point that was displaced otherwise, the body has opened.
        of = picture[rows, columns]
        back = np.stack([centre_x[columns], centre_y[rows], np.zeros(len(rows))], axis=1) - shift[of]
        if len(rows):
            jump = np.linalg.norm(shift[nearest(points - shift, back)] - shift[of], axis=1)
            whole[rows, columns] = jump <= GAP * size[rows, columns]
        drawn = inside & (drawn | whole)
    return np.where(drawn, picture, -1), np.where(drawn, distance, np.inf)


def paint(picture, values):
    """Values of the points as a masked picture."""
    painted = np.ma.array(np.zeros(picture.shape), mask=True)
    inside = picture >= 0
    painted[inside] = values[picture[inside]]
    return painted
