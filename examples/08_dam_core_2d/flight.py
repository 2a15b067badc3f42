#!/usr/bin/env python3
"""The centre of the thrown block beside a free body's: x = x0 + vx t, y = y0 + vy t - g t^2 / 2.

    PYTHONPATH=python /usr/bin/python3 examples/08_dam_core_2d/flight.py out/d1_thrown [FROM TO]

From when the block has left the ground to when it touches it again [s]. Prints a row a frame; the deviation is given in
percent of the way that the centre has gone since.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np

from berm.results import Run

G = 9.81
REACH = 2.0  # of the block from its middle [m]


def piece(frame, number):
    """Ids of the points of a body that fly together: not the crumbs that it has left behind."""
    of = np.asarray(frame["body"]) == number
    position = np.asarray(frame["position"], float)[of, :2]
    near = np.linalg.norm(position - np.median(position, axis=0), axis=1) < REACH
    return np.asarray(frame["id"])[of][near]


def centre(frame, ids):
    """Time, position and velocity of the centre of mass of points of one material."""
    of = np.isin(frame["id"], ids)
    mass = np.asarray(frame["volume"], float)[of]  # at the start, of one density
    mean = [np.average(np.asarray(frame[name], float)[of, :2], axis=0, weights=mass) for name in ("position", "velocity")]
    return frame["time"], *mean


def main(out, begin=1.8, end=2.15):
    run = Run(out)
    number = list(tomllib.loads((Path(out) / "case.toml").read_text())["body"]).index("block")
    frames = [run.frame(k) for k, (time, _) in enumerate(run.frames) if begin <= time <= end]
    ids = piece(frames[-1], number)
    path = [centre(frame, ids) for frame in frames]
    t0, x0, v0 = path[0]
    worst, before = 0.0, path[0]
    print(f"{'t [s]':>8} {'x [m]':>8} {'free':>8} {'y [m]':>8} {'free':>8} {'way [m]':>8} {'off [%]':>8} {'ay [m/s2]':>10}")
    for now in path[1:]:
        t, x, v = now
        free = x0 + v0 * (t - t0) - np.array([0.0, 0.5 * G * (t - t0) ** 2])
        way = np.linalg.norm(free - x0)
        off = 100.0 * np.linalg.norm(x - free) / way
        fall = (v[1] - before[2][1]) / (t - before[0])
        worst, before = max(worst, off), now
        print(f"{t:8.3f} {x[0]:8.3f} {free[0]:8.3f} {x[1]:8.3f} {free[1]:8.3f} {way:8.3f} {off:8.3f} {fall:10.4f}")
    print(f"largest deviation: {worst:.3f} % of the way")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 4):
        sys.exit(__doc__)
    main(sys.argv[1], *(float(t) for t in sys.argv[2:]))
