#!/usr/bin/env python3
"""Whole runs on several processes, stopped and continued ones, and how they end: runs.py BERM [unittest arguments]

Runs with 1, 2 and 4 processes differ by the order of sums and by the elimination order of the direct solver, i.e. by
rounding. That is about 1e-12 where the response is smooth (ELASTIC below leaves a margin); softening and points that
cross cells multiply it, by how much is said at each case.
"""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from berm import compare  # noqa: E402
from berm.results import Run, read_mesh  # noqa: E402

ELASTIC = 1e-8
TIMEOUT = 300  # s: far more than any run here takes; a hang ends as an error
BERM = ""
FOLDER = pathlib.Path()
ENVIRONMENT = {
    **os.environ,
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",  # more processes than cores
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "LC_ALL": "C",
}
MPIEXEC = ["mpiexec", "--allow-run-as-root", "--oversubscribe"]

# ---- cases

ROCK = """
[material.rock]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "10 GPa"
poisson_ratio = 0.2
"""
CONCRETE = """
[material.rock]
law = "simo_ju"
density = 2410.0
youngs_modulus = "35.5 GPa"
poisson_ratio = 0.2
tensile_strength = "3.05 MPa"
strength_ratio = 12.3
fracture_energy = 100.0
"""
NOMINAL = """
[output.nominal]
load = "platen"
displacement = "platen"
direction = [0.0, -1.0, 0.0]
area = 7.85e-3
length = 0.2
"""
# Tie contact, surface points on curved cut cells, a gauge and probes in space.
CYLINDER = f"""
[model]
dimension = 3
[grid]
kind = "hexahedra"
origin = [-0.063, 0.0, -0.063]
cell_size = 0.018
cells = [7, 12, 7]
{CONCRETE}
[body.specimen]
material = "rock"
shape.cylinder = {{ from = [0.0, 0.0, 0.0], to = [0.0, 0.2, 0.0], radius = 0.05 }}
[body.platen]
rigid = true
shape.box = {{ min = [-0.055, 0.2, -0.055], max = [0.055, 0.208, 0.055] }}
displacement = [0.0, -2.2e-4, 0.0]
[contact.top]
body = "specimen"
rigid = "platen"
kind = "tie"
[boundary.base]
where.box = {{ min = [-1.0, -1e-6, -1.0], max = [1.0, 1e-6, 1.0] }}
ux = 0.0
uy = 0.0
uz = 0.0
[gauge.height]
from = [0.0, 0.05, 0.0]
to = [0.0, 0.15, 0.0]
[probe.middle]
at = [0.01, 0.1, 0.0]
quantity = "stress_yy"
[probe.side]
at = [0.0, 0.1, 0.04]
quantity = "displacement_z"
[solver]
integration = "impl_ex"
[steps]
count = 10
adaptive = false
[output]
frames = 4
{NOMINAL}
"""
# A bordered system: the pressures' factor is unknown, the diameter grows. Pins hold the disc.
DISC = """
[model]
plane = "stress"
[grid]
origin = [-0.085, -0.085]
cell_size = 0.01
cells = [17, 17]
[material.rock]
law = "rankine"
density = 2410.0
youngs_modulus = "35.5 GPa"
poisson_ratio = 0.2
tensile_strength = "3.05 MPa"
fracture_energy = 100.0
[body.disc]
material = "rock"
shape.disc = { centre = [0.0, 0.0], radius = 0.075 }
mesh = { kind = "quads", size = 0.01, structured = true }
[pressure.top]
body = "disc"
where.sector = { centre = [0.0, 0.0], from = 80.0, to = 100.0 }
value = "1 MPa"
[pressure.bottom]
body = "disc"
where.sector = { centre = [0.0, 0.0], from = 260.0, to = 280.0 }
value = "1 MPa"
[pin.centre]
body = "disc"
at = [0.0, 0.0]
fix = "xy"
[pin.axis]
body = "disc"
at = [0.0, 0.05]
fix = "x"
[gauge.lateral]
from = [-0.075, 0.0]
to = [0.075, 0.0]
[probe.centre]
at = [0.0, 0.0]
quantity = "stress_xx"
[control]
kind = "gauge"
gauge = "lateral"
target = 2e-5
[steps]
count = 60
adaptive = false
[solver]
integration = "impl_ex"
[output]
frames = 6
[output.nominal]
load = "top"
displacement = "lateral"
direction = [0.0, -1.0]
area = 0.2356
length = 0.15
"""
# Weight and a platen whose points move the nodes around them.
SHARED = f"""
[model]
plane = "strain"
gravity = [0.0, -9.81]
[grid]
origin = [-0.75, 0.0]
cell_size = 0.125
cells = [12, 12]
{ROCK}
[body.block]
material = "rock"
shape.box = {{ min = [-0.5, 0.0], max = [0.5, 1.0] }}
[body.platen]
rigid = true
shape.box = {{ min = [-0.5, 1.0], max = [0.5, 1.25] }}
displacement = [1e-4, -1e-3]
[contact.top]
body = "block"
rigid = "platen"
kind = "shared_nodes"
[boundary.base]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[probe.middle]
at = [0.1, 0.4]
quantity = "stress_yy"
[steps]
count = 6
[output]
frames = 2
[output.nominal]
load = "platen"
displacement = "platen"
"""
# Two rigid bodies, one without friction and one without slip, that the block leaves in part as it is pressed.
UNILATERAL = f"""
[model]
plane = "strain"
[grid]
origin = [-0.75, -0.25]
cell_size = 0.125
cells = [12, 12]
{ROCK}
[body.block]
material = "rock"
shape.difference = [{{ box = {{ min = [-0.5, 0.0], max = [0.5, 1.0] }} }}, {{ disc = {{ centre = [0.5, 0.5], radius = 0.2 }} }}]
[body.floor]
rigid = true
shape.box = {{ min = [-0.7, -0.2], max = [0.7, 0.0] }}
[body.platen]
rigid = true
shape.box = {{ min = [-0.3, 1.0], max = [0.5, 1.2] }}
displacement = [0.0, -1e-3]
[contact.bottom]
body = "block"
rigid = "floor"
kind = "no_slip"
stiffness = 10.0
[contact.top]
body = "block"
rigid = "platen"
kind = "frictionless"
stiffness = 10.0
[pin.left]
body = "block"
at = [-0.1, 0.5]
fix = "x"
[steps]
count = 6
[output]
frames = 2
[output.nominal]
load = "platen"
displacement = "platen"
"""
FEM_SOLID = f"""
method = "fem"
[model]
dimension = 3
gravity = [0.0, -9.81, 0.0]
{CONCRETE}
[body.block]
material = "rock"
shape.difference = [{{ box = {{ min = [0.0, 0.0, 0.0], max = [0.1, 0.2, 0.1] }} }}, {{ box = {{ min = [0.05, 0.1, 0.0], max = [0.1, 0.15, 0.1] }} }}]
mesh = {{ kind = "hexahedra", size = 0.025, structured = true }}
[body.platen]
rigid = true
shape.box = {{ min = [-0.01, 0.2, -0.01], max = [0.11, 0.21, 0.11] }}
displacement = [0.0, -4e-5, 0.0]
[contact.top]
body = "block"
rigid = "platen"
kind = "tie"
[boundary.base]
where.box.max = [10.0, 1e-6, 10.0]
ux = 0.0
uy = 0.0
uz = 0.0
[gauge.height]
from = [0.02, 0.05, 0.05]
to = [0.02, 0.15, 0.05]
[solver]
integration = "impl_ex"
[steps]
count = 10
adaptive = false
[output]
frames = 2
[output.nominal]
load = "platen"
displacement = "platen"
"""
AXISYMMETRIC = f"""
[model]
plane = "axisymmetric"
[grid]
cell_size = 0.01
cells = [7, 22]
{CONCRETE}
[body.specimen]
material = "rock"
shape.box = {{ min = [0.0, 0.0], max = [0.055, 0.2] }}
[body.platen]
rigid = true
shape.box = {{ min = [0.0, 0.2], max = [0.06, 0.21] }}
displacement = [0.0, -2e-4]
[contact.top]
body = "specimen"
rigid = "platen"
kind = "tie"
[boundary.base]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[boundary.axis]
where.box.max = [1e-6, 10.0]
ux = 0.0
[solver]
integration = "impl_ex"
[steps]
count = 10
adaptive = false
[output]
frames = 2
[output.nominal]
load = "platen"
displacement = "platen"
"""
# A block that is drawn along through more than four cells, and stretched, by what it is tied to, so that nearly all
# points change their process; the cells are shared out anew again and again.
DRAWN = f"""
[model]
plane = "strain"
[grid]
cell_size = 0.1
cells = [16, 5]
{ROCK}
[body.block]
material = "rock"
shape.box = {{ min = [0.2, 0.0], max = [1.0, 0.33] }}
[body.hand]
rigid = true
shape.box = {{ min = [0.1, 0.0], max = [0.2, 0.33] }}
displacement = [0.4321, 0.0]
[contact.grip]
body = "block"
rigid = "hand"
kind = "tie"
stiffness = 1.0
[body.pull]
rigid = true
shape.box = {{ min = [1.0, 0.0], max = [1.1, 0.33] }}
displacement = [0.4521, 0.0]
[contact.pull]
body = "block"
rigid = "pull"
kind = "tie"
stiffness = 1.0
[boundary.floor]
where.box.max = [10.0, 1e-6]
uy = 0.0
[gauge.length]
from = [0.3, 0.1]
to = [0.9, 0.2]
[probe.middle]
at = [0.6, 0.15]
quantity = "displacement_x"
[parallel]
rebalance = 1.02
[steps]
count = 40
[solver]
ghost_penalty = 0.01
[output]
frames = 4
[output.nominal]
load = "pull"
displacement = "pull"
direction = [1.0, 0.0]
"""
# A bar that becomes half as long again: points with domains are split at a third.
STRETCHED = f"""
[model]
plane = "strain"
[grid]
origin = [-0.5, -0.5]
cell_size = 0.1
cells = [30, 12]
{ROCK}
[body.bar]
material = "rock"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 0.5] }}
[boundary.left]
body = "bar"
where.box.max = [1e-6, 10.0]
ux = 0.0
[boundary.bottom]
body = "bar"
where.box.max = [10.0, 1e-6]
uy = 0.0
[boundary.top]
body = "bar"
where.box.min = [-10.0, 0.499999]
uy = 0.0
[boundary.right]
body = "bar"
where.box.min = [0.999999, -10.0]
ux = "0.5*t"
[probe.middle]
at = [0.5, 0.2]
quantity = "displacement_x"
[steps]
count = 60
adaptive = false
[output]
frames = 4
[output.nominal]
load = "right"
displacement = "right"
direction = [1.0, 0.0]
"""
# DRAWN, its left side a boundary that moves with it.
HELD = (DRAWN[:DRAWN.index("[body.hand]")] + """[boundary.grip]
body = "block"
where.box.max = [0.2001, 10.0]
ux = "0.4321*t"
""" + DRAWN[DRAWN.index("[body.pull]"):])
DRAWN_SOLID = f"""
[model]
dimension = 3
[grid]
cell_size = 0.1
cells = [10, 4, 4]
{ROCK}
[body.block]
material = "rock"
shape.box = {{ min = [0.1, 0.0, 0.0], max = [0.5, 0.23, 0.27] }}
[body.hand]
rigid = true
shape.box = {{ min = [0.0, 0.0, 0.0], max = [0.1, 0.23, 0.27] }}
displacement = [0.2321, 0.0, 0.0]
[contact.grip]
body = "block"
rigid = "hand"
kind = "tie"
stiffness = 1.0
[body.pull]
rigid = true
shape.box = {{ min = [0.5, 0.0, 0.0], max = [0.6, 0.23, 0.27] }}
displacement = [0.2421, 0.0, 0.0]
[contact.pull]
body = "block"
rigid = "pull"
kind = "tie"
stiffness = 1.0
[boundary.floor]
where.box.max = [10.0, 1e-6, 10.0]
uy = 0.0
[boundary.wall]
where.box.max = [10.0, 10.0, 1e-6]
uz = 0.0
[parallel]
rebalance = 1.02
[steps]
count = 12
[output]
frames = 3
[output.nominal]
load = "pull"
displacement = "pull"
direction = [1.0, 0.0, 0.0]
"""
# Pressures that follow a soft block and depend on the place, friction on the floor, a stamp that pushes.
SLIDING = """
[model]
plane = "strain"
gravity = [0.0, "-9.81*min(t/0.2,1)"]
[grid]
origin = [-1.0, -0.25]
cell_size = 0.125
cells = [20, 12]
[material.rubber]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "1 MPa"
poisson_ratio = 0.3
[body.block]
material = "rubber"
shape.box = { min = [-0.5, 0.0], max = [0.53, 1.0] }
[body.floor]
rigid = true
shape.box = { min = [-1.0, -0.2], max = [1.5, 0.0] }
[body.stamp]
rigid = true
shape.box = { min = [-0.8, 0.1], max = [-0.5, 0.4] }
displacement = ["0.05*max(t-0.2,0)", 0.0]
[contact.bottom]
body = "block"
rigid = "floor"
kind = "friction"
friction = 0.3
stiffness = 100.0
[contact.side]
body = "block"
rigid = "stamp"
kind = "frictionless"
stiffness = 100.0
[pressure.top]
body = "block"
where.box.min = [-1.0, 0.95]
value = "3e4*(1+x)*min(t,0.5)"
[gauge.width]
from = [-0.4, 0.3]
to = [0.4, 0.3]
[steps]
count = 20
adaptive = false
[output]
frames = 4
[output.nominal]
load = "stamp"
displacement = "stamp"
direction = [1.0, 0.0]
"""
# A turned grid whose lines slip, and a base that moves as a function of the place.
INCLINED = f"""
[model]
plane = "strain"
gravity = [0.0, -9.81]
[grid]
cell_size = 0.1
cells = [10, 12]
angle = 30.0
{ROCK}
[body.block]
material = "rock"
shape.polygon = [[0.0, 0.0], [0.8660254037844387, 0.5], [0.3660254037844387, 1.3660254037844386], [-0.5, 0.8660254037844387]]
[boundary.left]
where.beyond = {{ at = [0.0, 1e-6], normal = [-0.8660254037844387, -0.5] }}
normal = [-0.8660254037844387, -0.5]
[boundary.right]
where.beyond = {{ at = [0.86602, 0.5], normal = [0.8660254037844387, 0.5] }}
normal = [0.8660254037844387, 0.5]
un = -1e-3
[boundary.base]
where.beyond = {{ at = [0.0, 1e-6], normal = [0.5, -0.8660254037844387] }}
ux = "1e-3*t*y"
uy = "-2e-3*t*x*y"
[gauge.height]
from = [0.4, 0.3]
to = [0.0, 1.0]
[steps]
count = 8
adaptive = false
[output]
frames = 2
[output.nominal]
load = "right"
displacement = "right"
direction = [-1.0, 0.0]
"""

# Thrown: turns, vibrates and falls through the grid, so that points change their process.
THROWN = """
[model]
plane = "strain"
gravity = [0.0, "t < 0.1 ? -98.1*t : -9.81"]
[grid]
origin = [-0.3, -5.0]
cell_size = 0.1
cells = [50, 70]
[material.rock]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "2 MPa"
poisson_ratio = 0.3
[body.block]
material = "rock"
shape.box = { min = [0.0, 0.0], max = [0.8, 0.43] }
velocity = ["3 - 2*y", "2*x"]
[gauge.length]
from = [0.1, 0.2]
to = [0.7, 0.2]
[probe.middle]
at = [0.4, 0.2]
quantity = "velocity_y"
[dynamics]
transfer = "blend"
rayleigh_stiffness = 1e-4
[stage.start]
analysis = "dynamic"
duration = 0.1
count = 10
[stage.motion]
analysis = "dynamic"
duration = 0.5
count = 50
[stage.again]
analysis = "dynamic"
duration = 0.4
count = 60
dynamics = { integrator = "hht", mass = "consistent", transfer = "apic" }
[output]
frames = 4
"""

# Two blocks that rest on, slide on and leave each other, on a grid with fields of their own; dashpots under them.
STACKED = """
[model]
plane = "strain"
gravity = [0.0, "-10*min(t/0.2, 1)"]
[grid]
origin = [-0.1, 0.0]
cell_size = 0.1
cells = [44, 14]
[material.rock]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "1 MPa"
poisson_ratio = 0.2
[body.lower]
material = "rock"
shape.box = { min = [0.0, 0.0], max = [1.6, 0.4] }
[body.upper]
material = "rock"
shape.box = { min = [0.4, 0.4], max = [0.9, 0.85] }
acceleration = ["t < 0.3 ? 0 : 12", 0.0]
[contact.between]
body = "upper"
other = "lower"
kind = "friction"
friction = 0.4
[boundary.base]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[absorbing.side]
body = "lower"
where.box = { min = [1.599, 0.0], max = [1.601, 0.4] }
p_wave_speed = 33.0
s_wave_speed = 20.0
density = 1000.0
[stage.weight]
analysis = "dynamic"
duration = 0.2
count = 20
dynamics.rayleigh_mass = 20.0
[stage.push]
analysis = "dynamic"
duration = 0.8
count = 160
[dynamics]
integrator = "bossak"
transfer = "blend"
[output]
frames = 4
"""

# Nearly incompressible, on its way down; cells that hold a few points only.
SLUMP = """
[model]
gravity = [0.0, -0.4]
volumetric = "mixed"
[grid]
cell_size = 0.1
cells = [12, 8]
[material.clay]
law = "von_mises"
density = 1800.0
youngs_modulus = "40 kPa"
poisson_ratio = 0.499
yield_stress = "80 Pa"
[body.heap]
material = "clay"
shape.box = { min = [0.0, 0.0], max = [0.4, 0.62] }
[boundary.left]
where.box.max = [1e-6, 10.0]
ux = 0.0
[boundary.base]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[steps]
analysis = "dynamic"
count = 40
"""

# Three blocks in a row: two in contact, the third left out.
# Two bodies with their border inside cells, which fly through the grid, turn and swing.
JOINED = """
[model]
plane = "strain"
[grid]
origin = [0.0, 0.0]
cell_size = 0.1
cells = [24, 12]
[material.hard]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "1 MPa"
poisson_ratio = 0.2
[material.soft]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "0.1 MPa"
poisson_ratio = 0.2
[body.left]
material = "hard"
shape.polygon = [[0.3, 0.3], [0.72, 0.3], [0.65, 0.8], [0.3, 0.8]]
velocity = [4.0, "x - 0.7"]
mesh = { kind = "quads", size = 0.1 }
[body.right]
material = "soft"
shape.polygon = [[0.72, 0.3], [1.1, 0.3], [1.1, 0.8], [0.65, 0.8]]
velocity = [4.0, "x - 0.7"]
mesh = { kind = "quads", size = 0.08 }
[steps]
analysis = "dynamic"
duration = 0.1
count = 50
[output]
frames = 4
"""

THREE = """
[model]
[grid]
cell_size = 0.1
cells = [12, 4]
[material.stone]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "1 MPa"
poisson_ratio = 0.2
[body.left]
material = "stone"
shape.box = { min = [0.0, 0.0], max = [0.4, 0.4] }
[body.middle]
material = "stone"
shape.box = { min = [0.4, 0.0], max = [0.8, 0.4] }
[body.right]
material = "stone"
shape.box = { min = [0.85, 0.0], max = [1.2, 0.4] }
[boundary.base]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[contact.joint]
body = "left"
other = "middle"
kind = "frictionless"
[steps]
count = 1
"""

TEXT = {
    "stacked": STACKED,
    "cylinder": CYLINDER,
    "thrown": THROWN,
    "disc": DISC,
    "shared": SHARED,
    "unilateral": UNILATERAL,
    "fem_solid": FEM_SOLID,
    "axisymmetric": AXISYMMETRIC,
    "drawn": DRAWN,
    "held": HELD,
    "stretched": STRETCHED,
    "drawn_solid": DRAWN_SOLID,
    "sliding": SLIDING,
    "inclined": INCLINED,
    "slump": SLUMP,
    "joined": JOINED,
    "three": THREE,
}
FINITE = ["model.kinematics=finite", "model.formulation=updated_lagrangian"]
SMALL = ["model.kinematics=small", "model.formulation=total_lagrangian"]
F_BAR = ["model.volumetric=f_bar"]
MIXED = ["model.volumetric=mixed"]
CHECKPOINTS = ["checkpoint.every_steps=5"]


# ---- running

def case_file(name):
    path = FOLDER / f"{name}.toml"
    if not path.exists():
        path.write_text(f'title = "{name}"\n' + TEXT[name].lstrip())
    return str(path)


def sets(overrides):
    return [word for o in overrides for word in ("--set", o)]


def plain(name):
    """Cases that do not name their functions are about linear ones, whose bounds here are tight."""
    text = TEXT[name]
    return ["grid.shape_functions=linear"] if "[grid]" in text and "shape_functions" not in text else []


def command(name, out, processes=1, overrides=(), more=(), mpiexec=False):
    words = [BERM, "run", case_file(name), "--out", str(out), *sets([*plain(name), *overrides]), *more]
    if mpiexec:
        return [*MPIEXEC, "-n", str(processes), *words]
    return words + (["-n", str(processes), "--oversubscribe"] if processes > 1 else [])


def call(words):
    return subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, timeout=TIMEOUT, check=False)


def fresh(label):
    out = FOLDER / label
    shutil.rmtree(out, ignore_errors=True)
    return out


FINISHED = {}  # runs are done once


def finished(name, processes=1, overrides=(), mpiexec=False):
    """The folder of a run from beginning to end."""
    key = (name, processes, *overrides, mpiexec)
    if key not in FINISHED:
        out = fresh(f"{name}_{len(FINISHED)}_{processes}")
        done = call(command(name, out, processes, overrides, mpiexec=mpiexec))
        if done.returncode != 0:
            raise AssertionError(f"{' '.join(done.args)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
        FINISHED[key] = out
    return FINISHED[key]


def stress_of_cells(folder):
    """Means of stress_xx in the cells of all frames, in the order of size: cells have no number of their own."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    meshes = [read_mesh(path) for _, path in Run(folder).mesh_frames]
    return np.concatenate([np.sort(vtk_to_numpy(mesh.GetCellData().GetArray("stress"))[:, 0]) for mesh in meshes])


def descendants(pid):
    """The process and all below it."""
    children = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError, ValueError):
            fields = stat.read_text().rpartition(")")[2].split()
            children.setdefault(int(fields[1]), []).append(int(stat.parent.name))
    found, queue = [], [pid]
    while queue:
        found.append(queue.pop())
        queue += children.get(found[-1], [])
    return found


def wait_for(condition, process):
    end = time.monotonic() + TIMEOUT
    while not condition():
        if process.poll() is not None or time.monotonic() > end:
            process.kill()
            out, errors = process.communicate()
            raise AssertionError(f"ended with {process.returncode} before it could be interrupted:\n{out}{errors}")
        time.sleep(0.005)


def rows(out):
    try:
        return max(0, (out / "history.csv").read_text().count("\n") - 1)
    except OSError:
        return 0


def start(words):
    return subprocess.Popen(
        words, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


class Case(unittest.TestCase):
    def assert_agree(self, a, b, history, points, before=None):
        a, b = Run(a), Run(b)
        differences, problems, until = compare.compare_history(a, b, history, before)
        fields, more, at = compare.compare_points(a, b, points, until)
        self.assertEqual(problems + more, [], f"{a.path} and {b.path}")
        self.assertIsNotNone(at, "no frame to compare")
        judged = [[d for d in group if d.tolerance is not None] for group in (differences, fields)]
        worst = [max(group, key=lambda d: d.value) for group in judged]
        print(
            f"{self.id().split('.')[-1]}: {a.name} and {b.name}: "
            + ", ".join(f"{d.name} {d.value:.1e} at {d.place}" for d in worst),
            flush=True,
        )
        off = [f"{d.name}: {d.value:.2e} > {d.tolerance:g} at {d.place}" for group in judged for d in group if d.off]
        self.assertEqual(off, [], f"{a.path} and {b.path}")

    def assert_complete(self, out, points=None, end=1.0):
        """Nothing lost, nothing twice, every frame there."""
        run = Run(out)
        self.assertEqual(run.summary["status"], "done")
        self.assertEqual(run.metric("points_lost"), 0)
        self.assertEqual(list(run.history["step"]), list(range(len(run.history["step"]))))
        self.assertAlmostEqual(run.history["time"][-1], end, 12)
        times = [t for t, _ in run.frames]
        self.assertEqual(times, sorted(set(times)))
        self.assertEqual(times, [t for t, _ in run.mesh_frames])
        for k in range(len(run.frames)):
            ids = run.frame(k)["id"]
            self.assertEqual(len(np.unique(ids)), len(ids))
        self.assertEqual(len(run.last()["id"]), run.summary["points"])
        if points is not None:
            self.assertEqual(run.summary["points"], points)

    def assert_one_message(self, done, code, words):
        """That exit code, and those words once and in the last line."""
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        self.assertTrue(lines, done.stdout)
        self.assertIn(words, lines[-1])
        self.assertEqual(done.stderr.count(words), 1, done.stderr)
        self.assertNotIn("PETSC ERROR", done.stderr)


# ---- the same on any number of processes

class AnyNumberOfProcesses(Case):
    def same(self, name, overrides=(), history=ELASTIC, points=ELASTIC, before=None, counts=(2, 4)):
        one = finished(name, 1, overrides)
        for n in counts:
            more = finished(name, n, overrides)
            self.assert_agree(one, more, history, points, before)
            self.assert_complete(more, Run(one).summary["points"], Run(one).history["time"][-1])
            self.assertEqual(Run(more).summary["processes"], n)
            error = Run(one).metric("stress_error")  # sums over patches that lie across processes; only with a nominal load
            self.assertEqual(error is None, "nominal" not in TEXT[name])
            if error is not None:
                self.assertAlmostEqual(Run(more).metric("stress_error"), error, delta=10 * history * error)

    # Softening: IMPL-EX steps are linear, what they amplify is the difference of the start of damage; 1e-10 was seen.
    def test_cylinder_small_strain(self):
        self.same("cylinder", SMALL, points=1e-7)

    def test_cylinder_finite_strain(self):
        self.same("cylinder", FINITE, points=1e-7)

    # Multigrid differs with the number of processes: what is left is its tolerance.
    def test_iterative_solver(self):
        more = ["solver.linear=iterative", "solver.linear_tolerance=1e-10", "steps.count=4"]
        # Where damage has just begun, the energy released so far is a small difference: 1e-4 of it.
        self.same("cylinder", SMALL + more, history=1e-6, points=1e-4, counts=(2,))

    # MUMPS on all processes: the last digits are those of no other run.
    def test_distributed_solver(self):
        self.same("disc", ["solver.linear=distributed"], history=1e-6, points=1e-5, counts=(2,))

    def test_tetrahedra(self):
        self.same("cylinder", [*SMALL, "grid.kind=tetrahedra", "steps.count=4"], points=1e-7, counts=(2,))

    def test_started_with_mpiexec(self):
        a, b = finished("cylinder", 2, SMALL), finished("cylinder", 2, SMALL, mpiexec=True)
        self.assert_agree(a, b, 1e-14, 1e-14)
        self.assert_complete(b)

    def test_gauge_control_before_the_peak(self):
        self.same("disc", before=0.9)

    # Past the peak the crack chooses its way among equals: the disc is symmetric.
    def test_gauge_control_past_the_peak(self):
        self.same("disc", history=1e-6, points=1e-5)

    def test_gauge_control_fem(self):
        self.same("disc", ["method=fem"], history=1e-6, points=1e-5)

    def test_gravity_and_shared_nodes(self):
        self.same("shared")

    def test_unilateral_contact(self):
        self.same("unilateral")

    def test_friction_and_following_pressure(self):
        self.same("sliding", history=1e-7, points=1e-6)

    def test_inclined_supports(self):
        self.same("inclined")

    def test_fem_in_space(self):
        self.same("fem_solid")

    def test_fem_tetrahedra_of_order_two(self):
        mesh = 'body.block.mesh={ kind = "tetrahedra", size = 0.04, order = 2 }'
        self.same("fem_solid", [mesh, "steps.count=4"], counts=(2,))

    def test_axisymmetric(self):
        self.same("axisymmetric")

    def test_axisymmetric_finite_strain(self):
        self.same("axisymmetric", FINITE, counts=(4,))

    def test_ghost_stabilisation(self):
        self.same("disc", ["solver.ghost_penalty=0.1"], before=0.9)
        # It must matter, or else nothing was tested.
        weak, strong = Run(finished("disc", 4)), Run(finished("disc", 4, ["solver.ghost_penalty=0.1"]))
        self.assertGreater(abs(weak.history["reaction"][1] / strong.history["reaction"][1] - 1.0), 1e-6)

    # Every crossing of a cell is a jump of the forces: it must come in the same step everywhere.
    def test_points_that_travel(self):
        self.same("drawn", history=1e-7, points=1e-7)
        before, after = (Run(finished("drawn", 4)).frame(k) for k in (0, -1))
        self.assertGreater((after["position"] - before["position"])[:, 0].min(), 0.4)

    def test_points_that_travel_in_space(self):
        self.same("drawn_solid", history=1e-7, points=1e-7)

    def test_motion(self):
        self.same("thrown", history=1e-6, points=1e-6)

    # Sticking and sliding multiply rounding.
    def test_bodies_on_each_other(self):
        self.same("stacked", history=1e-5, points=1e-5)
        for functions in ("cpgimp", "b2gimp"):
            self.same("stacked", [f"grid.shape_functions={functions}"], history=1e-5, points=1e-5, counts=(2,))

    def test_bodies_that_stay_together(self):
        self.same("joined", history=1e-6, points=1e-6)
        self.same("joined", ["method=fem"], history=1e-7, points=1e-7, counts=(2,))

    def test_motion_fem(self):
        mesh = 'body.block.mesh={ kind = "quads", size = 0.1, structured = true, order = 2 }'
        self.same("thrown", ["method=fem", mesh], history=1e-7, points=1e-7, counts=(2,))

    def test_f_bar(self):
        self.same("drawn", F_BAR, history=1e-7, points=1e-7)
        self.same("axisymmetric", [*FINITE, *F_BAR], counts=(4,))
        self.same("drawn_solid", [*F_BAR, "model.formulation=total_lagrangian"], history=1e-7, points=1e-7, counts=(2,))

    def test_mixed(self):
        self.same("drawn", MIXED, history=1e-7, points=1e-7)
        self.same("drawn_solid", MIXED, history=1e-7, points=1e-7, counts=(2,))
        self.same("slump", history=1e-5, points=1e-5, counts=(2,))

    def test_splines(self):
        for degree, counts in (("quadratic", (2, 4)), ("cubic", (2,))):
            self.same("drawn", [f"grid.shape_functions={degree}_bspline"], history=1e-7, points=1e-7, counts=counts)
        self.same("drawn_solid", ["grid.shape_functions=quadratic_bspline"], history=1e-7, points=1e-7, counts=(2,))

    def test_domains(self):
        for functions, counts in (("cpgimp", (2, 4)), ("b2gimp", (2,)), ("cpdi", (2, 4))):
            shape = f"grid.shape_functions={functions}"
            self.same("drawn", [shape, *FINITE], history=1e-7, points=1e-7, counts=counts)
            self.same("drawn_solid", [shape, *FINITE], history=1e-7, points=1e-7, counts=(2,))

    def test_f_bar_of_domains(self):
        """Boxes with one list of nodes have one mean dilatation, wherever their middles lie; cells hold what lies in them."""
        for functions, counts in (("cpgimp", (2, 4)), ("cpdi", (2,))):
            overrides = [f"grid.shape_functions={functions}", *FINITE, *F_BAR]
            self.same("drawn", overrides, history=1e-7, points=1e-7, counts=counts)
            one, *more = (stress_of_cells(finished("drawn", n, overrides)) for n in (1, *counts))
            for other in more:
                np.testing.assert_allclose(other, one, rtol=1e-6, atol=1e-6 * np.abs(one).max())

    def test_held_surface(self):
        self.same("held", history=1e-7, points=1e-7)

    def test_motion_without_a_value_on_one_process(self):
        """One error in place of a process that waits for ever."""
        for n in (1, 2):
            words = command("held", fresh(f"nan_{n}"), n, ["boundary.grip.ux=0.4321*t + 0*y*sqrt(0.5 - t)"])
            self.assert_one_message(call(words), 1, "sqrt(0.5 - t)")
        self.same("held", ["grid.shape_functions=cpdi"], history=1e-7, points=1e-7, counts=(2,))

    def test_without_rebalancing(self):
        self.same("drawn", ["parallel.rebalance=100.0"], history=1e-7, points=1e-7, counts=(4,))

    def test_vtk_reads_the_lists_of_pieces(self):
        from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader

        out = finished("cylinder", 4, SMALL)
        n = Run(out).summary["points"]
        for kind in ("points", "mesh"):
            lists = sorted(out.glob(f"{kind}_*.pvtu"))
            self.assertGreater(len(lists), 3)
            for path in lists:
                reader = vtkXMLPUnstructuredGridReader()
                errors = []
                reader.AddObserver("ErrorEvent", lambda *_, errors=errors, path=path: errors.append(path))
                reader.SetFileName(str(path))
                reader.Update()
                self.assertEqual(errors, [])
                grid = reader.GetOutput()
                if kind == "points":
                    self.assertEqual(grid.GetNumberOfPoints(), n)
                    self.assertIsNotNone(grid.GetPointData().GetArray("stress"))
                else:
                    whole = read_mesh(str(finished("cylinder", 1, SMALL) / (path.stem + ".vtu")))
                    self.assertEqual(grid.GetNumberOfCells(), whole.GetNumberOfCells())
                    ranks = grid.GetCellData().GetArray("rank")
                    self.assertEqual(ranks.GetRange(), (0.0, 3.0))


# ---- stopped and continued

class Continued(Case):
    def killed(self, name, processes, overrides, after):
        """The folder of a run that was killed, all of it, at once and without a warning, after that many steps, or was
        over by then."""
        out = fresh(f"{name}_killed_{processes}_{len(overrides)}")
        process = start(command(name, out, processes, overrides))
        wait_for(lambda: process.poll() == 0 or (rows(out) > after and (out / "checkpoint.h5").exists()), process)
        for pid in descendants(process.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        process.communicate(timeout=TIMEOUT)
        return out

    def goes_on(self, name, before, after, overrides=(), history=ELASTIC, points=ELASTIC, steps=7):
        overrides = [*overrides, *CHECKPOINTS]
        whole = finished(name, 1, overrides)
        for _ in range(10):  # on a busy machine the run may be faster than who watches it
            out = self.killed(name, before, overrides, steps)
            if rows(out) < rows(whole):
                break
        self.assertLess(rows(out), rows(whole), "the run was over before it was killed")
        done = call(command(name, out, after, overrides, ["--restart", str(out / "checkpoint.h5")]))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assert_complete(out, Run(whole).summary["points"], Run(whole).history["time"][-1])
        self.assertEqual([t for t, _ in Run(out).frames], [t for t, _ in Run(whole).frames])
        self.assert_agree(whole, out, history, points)

    def test_solid_on_more_processes(self):
        self.goes_on("cylinder", 1, 2, [*SMALL, "steps.count=20"], points=1e-7)

    def test_solid_on_fewer_processes(self):
        self.goes_on("cylinder", 2, 1, [*FINITE, "steps.count=20"], points=1e-7)

    def test_gauge_control(self):
        self.goes_on("disc", 2, 4, ["output.frames=12"], history=1e-6, points=1e-5, steps=12)

    # The forces of held surfaces; domains of points.
    def test_held_surface(self):
        self.goes_on("held", 1, 2, ["grid.shape_functions=cpdi"], history=1e-7, points=1e-7)

    # More points than at the start.
    def test_domains_that_were_split(self):
        self.goes_on("stretched", 1, 2, ["grid.shape_functions=cpdi"], history=1e-7, points=1e-7, steps=45)
        run = Run(finished("stretched", 1, ["grid.shape_functions=cpdi", *CHECKPOINTS]))
        self.assertGreater(len(run.last()["id"]), len(run.frame(0)["id"]))
        probe = run.history["probe:middle"]  # exact at any step, also where the points become others
        np.testing.assert_allclose(probe, 0.25 * run.history["time"], atol=2e-3)

    # The slip of contacts, and the place of the points of a rigid body that moves.
    def test_contact(self):
        self.goes_on("unilateral", 1, 2, ["steps.count=40"])

    def test_contact_on_fewer_processes(self):
        self.goes_on("unilateral", 4, 2, ["steps.count=40"])

    def test_friction_and_following_pressure(self):
        self.goes_on("sliding", 2, 1, ["steps.count=60"], history=1e-7, points=1e-6)

    def test_inclined_supports(self):
        self.goes_on("inclined", 1, 2, ["steps.count=60"])

    def test_shared_nodes_that_move_through_cells(self):
        push = ["body.platen.displacement=[0.0, -0.2]", "steps.count=40", "material.rock.youngs_modulus=1e6"]
        self.goes_on("shared", 2, 1, push, history=1e-6, points=1e-6, steps=26)

    def test_points_that_travel(self):
        self.goes_on("drawn", 2, 4, history=1e-7, points=1e-7, steps=22)

    # In the second and in the third stage.
    def test_motion(self):
        self.goes_on("thrown", 2, 1, history=1e-6, points=1e-6, steps=22)

    def test_bodies_on_each_other(self):
        self.goes_on("stacked", 2, 1, history=1e-5, points=1e-5, steps=80)

    def test_bodies_that_stay_together(self):
        self.goes_on("joined", 2, 1, history=1e-6, points=1e-6, steps=22)
        self.goes_on("joined", 1, 2, ["method=fem"], history=1e-7, points=1e-7, steps=22)

    def test_motion_in_a_later_stage(self):
        self.goes_on("thrown", 1, 2, history=1e-7, points=1e-7, steps=80)

    def test_motion_fem(self):
        mesh = 'body.block.mesh={ kind = "quads", size = 0.1, structured = true, order = 2 }'
        self.goes_on("thrown", 1, 2, ["method=fem", mesh], history=1e-7, points=1e-7, steps=80)

    def test_fem(self):
        self.goes_on("fem_solid", 1, 4, ["steps.count=30"])

    def test_fem_on_fewer_processes(self):
        self.goes_on("fem_solid", 2, 1, ["steps.count=30"])

    def test_axisymmetric(self):
        self.goes_on("axisymmetric", 4, 1, [*FINITE, "steps.count=30"])

    # The total Lagrangian form keeps what it needs to get back from the mean dilatation.
    def test_f_bar(self):
        total = [*F_BAR, "model.kinematics=finite", "model.formulation=total_lagrangian"]
        self.goes_on("axisymmetric", 2, 1, [*total, "steps.count=30"])

    def test_mixed(self):
        self.goes_on("drawn", 2, 1, MIXED)

    def test_in_another_folder(self):
        """Frames that are not there are not listed."""
        whole = finished("shared", 1, CHECKPOINTS)
        out = fresh("shared_elsewhere")
        done = call(command("shared", out, 1, CHECKPOINTS, ["--restart", str(whole / "checkpoint.h5")]))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        run = Run(out)
        self.assertTrue(all(os.path.isfile(path) for _, path in run.frames + run.mesh_frames))
        self.assert_agree(whole, out, ELASTIC, ELASTIC)

    def test_log_goes_on(self):
        whole = finished("shared", 1, CHECKPOINTS)
        out = fresh("shared_log")
        shutil.copytree(whole, out)
        first = (out / "log.txt").read_text()
        done = call(command("shared", out, 1, CHECKPOINTS, ["--restart", str(out / "checkpoint.h5")]))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        log = (out / "log.txt").read_text()
        self.assertTrue(log.startswith(first))
        self.assertIn("goes on after step 5", log)


class Stopped(Case):
    def stopped(self, number, processes, mpiexec=False):
        out = fresh(f"stopped_{number.name}_{processes}_{mpiexec}")
        overrides = ["steps.count=2000"]
        process = start(command("drawn", out, processes, overrides, mpiexec=mpiexec))
        wait_for(lambda: rows(out) > 3, process)
        os.kill(process.pid, number)
        text, errors = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 1, text + errors)
        self.assertTrue((out / "checkpoint.h5").exists())
        self.assertEqual(errors.count("stopped by a signal"), 1, errors)
        self.assertIn(f"--restart {out / 'checkpoint.h5'}", errors)
        if not mpiexec:  # mpiexec has words of its own
            self.assertEqual(len(errors.strip().splitlines()), 1, errors)
        run = Run(out)
        self.assertEqual(run.summary["status"], "stopped")
        self.assertIn("--restart", run.summary["reason"])
        self.assertEqual(run.frames[-1][0], run.history["time"][-1])

    def test_sigterm_alone(self):
        self.stopped(signal.SIGTERM, 1)

    def test_sigint_alone(self):
        self.stopped(signal.SIGINT, 1)

    def test_sigterm_on_two(self):
        self.stopped(signal.SIGTERM, 2)

    def test_sigint_on_two(self):
        self.stopped(signal.SIGINT, 2)

    def test_sigusr1_to_mpiexec(self):
        self.stopped(signal.SIGUSR1, 2, mpiexec=True)


# ---- what cannot be done

class Refused(Case):
    def refused(self, name, file, words, processes=(1, 2), overrides=()):
        for n in processes:
            out = fresh(f"refused_{n}")
            out.mkdir()
            (out / "log.txt").write_text("berm 0.1.0\n")  # a folder of results
            (out / "history.csv").write_text("step [-]\n0\n")
            done = call(command(name, out, n, overrides, ["--restart", str(file)]))
            self.assert_one_message(done, 2, words)
            self.assertEqual((out / "history.csv").read_text(), "step [-]\n0\n", "the results of another run are lost")

    def test_file_that_is_missing(self):
        self.refused("shared", FOLDER / "absent.h5", "absent.h5: No such file")

    def test_text_file(self):
        file = FOLDER / "text.h5"
        file.write_text("time = 1\n" * 100)
        self.refused("shared", file, "text.h5 is not a checkpoint of berm")

    def test_truncated_file(self):
        whole = (finished("shared", 1, CHECKPOINTS) / "checkpoint.h5").read_bytes()
        for part in (0.3, 0.99):
            file = FOLDER / "short.h5"
            file.write_bytes(whole[: int(part * len(whole))])
            self.refused("shared", file, "short.h5 is not a checkpoint of berm: its checksum does not fit")

    def test_flipped_bits(self):
        whole = (finished("shared", 1, CHECKPOINTS) / "checkpoint.h5").read_bytes()
        for place in (0.05, 0.4, 0.8):
            broken = bytearray(whole)
            broken[int(place * len(whole))] ^= 16
            file = FOLDER / "flipped.h5"
            file.write_bytes(broken)
            self.refused("shared", file, "flipped.h5 is not a checkpoint of berm: its checksum does not fit")

    def test_other_models(self):
        file = finished("shared", 1, CHECKPOINTS) / "checkpoint.h5"
        for other, words in (
            (["grid.cells=[14, 12]"], "grid.cells[0] was 12, now it is 14"),
            (["grid.shape_functions=quadratic_bspline"], 'grid.shape_functions was'),
            (["probe.middle.quantity=stress_xx"], 'probe.middle.quantity was "stress_yy", now it is "stress_xx"'),
            (["steps.analysis=dynamic"], 'steps.analysis was'),
            (["model.kinematics=small"], 'model.kinematics was "finite", now it is "small"'),
            (["model.formulation=total_lagrangian"], "model.formulation was"),
            (["body.block.points.per_direction=3"], "body.block.points.per_direction was"),
        ):
            self.refused("shared", file, "written by another case: " + words, processes=(1,), overrides=other)
        self.refused("fem_solid", file, 'written by another case: method was "mpm", now it is "fem"')

    def test_what_changed_is_told(self):
        """Loads and steps may change; the log says what did."""
        whole = finished("shared", 1, CHECKPOINTS) / "checkpoint.h5"
        out = fresh("changed")
        done = call(command("shared", out, 1, ["solver.max_iterations=33"], ["--restart", str(whole)]))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("solver.max_iterations was 25, now it is 33", (out / "log.txt").read_text())

    def test_other_gauges(self):
        file = finished("shared", 1, CHECKPOINTS) / "checkpoint.h5"
        other = ["gauge.more.from=[0.0, 0.2]", "gauge.more.to=[0.0, 0.7]"]
        self.refused("shared", file, "gauge.more.from[0] was absent, now it is 0.0", overrides=other)

    def test_wrong_key(self):
        for n in (1, 2):
            done = call(command("shared", fresh("wrong_key"), n, ["model.gravty=[0.0, -9.81]"]))
            self.assert_one_message(done, 2, 'unknown key "gravty"')

    def test_body_outside_the_grid(self):
        for n in (1, 2):
            done = call(command("shared", fresh("outside"), n, ["grid.cells=[12, 6]"]))
            self.assert_one_message(done, 2, "make the grid larger")

    def test_point_that_leaves_the_grid(self):
        """On the right only, where one process of two is."""
        for n in (1, 2, 4):
            out = fresh(f"leaves_{n}")
            done = call(command("drawn", out, n, ["grid.cells=[13, 5]"]))
            self.assert_one_message(done, 1, "has left the background grid")
            run = Run(out)
            self.assertEqual(run.summary["status"], "failed")
            self.assertIn("has left the background grid", run.summary["reason"])

    def test_folder_that_cannot_be_made(self):
        (FOLDER / "file").write_text("")
        for n in (1, 2):
            self.assert_one_message(call(command("shared", FOLDER / "file" / "out", n)), 2, "cannot create the output")

    def test_history_that_cannot_be_written(self):
        """Only the first process writes it."""
        for n in (1, 2):
            out = fresh(f"full_{n}")
            (out / "history.csv").mkdir(parents=True)
            (out / "history.csv" / "x").write_text("")
            done = call(command("shared", out, n, CHECKPOINTS,
                                ["--restart", str(finished("shared", 1, CHECKPOINTS) / "checkpoint.h5")]))
            self.assert_one_message(done, 1, "cannot write " + str(out / "history.csv"))

    def test_log_that_cannot_be_written(self):
        for n in (1, 2):
            out = fresh(f"log_{n}")
            (out / "log.txt").mkdir(parents=True)
            self.assert_one_message(call(command("shared", out, n)), 1, "cannot write " + str(out / "log.txt"))


class Words(Case):
    def test_check_with_mpiexec(self):
        for n in (1, 2):
            done = call([*MPIEXEC, "-n", str(n), BERM, "check", case_file("cylinder")])
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout.count("body specimen"), 1)
            self.assertEqual(done.stderr, "")
        done = call([*MPIEXEC, "-n", "2", BERM, "check", case_file("cylinder"), "--set", "solver.petc=x"])
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count('unknown key "petc"'), 1)

    def test_bodies_that_nothing_keeps_apart(self):
        for n in (1, 2):
            done = call([*MPIEXEC, "-n", str(n), BERM, "check", case_file("three")])
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout.count('"right" and "middle" lie next to each other and do not'), 1)
            self.assertEqual(done.stdout.count("without a [contact.NAME] they will pass"), 1)

    def test_petsc_options(self):
        done = call(command("shared", fresh("options"), 2, ["solver.petsc=-ksp_monitor", "steps.count=1"]))
        self.assertEqual(done.returncode, 0, done.stderr)
        monitor = [line for line in done.stdout.splitlines() if "KSP Residual norm" in line]
        self.assertTrue(monitor, done.stdout)
        first = [line for line in monitor if line.strip().startswith("0 KSP")]
        last = [line for line in monitor if line.strip().startswith("1 KSP")]
        self.assertEqual((len(first), len(last)), (len(monitor) // 2, len(monitor) // 2))
        self.assertEqual(len(set(first)), len(first), "the same line twice: from two processes")

    def test_no_control_characters_where_there_is_no_terminal(self):
        for mpiexec in (False, True):
            done = call(command("shared", fresh("plain"), 2, mpiexec=mpiexec))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("\x1b", done.stdout)
            self.assertEqual(done.stderr, "")


def main():
    global BERM, FOLDER
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    BERM = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        FOLDER = pathlib.Path(folder)
        unittest.main(argv=[sys.argv[0], *sys.argv[2:]])


if __name__ == "__main__":
    main()
