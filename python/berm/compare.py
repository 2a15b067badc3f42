"""Compares the output folders of two runs that should agree: 1, 2 or 4 processes, or a restart.

    python3 -m berm.compare A B [--history RTOL] [--points RTOL] [--before PEAKFRACTION]

Prints the largest difference of every column of history.csv and of every field of the last frame of points, which are
matched by `id`. Differences are relative to the largest magnitude of the column or field in A or B; the parts of a
reaction (reaction_x:NAME, reaction_y:NAME, ...) share theirs and so do the energies, so that a part that should vanish
is not measured by its own rounding; a reaction or an opening of cracks below a millionth of the largest reaction or
displacement is measured by that. energy_error and extrapolation_error are fractions and compared as they are.
`newton_iterations` and `residual` depend on rounding: they are shown and not judged.
--before 0.5 compares up to half the peak load of A, and the last frame that is not later.
Exit code 1: a difference exceeds the tolerance, or steps, columns, fields or points are not the same; 2: a folder is
not the output of a run, or a file cannot be read.
"""

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from berm import words
from berm.errors import ResultError
from berm.results import Run

TOOL = "berm.compare"
TOLERANCE = 1e-6
ROUNDING = 1e-6  # of the largest reaction or displacement: less than that is measured by it
NOT_JUDGED = ("newton_iterations", "residual")
FRACTIONS = ("energy_error", "extrapolation_error")
ENERGIES = (
    "external_work",
    "elastic_energy",
    "dissipated_energy",
    "kinetic_energy",
    "damping_energy",
    "transfer_energy",
    "friction_energy",
)


@dataclass
class Difference:
    """The largest difference of a column or a field, relative to `scale`; where it is, in words."""

    name: str
    value: float
    scale: float
    place: str
    tolerance: float | None  # None: shown only

    @property
    def off(self):
        return self.tolerance is not None and not self.value <= self.tolerance


def quantity(column):
    """What shares its scale with the column."""
    if column in ENERGIES:
        return "energy"
    name, _, body = column.partition(":")
    return f"reaction:{body}" if name in ("reaction_x", "reaction_y", "reaction_z") else column


def magnitude(*arrays):
    return max((np.abs(a[np.isfinite(a)]).max(initial=0.0) for a in arrays), default=0.0)


def largest_difference(a, b, scale):
    """(largest |a - b| / scale, its row); two NaN are equal, a NaN and a number are infinitely far apart."""
    if not len(a):
        return 0.0, 0
    rows_a, rows_b = (np.asarray(v, float).reshape(len(v), -1) for v in (a, b))
    same = (rows_a == rows_b) | (np.isnan(rows_a) & np.isnan(rows_b))
    with np.errstate(invalid="ignore"):
        difference = np.where(same, 0.0, np.abs(rows_a - rows_b) / (scale or 1.0))
    difference = np.where(np.isnan(difference), np.inf, difference).max(axis=1)
    row = int(difference.argmax())
    return float(difference[row]), row


def rows_to_compare(run, before):
    """Number of rows until the load first reaches that fraction of its peak; all of them without a fraction."""
    if before is None:
        return len(run.history["time"])
    peak = run.peak_row()
    if peak is None:
        raise ResultError(f"{run.path}/history.csv has no nominal stress, so there is no peak for --before")
    stress = np.abs(run.history["nominal_stress"])
    return int(np.argmax(stress >= before * stress[peak]))


def compare_history(a, b, tolerance, before):
    """([Difference], [what is not the same], time up to which was compared [s])."""
    for run in (a, b):
        if not len(run.history.get("time", ())):
            raise ResultError(f"{run.path}/history.csv has no rows of time")
    rows = rows_to_compare(a, before)
    if rows == 0:
        raise ResultError(f"{a.path}/history.csv has no row before that fraction of the peak load")
    problems = [
        f"only {one.path}/history.csv has the column {name}"
        for one, other in ((a, b), (b, a))
        for name in one.history
        if name not in other.history
    ]
    available = len(b.history["time"])
    if available < rows or (before is None and available != rows):
        problems.append(
            f"{a.path} has {rows} rows{'' if before is None else ' to compare'}, {b.path} has {available}"
        )
    count = min(rows, available)
    times = [run.history["time"][:count] for run in (a, b)]
    moved = np.flatnonzero(np.abs(times[0] - times[1]) > 1e-9 * max(magnitude(*times), 1e-300))
    if len(moved):
        first = moved[0]
        problems.append(f"the steps differ from row {first} on: {times[0][first]:.9g} s and {times[1][first]:.9g} s")
        count = first
    common = [name for name in a.history if name in b.history]
    scales = {}
    for name in common:
        size = magnitude(a.history[name], b.history[name])
        scales[quantity(name)] = max(size, scales.get(quantity(name), 0.0))
    reactions = [size for name, size in scales.items() if name.startswith("reaction:")]
    for name in scales:  # what touches nothing has the rounding of the others
        if name.startswith("reaction:"):
            scales[name] = max(scales[name], ROUNDING * max(reactions))
    differences = []
    for name in common:
        scale = 1.0 if name in FRACTIONS else scales[quantity(name)]
        value, row = largest_difference(a.history[name][:count], b.history[name][:count], scale)
        place = f"row {row}, t = {times[0][row]:.6g} s" if count else "no row"
        differences.append(Difference(name, value, scale, place, None if name in NOT_JUDGED else tolerance))
    # A hair later than the last row: times of frames are written with fewer digits than doubles have.
    return differences, problems, times[0][count - 1] * (1 + 1e-9) if count else -np.inf


def compare_points(a, b, tolerance, until):
    """([Difference], [what is not the same], time of the frame [s] or None)."""
    frames = [[k for k, (time, _) in enumerate(run.frames) if time <= until] for run in (a, b)]
    if not frames[0] and not frames[1]:
        return [], [], None
    if not frames[0] or not frames[1]:
        return [], [f"only {(a if frames[0] else b).path} has a frame of points to compare"], None
    one, other = a.frame(frames[0][-1]), b.frame(frames[1][-1])
    if abs(one["time"] - other["time"]) > 1e-6 * max(abs(one["time"]), abs(other["time"])):
        return [], [f"the last frames are at {one['time']:.9g} s and {other['time']:.9g} s"], None
    if ("id" in one) != ("id" in other):
        return [], [f"only the points of {(a if 'id' in one else b).path} have an id"], None
    counts = [len(frame["position"]) for frame in (one, other)]
    if "id" in one and not np.array_equal(one["id"], other["id"]):
        only = [len(np.setdiff1d(x["id"], y["id"])) for x, y in ((one, other), (other, one))]
        return [], [f"{only[0]} points are only in {a.path}, {only[1]} only in {b.path}"], one["time"]
    if counts[0] != counts[1]:
        return [], [f"{a.path} has {counts[0]} points, {b.path} has {counts[1]}"], one["time"]
    problems = [
        f"only the points of {run.path} have the field {name}"
        for run, x, y in ((a, one, other), (b, other, one))
        for name in x
        if name not in y
    ]
    differences = []
    for name in sorted((set(one) & set(other)) - {"id", "time", "rank"}):
        first, second = one[name], other[name]
        if first.shape != second.shape:
            problems.append(f"the field {name} has the shapes {first.shape} and {second.shape}")
            continue
        scale = np.ptp(first, axis=0).max() if name == "position" and counts[0] else magnitude(first, second)
        if name == "crack_opening":  # of what has not cracked it is rounding of displacements
            scale = max(scale, ROUNDING * magnitude(one.get("displacement", np.zeros(1))))
        value, row = largest_difference(first, second, scale)
        place = (f"id {one['id'][row]}" if "id" in one else f"point {row}") if counts[0] else "no point"
        differences.append(Difference(name, value, float(scale), place, tolerance))
    return differences, problems, one["time"]


def print_differences(title, differences):
    print(title)
    width = max((len(d.name) for d in differences), default=0)
    for d in differences:
        verdict = "not judged" if d.tolerance is None else "OFF" if d.off else "ok"
        print(f"  {d.name.ljust(width)}  {d.value:9.2e}  of {d.scale:9.3e}  {verdict:10}  {d.place}")


def compare(path_a, path_b, history=TOLERANCE, points=None, before=None):
    """Prints the comparison; True if the runs agree. Raises ResultError for unusable folders and files."""
    a, b = Run(path_a), Run(path_b)
    rows, problems, until = compare_history(a, b, history, before)
    points_rows, points_problems, time = compare_points(a, b, history if points is None else points, until)
    print_differences(f"history.csv up to t = {until:.6g} s", rows)
    if time is not None:
        print_differences(f"points at t = {time:.6g} s", points_rows)
    for problem in problems + points_problems:
        print(f"not the same: {problem}")
    off = sum(d.off for d in rows + points_rows) + len(problems) + len(points_problems)
    print("the runs agree" if not off else f"the runs differ in {off} respect{'s' if off > 1 else ''}")
    return not off


def main(arguments=None):
    parser = argparse.ArgumentParser(prog=TOOL, description="Compares two runs that should agree.")
    parser.add_argument("a", metavar="A", help="output folder of a run")
    parser.add_argument("b", metavar="B", help="output folder of the other run")
    parser.add_argument(
        "--history", type=words.at_least_zero, default=TOLERANCE, metavar="RTOL", help=f"for history.csv (default {TOLERANCE:g})"
    )
    parser.add_argument("--points", type=words.at_least_zero, metavar="RTOL", help="for the points (default: as for history.csv)")
    parser.add_argument(
        "--before", type=float, metavar="PEAKFRACTION", help="compare until the load reaches this part of A's peak"
    )
    options = parser.parse_args(arguments)
    if options.before is not None and not 0.0 < options.before <= 1.0:
        parser.error("--before must be above 0 and at most 1")
    try:
        return 0 if compare(options.a, options.b, options.history, options.points, options.before) else 1
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    words.run(main, TOOL)
