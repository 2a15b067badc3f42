#!/usr/bin/env python3
"""How the core moves in two runs of the dam: mean displacement of its points over time, and of those at its crest.

    PYTHONPATH=python /usr/bin/python3 examples/09_dam_core_3d/against_plane.py out/slice out/d1_coarse
"""

import sys
import tomllib
from pathlib import Path

import numpy as np

from berm.results import Run

CREST = 4.5  # points that start above this height [m]


def motion(out):
    """Times, and by frame the mean displacement (x, y) of the core and of its crest [m]."""
    run = Run(out)
    number = list(tomllib.loads((Path(out) / "case.toml").read_text())["body"]).index("core")
    times, core, crest = [], [], []
    for k in range(len(run.frames)):
        frame = run.frame(k)
        of = np.asarray(frame["body"]) == number
        u, x = np.asarray(frame["displacement"], float)[of], np.asarray(frame["position"], float)[of]
        volume = np.asarray(frame["volume"], float)[of]
        high = (x - u)[:, 1] > CREST
        times.append(frame["time"])
        core.append(np.average(u[:, :2], axis=0, weights=volume))
        crest.append(np.average(u[high, :2], axis=0, weights=volume[high]))
    return np.array(times), np.array(core), np.array(crest)


def main(first, second):
    times, core, crest = motion(first)
    other_times, other_core, other_crest = motion(second)
    largest = np.linalg.norm(core, axis=1).max()
    print(f"{'t [s]':>7} {'core x':>8} {'other':>8} {'core y':>8} {'other':>8} {'crest x':>8} {'other':>8} {'core off [%]':>13}")
    worst = 0.0
    for k, t in enumerate(times):
        def at(values, t=t):
            return np.array([np.interp(t, other_times, column) for column in values.T])

        c, r = at(other_core), at(other_crest)
        off = 100.0 * np.linalg.norm(core[k] - c) / largest
        worst = max(worst, off)
        if k % 5 == 0 or k == len(times) - 1:
            print(f"{t:7.3f} {core[k][0]:8.4f} {c[0]:8.4f} {core[k][1]:8.4f} {c[1]:8.4f} {crest[k][0]:8.4f} {r[0]:8.4f} {off:13.3f}")
    print(f"largest difference of the core: {worst:.2f} % of its largest displacement")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
