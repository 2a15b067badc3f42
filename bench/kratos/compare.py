#!/usr/bin/python3
"""berm and Kratos MPM side by side: a column collapses under its weight. Same grid, points, law, step and mass matrix.

    bench/kratos/compare.py --berm build/release/berm --kratos /tmp/kratos_venv/bin/python --out out/kratos

Prints, for every case, what a Newton iteration takes in each, and how far their points are from each other. Kratos is
needed for nothing else; how to get it: bench/README.md.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
import kratos_case  # noqa: E402
from berm.results import Run  # noqa: E402

FRAMES = 4
# Kratos's own default first (conjugate gradients with algebraic multigrid), then the direct one of its wheel (Eigen).
SOLVERS = {
    "multigrid": {"solver_type": "amgcl", "smoother_type": "damped_jacobi", "krylov_type": "cg",
                  "coarsening_type": "aggregation", "max_iteration": 200, "tolerance": 1e-7, "coarse_enough": 50},
    "direct": {"solver_type": "LinearSolversApplication.sparse_lu"},
}
ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Case:
    """Column of aluminium bars (Bui et al. 2008), with a little cohesion, or the same column of soft rubber."""

    law: str
    h: float
    dt: float
    steps: int
    tolerance: float
    youngs_modulus: float
    poisson_ratio: float = 0.3
    density: float = 2650.0
    cohesion: float = 10.0
    friction_angle: float = 19.8
    width: float = 0.2
    height: float = 0.1

    @property
    def cells(self):
        return round(0.4 / self.h), round(0.12 / self.h)

    @property
    def name(self):
        return f"{self.law}_{1e3 * self.h:g}mm_{1e3 * self.dt:g}ms"


def berm_case(c):
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
[dynamics]
integrator = "newmark"
mass = "lumped"
transfer = "flip"
[output]
frames = {FRAMES}
[checkpoint]
every_minutes = 0
"""


@dataclass
class Result:
    dofs: int
    points: int
    iterations: int
    seconds: float
    failed: int  # steps without convergence, or cut
    start: np.ndarray
    frames: dict  # time: position of the points, in the order of `start`

    @property
    def per_iteration(self):
        return self.seconds / self.iterations


def in_order(start, *others):
    """Sorted by place at the start, so that the points of both programs stand in the same row."""
    order = np.lexsort(np.round(start, 9).T)
    return [a[order] for a in (start, *others)]


def children_seconds():
    """Of the processor, by all ended programs that this one started: others at work on the machine are not in it."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_berm(program, folder, c):
    """Its seconds are the processor's, of the whole run: set-up and output are in them."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "column.toml").write_text(berm_case(c))
    command = [program, "run", folder / "column.toml", "--out", folder / "out"]
    before = children_seconds()
    with open(folder / "terminal.txt", "w") as log:
        subprocess.run(command, env=ONE_THREAD, check=True, stdout=log, stderr=subprocess.STDOUT)
    seconds = children_seconds() - before
    run = Run(str(folder / "out"))
    s = run.summary
    frames = {}
    for index in range(len(run.frames)):
        data = run.frame(index)
        now = data["position"][:, :2]
        start, frames[data["time"]] = in_order(now - data["displacement"][:, :2], now)
    return Result(s["dofs"], s["points"], s["newton_iterations"], seconds, s["cut_steps"], start, frames)


def run_kratos(python, folder, c, solver):
    """Its seconds are the processor's, of the steps alone."""
    folder.mkdir(parents=True, exist_ok=True)
    kratos_case.write(folder, c, solver)
    script = Path(__file__).resolve().parent / "kratos_run.py"
    command = [python, script, "ProjectParameters.json", "result.json", str(FRAMES)]
    with open(folder / "terminal.txt", "w") as log:
        subprocess.run(command, cwd=folder, env=ONE_THREAD, check=True, stdout=log, stderr=subprocess.STDOUT)
    r = json.loads((folder / "result.json").read_text())
    if r["lost"]:
        raise SystemExit(f"Kratos lost {r['lost']} points: nothing to compare ({folder})")
    start = np.array(r["start"])
    frames = {f["time"]: in_order(start, np.array(f["position"]))[1] for f in r["frames"]}
    return Result(r["dofs"], r["points"], sum(r["iterations"]), sum(r["seconds"]), r["not_converged"],
                  in_order(start)[0], frames)


def difference(a, b):
    """Of two results at the times they share: rows of time, fronts, mean displacement, distance of the points."""
    if a.start.shape != b.start.shape or np.abs(a.start - b.start).max() > 1e-8:
        raise SystemExit("the points do not start at the same places")
    rows = []
    for time, x in sorted(a.frames.items()):
        match = [y for t, y in b.frames.items() if abs(t - time) < 1e-9]
        if time == 0.0 or not match:
            continue
        y = match[0]
        move = np.linalg.norm(x - a.start, axis=1)
        apart = np.linalg.norm(x - y, axis=1)
        rows.append((time, x[:, 0].max(), y[:, 0].max(), move.mean(), apart.mean(), apart.max()))
    return rows


def least(runs):
    """The quickest of several runs, which differ in time alone."""
    return min(runs, key=lambda r: r.seconds)


def compare(arguments, c):
    folder = arguments.out / c.name
    berm, kratos = [], {name: [] for name in SOLVERS}
    for turn in range(arguments.repeat):  # in turns, so that a noisy machine troubles both
        berm.append(run_berm(arguments.berm, folder / f"berm_{turn}", c))
        for name, solver in SOLVERS.items():
            kratos[name].append(run_kratos(arguments.kratos, folder / f"kratos_{name}_{turn}", c, solver))
    return least(berm), {name: least(runs) for name, runs in kratos.items()}


def cases(arguments):
    bars = Case("mohr_coulomb", 0.004, 5e-4, 200, arguments.tolerance, 0.84e6)
    rubber = Case("neo_hookean", 0.004, 5e-4, 200, arguments.tolerance, 2e4)
    both = [bars, replace(bars, dt=2.5e-4, steps=400), rubber]
    if arguments.fine:
        both += [replace(bars, h=0.002, dt=2.5e-4, steps=200), replace(rubber, h=0.002, dt=2.5e-4, steps=200)]
    return [c for c in both if arguments.only in c.name]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--berm", type=Path, required=True, help="the program, from preset release")
    parser.add_argument("--kratos", type=Path, required=True, help="the Python that has KratosMPMApplication")
    parser.add_argument("--out", type=Path, default=Path("out/kratos"))
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative, of the residual, in both")
    parser.add_argument("--repeat", type=int, default=2, help="runs of each, of which the quickest counts")
    parser.add_argument("--fine", action="store_true", help="cells of 2 mm too")
    parser.add_argument("--only", default="", help="cases with this in their name")
    arguments = parser.parse_args()
    arguments.berm, arguments.kratos = arguments.berm.resolve(), arguments.kratos.absolute()
    arguments.out = arguments.out.resolve()

    speed = ["| case | program | dofs | points | steps | failed | iterations | s an iteration | berm is faster by |",
             "|---|---|---|---|---|---|---|---|---|"]
    accuracy = ["| case | time [s] | front, berm [m] | front, Kratos [m] | mean path [mm] | mean distance [mm] | largest [mm] |",
                "|---|---|---|---|---|---|---|"]
    for c in cases(arguments):
        berm, kratos = compare(arguments, c)
        for name, r in {"berm": berm, **{f"Kratos, {s}": r for s, r in kratos.items()}}.items():
            ratio = "" if r is berm else f"{r.per_iteration / berm.per_iteration:.1f} (run: {r.seconds / berm.seconds:.1f})"
            speed.append(f"| {c.name} | {name} | {r.dofs} | {r.points} | {c.steps} | {r.failed} | {r.iterations} | "
                         f"{r.per_iteration:.4f} | {ratio} |")
        for t, xb, xk, path, mean, largest in difference(berm, kratos["direct"]):
            accuracy.append(f"| {c.name} | {t:.4f} | {xb:.5f} | {xk:.5f} | {1e3 * path:.3f} | {1e3 * mean:.4f} | "
                            f"{1e3 * largest:.4f} |")
        print(speed[-1], flush=True)
    table = "\n".join([*speed, "", *accuracy, ""])
    (arguments.out / "table.md").write_text(table)
    print(table)


if __name__ == "__main__":
    main()
