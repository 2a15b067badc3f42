#!/usr/bin/env python3
"""Models that are wrong, and what `berm check` says of them: all of it, each with its place in the file.

    run.py BERM [NAMES ...]

Every entry is a case and, for every fault in it, words that one line must contain together with the line of the table that is at fault. Where the case
may run all the same, the words begin with "warning: ". Exits with 1 if one is missing.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "messages"), str(pathlib.Path(__file__).resolve().parents[1])]
from gmsh_text import mesh_22  # noqa: E402
from run import BASE, BLOCK, CUBE, ELASTIC, FEM, FEW, GRID, PLATE, TOP  # noqa: E402

PARTS = ('[body.a]\nmaterial = "m"\nshape.union = [ { box = { min = [0.0, 0.0], max = [0.4, 1.0] } }, '
         '{ box = { min = [1.0, 0.0], max = [1.4, 1.0] } } ]\nmesh = { kind = "quads", size = 0.1, structured = true }\n')
LEFT_BASE = BASE.replace("{ max = [9.0, 1e-6] }", "{ max = [0.45, 1e-6] }")
ROLLERS = "[boundary.base]\nwhere.box = { max = [9.0, 1e-6] }\nuy = 0.0\n"
UPON = BLOCK.replace("body.a", "body.b").replace("[0.0, 0.0]", "[0.0, 1.0]").replace("[1.0, 1.0]", "[1.0, 2.0]")
SEAM = mesh_22([(0, 0), (1, 0), (1, 1), (0, 1), (1, 0), (2, 0), (2, 1), (1, 1)], [(1, 2, 3, 4), (5, 6, 7, 8)])  # the places of 2 and 3 twice
TWICE = mesh_22([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (2, 0), (2, 1), (0.5, 1)], [(1, 2, 3, 4), (5, 6, 7, 8)])
INSIDE = mesh_22([(0.2, 0), (0.3, 0), (0.3, 0.1), (0.2, 0.1), (0, 0), (2, 0), (2, 1), (0, 1)], [(1, 2, 3, 4), (5, 6, 7, 8)])  # no corner of the large one
COARSE = mesh_22([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)], [(1, 2, 3, 4), (2, 5, 6, 3)])
SMOOTH = '[contact.c]\nbody = "a"\nother = "b"\nkind = "frictionless"\n'
ON_PLATE = '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "KIND"\n'
AT_REST = PLATE[:PLATE.index("displacement")]
PIN = '[pin.NAME]\nbody = "a"\nat = AT\nfix = "xy"\n'
GAUGE = "[gauge.NAME]\nfrom = [0.5, 0.2]\nto = TO\n"
PROBE = '[probe.NAME]\nat = AT\nquantity = "stress_yy"\n'
PRESSURE = '[pressure.NAME]\nbody = "a"\nwhere.box.min = MIN\nvalue = "VALUE"\n'
DASHPOTS = '[absorbing.NAME]\nbody = "a"\nwhere.box = WHERE\np_wave_speed = 100.0\ns_wave_speed = 50.0\ndensity = 2000.0\n'
MOVES = '[steps]\nanalysis = "dynamic"\nduration = 0.01\ncount = 2\n'
WEIGHT = "model.gravity = [0.0, -9.81]\n"
ROLLER = '[body.NAME]\nrigid = true\nshape.disc = { centre = AT, radius = 0.1 }\n[contact.NAME]\nbody = "a"\nrigid = "NAME"\nkind = "frictionless"\n'
FREE = "nothing holds it there"
STAGES = "[stage.first]\ncount = 2\n[stage.second]\ncount = 2\n"

# name: (case, [(table at fault, words), ...])
MODELS = {
    "one of two parts held": (GRID + ELASTIC + PARTS + LEFT_BASE + FEW, [("body.a", "(1 of its 2 parts that are not connected)")]),
    "one of two parts held, fem": (FEM + ELASTIC + PARTS + LEFT_BASE + FEW, [("body.a", "(1 of its 2 parts that are not connected)")]),
    "two parts on rollers": (GRID + ELASTIC + PARTS + ROLLERS + FEW, [("body.a", "can move along x")]),
    "held in the first stage only": (GRID + ELASTIC + BLOCK + BASE + 'stages = ["first"]\n' + STAGES, [("body.a", "can move along x, y and turn in [stage.second]: " + FREE)]),
    "lets go of one direction, fem": (FEM + ELASTIC + BLOCK + ROLLERS + BASE.replace("base", "first") + 'stages = ["first"]\n' + STAGES, [("body.a", "can move along x in [stage.second]")]),
    "pins let go, contact stays": (GRID + ELASTIC + BLOCK + PLATE + ON_PLATE.replace("KIND", "frictionless") + PIN.replace("NAME", "p").replace("AT", "[0.0, 0.0]") + 'stages = ["first"]\n' + STAGES,
                                   [("body.a", "can move along x in [stage.second]")]),
    "tie of the second stage": (GRID + ELASTIC + BLOCK + UPON + '[contact.c]\nbody = "a"\nother = "b"\nkind = "tie"\nstages = ["second"]\n' + BASE + STAGES,
                                [("body.b", "in [stage.first]: " + FREE)]),
    "a load without a value at the start": (GRID + ELASTIC + BLOCK + BASE + PRESSURE.replace("NAME", "p").replace("MIN", "[-9.0, 0.9999]").replace("VALUE", "1e3/t") + FEW,
                                            [("pressure.p", "\"1e3/t\" is inf at t = 0 s")]),
    "a motion without a value at the end": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"0.001*sqrt(0.5 - t)"') + FEW, [("boundary.top", "nan at t = ")]),
    "a motion that is not 0 where it begins to act": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"-0.001*t"') + 'stages = ["second"]\n' + STAGES,
                                                      [("boundary.top", "warning: -0.001*t\" is -0.001 m")]),
    "a gauge and nothing to scale": (GRID + ELASTIC + BLOCK + BASE + PRESSURE.replace("NAME", "p").replace("MIN", "[-9.0, 0.9999]").replace('"VALUE"', "0.0")
                                     + GAUGE.replace("NAME", "g").replace("TO", "[0.5, 0.8]") + '[control]\nkind = "gauge"\ngauge = "g"\ntarget = 0.001\n' + FEW,
                                     [("control", "all are zero")]),
    "on rollers, fem": (FEM + ELASTIC + BLOCK + ROLLERS + FEW, [("body.a", "can move along x: " + FREE)]),
    "slides on a smooth block": (GRID + ELASTIC + BLOCK + UPON + SMOOTH + BASE + FEW, [("body.b", "can move along x: " + FREE)]),
    "slides on a smooth plate": (GRID + ELASTIC + BLOCK + PLATE + ON_PLATE.replace("KIND", "frictionless") + FEW, [("body.a", "can move along x: " + FREE)]),
    "two free bodies": (GRID + ELASTIC + BLOCK.replace("[1.0, 1.0]", "[0.4, 1.0]") + BLOCK.replace("body.a", "body.b").replace("[0.0, 0.0]", "[0.7, 0.0]") + FEW,
                        [("body.a", "can move along x, y and turn"), ("body.b", "can move along x, y and turn")]),
    "cube on one pin": (CUBE + ELASTIC + '[pin.p]\nbody = "a"\nat = [0.0, 0.0, 0.0]\nfix = "xyz"\n' + FEW, [("body.a", "can turn")]),
    "hinged in two places of one line": (CUBE + ELASTIC + '[pin.p]\nbody = "a"\nat = [0.0, 0.0, 0.0]\nfix = "xyz"\n[pin.q]\nbody = "a"\nat = [0.4, 0.0, 0.0]\nfix = "yz"\n' + FEW,
                                         [("body.a", "can turn")]),
    "a mesh in two pieces that touch": (FEM + ELASTIC + '[body.a]\nmaterial = "m"\nfile = "seam.msh"\n' + BASE + FEW, [("body.a", "warning: 2 nodes lie in the place of another")]),
    "two idle supports": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("0.9999", "1.1999").replace("1.0001", "1.2001") + TOP.replace("top", "above").replace("0.9999", "1.2999").replace("1.0001", "1.3001") + FEW,
                          [("boundary.top", "warning: holds nothing at the start"), ("boundary.above", "warning: holds nothing at the start")]),
    "a plate out of reach": ("model.gravity = [0.0, -9.81]\n" + GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[0.0, 0.3]") + PLATE.replace("[-0.1, 1.0]", "[-0.1, -0.1]").replace("[1.1, 1.4]", "[1.1, 0.0]")
                             + ON_PLATE.replace("KIND", "no_slip") + FEW, [("body.a", "[contact.c] is 0.3 m apart")]),
    "a block out of reach": (GRID + ELASTIC + BLOCK.replace("[1.0, 1.0]", "[1.0, 0.5]") + UPON + SMOOTH.replace('"frictionless"', '"friction"\nfriction = 0.5') + BASE + FEW,
                             [("body.b", "\"b\" are apart")]),
    "hangs under a plate": ("model.gravity = [0.0, -9.81]\n" + GRID + ELASTIC + BLOCK + AT_REST + ON_PLATE.replace("KIND", "no_slip") + FEW, [("body.a", "the weight draws the body away")]),
    "slips down beside a plate": ("model.gravity = [0.0, -9.81]\n" + GRID + ELASTIC + BLOCK + AT_REST.replace("[-0.1, 1.0]", "[1.0, 0.0]").replace("1.1, 1.4", "1.2, 1.0")
                                  + ON_PLATE.replace("KIND", "friction").replace('"a"', '"a"\nfriction = 0.5') + FEW, [("body.a", "the weight draws the body away from there or along it")]),
    "contact across a gap in small strain": ('model.kinematics = "small"\n' + GRID + ELASTIC + BLOCK.replace("[1.0, 1.0]", "[1.0, 0.5]") + UPON.replace("[0.0, 1.0]", "[0.0, 0.55]").replace("[1.0, 2.0]", "[1.0, 1.0]") + SMOOTH + BASE
                                             + TOP.replace("uy", "ux = 0.0\nuy") + FEW, [("contact.c", "start apart, and with small strain")]),
    "bodies that touch at a corner": (GRID + ELASTIC + BLOCK.replace("[1.0, 1.0]", "[0.5, 0.5]") + UPON.replace("[0.0, 1.0]", "[0.5, 0.5]").replace("[1.0, 2.0]", "[1.0, 1.0]") + BASE + FEW,
                                      [("body.a", "warning: bodies \"a\" and \"b\" touch at a corner")]),
    "a disc beyond all cells": (GRID + ELASTIC + '[body.a]\nmaterial = "m"\nshape.disc = { centre = [1e300, 0.5], radius = 0.5 }\npoints = { mesh = "triangles", size = 0.1 }\n' + BASE + FEW,
                                [("body.a", "reaches 1e+300 m: places must lie within 1e+10 m")]),
    "a plate that goes out of reach": (WEIGHT + GRID + ELASTIC + BLOCK + AT_REST + 'displacement = [1e200, 0.0]\n' + ON_PLATE.replace("KIND", "frictionless") + BASE + FEW,
                                       [("body.plate", "moves by 1e+200 m: places must lie within 1e+10 m")]),
    "a plate that flies out of reach": (WEIGHT + GRID + ELASTIC + BLOCK + AT_REST + 'displacement = ["exp(700*t)-1", 0.0]\n' + ON_PLATE.replace("KIND", "frictionless") + BASE + FEW,
                                        [("body.plate", "m: places must lie within 1e+10 m")]),
    "a support that goes out of reach": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", "-1e11") + FEW, [("boundary.top", "moves by 1e+11 m: places must lie within 1e+10 m")]),
    "a unit forgotten": ("model.gravity = [0.0, -9.81]\n" + GRID + ELASTIC.replace("1e7", "1e4") + BLOCK + BASE + FEW, [("material.m", "warning: [material.m]: under its own weight")]),
    "a smooth beam on smooth rollers": (WEIGHT + GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[0.0, 0.6]") + ROLLER.replace("NAME", "l").replace("AT", "[0.2, 0.5]") + ROLLER.replace("NAME", "r").replace("AT", "[0.8, 0.5]")
                                        + FEW, [("body.a", "warning: can move along x on what it touches without friction")]),
    "a pressure on a joint": (WEIGHT + GRID + ELASTIC + BLOCK + UPON + BASE + PRESSURE.replace("NAME", "p").replace("MIN", "[-9.0, 0.9999]").replace('"VALUE"', "1e3") + FEW,
                              [("pressure.p", "warning: 1 of its 1 m2 are where body \"a\" is joined to \"b\"")]),
    "motions in millimetres": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", "-5.0") + FEW, [("boundary.top", "warning: moves by 5 m, 3.5 times as far as all bodies are long")]),
    "a plate that moves in millimetres": (GRID + ELASTIC + BLOCK + AT_REST + "displacement = [0.0, -10.0]\n" + ON_PLATE.replace("KIND", "frictionless") + BASE + FEW,
                                          [("body.plate", "warning: moves by 10 m, 7.1 times as far as all bodies are long")]),
    "a strength in megapascals": (GRID + ELASTIC.replace("linear_elastic", "von_mises").replace("1e7", "2.1e11") + "yield_stress = 250.0\n" + BLOCK + BASE + TOP + FEW,
                                  [("material.m", "warning: yield_stress = 250 Pa is 1.2e-09 of the stiffness")]),
    "a support of splines": (GRID.replace("24] }", '24], shape_functions = "quadratic_bspline" }') + ELASTIC + BLOCK + BASE + FEW,
                             [("boundary.base", "warning: 50 % of its motion there is that of free nodes"), ("boundary.base", "warning: boundary.base.body = \"a\"")]),
    "a motion between the steps": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"-0.001*sin(2*pi*50*t)"') + "[steps]\ncount = 100\n",
                                   [("boundary.top", "warning: the steps of 0.01 s do not see")]),
    "columns beside each other on a slab": (GRID + ELASTIC + ELASTIC.replace("material.m", "material.n").replace("1e7", "2e6")
                                            + "".join(f'[body.{name}]\nmaterial = "{of}"\nshape.box = {{ min = {low}, max = {high} }}\n' for name, of, low, high in (
                                                ("slab", "m", [0.0, 0.0], [2.0, 0.25]), ("left", "n", [0.4, 0.25], [0.8, 1.25]), ("right", "n", [0.85, 0.25], [1.25, 1.25]))) + BASE + FEW,
                                            [("body.left", 'the gap of 0.05 m between bodies "left" and "right"')]),
    "a joint that the grid does not see": (GRID + ELASTIC + BLOCK + UPON.replace("[0.0, 1.0]", "[0.0, 1.002]") + BASE + FEW, [("body.a", "the gap of 0.002 m between")]),
    "a joint that nothing closes, fem": (FEM + ELASTIC + BLOCK + UPON.replace("[0.0, 1.0]", "[0.0, 1.002]") + BASE + TOP.replace("0.9999", "1.9999").replace("1.0001", "2.0001").replace("uy", "ux = 0.0\nuy") + FEW,
                                         [("body.a", "warning: 0.002 m apart and not joined")]),
    "a gap under a block that contact holds": (GRID + ELASTIC + BLOCK + UPON.replace("[0.0, 1.0]", "[0.0, 1.02]") + SMOOTH.replace('"frictionless"', '"friction"\nfriction = 0.5') + BASE + FEW,
                                               [("body.b", "are apart")]),
    "a stamp that begins inside": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("[-0.1, 1.0]", "[-0.1, 0.999]") + ON_PLATE.replace("KIND", "frictionless") + FEW,
                                   [("contact.c", "warning: starts up to 0.001 m inside of rigid body")]),
    "elements in one another": (FEM + ELASTIC + '[body.a]\nmaterial = "m"\nfile = "twice.msh"\n' + BASE + FEW, [("body.a", "lie in one another")]),
    "elements in one another, the other way round": (FEM + ELASTIC + '[body.a]\nmaterial = "m"\nfile = "inside.msh"\n' + BASE + FEW, [("body.a", "lie in one another")]),
    "touched in two ways": (GRID + ELASTIC + BLOCK + BASE + PLATE + ON_PLATE.replace("KIND", "tie") + ON_PLATE.replace("KIND", "no_slip").replace("contact.c", "contact.d") + FEW,
                            [("contact.d", "is for the same two bodies already")]),
    "weight along the radius": ('model = { plane = "axisymmetric", gravity = [-9.81, 0.0] }\n' + GRID.replace("[-0.2,", "[0.0,") + ELASTIC + BLOCK + BASE + FEW,
                                [("model", "gravity along the radius is no weight")]),
    "nothing acts": (GRID + "[model]\ngravity = [0.0, 0.0]\n" + ELASTIC + BLOCK + BASE + FEW, [("model", "warning: nothing acts on the bodies")]),
    "a plate that touches nothing": (GRID + ELASTIC + BLOCK + BASE + PLATE + FEW, [("body.plate", "warning: touches nothing")]),
    "places beside the body": (GRID + ELASTIC + BLOCK + BASE + PIN.replace("NAME", "p").replace("AT", "[1.02, 0.5]") + GAUGE.replace("NAME", "g").replace("TO", "[1.8, 0.2]")
                               + PROBE.replace("NAME", "q").replace("AT", "[1.9, 1.9]") + FEW,
                               [("pin.p", "(1.02, 0.5)"), ("gauge.g", "(1.8, 0.2)"), ("probe.q", "(1.9, 1.9)")]),
    "a probe beyond all numbers": (GRID + ELASTIC + BLOCK + BASE + PROBE.replace("NAME", "q").replace("AT", "[0.5, 1e300]") + FEW, [("probe.q", "lies outside of every deformable body")]),
    "places beside the body, fem": (FEM + ELASTIC + BLOCK + BASE + PIN.replace("NAME", "p").replace("AT", "[1.7, 1.7]") + PROBE.replace("NAME", "q").replace("AT", "[1.9, 1.9]") + FEW,
                                    [("pin.p", "(1.7, 1.7)"), ("probe.q", "(1.9, 1.9)")]),
    "loads and supports that catch nothing": (GRID + ELASTIC + BLOCK + BASE + TOP.replace("0.9999", "0.93").replace("1.0001", "0.95") + PRESSURE.replace("NAME", "p").replace("MIN", "[1.3, 0.0]").replace("VALUE", "1 MPa")
                                              + PRESSURE.replace("NAME", "q").replace("MIN", "[0.0, 1.3]").replace("VALUE", "1 MPa") + FEW,
                                              [("boundary.top", "catches no node"), ("pressure.p", "catches no part"), ("pressure.q", "catches no part")]),
    "loads that catch nothing, fem": (FEM + ELASTIC + BLOCK + BASE + TOP.replace("0.9999", "0.93").replace("1.0001", "0.95") + PRESSURE.replace("NAME", "p").replace("MIN", "[1.3, 0.0]").replace("VALUE", "1 MPa") + FEW,
                                      [("boundary.top", "catches no node"), ("pressure.p", "catches no part")]),
    "held surface that is none": (GRID + ELASTIC + BLOCK + BASE + '[boundary.side]\nbody = "a"\nwhere.box.min = [1.2, 0.0]\nux = 0.0\n' + FEW, [("boundary.side", "catches no part")]),
    "absorbing where there is nothing": (GRID + ELASTIC + BLOCK + BASE + DASHPOTS.replace("NAME", "w").replace("WHERE", "{ min = [1.2, 0.0] }") + MOVES, [("absorbing.w", "catches no part")]),
    "absorbing twice": (GRID + ELASTIC + BLOCK + BASE + DASHPOTS.replace("NAME", "all").replace("WHERE", "{ min = [0.999, 0.0] }")
                        + DASHPOTS.replace("NAME", "part").replace("WHERE", "{ min = [0.999, 0.0], max = [1.001, 0.42] }") + MOVES, [("absorbing.all", "and [absorbing.part] act on the same part")]),
    "tie that does not touch, and a load beside": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("1.0]", "1.3]").replace("1.4]", "1.6]") + ON_PLATE.replace("KIND", "tie")
                                                   + PRESSURE.replace("NAME", "p").replace("MIN", "[1.3, 0.0]").replace("VALUE", "1 MPa") + FEW,
                                                   [("contact.c", "do not touch"), ("pressure.p", "catches no part")]),
    "two bodies outside of the grid": (GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[-0.5, 0.0]") + BLOCK.replace("body.a", "body.b").replace("[0.0, 0.0]", "[1.5, 0.0]").replace("[1.0, 1.0]", "[3.0, 1.0]") + BASE + FEW,
                                       [("body.a", "make the grid larger"), ("body.b", "make the grid larger")]),
    "shapes without a content": (GRID + ELASTIC + BLOCK.replace("[1.0, 1.0]", "[0.0, 1.0]") + '[body.b]\nmaterial = "m"\nshape.disc = { centre = [0.5, 0.5], radius = 0.0 }\n' + BASE + FEW,
                                 [("body.a", "must lie above"), ("body.b", "radius")]),
    "pascals": (GRID + ELASTIC.replace("1e7", "35.5") + BLOCK + BASE + FEW, [("material.m", "warning: youngs_modulus = 35.5")]),
    "tonnes": (GRID + ELASTIC.replace("1000.0", "2.4") + BLOCK + BASE + FEW, [("material.m", "warning: density = 2.4")]),
    "millimetres": (GRID.replace("-0.2", "-200.0").replace("0.1", "100.0") + ELASTIC + BLOCK.replace("1.0", "2000.0") + BASE.replace("9.0", "9000.0") + FEW, [("body.a", "warning: ")]),
    "a small pressure": (GRID + ELASTIC + BLOCK + BASE + PRESSURE.replace("NAME", "p").replace("MIN", "[-9.0, 0.9999]").replace('"VALUE"', "2.5") + FEW, [("pressure.p", "warning: value = 2.5")]),
    "friction in degrees": (GRID + ELASTIC + BLOCK + BASE + PLATE + '[contact.c]\nbody = "a"\nrigid = "plate"\nkind = "friction"\nfriction = 30.0\n' + FEW, [("contact.c", "warning: friction = 30")]),
    "gravity in millimetres": ("model.gravity = [0.0, -9810.0]\n" + GRID + ELASTIC + BLOCK + BASE + FEW, [("", "warning: gravity of -9810")]),
    "different displacements of one node": (GRID + ELASTIC + BLOCK + BASE + BASE.replace("base", "again").replace("uy = 0.0", "uy = 0.001") + FEW, [("boundary.base", "prescribe different displacements")]),
    "different displacements of one surface": (GRID + ELASTIC + BLOCK + '[boundary.s]\nbody = "a"\nwhere.box = { max = [9.0, 1e-6] }\nux = 0.0\nuy = 0.0\n[boundary.t]\nbody = "a"\nwhere.box = { max = [0.5, 1e-6] }\nuy = 0.001\n' + FEW,
                                               [("boundary.s", "prescribe different displacements")]),
    "overlap and a probe beside": (GRID + ELASTIC + BLOCK + BLOCK.replace("body.a", "body.b") + BASE + PROBE.replace("NAME", "q").replace("AT", "[1.9, 1.9]") + FEW,
                                   [("body.a", "overlap: 1 m2"), ("probe.q", "(1.9, 1.9)")]),
    "hangs on nodes, and another body is free": (GRID + ELASTIC + BLOCK.replace("[0.0, 0.0]", "[0.0, 0.05]") + BASE + FEW, [("boundary.base", "would hang on them")]),
    "plate in a plate's way": (GRID + ELASTIC + BLOCK + BASE + PLATE.replace("[-0.1, 1.0]", "[-0.1, 0.5]") + ON_PLATE.replace("KIND", "frictionless") + FEW, [("contact.c", "0.5 m2")]),
}

SIDE = '[body.NAME]\nrigid = true\nshape.box = { min = MIN, max = MAX }\n[contact.NAME]\nbody = "a"\nrigid = "NAME"\nkind = "no_slip"\n'
# Models with nothing wrong, each near to one above: no word may be said.
RIGHT = {
    "jammed between two walls": WEIGHT + GRID + ELASTIC + BLOCK + SIDE.replace("NAME", "l").replace("MIN", "[-0.2, -0.1]").replace("MAX", "[0.0, 1.1]")
                                + SIDE.replace("NAME", "r").replace("MIN", "[1.0, -0.1]").replace("MAX", "[1.2, 1.1]") + FEW,
    "a stamp that touches": GRID + ELASTIC + BLOCK + BASE + PLATE + ON_PLATE.replace("KIND", "frictionless") + FEW,
    "a mesh around a rigid disc": FEM + ELASTIC + '[body.a]\nmaterial = "m"\nshape.difference = [ { box = { min = [0.0, 0.0], max = [1.0, 1.0] } }, { disc = { centre = [0.5, 0.5], radius = 0.2 } } ]\n'
                                  'mesh = { kind = "triangles", size = 0.05 }\n' + BASE + '[body.r]\nrigid = true\nshape.disc = { centre = [0.5, 0.5], radius = 0.2 }\ndisplacement = [0.0, "-0.001*t"]\n'
                                  '[contact.c]\nbody = "a"\nrigid = "r"\nkind = "frictionless"\n' + FEW,
    "a tip on a block": WEIGHT + GRID + ELASTIC + BLOCK + '[body.b]\nmaterial = "m"\nshape.polygon = [[0.5, 1.0], [0.9, 1.5], [0.1, 1.5]]\n' + SMOOTH.replace('"frictionless"', '"friction"\nfriction = 0.5') + BASE
                        + '[boundary.guide]\nwhere.box.min = [-9.0, 1.4999]\nux = 0.0\n' + FEW,
    "pulses that the steps see": GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"-0.001*sin(2*pi*5*t)"') + PRESSURE.replace("NAME", "p").replace("MIN", "[0.9999, -9.0]").replace("VALUE", "t > 0.5 ? 1e3 : 0")
                                 + "[steps]\ncount = 100\n",
    "a probe on the edge of a coarse mesh": GRID.replace("0.1", "0.5").replace("-0.2", "-0.5").replace("[24, 24]", "[6, 6]") + ELASTIC + '[body.a]\nmaterial = "m"\nfile = "coarse.msh"\npoints = { per_element = 4 }\n' + BASE + TOP + PROBE.replace("NAME", "q").replace("AT", "[1.0, 1.0]") + FEW,
    "a motion of the first stage only": GRID + ELASTIC + BLOCK + BASE + TOP.replace("-0.001", '"-0.001*min(t, 1)"') + 'stages = ["first"]\n' + TOP.replace("top", "after").replace("-0.001", '"-0.001*min(t, 1)"')
                                        + 'stages = ["second"]\n[stage.first]\ncount = 2\n[stage.second]\ncount = 2\nduration = 10000.0\n',
    "rubber drawn to three times its length": GRID.replace("[24, 24]", "[24, 44]") + ELASTIC + BLOCK + BASE + TOP.replace("0.001", "2.0").replace("uy = -", 'body = "a"\nuy = ') + FEW,
    "a block on a block": WEIGHT + GRID + ELASTIC + BLOCK + UPON + BASE + FEW,
}


def line_of(text, table):
    """Of a table's head; 0: any."""
    for number, line in enumerate(text.split("\n"), 1):
        if table and line.strip() == f"[{table}]":
            return number
    return 0


def main():
    parser = argparse.ArgumentParser(description="Models that are wrong.")
    parser.add_argument("berm", metavar="BERM")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    wrong = 0
    for name, (text, faults) in MODELS.items():
        if options.names and name not in options.names:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            path = pathlib.Path(scratch) / "case.toml"
            path.write_text(text, encoding="utf-8")
            for file, mesh in (("seam.msh", SEAM), ("twice.msh", TWICE), ("inside.msh", INSIDE)):
                (pathlib.Path(scratch) / file).write_text(mesh, encoding="ascii")
            done = subprocess.run([options.berm, "check", path], capture_output=True, text=True, timeout=60, check=False)
        said = done.stdout + done.stderr
        missing = []
        for table, words in faults:
            warns, words = words.startswith("warning: "), words.removeprefix("warning: ")
            # Keys of a table stand below its head: a place in it is as good as that of the head.
            begin = line_of(text, table)
            hits = [line for line in said.split("\n") if words in line and (not warns or "warning" in line)]
            places = [int(m.group(1)) for line in hits if (m := re.search(r"case\.toml:(\d+):", line))]
            end = next((k for k, line in enumerate(text.split("\n"), 1) if k > begin and line.startswith("[")), 10**6)
            if not any(begin <= p < end for p in places):
                missing.append(f"[{table}] {words}")
            if (done.returncode == 0) != warns:
                missing.append(f"exit code {done.returncode}")
        wrong += bool(missing)
        print(f"{'BAD' if missing else 'ok '} {name}" + (f": missing {missing}; said\n{said.strip()[-1500:]}" if missing else ""), flush=True)
    for name, text in RIGHT.items():
        if options.names and name not in options.names:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            path = pathlib.Path(scratch) / "case.toml"
            path.write_text(text, encoding="utf-8")
            (pathlib.Path(scratch) / "coarse.msh").write_text(COARSE, encoding="ascii")
            done = subprocess.run([options.berm, "check", path], capture_output=True, text=True, timeout=60, check=False)
        alarm = done.returncode != 0 or "warning" in done.stdout + done.stderr
        wrong += alarm
        print(f"{'BAD' if alarm else 'ok '} {name}" + (f": {(done.stdout + done.stderr).strip()[-800:]}" if alarm else ""), flush=True)
    print(f"{wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
