#!/usr/bin/env python3
"""Variants of wall_active.toml and wall_passive.toml: friction angle, cohesion and cells, against Rankine's values.

    walls.py BERM [--walls active passive] [--angles 20 30 40] [--cohesions 0.1 5] [--cells 20 40 80] [--set KEY=VALUE] [--limit 300] [--out out/walls]

The wall is 2 m high; cells are those of its height. Right: Ka gamma H^2/2 - 2 c sqrt(Ka) H and Kp gamma H^2/2 + 2 c sqrt(Kp) H (Rankine 1857), reached within
the movement and held to its end: the mean of its second half and the last value are shown, and the largest jump of the reaction from one step to the next
after the first tenth of the movement, over the right value. Cohesion: with c = 5 kPa the active wall would be pulled by the topmost soil,
2 c/(gamma sqrt(Ka)) deep; a wall without tension carries Ka gamma (H - z)^2/2 below that depth z, and that is the right value.
"""

import argparse
import math
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run import HERE, Run, execute, last_words  # noqa: E402

HEIGHT, WEIGHT = 2.0, 2000.0 * 9.81


def right_value(wall, angle, cohesion):
    k = math.tan(math.radians(45 + (angle if wall == "passive" else -angle) / 2)) ** 2
    if wall == "passive":
        return k * WEIGHT * HEIGHT**2 / 2 + 2 * cohesion * math.sqrt(k) * HEIGHT
    crack = min(HEIGHT, 2 * cohesion / (WEIGHT * math.sqrt(k)))
    return k * WEIGHT * (HEIGHT - crack) ** 2 / 2


def overrides(wall, angle, cohesion, cells):
    h = HEIGHT / cells
    grid = f"{{ origin = [{-4 * h!r}, 0.0], cell_size = {h!r}, cells = [{round(5.0 / h) + 5}, {cells + 7}] }}"
    return [f"grid={grid}", f"material.sand.friction_angle={angle}", f"material.sand.cohesion={1e3 * cohesion}", f"body.sand.mesh.size={h!r}"]


def measure(folder, right):
    run = Run(folder)
    time, force = run["time"], np.abs(run["reaction_x:wall"])
    second = time > 1.5
    later = time > 1.1
    mean = force[second].mean() if second.any() else math.nan
    jump = np.abs(np.diff(force[later])).max() / right if later.sum() > 1 else math.nan
    return mean, force[-1], jump, time[-1], run.summary["status"]


def main():
    parser = argparse.ArgumentParser(description="Retaining walls against Rankine's values.")
    parser.add_argument("berm", metavar="BERM")
    parser.add_argument("--walls", nargs="+", default=["active", "passive"], choices=["active", "passive"])
    parser.add_argument("--angles", nargs="+", type=float, default=[20.0, 30.0, 40.0])
    parser.add_argument("--cohesions", nargs="+", type=float, default=[0.1, 5.0], help="[kPa]")
    parser.add_argument("--cells", nargs="+", type=int, default=[20, 40, 80], help="cells of the height of the wall")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds a run may take")
    parser.add_argument("--out", default="out/walls")
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    print("| wall | angle | c [kPa] | cells | right [kN/m] | second half | last | largest jump | seconds | end |\n|---|---|---|---|---|---|---|---|---|---|")
    for wall in options.walls:
        for angle in options.angles:
            for cohesion in options.cohesions:
                for cells in options.cells:
                    right = right_value(wall, angle, 1e3 * cohesion)
                    folder = pathlib.Path(options.out) / f"{wall}_{angle:g}_{cohesion:g}_{cells}"
                    folder.mkdir(parents=True, exist_ok=True)
                    words = [w for s in overrides(wall, angle, cohesion, cells) + options.set for w in ("--set", s)]
                    log = folder / "terminal.txt"
                    command = [options.berm, "run", str(HERE / f"wall_{wall}.toml"), "--quiet", "--force", "--out", str(folder), *words]
                    seconds, code = execute(command, options.limit, log)
                    try:
                        mean, end, jump, time, status = measure(folder, right)
                        reason = "not finished in time" if code is None else "done" if status == "done" else f"stops at {100 * (time - 1):.0f} % of the movement"
                        numbers = f"{mean / 1e3:.2f} ({100 * (mean / right - 1):+.1f} %) | {end / 1e3:.2f} ({100 * (end / right - 1):+.1f} %) | {100 * jump:.1f} %"
                    except (OSError, ValueError, KeyError, IndexError) as error:
                        reason, numbers = "not finished in time" if code is None else f"{last_words(log)} ({error})", "- | - | -"
                    print(f"| {wall} | {angle:g} | {cohesion:g} | {cells} | {right / 1e3:.2f} | {numbers} | {seconds:.0f} | {reason} |", flush=True)


if __name__ == "__main__":
    main()
