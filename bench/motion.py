"""Energy that every transfer keeps with every basis and mass: a table for docs/theory/dynamics.md.

    python3 bench/motion.py build/release/berm [folder]

A free bar vibrates for 100 periods of its first mode, 12 steps each; a free square turns ten times, 100 steps each, through the cells. Ten minutes on one core.
"""

import csv
import itertools
import pathlib
import subprocess
import sys
import tempfile

BAR = """
[grid]
origin = [-0.5, -0.25]
cell_size = 0.125
cells = [16, 5]
[material.m]
law = "linear_elastic"
density = 2500.0
youngs_modulus = "100 MPa"
poisson_ratio = 0.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 0.125] }
velocity = ["0.001*cos(pi*x)", 0.0]
[steps]
analysis = "dynamic"
duration = 1.0
count = 1200
adaptive = false
[output]
frames = 1
"""

SQUARE = """
model = { plane = "stress" }
grid = { origin = [-1.0, -1.0], cell_size = 0.2, cells = [10, 10] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
[body.b]
material = "m"
shape.box = { min = [-0.5, -0.5], max = [0.5, 0.5] }
velocity = ["-2*pi*y", "2*pi*x"]
[steps]
analysis = "dynamic"
duration = 10.0
count = 1000
adaptive = false
[output]
frames = 1
"""

TRANSFERS = ("flip", "pic", "blend", "apic")
BASES = ("linear", "quadratic_bspline", "cubic_bspline", "ugimp", "cpgimp", "b2gimp", "cpdi")
MASSES = ("lumped", "consistent")


def energies(berm, text, folder, transfer, basis, mass):
    """Of the end and the largest, over that of the start, and the part of the run that was done."""
    case = folder / "case.toml"
    case.write_text(text)
    keys = [f'dynamics.transfer="{transfer}"', f'grid.shape_functions="{basis}"', f'dynamics.mass="{mass}"']
    command = [berm, "run", str(case), "--quiet", "--force", "--out", str(folder / "out")]
    for key in keys:
        command += ["--set", key]
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    with open(folder / "out" / "history.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    total = [float(r["kinetic_energy [J]"]) + float(r["elastic_energy [J]"]) for r in rows]
    return total[-1] / total[0], max(total) / total[0], float(rows[-1]["time [s]"])


def cell(berm, text, duration, folder, *choice):
    try:
        end, most, time = energies(berm, text, folder, *choice)
    except (OSError, IndexError, KeyError) as problem:
        return f"refused ({type(problem).__name__})"
    note = f", most 1 + {most - 1.0:.1e}" if most > 1.0 + 1e-6 else ""
    return f"{end:.4f}{note}" + (f", stops at {time:.2g} s" if time < 0.999 * duration else "")


def main():
    berm = sys.argv[1]
    print("| transfer | functions | bar, lumped | bar, consistent | square, lumped | square, consistent |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else name)
        folder.mkdir(exist_ok=True)
        for basis, transfer in itertools.product(BASES, TRANSFERS):
            cells = [cell(berm, text, duration, folder, transfer, basis, mass)
                     for text, duration in ((BAR, 1.0), (SQUARE, 10.0)) for mass in MASSES]
            print("| " + " | ".join([transfer, basis, *cells]) + " |", flush=True)


main()
