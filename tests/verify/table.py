#!/usr/bin/env python3
"""Runs the verification tests and writes docs/verification.md from the figures that they reached.

    table.py TEST_VERIFY [--out FILE]

Takes half an hour: with BERM_WHOLE_TABLES in the environment the manufactured solutions have a grid and functions more than
in every run of the tests.
"""

import argparse
import csv
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]

HEAD = """# Verification

Written by `tests/verify/table.py` from a run of `tests/verify/*.cpp`; nothing here is typed by hand but the introductions. Every row is a test:
*reached* must agree with *should be* within *demanded*, or the test fails. Rows that say "reported" show a property of the method rather than of the program.

```sh
tests/verify/table.py build/test/tests/test_verify
```
"""

# What stands above each group of rows.
INTRODUCTIONS = {
    "Single element": """One cell, each law, MPM and FEM, plane strain and plane stress, small and logarithmic strain (tests/verify/single_element.cpp, and with case files
examples/01_single_element). The closed forms are programmed a second time in tests/verify/closed_forms.hpp, from the equations of theory/damage.md. In finite
strain they hold between Kirchhoff stress and logarithmic strain. The rows give the largest relative error of any point at any of 25 steps of the eight runs.""",
    "Single element in space": """A cube, each law, MPM and FEM, small and logarithmic strain (tests/verify/solid_element.cpp): the same closed forms with all
three directions free to move where the path does not hold them. The rows give the largest relative error of any point at any of 25 steps of the four runs.""",
    "Single element around the axis": """A cylinder and a ring of one cell, axisymmetric, each law, MPM and FEM, small and logarithmic strain (tests/verify/solid_element.cpp). Radial
expansion strains the radius and the direction around the axis alike. The rows give the largest relative error of the eight runs.""",
    "Newton": """A block of 8 x 8 cells, clamped along half of its lower side and pulled, tough enough not to crack at once (tests/verify/newton_order.cpp). The order p of
r(k+1) = c r(k)^p from the last three residuals of each damaging step that lie above rounding; the median over the steps.""",
    "Newton in space": """A block of 4 x 4 x 4 cells, held and pulled as above (tests/verify/solid_newton.cpp). The iterative solver is conjugate gradients, or GMRES where
damage grows, with algebraic multigrid and a tolerance of 1e-10. With one Krylov iteration allowed every system must reach the direct solver.""",
    "Patch test": """Unit square, E = 1 MPa, nu = 0.3, plane strain, u = (1e-3 x + 2e-4 y, 1e-4 x - 5e-4 y) on the boundary; displacement and stress at every point
(tests/verify/patch.cpp). Where the grid does not fit the body, the nodes of the cut cells are held. Points of a body with a known outline have their
quadrature fitted to body and cell and pass wherever they stand; points from a mesh file are taken as they are, and the error is that of their quadrature.""",
    "Patch test in space": """Unit cube, E = 1 MPa, nu = 0.3, an affine displacement with nine different gradients on its surface, of 1e-3 in small and of some per cent in
logarithmic strain (tests/verify/solid_patch.cpp); the worse of the two. Where the grid does not fit the body, the nodes of the cut cells are held.""",
    "Blocks in space": """Blocks of cells of 0.25 m on three planes of symmetry, E = 30 GPa, nu = 0.2 (tests/verify/solid_loads.cpp). Pressure and contact act at the centres of
pieces of the surface, a third of a cell long: the total is exact, but of all elements only hex8 with square pieces gets its nodes' shares right, and near the loaded
face the displacement of the others is off by the figures below.""",
    "Thick-walled cylinder": """Inner radius 0.05 m, outer radius 0.1 m, inner pressure 10 MPa, E = 30 GPa, nu = 0.2, ends held (tests/verify/lame.cpp): around the axis with 4 to 32
cells over the wall, in space a quarter with 4 to 16. L2 errors over the points, orders between the two finest meshes.""",
    "Thick-walled cylinder, nu = 0.4999": """The same tube of a nearly incompressible solid, with F-bar and with pressures at the nodes (tests/verify/lame.cpp); the walls cut cells.""",
    "Recovered stress": """The tube of "Thick-walled cylinder" on the finest mesh: stress at the nodes out of polynomials fitted about them ([formulation (63) - (65)](theory/formulation.md)), its
RMS error over the nodes in the wall, its order between the two finest meshes, and the error of the stress at the points as estimated without the exact solution over the true one.""",
    "Cantilever, self-weight": """8 m x 1 m, E = 90 MPa, nu = 0, 1000 kg/m3, 9.81 m/s2, Hencky's solid, tip deflection 8 % of the length (tests/verify/cantilever.cpp). In one step from
the undeformed state, with points at Gauss positions, MPM and FEM are the same equations if, and only if, the increment of F takes its gradients on the
configuration at t_n. With many steps the points leave the Gauss positions, which costs the updated Lagrangian form accuracy; the total Lagrangian one is
indifferent to it. The reference is a geometrically exact beam with shear, integrated in the test.""",
    "Brazilian disc, elastic": """D = 0.15 m, pressure on arcs of 11.478 deg, plane stress (tests/verify/brazilian_elastic.toml, brazilian.cpp). Stress on the diameter by a quadratic
least-squares fit to the points within one cell. Stress xx falls from its plateau to strong compression within a few millimetres under the load; with bilinear
cells of 5 mm the fit catches that fall best where the axis runs through mid-cell, because stress xx of a bilinear cell is constant in x. Quadratic elements do
not care.""",
    "Cut cells": """A specimen of 8 x 16 cells on a grid shifted by 0 to 1 cells in both directions: slivers from 1e-9 to 1 of a cell (tests/verify/cut_cells.cpp). Ghost stabilisation
keeps stiffness and iterations what they are.""",
    "Cut cells, 40 grid offsets between 0 and h, rough platens (V3)": """The same specimen between tied platens at 40 offsets, by shape function, with and without ghost stabilisation: condition number of the
matrix of the first step (Eigen's dense eigenvalues), spread of the stiffness, linear solves (tests/verify/cut_cells.cpp).""",
    "Held surfaces that cut cells": """`[boundary.NAME]` with a `body`: displacements prescribed on a surface that does not fit the grid, by a penalty (tests/verify/held_surface.cpp).""",
    "Stressed block that travels through the grid (V2)": """A block under uniform stress, its points out of step with the cells, is carried rigidly by 3.7 and 2.3 cells in 100 steps: nodal forces inside it, which should be zero
(tests/verify/crossing.cpp).""",
    "Bar drawn to three times its length (V6)": """1 m x 0.2 m, nu = 0, in 200 steps: stretch up to which every point's stress is within 1 % of the exact one, E (L - 1/L) / 2
of the neo-Hookean bar, whose force rises all the way, and E ln(L) / L of Hencky's, whose force is largest at the stretch e, beyond which the bar would neck
(tests/verify/crossing.cpp).""",
    "Bar with cell crossing, manufactured (V8, A = 0.05)": """u = A sin(pi X) sin(c pi t) between fixed ends over one period, Hencky's law: largest root mean square of the error of the displacement over A, by shape function, lumped and
consistent mass (tests/verify/manufactured.cpp). Independent one-dimensional programs, explicit (MUSL), gave with 8, 16, 32, 64 cells:

| functions | lumped mass | consistent mass, solved |
|---|---|---|
| linear | 0.16, 0.17, 0.30, 0.52 | 0.085, ... (diverges) |
| quadratic B-spline | 0.17, 0.043, 0.012, 0.0051 | 0.0073, 0.0044, 0.0035, 0.0030 |
| cpGIMP | 0.13, 0.033, 0.0081, 0.0020 | 0.0038, 0.00083, 0.00031, 9.6e-05 |
| B2-GIMP | 0.18, ..., 0.00074 with 128 | 0.00028, 0.00012, 3.1e-05, 8.2e-06 |
| quadratic B-spline, total Lagrangian | | 0.0069, ..., 2.7e-05 with 128 |""",
    "Square stretched along its edges, manufactured (V9, A = 0.05)": """The same in both directions with opposite signs between planes of symmetry (Wallstedt and Guilkey 2008; tests/verify/manufactured.cpp).
They and others report order 2 down to 1e-4 for explicit GIMP, and that linear functions stay at 1e-2 or above.""",
    "Ring that is sheared and turned, manufactured (V10, A = 0.1)": """The generalised vortex of Kamojjala et al. (2015) for a neo-Hookean solid, its rims held where they cut the cells (tests/verify/manufactured.cpp).
inf: a run finds no equilibrium before its end.""",
    "Ring that is sheared and turned, manufactured (V10, A = 0.5)": """The same turned five times as far, with shears up to 3.5.""",
    "Ring that is sheared and turned, manufactured (V10, A = 1)": """The same as in the literature, with shears up to 7.""",
    "Softening bar": """One weak cell, Rankine, everything else elastic, 1D, small strain (tests/verify/softening_bar.cpp): delta(s) = (L - l) s/E + l ft/E (1 - ln(s/ft)/A). A bar of 0.6 m
snaps back and is driven by the opening of its crack. The damage cap of 1 - 1e-5 leaves 0.9 to 2.6 % of Gf undissipated (theory/damage.md, equation 18):
"should be" contains that. IMPL-EX overshoots the peak; its error tolerance says by how much.""",
    "Thick tube of von Mises steel (V21)": """Inner radius 0.1 m, outer radius 0.2 m, E = 210 GPa, nu = 0.3, yield stress 0.24 GPa, inner pressure up to 0.18 GPa, ends held, around the axis
(tests/verify/hill.cpp). Hill takes the plastic part as incompressible in the elastic range too, which alone is worth about 1 %.""",
    "Cook's membrane (V13)": """The tapered panel (0,0) (48,44) (48,60) (0,44), left side clamped, shear traction on the right one, 16 cells a side, plane strain unless said
otherwise, small strain (tests/verify/locking.cpp). Fitted: the grid is a mesh of the panel; cut: square cells of a sixteenth of its width. Vertical displacement of the
upper right corner and of the middle of the right edge.""",
    "Strip footing (V22)": """Rigid rough strip of width B = 1 m on weightless ground, half of it on 5 x 3 m, small strain, E = 10000 c (tests/verify/locking.cpp). Cells of B/11, so
that the edge of the strip lies half-way between the last node that it moves and the first free one: the mean stress is that over the true width. Plateau: increase of the load over
the last 40 % of the settlement, relative.""",
    "Soil in the laboratory (V20)": """One cell, Mohr-Coulomb, MPM and FEM, small strain (tests/verify/soil_element.cpp): triaxial (axisymmetric) and biaxial (plane strain) compression under a
lateral pressure, clay with 25 degrees and 5 kPa, rockfill with 37 degrees, E = 1 MPa, nu = 0.29; simple shear under 100 kPa. The value farthest from the reference of all variants is shown.""",
    "Deposit of soil (V24)": """10 m of soil, 2000 kg/m3, nu = 0.29, under its own weight between smooth walls, E = 50 MPa or 1 MPa, and an oedometer under 100 kPa (tests/verify/geostatic.cpp).
Stress noise is the metric described at the end. In a linear cell the stress does not follow the depth, so that points are off by up to cell size / sqrt(12) over the depth; means of cells are exact.
Gravity in one step and in twenty gives the same to the solver's tolerance, but for updated Lagrangian points, which have moved in their cells.""",
    "Column under its own weight (V11)": """nu = 0, 80 kg/m3, 10 m/s2, Hencky's solid, width held, two points a cell and direction, at its quarters (tests/verify/column.cpp; the problem of AMPLE, Coombs and
Augarde 2020): 50 m in 20 steps with E = 1 MPa, where the top settles by 0.962009 m, and 10 m in 40 steps with E = 10 kPa, 2.373111 m. Stress: mean absolute error over the volume, over the stress at the base;
displacement: L2, relative. Linear functions on updated Lagrangian points do not converge: the gradient jumps where a point crosses the edge of a cell.
Independent one-dimensional programs gave for the stress with 8, 16, 32, 64, 128 cells:

| functions | 50 m | 10 m |
|---|---|---|
| linear | 0.031, 0.030, 0.032, 0.035, 0.036 | 0.11, 0.12, 0.095, 0.094, 0.092 |
| uGIMP | 0.026, 0.0098, 0.0026, 0.0011, 0.00068 | 0.029, 0.015, 0.013, 0.011, 0.013 |
| cpGIMP (AMPLE) | 0.026, 0.0096, 0.0024, 0.0008, 0.00024 | 0.011, 0.0034, 0.00099, 0.00036, 0.00015 |
| quadratic B-spline | 0.0021, 0.00074, 0.00092, 0.00079, 0.00075 | 0.011, 0.0080, 0.0050, 0.0056, 0.0069 |
| cubic B-spline | 0.019, 0.0093, 0.0050, 0.0023, 0.0012 | 0.026, 0.0099, 0.0043, 0.0022, 0.0017 |
| B2-GIMP | 0.0015, 0.0004, 0.00019, 0.0002, 5e-05 | 0.012, 0.0032, 0.00081, 0.00025, 5.4e-05 |
| quadratic B-spline, total Lagrangian | 0.0020, 0.00049, 0.00012, 3.1e-05, 7.6e-06 | 0.0021, ... |""",
    "Cantilever, load at its end (V12)": """10 m x 1 m, E = 12 MPa, nu = 0.2, plane strain, Hencky's solid, 100 kN in 50 steps (tests/verify/cantilever_end_load.cpp): tip deflection 80 % of the length. The root
slides on a wall and is pinned at mid-depth. The load is a dead pressure on the last 0.25 m of the top and a pull on the same part of the bottom; "should be" is the geometrically exact beam with shear under
that load, integrated in the test and checked there against the values for a force at the very end (100 kN: elastica 8.0624 m, with shear 8.1754 m). The beam knows no finite strain, which is 20 % at the root:
the solid bends 1.2 % further, and a beam twice as slender under the same relative load a quarter of that. Total Lagrangian MPM is quad4, and second order away from the quadratic elements. With updated Lagrangian
points linear functions are too soft, and find no equilibrium beyond 40 % of the load.""",
    "Slopes (V23)": """Small strain, Mohr-Coulomb, gravity grows until no equilibrium is found (tests/verify/slope.cpp, examples/11_slope_failure). The slope 2:1 of Griffiths and Lane: 10 m, c = 10 kPa, 20 degrees,
no dilatancy, 20 kN/m3; it has failed too if a point moves more than three times as far as with the whole strength. The vertical cut of 10 m: Tresca, cu = 20 kPa. Fully integrated linear functions lock in flow
without change of volume: they find an equilibrium far beyond the true factor (the row "by loss of equilibrium alone"), and carry a vertical cut of any height.""",
    "Nearly incompressible, large strain": """A block 1 m high of a nearly incompressible solid (nu = 0.4999, Hencky) between rough platens, cells of 0.25 m, ten steps
(tests/verify/locking.cpp). The mixed formulation stores energy in its stabilisation, which is not counted: at the corners of the platens the pressure is rough.""",
    "Oblique crack": """A notched plate, 150 x 100 mm, Rankine, cells of 5 mm, IMPL-EX, pulled apart on grids turned against it (tests/verify/oblique_crack.cpp). The crack-band length of a
cell is the root of its area whatever the direction of the crack. Along a row of cells that is exact; a crack across the rows damages a band wider than one cell and dissipates
more than the fracture energy, which is the known bias of local damage on a grid. Results with cracks at an angle to the grid are too tough by the figures below.""",
    "Free fall of a block (V5)": """0.4 x 0.4 m, E = 1 MPa, 1000 kg/m3, thrown sideways at 2 m/s, one second in 100 steps, lumped mass, each way to take the points' velocity from the grid; and the same block at rest
on a support under its weight, which then lets go (tests/verify/motion.cpp). A motion that starts without the acceleration of its first instant is late by half a step for good.""",
    "Vibrating bar (V7)": """Length 25 m, E = 100 Pa, 1 kg/m3, nu = 0, clamped at one end, first mode with 0.1 m/s at the tip: period 10 s (tests/verify/motion.cpp; the problem of Sulsky, Chen and Schreyer 1994 and
Bardenhagen 2002). One row of 25 cells of 1 m, Newmark without numerical damping unless said otherwise; the period is taken from the zeros of the mean velocity, the energy is kinetic and stored.""",
    "Turning disc (V4)": """Free elastic disc, R = 1 m, E = 1 MPa, 1000 kg/m3, 1 rad/s, cells of 0.1 m, 400 steps a turn (tests/verify/motion.cpp). The angular momentum is that of the points' velocities. PIC loses it by
smoothing the velocity in every step and is reported only. Over ten turns (4000 steps, not among the tests): FLIP with lumped mass -6.9 %, with consistent mass -0.013 %, APIC -0.71 %, of which
-0.69 % in the first turn, when part of it passes to the gradients that points carry.""",
    "Koyna dam (V18)": """Height 103 m, base 70 m, E = 31.027 GPa, nu = 0.2, 2643 kg/m3, plane stress, small strain, base held (tests/verify/koyna.cpp). The crest is kicked, and the frequencies are the largest Fourier
components of its motion over 8 s in 3200 steps, corrected for Newmark's elongation of the period. "Should be" is a converged finite-element computation.""",
    "Coulomb friction": """A block, 1 x 0.5 m, 2000 kg/m3, E = 10 MPa, cells of 0.125 m, on a rigid plane with mu = 0.4, along the grid or turned by 20 degrees against it (tests/verify/friction.cpp): pushed
by 2 mm by a stamp, and under gravity that turns until there is no equilibrium. Relative errors.""",
    "Inclined slip boundary": """A block, 1 x 2 m, 20 kN/m3, E = 10 MPa, nu = 0.3, small strain, under its weight between rollers, one of which moves by 1 mm; block, rollers and grid are turned (tests/verify/inclined.cpp).
Relative errors.""",
    "Rankine's earth pressure (V28)": """A smooth rigid wall of 4 m before a cohesionless backfill that has its weight first; then the wall gives way or pushes (tests/verify/rankine.cpp).""",
    "Triangular gravity dam (V16)": """Height 100 m, downstream slope 0.8, full water, E = 30 GPa, nu = 0.2, plane strain, small strain; the stresses of the exact solution are linear, and the base is moved as it says
(tests/verify/gravity_dam.cpp). In MPM both faces cut the cells. L2 errors, orders over the grids named.""",
    "Damping of free motion": """A block in free motion with Rayleigh damping from its first instant (tests/verify/stages.cpp): the rule of the trapezoid alone costs 0.17 %.""",
    "Viscous shear flow": """A layer of viscous fluid, 1 m thick, between walls; its sine of velocity dies away (tests/verify/stages.cpp): 20 cells, 10 s in 40 steps, FLIP, each way to integrate in time.""",
    "Block on an incline (V32)": """1 x 1 m, E = 10 MPa, 1000 kg/m3, cells of 0.25 m, on a rigid plane along the grid or turned by 30 degrees against it; gravity is inclined against the plane (tests/verify/sliding.cpp). The weight is
put on while the block is tied to the plane, then friction takes over. What is reported as drift at mu = 0.6 is mostly elastic: the shear of the block under its own weight.""",
    "Contact on the grid": """Two deformable bodies, each with its own field of displacement on the grid: a block of 1 m on one of 3 m, E = 10 MPa, 1000 kg/m3, 10 m/s2, mu = 0.5, cells of 0.25 m (tests/verify/sliding.cpp).
The weight is quasi-static; then the upper block is pushed with a force that grows with time.""",
    "Colliding discs (V34)": """R = 0.2 m, E = 1000 Pa, nu = 0.3, 1000 kg/m3, towards each other on a diagonal with 0.1 m/s in each direction, cells of 0.05 m, frictionless contact (tests/verify/sliding.cpp; the problem of
Sulsky, Chen and Schreyer 1994). The gap is taken from the outermost points, so that contact does not begin where the circles are still a cell apart.""",
    "Dam break (V36)": """A column of water, a = 57.15 mm wide and 2 a high, let go at once on a frictionless floor; 12 cells over the width, sound at 20 m/s, APIC, 0.5 ms a step (tests/verify/flow.cpp; examples/13_dam_break_water
has a finer grid and the whole curve). Front: the third point from the right; height: the highest point within a tenth of a of the wall.""",
    "Water in a tank (V36)": """0.6 x 1 m, bulk modulus 2 MPa, viscosity 1e-3 Pa s, 10 m/s2 within 0.5 s under damping, then 5 s without, cells of 0.1 m (tests/verify/flow.cpp).""",
    "Column of aluminium bars (V26)": """0.2 x 0.1 m, Mohr-Coulomb with 19.8 degrees, no cohesion, no dilatancy, E = 0.84 MPa, 2650 kg/m3, rough floor, gate removed at once, F-bar, cells of 10 mm (tests/verify/flow.cpp;
examples/10_granular_column has finer ones).""",
    "Column of sand (V27)": """5 cm wide, 31 degrees, no cohesion, no dilatancy, rough floor, F-bar, cells of 5 mm (tests/verify/flow.cpp; examples/10_granular_column has more aspect ratios a). Run-out over width: 1.2 a
(a < 1.8) and 1.9 a^(2/3) (a > 2.8) by Lube et al., 1.8 a (a < 3) and 2.3 a^(2/3) by Lajeunesse et al.: the two are the bounds in "should be".""",
    "Pressure that follows the face": """A tube of Hencky's solid (E = 1 MPa, nu = 0.3, ends held) whose inner pressure of 0.12 MPa stays normal to the wall while it widens by 40 %, a cantilever bent beyond the vertical by a load that stays
normal to it, and the lift of water on a body that is turned and stretched (tests/verify/follower.cpp). Relative errors.""",
    "Absorbing boundary": """A bar of 10 m, E = 10 kPa, 100 kg/m3, nu = 0, waves of 10 m/s, a Gaussian pulse of velocity in its middle, dashpots (Lysmer and Kuhlemeyer 1969) at both ends, cells of 0.1 m, 1.5 s in 600 steps
(tests/verify/flow.cpp). Half of the pulse runs to each end.""",
}

TAIL = """
## Stress noise
The metric `stress_noise` of summary.json is N = RMS over the points of |s - s'| / max |s|, with the in-plane stress components, |.| their Frobenius norm and s' a linear
least-squares fit (weights: volume times a linear hat) over the points within one and a half cells. It is taken at the step closest to half the peak load. In space the mean is over a sample of about 5000 points. A smooth field gives
N near 0; the value says how much of the stress is the grid's.
"""


def read_rows(binary):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "rows.tsv"
        done = subprocess.run(
            [binary], env={**os.environ, "BERM_VERIFICATION_RECORD": str(path), "BERM_WHOLE_TABLES": "1"}, stdout=subprocess.PIPE, check=False
        )
        text = done.stdout.decode("utf-8", "replace")
        if done.returncode != 0:
            sys.exit("the tests fail, no table is written:\n" + "\n".join(text.splitlines()[-20:]))
        with open(path, encoding="utf-8", newline="") as file:
            return list(csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def number(text):
    """Errors at the level of rounding differ from machine to machine: only their size is shown."""
    value = float(text)
    return f"{value:.0e}" if 0.0 < abs(value) < 1e-9 else f"{value:.6g}"


def table(rows):
    yield "| quantity | reached | should be | demanded | reference |"
    yield "|---|---|---|---|---|"
    for _, quantity, reached, reference, tolerance, source in rows:
        yield f"| {quantity} | {number(reached)} | {reference} | {tolerance} | {source} |"


def main():
    parser = argparse.ArgumentParser(description="Runs the verification tests and writes docs/verification.md.")
    parser.add_argument("binary", metavar="TEST_VERIFY", help="the test program")
    parser.add_argument("--out", default=ROOT / "docs" / "verification.md", help="where to write")
    options = parser.parse_args()
    rows = read_rows(pathlib.Path(options.binary).resolve())
    unknown = {row[0] for row in rows} - set(INTRODUCTIONS)
    if unknown:
        sys.exit(f"no introduction for {', '.join(sorted(unknown))}: add it to {__file__}")
    lines = [HEAD]
    for group, introduction in INTRODUCTIONS.items():
        own = [row for row in rows if row[0] == group]
        if own:
            lines += [f"## {group}", introduction, "", *table(own), ""]
    pathlib.Path(options.out).write_text("\n".join(lines).rstrip() + "\n" + TAIL, encoding="utf-8")


if __name__ == "__main__":
    main()
