#!/usr/bin/python3
"""Stands in for the program in the tests of sweeps: `run CASE --out DIR --set KEY=VALUE ...`.

Keys: factor (of the load), steps, fail (a reason).
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import synthetic  # noqa: E402

assert sys.argv[1] == "run" and os.path.isfile(sys.argv[2]) and sys.argv[3] == "--out", sys.argv
settings = dict(a.split("=", 1) for flag, a in zip(sys.argv[5::2], sys.argv[6::2]) if flag == "--set")
if "fail" in settings:
    sys.exit(f"some words\n{settings['fail']}")
synthetic.write_run(
    sys.argv[4], "mpm", float(settings.get("factor", 1)), cell=0.05, steps=int(settings.get("steps", 20)), frames=2
)
