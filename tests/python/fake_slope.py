#!/usr/bin/python3
"""Stands in for the program in the tests of the factor of safety: `run CASE --out DIR --set KEY=VALUE ... --force`.

A slope of 10 kPa and 20 degrees (in case.toml) that falls once both strengths are divided by more than 1.37 (key
`falls_at`); with `runs_out = true` it finds equilibrium all the same, after ten times the displacement, with `comes_down = true` at the foot of the
slope. With `breaks` it writes nothing.
"""

import json
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import synthetic  # noqa: E402

assert sys.argv[1] == "run" and os.path.isfile(sys.argv[2]) and sys.argv[3] == "--out", sys.argv
settings = dict(a.split("=", 1) for flag, a in zip(sys.argv[5::2], sys.argv[6::2]) if flag == "--set")
if "nonsense" in settings:
    sys.exit(2)
if "breaks" in settings:
    sys.exit("the disk is full")
assert sys.argv[-1] == "--force", sys.argv
out = sys.argv[4]
falls_at = float(settings.get("falls_at", 1.37))
cohesion = float(settings.get("material.soil.cohesion", 10e3))
angle = float(settings.get("material.soil.friction_angle", 20.0))
by_cohesion, by_friction = 10e3 / cohesion, math.tan(math.radians(20.0)) / math.tan(math.radians(angle))
assert abs(by_cohesion - by_friction) < 1e-9, "cohesion and friction must be reduced alike"
assert float(settings.get("material.soil.dilatancy_angle", 0.0)) <= angle
if by_cohesion > 1.3:
    print("warning: strains of 0.2 in small strain", file=sys.stderr)
falls, comes_down = by_cohesion > falls_at, settings.get("comes_down") == "true"
runs_out = comes_down or settings.get("runs_out") == "true"

synthetic.TRAVEL *= (100.0 if comes_down else 10.0) if falls else 1.0 + 0.1 * by_cohesion
synthetic.write_run(out, "mpm", 1.0, cell=0.05, steps=20, frames=2)
with open(os.path.join(out, "case.toml"), "w", encoding="utf-8") as file:
    file.write(
        f'[material.rock]\nlaw = "linear_elastic"\n[material.soil]\nlaw = "{settings.get("law", "mohr_coulomb")}"\n'
        'cohesion = "10 kN/m²"\nfriction_angle = 20\ndilatancy_angle = "5 deg"\n[steps]\nduration = 2.0\n'
    )
if falls and not runs_out:
    path = os.path.join(out, "summary.json")
    with open(path, encoding="utf-8") as file:
        summary = json.load(file)
    summary["status"] = "failed"
    summary["reason"] = settings.get("reason", "no equilibrium found at time 1 (step 0.001, the smallest allowed)")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(summary, file)
    sys.exit(1)
