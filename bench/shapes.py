#!/usr/bin/python3
"""Cost of a Newton iteration by shape function, plane and solid: a block under its weight, finite strain, updated Lagrangian.

    OPENBLAS_NUM_THREADS=1 bench/shapes.py build/bench/berm [--repeat 3]

Prints a table in Markdown: milliseconds an iteration by phase, the best of the repeats, and the whole over that of linear
functions."""

import argparse
import csv
import pathlib
import re
import subprocess
import tempfile

FUNCTIONS = ["linear", "linear, Gauss points", "quadratic_bspline", "cubic_bspline", "ugimp", "cpgimp", "b2gimp", "cpdi"]
PHASES = ["connectivity", "laws", "assembly", "linear solver"]
CASE = """
[model]
{model}
formulation = "updated_lagrangian"
gravity = {gravity}
[grid]
{grid}
[material.soil]
law = "linear_elastic"
density = 2000.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[body.block]
material = "soil"
shape.box = {{ min = {low}, max = {high} }}
[boundary.base]
where.box = {{ max = {base} }}
{held}
[steps]
count = 20
adaptive = false
"""
PLANE = dict(model='plane = "strain"', gravity="[0.0, -10.0]", grid="cells = [120, 100]\ncell_size = 0.01", low="[0.1, 0.0]",
             high="[1.1, 0.9]", base="[2.0, 1e-6]", held="ux = 0.0\nuy = 0.0")
SOLID = dict(model="dimension = 3", gravity="[0.0, 0.0, -10.0]", grid="cells = [14, 14, 12]\ncell_size = 0.1",
             low="[0.2, 0.2, 0.0]", high="[1.2, 1.2, 1.0]", base="[2.0, 2.0, 1e-6]",
             held="ux = 0.0\nuy = 0.0\nuz = 0.0")


def measure(berm, text, folder):
    """Milliseconds an iteration by phase and in all; unknowns."""
    (folder / "case.toml").write_text(text)
    out = subprocess.run([berm, "run", str(folder / "case.toml"), "--force", "--out", str(folder / "out")], check=True, text=True,
                         capture_output=True).stdout
    with open(folder / "out" / "history.csv") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    iterations = sum(float(row["newton_iterations [-]"]) for row in rows)
    seconds = [float(re.search(rf"{phase} ([0-9.]+) s", out).group(1)) for phase in PHASES]
    unknowns = int(re.search(r"unknowns +(\d+)", out).group(1))
    return [1e3 * s / iterations for s in seconds + [sum(seconds)]], unknowns, iterations


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("berm")
    parser.add_argument("--repeat", type=int, default=3)
    args = parser.parse_args()
    print("| | functions | unknowns | iterations | " + " | ".join(PHASES) + " | all [ms] | over linear |")
    print("|" + "---|" * (7 + len(PHASES)))
    with tempfile.TemporaryDirectory() as folder:
        for name, parts in (("plane", PLANE), ("solid", SOLID)):
            first = None
            for functions in FUNCTIONS:
                word, *gauss = functions.split(", ")
                grid = parts["grid"] + f'\nshape_functions = "{word}"'
                model = parts["model"] + ('\nquadrature = "gauss"' if gauss else "")
                text = CASE.format(**{**parts, "grid": grid, "model": model})
                runs = [measure(args.berm, text, pathlib.Path(folder)) for _ in range(args.repeat)]
                best, unknowns, iterations = min(runs, key=lambda run: run[0][-1])
                first = first or best[-1]
                print(f"| {name} | {functions} | {unknowns} | {iterations:.0f} | " + " | ".join(f"{ms:.1f}" for ms in best) +
                      f" | {best[-1] / first:.2f} |", flush=True)


if __name__ == "__main__":
    main()
