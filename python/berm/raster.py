"""Pictures from material points: every pixel takes the value of its nearest point."""

import math

import numpy as np

# A point reaches over its pixels up to this many of its own sides from its centre: half a side where points tile the
# body evenly; the rest closes the seams between unevenly placed ones (Gauss points stand up to 0.577 cells apart).
REACH = 0.6


def nearest_points(x, y, side, extent, pixel):
    """Number of the nearest point for every pixel, -1 where no point reaches.

    x, y, side: centres and sides of the square points [m]; extent: (x0, x1, y0, y1) [m]; pixel: its size [m].
    Row 0 of the picture is the bottom.
    """
    x0, x1, y0, y1 = extent
    nx, ny = max(1, math.ceil((x1 - x0) / pixel)), max(1, math.ceil((y1 - y0) / pixel))
    picture = np.full((ny, nx), -1, dtype=np.int64)
    distance = np.full((ny, nx), np.inf)
    centre_x, centre_y = x0 + pixel * (np.arange(nx) + 0.5), y0 + pixel * (np.arange(ny) + 0.5)
    reach = np.maximum(REACH * side, pixel)
    first_col = np.clip(np.floor((x - reach - x0) / pixel), 0, nx).astype(int)
    last_col = np.clip(np.ceil((x + reach - x0) / pixel), 0, nx).astype(int)
    first_row = np.clip(np.floor((y - reach - y0) / pixel), 0, ny).astype(int)
    last_row = np.clip(np.ceil((y + reach - y0) / pixel), 0, ny).astype(int)
    for p in range(len(x)):
        rows, cols = slice(first_row[p], last_row[p]), slice(first_col[p], last_col[p])
        dx2, dy2 = (centre_x[cols] - x[p]) ** 2, (centre_y[rows] - y[p]) ** 2
        square = np.add.outer(dy2, dx2)
        reached = np.logical_and.outer(dy2 <= reach[p] ** 2, dx2 <= reach[p] ** 2)
        closer = reached & (square < distance[rows, cols])
        distance[rows, cols][closer] = square[closer]
        picture[rows, cols][closer] = p
    return picture


def paint(picture, values):
    """Values of the points as a masked picture."""
    painted = np.ma.array(np.zeros(picture.shape), mask=True)
    inside = picture >= 0
    painted[inside] = values[picture[inside]]
    return painted
