"""Relative L2 difference between the stress of a run in space and that of an axisymmetric one, in the elastic range.

python3 against_axis.py SPACE_RUN AXISYMMETRIC_RUN [TIME]

Both runs must have frames at TIME (default: the last one before half of the peak load). Every point of the run in space
takes the axisymmetric stress at its radius and height (a linear fit over the nearest eight points) turned to its angle;
the cylinder's axis is y. Prints the difference of each component and of the whole tensor, weighted by volume and relative to
the norm of the axisymmetric tensor, and of the cell means, which is what a picture shows. Exit code 1 above 5 %.
"""

import sys

import numpy as np

from berm.results import Run

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
ALLOWED = 0.05


def tensors(stress):
    """(n, 3, 3) from (n, 6) in Voigt order."""
    out = np.empty((len(stress), 3, 3))
    for k, (i, j) in enumerate(PAIRS):
        out[:, i, j] = out[:, j, i] = stress[:, k]
    return out


def fit_at(places, values, at, neighbours=8):
    """Linear fits of `values` (n, m) over the points nearest to each of `at` (k, 2)."""
    out = np.empty((len(at), values.shape[1]))
    for k, x in enumerate(at):
        near = np.argpartition(((places - x) ** 2).sum(axis=1), neighbours)[:neighbours]
        basis = np.column_stack((np.ones(neighbours), places[near] - x))
        out[k] = np.linalg.lstsq(basis, values[near], rcond=None)[0][0]
    return out


def expected_in_space(axis_frame, space_frame):
    """Axisymmetric stress (x radius, y axis, zz hoop) at the points of a run in space, in its axes (n, 3, 3)."""
    place = space_frame["position"] - space_frame["displacement"]
    radius = np.hypot(place[:, 0], place[:, 2])
    reference = axis_frame["position"] - axis_frame["displacement"]
    local = tensors(fit_at(reference[:, :2], axis_frame["stress"], np.column_stack((radius, place[:, 1]))))
    # Columns: radial, axial and hoop direction of each point.
    turn = np.zeros_like(local)
    turn[:, 0, 0], turn[:, 2, 0] = place[:, 0] / radius, place[:, 2] / radius
    turn[:, 1, 1] = 1.0
    turn[:, 0, 2], turn[:, 2, 2] = -place[:, 2] / radius, place[:, 0] / radius
    return turn @ local @ turn.transpose(0, 2, 1), place


def cell_means(place, volume, values, size):
    """Volume means over cubes of `size`; returns (means, volumes)."""
    _, cell = np.unique(np.floor(place / size + 1e-6).astype(int), axis=0, return_inverse=True)
    cell = cell.ravel()
    sums = np.zeros((cell.max() + 1,) + values.shape[1:])
    np.add.at(sums, cell, values * volume[:, None, None])
    volumes = np.bincount(cell, weights=volume)
    return sums / volumes[:, None, None], volumes


def difference(run, other, volume):
    """Relative L2 difference of tensor fields, weighted by volume."""
    weight = volume[:, None, None]
    return np.sqrt((weight * (run - other) ** 2).sum() / (weight * other**2).sum())


def main(arguments):
    space, axis = Run(arguments[0]), Run(arguments[1])
    load, time = axis.history["reaction"], axis.history["time"]
    peak = int(np.argmax(load))
    half = time[:peak][load[:peak] <= 0.5 * load[peak]][-1]
    wanted = float(arguments[2]) if len(arguments) > 2 else half
    frames = {round(t, 6) for t, _ in axis.frames} & {round(t, 6) for t, _ in space.frames}
    at = max(t for t in frames if t <= wanted + 1e-6)
    a, s = (run.frame(run.frame_at(at)) for run in (axis, space))
    expected, place = expected_in_space(a, s)
    stress, volume = tensors(s["stress"]), s["volume"]
    print(f"time {at:g}: load {np.interp(at, time, load):.5g} N, {np.interp(at, time, load) / load[peak]:.0%} of the peak")
    norm = np.sqrt((volume[:, None, None] * expected**2).sum())
    for k, (i, j) in enumerate(PAIRS):
        part = np.sqrt((volume * (stress[:, i, j] - expected[:, i, j]) ** 2).sum()) / norm
        print(f"  {'xx yy zz xy yz zx'.split()[k]}  {part:.3%} of the norm of the tensor")
    points = difference(stress, expected, volume)
    size = np.cbrt(8.0 * np.median(volume))
    mean, volumes = cell_means(place, volume, stress, size)
    means = difference(mean, cell_means(place, volume, expected, size)[0], volumes)
    print(f"points: {points:.3%}, cell means: {means:.3%}, allowed {ALLOWED:.0%}")
    return 0 if points <= ALLOWED else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
