#!/usr/bin/python3
"""Stands in for the program in the tests of sweeps: `run CASE --out DIR --set KEY=VALUE ... [--force]`.

Keys: factor (of the load), steps, fail (a reason). Without --force it refuses a folder with a summary.json.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import synthetic  # noqa: E402

assert sys.argv[1] == "run" and os.path.isfile(sys.argv[2]) and sys.argv[3] == "--out", sys.argv
settings = dict(a.split("=", 1) for flag, a in zip(sys.argv[5::2], sys.argv[6::2]) if flag == "--set")
if "fail" in settings:
    sys.exit(f"some words\n{settings['fail']}")
if "--force" not in sys.argv and os.path.exists(os.path.join(sys.argv[4], "summary.json")):
    print(f"{sys.argv[4]}: holds the results of a run that came to its end: --force replaces them", file=sys.stderr)
    sys.exit(2)
synthetic.write_run(
    sys.argv[4], "mpm", float(settings.get("factor", 1)), cell=0.05, steps=int(settings.get("steps", 20)), frames=2
)
