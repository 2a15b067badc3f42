#!/usr/bin/python3
"""berm and Kratos MPM side by side: a column collapses under its weight. Same grid, points, law, step and mass matrix.

    bench/kratos/compare.py --berm build/bench/bench/steps --kratos VENV/bin/python --out out/kratos

Prints what a Newton iteration takes in each, with two linear solvers each, and how far apart their points are. Kratos is
needed for nothing else; how to get it, and what is compared: bench/README.md.
"""

import argparse
import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import kratos_case

FRAMES = 4
LINEAR_TOLERANCE = 1e-7  # Kratos's default
# Lines of berm's [solver]. The first is what it takes of itself in the plane.
BERM_SOLVERS = {
    "direct (MUMPS)": "",
    "GMRES, ILU(0)": f'linear = "iterative"\nlinear_tolerance = {LINEAR_TOLERANCE}\npetsc = "-pc_type ilu"\n',
}
# Kratos's own default first, then the direct one of its wheel (Eigen). Others that were tried were not faster than the
# first: bench/README.md.
KRATOS_SOLVERS = {
    "CG, multigrid (amgcl)": {
        "solver_type": "amgcl", "smoother_type": "damped_jacobi", "krylov_type": "cg", "coarsening_type": "aggregation",
        "max_iteration": 200, "tolerance": LINEAR_TOLERANCE, "coarse_enough": 50},
    "direct (Eigen)": {"solver_type": "LinearSolversApplication.sparse_lu"},
}
ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Case:
    """Column of aluminium bars (Bui et al. 2008), with a little cohesion, or the same column of soft rubber."""

    law: str
    youngs_modulus: float
    cells_high: int
    steps: int
    tolerance: float
    dt: float = 5e-4
    poisson_ratio: float = 0.3
    density: float = 2650.0
    cohesion: float = 10.0
    friction_angle: float = 19.8
    width: float = 0.2
    height: float = 0.1

    @property
    def h(self):
        return self.height / self.cells_high

    @property
    def cells(self):
        return 4 * self.cells_high, round(1.2 * self.cells_high)

    @property
    def name(self):
        return f"{self.law} {2 * self.cells_high} x {self.cells_high}"


def cases(tolerance, only):
    steps = {  # by cells in the height; Mohr-Coulomb takes more iterations a step
        ("neo_hookean", 2e4): {15: 200, 50: 40, 100: 10},
        ("mohr_coulomb", 0.84e6): {15: 200, 50: 10, 100: 4},
    }
    every = [Case(law, E, high, n, tolerance) for (law, E), sizes in steps.items() for high, n in sizes.items()]
    return [c for c in every if only in c.name]


def berm_case(c, solver):
    strength = (f"cohesion = {c.cohesion}\nfriction_angle = {c.friction_angle}\ndilatancy_angle = 0.0\n"
                if c.law == "mohr_coulomb" else "")
    return f"""title = "Column, as in Kratos"
[model]
plane = "strain"
gravity = [0.0, -9.81]
volumetric = "standard"
[grid]
cell_size = {c.h}
cells = [{c.cells[0]}, {c.cells[1]}]
[material.column]
law = "{c.law}"
density = {c.density}
youngs_modulus = {c.youngs_modulus}
poisson_ratio = {c.poisson_ratio}
{strength}[body.column]
material = "column"
shape.box = {{ min = [0.0, 0.0], max = [{c.width}, {c.height}] }}
[boundary.wall]
where.box.max = [1e-6, 1.0]
ux = 0.0
[boundary.base]
where.box.max = [1.0, 1e-6]
ux = 0.0
uy = 0.0
[steps]
analysis = "dynamic"
duration = {c.steps * c.dt}
count = {c.steps}
adaptive = false
[solver]
relative_tolerance = {c.tolerance}
ghost_penalty = 0.0
{solver}[dynamics]
integrator = "newmark"
mass = "lumped"
transfer = "flip"
"""


class Result:
    """What both programs write, points in the order of their places at the start."""

    def __init__(self, file):
        r = json.loads(file.read_text())
        if r.get("lost"):
            raise SystemExit(f"{r['lost']} points are lost: nothing to compare ({file})")
        start = np.array(r["start"])
        order = np.lexsort(np.round(start, 9).T)
        self.start = start[order]
        self.frames = [(f["time"], np.array(f["position"])[order]) for f in r["frames"]]
        self.dofs, self.points, self.failed = r["dofs"], r["points"], r.get("not_converged", 0)
        self.iterations, self.seconds = sum(r["iterations"]), sum(r["seconds"])
        self.phases = r.get("phases")

    @property
    def per_iteration(self):
        return self.seconds / self.iterations


def run(command, folder):
    with open(folder / "terminal.txt", "w") as log:
        subprocess.run([*command, "result.json", str(FRAMES)], cwd=folder, env=ONE_THREAD, check=True, stdout=log,
                       stderr=subprocess.STDOUT)
    return Result(folder / "result.json")


def run_berm(program, folder, c, solver):
    (folder / "column.toml").write_text(berm_case(c, solver))
    return run([program, "column.toml"], folder)


def run_kratos(python, folder, c, solver):
    kratos_case.write(folder, c, solver)
    return run([python, Path(__file__).resolve().parent / "kratos_run.py", "ProjectParameters.json"], folder)


def measure(arguments, c):
    """The quickest run of every program and solver; in turns, so that a noisy machine troubles all alike."""
    jobs = {f"berm, {name}": (run_berm, arguments.berm, s) for name, s in BERM_SOLVERS.items()}
    jobs |= {f"Kratos, {name}": (run_kratos, arguments.kratos, s) for name, s in KRATOS_SOLVERS.items()}
    best = {}
    for turn in range(arguments.repeat):
        for number, (name, (job, program, solver)) in enumerate(jobs.items()):
            folder = arguments.out / c.name.replace(" ", "_") / f"{number}_{turn}"
            folder.mkdir(parents=True, exist_ok=True)
            result = job(program, folder, c, solver)
            if name not in best or result.seconds < best[name].seconds:
                best[name] = result
    return best


def speed_rows(c, results):
    berm = min((r for name, r in results.items() if name.startswith("berm")), key=lambda r: r.per_iteration)
    for name, r in results.items():
        ratio = ("" if name.startswith("berm") else
                 f"{r.per_iteration / berm.per_iteration:.1f} | {r.seconds / berm.seconds:.1f}")
        failed = f" ({r.failed} steps failed)" if r.failed else ""
        yield (f"| {c.name} | {name} | {r.dofs} | {r.points} | {c.steps} | {r.iterations}{failed} | "
               f"{1e3 * r.per_iteration:.2f} | {ratio or ' | '} |")


def accuracy_rows(c, a, b):
    """Of berm and Kratos, both with their direct solvers."""
    if a.start.shape != b.start.shape or np.abs(a.start - b.start).max() > 1e-8:
        raise SystemExit("the points do not start at the same places")
    for (time, x), (other, y) in zip(a.frames, b.frames):
        if abs(time - other) > 1e-9:
            raise SystemExit("the points are not of the same times")
        path, apart = np.linalg.norm(x - a.start, axis=1), np.linalg.norm(x - y, axis=1)
        yield (f"| {c.name} | {time:.4f} | {1e3 * path.mean():.4f} | {1e6 * apart.mean():.3g} | "
               f"{1e6 * apart.max():.3g} | {100 * apart.mean() / path.mean():.2g} % |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--berm", type=Path, required=True, help="the program `steps` of preset bench")
    parser.add_argument("--kratos", type=Path, required=True, help="the Python that has KratosMPMApplication")
    parser.add_argument("--out", type=Path, default=Path("out/kratos"), help="folder of the runs and of table.md")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative, of the residual, in both")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each, of which the quickest counts")
    parser.add_argument("--only", default="", help='cases with this in their name, as "neo_hookean" or "30 x 15"')
    arguments = parser.parse_args()
    arguments.berm, arguments.kratos = arguments.berm.resolve(), arguments.kratos.absolute()
    arguments.out = arguments.out.resolve()

    speed = ["| law, cells | program | dofs | points | steps | iterations | ms an iteration | times berm's best | "
             "whole run |",
             "|---|---|---|---|---|---|---|---|---|"]
    accuracy = ["| law, cells | time [s] | mean path [mm] | mean distance [µm] | largest [µm] | mean distance / path |",
                "|---|---|---|---|---|---|"]
    print(speed[0], flush=True)
    for c in cases(arguments.tolerance, arguments.only):
        results = measure(arguments, c)
        speed += speed_rows(c, results)
        accuracy += accuracy_rows(c, results["berm, direct (MUMPS)"], results["Kratos, direct (Eigen)"])
        print("\n".join(speed[-len(results):]), flush=True)
    table = "\n".join([*speed, "", *accuracy, ""])
    (arguments.out / "table.md").write_text(table)
    print("\n" + table)


if __name__ == "__main__":
    main()
