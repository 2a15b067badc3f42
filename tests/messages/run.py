#!/usr/bin/env python3
"""Runs that are made to fail: what the program says, and whether the remedy that it names is accepted and helps.

    run.py BERM [--markdown FILE] [NAMES ...]

Every entry is a small case, what must be said, and the remedy of that message as changes of the case. A remedy helps if the case then runs to its
end (or is accepted, where `run = False`) without saying it again. Exits with 1 if a word is missing or a remedy does not help.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

ELASTIC = """
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
"""
BRITTLE = """
[material.m]
law = "rankine"
density = 2400.0
youngs_modulus = "30 GPa"
poisson_ratio = 0.2
tensile_strength = "3 MPa"
fracture_energy = 100.0
"""
SAND = """
[material.m]
law = "mohr_coulomb"
density = 2000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
cohesion = 1e3
friction_angle = 30.0
"""
GRID = "grid = { origin = [-0.2, -0.2], cell_size = 0.1, cells = [24, 24] }\n"
BLOCK = '[body.a]\nmaterial = "m"\nshape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }\nmesh = { kind = "quads", size = 0.1, structured = true }\n'
BASE = "[boundary.base]\nwhere.box = { max = [9.0, 1e-6] }\nux = 0.0\nuy = 0.0\n"
TOP = "[boundary.top]\nwhere.box = { min = [-9.0, 0.9999], max = [9.0, 1.0001] }\nuy = -0.001\n"
FEW = "[steps]\ncount = 3\n"
MOVES = '[steps]\nanalysis = "dynamic"\nduration = 0.05\ncount = 10\n'
PLATE = '[body.plate]\nrigid = true\nshape.box = { min = [-0.1, 1.0], max = [1.1, 1.4] }\ndisplacement = [0.0, "-0.3*t"]\n'
LATE_TIE = '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "tie"\nstages = ["second"]\n[stage.first]\ncount = 2\n[stage.second]\ncount = 2\n'
ROLLERS = "[boundary.left]\nwhere.box.max = [1e-6, 9.0]\nux = 0.0\n" + BASE.replace("ux = 0.0\n", "")
PULLED = ('[pressure.p]\nbody = "a"\nwhere.box.min = [0.999, -9.0]\nvalue = 2e6\nstages = ["first"]\n[boundary.pull]\nwhere.box = { min = [0.999, -9.0], max = [1.001, 9.0] }\n'
          'ux = 0.0\nstages = ["second"]\n[stage.first]\ncount = 5\n[stage.second]\ncount = 5\n')
SLIT = '[body.a]\nmaterial = "m"\nshape.difference = [ { box = { min = [0.0, 0.0], max = [1.0, 1.0] } }, { box = { min = [-1.0, 0.45], max = [0.5, 0.55] } } ]\n'
TWO = BLOCK.replace("[1.0, 1.0]", "[0.5, 0.5]") + '[body.b]\nmaterial = "m"\nshape.box = { min = [0.55, 0.0], max = [1.0, 0.5] }\n'
SLOT = '[body.a]\nmaterial = "m"\nshape.difference = [ { box = { min = [0.0, 0.0], max = [1.0, 1.0] } }, { box = { min = [0.2, 0.4], max = [2.0, 0.6] } } ]\n'
THREE = "".join(f'[body.{name}]\nmaterial = "m"\nshape.box = {{ min = {low}, max = {high} }}\n' for name, low, high in (
    ("root", [0.0, 0.0], [0.2, 1.0]), ("low", [0.2, 0.0], [1.0, 0.4]), ("high", [0.2, 0.6], [1.0, 1.0]))) + '[contact.c]\nbody = "high"\nother = "low"\nkind = "friction"\nfriction = 0.3\n'
PRESSED = '[boundary.press]\nbody = "a"\nwhere.box = { min = [0.8, 0.9999] }\nuy = -0.15\n[steps]\ncount = 10\n'
PUSHED = '[boundary.push]\nbody = "b"\nwhere.box = { min = [1.1999, -9.0] }\nux = -0.28\nuy = 0.0\n[steps]\ncount = 5\n'
SQUASHED = (GRID + SAND.replace("1e3", "2e5") + 'tensile_strength = 0.0\n' + BLOCK + BASE.replace("ux = 0.0\n", "") + '[boundary.middle]\nwhere.box = { min = [0.499, -1.0], max = [0.501, 1e-6] }\nux = 0.0\n'
            + '[pressure.top]\nbody = "a"\nwhere.box.min = [-1.0, 0.999]\nvalue = "400 kPa"\n[steps]\ncount = 10\n')
FLOOR = """
[body.floor]
rigid = true
shape.box = { min = [-0.2, -0.2], max = [2.0, 0.0] }
[contact.c]
body = "a"
rigid = "floor"
kind = "friction"
friction = 0.3
"""
TIP = """
model.gravity = [0.0, "-9.81*t"]
[body.wedge]
material = "m"
shape.polygon = [[0.5, 0.0], [1.0, 0.5], [0.0, 0.5]]
[boundary.top]
where.box = { min = [-1.0, 0.4999], max = [3.0, 0.5001] }
ux = 0.0
[steps]
count = 5
""" + FLOOR.replace('"a"', '"wedge"').replace("0.3", "0.5")
SLOPE = """
model.gravity = [0.0, "-9.81*min(t, 1)"]
[body.a]
material = "m"
shape.polygon = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.2], [1.0, 2.0], [0.0, 2.0]]
[boundary.left]
where.box = { max = [1e-6, 9.0] }
ux = 0.0
"""
SLIDE = """
model = { gravity = [0.0, "-9.81*min(t, 1)"] }
[stage.rest]
analysis = "quasi_static"
count = 4
[stage.push]
analysis = "quasi_static"
count = 20
[pressure.side]
body = "a"
where.box = { max = [1e-6, 9.0] }
value = "6e3*max(0, t - 1)"
""" + FLOOR
# The middle cell is weaker by less than what a step adds: all three pass their peak in one.
THREE_CELLS = """
grid = { origin = [0.0, 0.0], cell_size = 0.1, cells = [1, 3] }
model = { kinematics = "small" }
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [0.1, 0.1] }
mesh = { kind = "quads", size = 0.1, structured = true }
[body.middle]
material = "weak"
shape.box = { min = [0.0, 0.1], max = [0.1, 0.2] }
mesh = { kind = "quads", size = 0.1, structured = true }
[body.b]
material = "m"
shape.box = { min = [0.0, 0.2], max = [0.1, 0.3] }
mesh = { kind = "quads", size = 0.1, structured = true }
[boundary.left]
where.box.max = [1e-6, 9.0]
ux = 0.0
[boundary.below]
where.box.max = [9.0, 1e-6]
uy = 0.0
[boundary.top]
where.box.min = [-1.0, 0.29999]
uy = 4e-4
[steps]
count = 200
""" + BRITTLE.replace("material.m", "material.weak").replace("3 MPa", "2.99 MPa")
# The second body is held by friction alone, which holds nothing before it is pressed.
FLIES = """
model.gravity = [0.0, -9.81]
grid = { origin = [-0.5, 0.0], cell_size = 0.1, cells = [35, 18] }
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [2.0, 0.5] }
[body.b]
material = "m"
shape.box = { min = [0.53, 0.5], max = [1.13, 1.3] }
[contact.c]
body = "b"
other = "a"
kind = "friction"
friction = 1e-6
[pressure.t]
body = "b"
where.box = { min = [0.0, 1.299], max = [2.0, 1.301] }
value = 80000.0
""" + ELASTIC.replace("1e7", "3e6") + BASE + "[steps]\ncount = 40\n"
BAR = """
grid = { origin = [-0.2, -0.2], cell_size = 0.1, cells = [44, 14] }
[body.a]
material = "m"
shape.difference = [ { box = { min = [0.0, 0.0], max = [4.0, 0.2] } }, { box = { min = [1.9, 0.1], max = [2.0, 0.3] } } ]
mesh = { kind = "quads", size = 0.1, structured = true }
[boundary.left]
where.box = { max = [1e-6, 9.0] }
ux = 0.0
[boundary.right]
where.box = { min = [3.9999, -9.0] }
ux = "2e-3*t"
[boundary.base]
where.box = { max = [1e-6, 1e-6] }
uy = 0.0
[steps]
count = 10
min_fraction = 0.05
"""
CLAY = """
model.gravity = [0.0, -9.81]
[material.m]
law = "modified_cam_clay"
density = 1800.0
reference_pressure = 50e3
critical_state_slope = 1.0
lambda_star = 0.05
kappa_star = 0.01
shear_modulus = 2e6
preconsolidation_pressure = 100e3
[boundary.right]
where.box.min = [0.9999, -9.0]
ux = 0.0
[steps]
count = 10
"""
WHOLE = "box = { min = [0.0, 0.0], max = [1.0, 0.2] }"
NOTCHED = "difference = [ { " + WHOLE + " }, { box = { min = [0.5, 0.1], max = [0.6, 0.3] } } ]"
UNIFORM_BAR = (BAR.replace("difference = [ { box = { min = [0.0, 0.0], max = [4.0, 0.2] } }, { box = { min = [1.9, 0.1], max = [2.0, 0.3] } } ]", WHOLE)
               .replace("3.9999", "0.9999").replace("2e-3*t", "4e-4*t").replace("count = 10", "count = 40"))
DILATES = """
grid = { origin = [0.0, 0.0], cell_size = 0.5, cells = [6, 6] }
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [0.5, 1.0] }
[boundary.base]
where.box = { max = [9.0, 1e-6] }
uy = 0.0
[boundary.left]
where.box = { max = [1e-6, 9.0] }
ux = 0.0
[boundary.top]
body = "a"
where.box = { min = [-9.0, 0.999] }
uy = "-0.3*t"
[steps]
count = 20
"""
FALLS = 'model.gravity = [0.0, -9.81]\n[steps]\nanalysis = "dynamic"\nduration = 0.5\ncount = 20\n'
CUBE = """
model.dimension = 3
grid = { kind = "hexahedra", origin = [-0.2, -0.2, -0.2], cell_size = 0.1, cells = [9, 9, 9] }
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0, 0.0], max = [0.4, 0.4, 0.4] }
"""
FEM = 'method = "fem"\n'
SPLINES = 'grid = { origin = [0, 0], cell_size = 1.0, cells = [1, 1], shape_functions = "cubic_bspline" }\n'

# name: (case, what must be said, changes of the text or [--set ...], does it run then)
FAILURES = {
    "slit": (GRID + ELASTIC + SLIT + BASE + TOP + FEW, "gap of 0.1 m in body", ["grid.origin=[-0.2,-0.25]", "boundary.base.body=a", "boundary.top.body=a"]),
    "slit of splines": (GRID.replace("24] }", '24], shape_functions = "quadratic_bspline" }') + ELASTIC + SLIT + BASE + FEW, "gap of 0.1 m in body",
                        ["model.allow_glued=true"]),
    "bodies apart": (GRID + ELASTIC + TWO + BASE + FEW, 'between bodies "a" and "b"', ['contact.c={body="a",other="b",kind="frictionless"}']),
    "bodies apart, allowed": (GRID + BRITTLE + TWO + BASE + FEW, 'between bodies "a" and "b"', ["model.allow_glued=true"]),
    "sides of a slot that close": (GRID + ELASTIC + SLOT + BASE + PRESSED, 'two sides of body "a" have come', ["replace " + SLOT + " => " + THREE, "boundary.press.body=high"]),
    "bodies that come together": (GRID + ELASTIC + TWO.replace("0.55", "0.8").replace("1.0, 0.5", "1.2, 0.5") + BASE.replace("9.0", "0.51") + PUSHED, 'bodies "a" and "b" have come',
                                  ['contact.c={body="a",other="b",kind="friction",friction=0.3}']),
    "hangs on nodes": (GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[0.04, 0.0]") + "[boundary.w]\nwhere.box = { max = [1e-6, 9.0] }\nux = 0.0\nuy = 0.0\n" + MOVES,
                       "would hang on them", ["boundary.w.body=a", "boundary.w.where.box.max=[0.041,9.0]"]),
    "hangs, nodes below": (GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[0.0, 0.05]") + BASE + FEW, "would hang on them",
                           ["boundary.base.body=a", "boundary.base.where.box.max=[9.0,0.051]"]),
    "overlap": (GRID + ELASTIC + BLOCK + BLOCK.replace("body.a", "body.b") + BASE + FEW, "overlap: 1 m2", ["body.b.shape.box.min=[0.0,1.0]", "body.b.shape.box.max=[1.0,2.0]"]),
    "overlap, fem": (FEM + ELASTIC + BLOCK + BLOCK.replace("body.a", "body.b") + BASE + FEW, "overlap: 1 m2",
                     ["body.b.shape.box.min=[0.0,1.0]", "body.b.shape.box.max=[1.0,2.0]"]),
    "inside a rigid body": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("[-0.1, 1.0]", "[-0.1, 0.8]").replace("-0.3", "-0.01") + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "frictionless"\n' + FEW,
                            "lies inside of rigid body", ["body.plate.shape.box.min=[-0.1,1.0]"]),
    "inside a rigid body, fem": (FEM + ELASTIC + BLOCK + BASE + PLATE.replace("[-0.1, 1.0]", "[-0.1, 0.8]").replace("-0.3", "-0.01") + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "no_slip"\n' + FEW,
                                 "lies inside of rigid body", ["body.plate.shape.box.min=[-0.1,1.0]"]),
    "no support": (GRID + BRITTLE + BLOCK + TOP + FEW, "can move along x", ['boundary.b={where={box={max=[9.0,1e-6]}},ux=0.0,uy=0.0}']),
    "no support in space": (CUBE + ELASTIC + FEW, "can move along x, y, z and turn", ["steps.analysis=dynamic"]),
    "turns": (GRID + ELASTIC + BLOCK + '[pin.p]\nbody = "a"\nat = [0.5, 0.5]\nfix = "xy"\n' + FEW, "can turn about (0.5, 0.5)", ['pin.q={body="a",at=[1.0,0.5],fix="y"}']),
    "turns, fem": (FEM + ELASTIC + BLOCK + '[pin.p]\nbody = "a"\nat = [0.5, 0.5]\nfix = "xy"\n' + FEW, "can turn about (0.5, 0.5)", ['pin.q={body="a",at=[0.5,0.9],fix="x"}']),
    "few points": (SPLINES + ELASTIC + BLOCK + BASE + FEW, "points.per_direction = 3", ["body.a.points.per_direction=3"]),
    "few points, quadratic": (SPLINES.replace("cubic", "quadratic") + ELASTIC + BLOCK + "[body.a.points]\nper_direction = 1\n" + BASE + FEW, "points.per_direction = 2",
                              ["body.a.points.per_direction=2"]),
    "a tie that is torn": (GRID.replace("-0.2", "-1.0").replace("24", "50") + ELASTIC + BLOCK + BASE + PLATE.replace("-0.3*t", "-10*t") + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "tie"\n[steps]\ncount = 20\n',
                           "[contact.c] ties are", ['body.plate.displacement=[0.0,"-0.001*t"]']),
    "held twice": (GRID + ELASTIC + BLOCK + BASE + TOP + TOP.replace("boundary.top", "boundary.surface").replace("-0.001", '-0.0005\nbody = "a"') + FEW, "something else holds it",
                   ["boundary.surface.uy=-0.001"]),
    "penetration": (GRID + ELASTIC + BLOCK + BASE + PLATE + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "frictionless"\nstiffness = 0.05\n[steps]\ncount = 20\n',
                    'kind = "shared_nodes"', ['contact.c={body="a",rigid="plate",kind="shared_nodes"}', 'body.plate.displacement=[0.0,"-0.1*t"]']),
    "penetration, told": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("-0.3", "-0.06") + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "frictionless"\nstiffness = 0.05\n[steps]\ncount = 10\n',
                          "deep inside of rigid body", ["contact.c.stiffness=100.0"]),
    "flies under a pressure": (FLIES, '[pressure.t] direction = "dead" does not', ["contact.c.friction=0.6"]),
    "slides": (GRID + ELASTIC + BLOCK + SLIDE, "the friction of [contact.c] is used up", ["stage.push.analysis=dynamic"]),
    "slides, soil": (GRID + SAND.replace("1e3", "1e6") + BLOCK + SLIDE, "the friction of [contact.c] is used up", ["stage.push.analysis=dynamic"]),
    "jumps over a snap-back": (BRITTLE + BAR, "where the structure snaps back", ["steps.analysis=dynamic", "boundary.right.ux=1e-4*t", "steps.count=50"]),
    "snaps back": (GRID + BRITTLE + BLOCK + BASE + TOP.replace("-0.001", "0.001") + "[steps]\nmin_fraction = 0.02\n", 'integration = "impl_ex"', ["solver.integration=impl_ex"]),
    "jumps over a snap-back, IMPL-EX": (BRITTLE + BAR + '[solver]\nintegration = "impl_ex"\n', "where the structure snaps back no step is small enough",
                                        ["steps.analysis=dynamic", "boundary.right.ux=1e-4*t", "steps.count=50"]),
    "clay that nothing holds": (GRID + CLAY + BLOCK + ROLLERS, "starts at the reference_pressure", ['pressure.top={body="a",where={box={min=[-9.0,0.9999]}},value="5e+04 + 0*t"}']),
    "clay that nothing holds, less": (GRID + CLAY + BLOCK + ROLLERS, "let it start at less", ["material.m.reference_pressure=2e3"]),
    "crosses the axis": ('model = { plane = "axisymmetric", gravity = [0.0, -9.81] }\n' + GRID.replace("[-0.2, -0.2]", "[0.0, 0.0]") + ELASTIC
                         + '[body.a]\nmaterial = "m"\nshape.disc = { centre = [0.5, 1.0], radius = 0.5 }\n[pin.p]\nbody = "a"\nat = [0.0, 1.0]\nfix = "y"\n[steps]\ncount = 2\n',
                         "crossed the axis of rotation", ['boundary.axis={where={box={max=[1e-6,9.0]}},ux=0.0}']),
    "smeared crack": (BRITTLE + UNIFORM_BAR, "cracks are smeared over", ["replace " + WHOLE + " => " + NOTCHED]),
    "smeared crack, small strain": (BRITTLE + UNIFORM_BAR + 'model.kinematics = "small"\n', "cracks are smeared over", ["replace " + WHOLE + " => " + NOTCHED]),
    "smeared crack, three cells": (BRITTLE + THREE_CELLS, "cracks are smeared over", ["material.weak.tensile_strength=2.7e6"]),
    "a stamp that moves away": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("-0.3*t", "0.001*t") + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "frictionless"\n' + FEW,
                                "never pressed on anything", ["body.plate.displacement=[0.0,\"-0.001*t\"]"]),
    "cells too large": (GRID + BRITTLE.replace("100.0", "0.5") + BLOCK + BASE + TOP + FEW, "fracture_energy", ["material.m.fracture_energy=100.0"]),
    "cells too large, fem": (FEM + BRITTLE.replace("100.0", "0.5") + BLOCK + BASE + TOP + FEW, "fracture_energy", ["material.m.fracture_energy=100.0"]),
    "leaves the grid": (GRID.replace("[-0.2, -0.2]", "[-0.2, 0.0]") + ELASTIC + BLOCK + FALLS, "make the grid larger", ["grid.origin=[-0.2,-1.5]", "grid.cells=[24,30]"]),
    "leaves the grid, soil": (GRID.replace("[-0.2, -0.2]", "[-0.2, 0.0]") + SAND + BLOCK + FALLS, "make the grid larger", ["grid.origin=[-0.2,-1.5]", "grid.cells=[24,30]"]),
    "out of sight": (GRID + ELASTIC + TWO.replace("0.55", "0.9").replace("1.0, 0.5", "1.4, 0.5") + BASE + 'model.formulation = "total_lagrangian"\n[contact.c]\nbody = "a"\nother = "b"\nkind = "frictionless"\n' + FEW,
                     'formulation = "updated_lagrangian"', ["model.formulation=updated_lagrangian"]),
    "out of sight, small strain": (GRID + ELASTIC + TWO.replace("0.55", "0.9").replace("1.0, 0.5", "1.4, 0.5") + BASE + 'model.kinematics = "small"\n[contact.c]\nbody = "a"\nother = "b"\nkind = "frictionless"\n' + FEW,
                                   'kinematics = "finite"', ["model.kinematics=finite"]),
    "a tie of later, across a gap": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("-0.3*t", "0.05*min(t, 1) - 0.01*max(0, t - 1)") + LATE_TIE, "begins in [stage.second] to tie surfaces",
                                     ["body.plate.displacement=[0.0,\"0.05*min(t,1) - 0.051*max(0,t-1)\"]", "contact.c.kind=frictionless"]),
    "a support of later, left behind": (GRID + ELASTIC + BLOCK + ROLLERS + PULLED, "holds nothing in [stage.second]", ["boundary.pull.body=a"]),
    "small strain, large motion": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", "-0.3") + 'model.kinematics = "small"\n' + FEW, 'kinematics = "finite"', ["model.kinematics=finite", "steps.count=20"]),
    "begins with a jump": (GRID + ELASTIC + BLOCK + TOP.replace("-0.001", '"-0.001*cos(10*t)"') + BASE + MOVES, 'take "-0.001*cos(10*t) - (-0.001)"',
                           ["boundary.top.uy=-0.001*cos(10*t) - (-0.001)"]),
    "steps as long as a period": (GRID + ELASTIC + BLOCK + 'acceleration = [0.0, "-9.81*min(t/0.01, 1)"]\n' + BASE + MOVES.replace("0.05", "0.2").replace("10", "20"), "times as many (steps.count)", ["steps.count=80"]),
    "assignment": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"t=5 ? 0 : -0.001*t"') + FEW, "equal is ==", ["boundary.top.uy=t==5 ? 0 : -0.001*t"]),
    "no value": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"1/0"') + FEW, "is inf", ["boundary.top.uy=-0.001"]),
    "swells": (SAND.replace("30.0", "35.0\ndilatancy_angle = 30.0") + DILATES, "residual_dilatancy_angle = 0", ["material.m.residual_dilatancy_angle=0.0", "material.m.softening_end=0.05"]),
    "swells, Drucker-Prager": (SAND.replace("mohr_coulomb", "drucker_prager").replace("30.0", "35.0\ndilatancy_angle = 30.0") + DILATES, "take dilatancy_angle = 0",
                               ["material.m.dilatancy_angle=0.0"]),
    "loads at once": (GRID + ELASTIC + BLOCK + BASE + '[pressure.p]\nbody = "a"\nwhere.box.min = [-9.0, 0.9999]\nvalue = "1e5 + 0*t"\n[steps]\ncount = 1\n', 'as in "1e5*t"',
                      ["pressure.p.value=1e5*t"]),
    "loads at once, fem": (FEM + ELASTIC + BLOCK + BASE + '[pressure.p]\nbody = "a"\nwhere.box.min = [-9.0, 0.9999]\nvalue = "1e5 + 0*t"\n[steps]\ncount = 1\n', 'as in "1e5*t"',
                           ["pressure.p.value=1e5*t"]),
    "points cross cells": (GRID.replace("24] }", '24], shape_functions = "linear" }') + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", "-0.1") + '[steps]\ncount = 20\n',
                           "leave the key out", ["drop grid.shape_functions", "boundary.top.body=a", "boundary.top.where.box.min=[-9.0,0.999]"]),
    "strains beyond small strain": (FEM + "model.kinematics = \"small\"\n" + ELASTIC + BLOCK + BASE + TOP.replace("uy = -0.001", "ux = 2.5\nuy = 0.0") + FEW.replace("3", "20"),
                                    "of which small strain knows nothing", ["model.kinematics=finite"]),
    "a contact that ends": (GRID + ELASTIC + TWO.replace("0.55", "0.5") + BASE + '[contact.c]\nbody = "b"\nother = "a"\nkind = "friction"\nfriction = 0.3\nstages = ["one"]\n[stage.one]\ncount = 2\n[stage.two]\ncount = 2\n'
                            + PRESSED.replace("0.8, 0.9999", "0.6, 0.4999").replace("-0.15", "-0.01").replace('body = "a"', 'body = "b"').replace("[steps]\ncount = 10\n", ""), "no contact keeps", ['contact.c.stages=["one","two"]']),
    "a wedge on its tip": (GRID + ELASTIC + TIP, "0.00352 m apart in the middle of the nearest piece", ["body.wedge.shape.polygon=[[0.5,-0.0035],[1.0,0.5],[0.0,0.5]]"]),
    "no tensile strength": (SQUASHED, "give [material.m] a tensile_strength", ["material.m.tensile_strength=400"]),
    "no tensile strength, in place": (SQUASHED, "next to no tensile strength", ["model.formulation=total_lagrangian"]),
    "slope that fails": (GRID + SAND + SLOPE + BASE + "[steps]\ncount = 10\nmin_fraction = 0.05\n", 'analysis = "dynamic"', ["steps.analysis=dynamic", "steps.duration=0.5", "grid.cells=[44,26]"]),
    "slope that fails, Tresca": (GRID + SAND.replace("30.0", "0.0") + SLOPE + BASE + "[steps]\ncount = 10\nmin_fraction = 0.05\n", 'analysis = "dynamic"',
                                 ["steps.analysis=dynamic", "steps.duration=0.5", "grid.cells=[44,26]"]),
    "probe beside the body": (GRID + ELASTIC + BLOCK + BASE + '[probe.p]\nat = [1.8, 1.8]\nquantity = "stress_yy"\n' + FEW, "outside of every deformable body", ["probe.p.at=[0.5,0.5]"]),
    "support between the nodes of splines": (GRID.replace("24] }", '24], shape_functions = "quadratic_bspline" }') + ELASTIC + BLOCK + BASE.replace("{ max", "{ min = [-1.0, -1e-6], max") + FEW, "or hold the surface that lies there",
                                             ["boundary.base.body=a"]),
    "support without nodes": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("0.9999", "0.93").replace("1.0001", "0.95") + FEW, "catches no node", ["boundary.top.where.box.max=[9.0,1.01]"]),
}


def run(berm, text, folder, sets=()):
    case = folder / "case.toml"
    for change in sets:
        if change.startswith("replace "):
            text = text.replace(*change.removeprefix("replace ").split(" => "))
        if change.startswith("drop "):  # a key of an inline table
            key = change.split(".")[-1]
            text = "\n".join(
                line.replace(", " + line[line.index(key):line.index(" }", line.index(key))], "") if key in line else line for line in text.split("\n"))
    case.write_text(in_order(text))
    words = [w for s in sets if not s.startswith(("drop ", "replace ")) for w in ("--set", quoted(s))]
    done = subprocess.run([berm, "run", str(case), "--force", "--out", str(folder / "out"), *words], capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


def quoted(change):
    """key=value as TOML: text in quotes."""
    key, value = change.split("=", 1)
    plain = value[:1] in "[{\"" or value in ("true", "false")
    try:
        float(value)
        plain = True
    except ValueError:
        pass
    return change if plain else f'{key}="{value}"'


def in_order(text):
    """Keys of the top level before the tables."""
    top, tables, table = [], [], False
    for line in text.split("\n"):
        table = table or line.startswith("[")
        if line.split("=")[0].split(".")[0].strip() in ("grid", "model", "method") and not line.startswith("["):
            top.append(line)
        else:
            tables.append(line)
    return "\n".join(top + tables)


def main():
    parser = argparse.ArgumentParser(description="Runs that are made to fail.")
    parser.add_argument("berm", metavar="BERM")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--markdown", help="write the table to this file")
    options = parser.parse_args()
    rows, wrong = [], 0
    for name, (text, words, remedy) in FAILURES.items():
        if options.names and name not in options.names:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            code, said = run(options.berm, text, pathlib.Path(scratch))
            then, says = run(options.berm, text, pathlib.Path(scratch), remedy)
        told = words in said
        helps = then == 0 and (words not in says or "allow_glued" in "".join(remedy))
        wrong += not (told and helps)
        last = said.strip().split("\n")[-1] if said.strip() else "nothing"
        print(f"{'ok ' if told and helps else 'BAD'} {name}: exit {code}: {last[:300]}" + ("" if helps else f"\n      then exit {then}: {says.strip()[-300:]}"), flush=True)
        rows.append(f"| {name} | {code} | {last.replace('|', '/')} | {', '.join('`' + r + '`' for r in remedy)} | {'yes' if told else 'no'} | {'yes' if helps else 'no'} |")
    if options.markdown:
        head = "| run | exit | last words | remedy tried | said | helped |\n|---|---|---|---|---|---|\n"
        pathlib.Path(options.markdown).write_text(head + "\n".join(rows) + "\n")
    print(f"{len(rows)} runs, {wrong} without the right words or a remedy that helps")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
