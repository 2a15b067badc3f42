"""The textbook problems: file, right value, how it is read from a run, best options. Sources are at the heads of the files.

P(name, what, right, unit, read): deviation is relative to the right value, or to `scale` where that is 0.
best: options as for --set; None: there is nothing to choose. fem: finite elements make sense; fem_sets: what they need beside the method.
factor: the value is that of `berm factor_of_safety`. short: --set options that make the run short, for a quick look.
"""

from dataclasses import dataclass
from math import exp, log, pi, sqrt
from typing import Callable

import numpy as np

import closed_forms


@dataclass
class P:
    name: str
    what: str
    right: float
    unit: str
    read: Callable
    best: tuple | None = None
    fem: bool = True
    fem_sets: tuple = ()
    tolerance: float = 0.03
    scale: float = 0.0
    factor: bool = False
    may_stop: bool = False  # the load falls faster than the motion can follow: only the peak counts
    short: tuple = ()
    case: str = ""

    @property
    def file(self):
        return self.case or f"{self.name}.toml"


def last(column, factor=1.0):
    return lambda r: factor * r.last(column)


def size(column, factor=1.0):
    return lambda r: factor * abs(r.last(column))


def largest(column, factor=1.0):
    return lambda r: factor * float(np.nanmax(np.abs(r[column])))


def probe(name, factor=1.0):
    return last(f"probe:{name}", factor)


def energy(r):
    return r["kinetic_energy"] + r["elastic_energy"]


def energy_kept(r):
    """What is left of the energy at the start; more than that, if there was more in between."""
    e = energy(r)
    share = e / e[0]
    return float(share.max() if share.max() > 1.03 else share[-1])


def energy_gained(r):
    e = energy(r)
    return float(max(e.max() / e[0], 1.0)) if np.isfinite(e).all() else float("inf")


def energy_left(r):
    return float(energy(r)[-1])


def touch(column, gravity, start=0.0):
    """Displacement when a falling body is 1 mm above free fall, sharpened by the line between rows."""

    def read(r):
        above = r[column] + 0.5 * gravity * r["time"] ** 2 - 1e-3
        first = int(np.argmax(above > 0)) if (above > 0).any() else len(above) - 1
        i = max(first, 1)
        share = -above[i - 1] / (above[i] - above[i - 1]) if above[i] > above[i - 1] else 1.0
        return float(r[column][i - 1] + share * (r[column][i] - r[column][i - 1]))

    return read


def heat_of_friction(r):
    return r.last("friction_energy") / max(abs(r.last("external_work")), 1e-30)


def hertz(r):
    load = 2 * abs(r.last("reaction"))
    b = sqrt(4 * load * 0.91 / (pi * 1e6))
    return abs(r.last("probe:syy")) / (2 * load / (pi * b) / sqrt(1 + (0.15528 / b) ** 2))


def zeros(t, u):
    """When u changes its sign."""
    i = np.nonzero(u[:-1] * u[1:] < 0)[0]
    return t[i] - u[i] * (t[i + 1] - t[i]) / (u[i + 1] - u[i])


def period_of_swing(r):
    """Of the end of a bar of 0.95 m below its pin, let go horizontally: twice from one way through the bottom to the next."""
    first, second, *_ = zeros(r["time"], r["probe:ux"] + 0.95)
    return 2 * (second - first)


def height_after(fall):
    """Of a rebound, above the place where a body that falls by `fall` touches."""
    return lambda r: float(r["probe:uy"][int(np.argmin(r["probe:uy"])) :].max() + fall)


def last_velocity(column):
    return lambda r: float((r[column][-1] - r[column][-21]) / (r["time"][-1] - r["time"][-21]))


def rebound(r):
    return (r.at("probe:u", 0.06) - r.at("probe:u", 0.04)) / 0.02


def frequency(column):
    """From the zeros of a column, the first at the start left out."""

    def read(r):
        at = zeros(r["time"][1:], r[column][1:])
        return 0.5 * (len(at) - 1) / (at[-1] - at[0])

    return read


def frequency_fitted(column, low, high):
    """Of the harmonic motion about a mean that fits a column best."""

    def read(r):
        def misfit(f):
            turn = 2 * pi * f * r["time"]
            A = np.column_stack([np.ones_like(turn), np.cos(turn), np.sin(turn)])
            return float(np.sum((A @ np.linalg.lstsq(A, r[column], rcond=None)[0] - r[column]) ** 2))

        return float(min(np.linspace(low, high, 1001), key=misfit))

    return read


def water_pressure(r):
    late = r["time"] > r.last("time") - 0.5
    return -float(np.mean([r[f"probe:{n}"][late].mean() for n in ("low", "high", "low2", "high2")]))


def deviator(r):
    return (r.last("probe:sxx") - r.last("probe:syy")) / 1e3


B2 = ("grid.shape_functions=b2gimp",)
CPDI = ("grid.shape_functions=cpdi",)
TL = ("model.formulation=total_lagrangian",)
FBAR = ("model.volumetric=f_bar",)
CONSISTENT = ("dynamics.mass=consistent",)
SOFT = ("contact.w.stiffness=20",)

Y_TUBE = 2 * 240 / sqrt(3)
TUBE_A = 0.101
FALL = -0.2174  # closed_forms.falling_bar(0.15, 1e6, 1000.0, 9.81)

PROBLEMS = [
    # Elastic solids, small and large strain
    P("squeezed_block", "block squeezed by 10 %", 1e3 * -log(0.9) / 0.9, "MN/m", size("reaction", 1e-6), B2),
    P("pressed_block", "block pressed by a smooth plate, 5 %", -20e3 / 0.91 * log(0.95) / 0.95, "kPa", size("nominal_stress", 1e-3), TL),
    P("oedometer", "oedometer, 20 %", -1e3 * 0.7 / (1.3 * 0.4) * log(0.8) / 0.8, "kPa", size("nominal_stress", 1e-3), B2),
    P("rubber_block", "rubber block pressed by 40 %", 1e-3 * -closed_forms.neo_hooke_plane_strain(0.6, 1e6, 0.45), "kPa", size("nominal_stress", 1e-3), B2),
    P("bar_drawn", "bar drawn to twice its length", 1e3 * log(2) / 2, "kPa", size("nominal_stress", 1e-3), B2),
    P("column_weight", "column under its own weight", -2.373111, "m", probe("top"), B2),
    P("bent_cantilever", "elastica, way of the tip along the axis", -22.20, "m", probe("ux"), CPDI),
    P("column_buckled", "column at 1.293 of Euler's load, way of its top", 10 * (0.55323 - 1), "m", probe("uy"), CPDI, tolerance=0.05),
    P("cantilever_shear", "short cantilever with shear", -265.6, "mm", probe("uy", 1e3), B2),
    P("beam_simple", "beam on two supports", -6.628, "mm", lambda r: 1e3 * (r.last("probe:uy") - r.last("probe:end")), B2),
    P("curved_beam", "curved beam across the grid", pi * 1e3 * 3.25 / (1e6 * (-1.25 + 3.25 * log(1.5))), "mm", probe("ux", 1e3), B2),
    P("cook", "Cook's membrane", 23.965, "", probe("uy"), B2),
    P("thick_tube", "thick tube, elastic", 2 * 10 * 2 * 0.91 / 3, "mm", probe("ux", 1e3), B2),
    P("plate_hole", "plate with a hole, widening", 3.0, "mm", probe("ux", 1e3), B2),
    P("inclusion", "stiff inclusion, stress in it", 2 / (1.3 + 0.07), "MPa", probe("sxx", 1e-6), B2),
    P("brazilian", "Brazilian disc, tension at the centre", 0.5499, "MPa", probe("sxx", 1e-6), B2),
    P("disc_centrifugal", "disc under the forces of a spin", 17.5, "mm", probe("ux", 1e3), B2),
    P("torsion", "torsion of a round bar, energy", 944.0, "J", last("elastic_energy"), B2),
    P("bars_in_series", "two bars in series, border on nodes", 0.1 * 1e-3 / (0.5e-9 + 0.5e-11) / 1e3, "kN", size("reaction", 1e-3)),
    P("interface_in_cell", "two bars in series, border inside a cell", 0.1 * 1e-3 / (0.53e-9 + 0.47e-11) / 1e3, "kN", size("reaction", 1e-3), B2),
    P("touching_supports", "half of the base sinks", -3.44, "kN/m", last("reaction_y:door", 1e-3), tolerance=0.1),
    P("bodies_touch_fem", "two touching blocks", 15.1, "MN/m", size("reaction", 1e-6)),
    P("tie_curved_fem", "rigid disc tied into a ring", closed_forms.disc_in_ring(0.5, 2.0, 1e7, 0.3) * 1e-5, "kN/m", size("reaction", 1e-3), B2, fem_sets=("body.soil.mesh.order=2",)),
    P("plate_clamped", "clamped circular plate", -0.624, "mm", probe("w", 1e3)),
    P("cantilever_oblique", "cantilever in space, oblique weight", 5.943, "mm", lambda r: 1e3 * abs(r.last("probe:uz"))),
    # Metal
    P("thick_tube_plastic", "thick tube, full plasticity", Y_TUBE * log(sqrt(0.03 + TUBE_A**2) / TUBE_A), "MPa", size("reaction_x:inside", 1e-6 / (2 * pi * TUBE_A * 0.005)), FBAR),
    P("steel_strip", "strip of steel drawn by 40 %", 593.7, "MPa", size("nominal_stress", 1e-6), (*TL, *FBAR)),
    P("mixed_plastic_stretch", "the same, mixed and total Lagrangian", 593.7, "MPa", size("nominal_stress", 1e-6), FBAR, fem=False),
    P("steel_bar", "round bar of steel drawn by 40 %", 1e-6 * closed_forms.hencky_plastic_bar(1.4, 206.9e9, 450e6, 700e6), "MPa", size("nominal_stress", 1e-6), (*TL, *FBAR)),
    P("necking_bar", "necking bar, largest load", 700 * exp(450 / 700 - 1) * exp(-700 / 206900), "MPa", largest("nominal_stress", 1e-6), (*TL, *FBAR)),
    P("taylor_bar", "Taylor's test, loss of length", -10.95, "mm", probe("top", 1e3), (*FBAR,)),
    P("beam_collapse", "clamped beam, plastic collapse", 500.0, "kN/m", largest("reaction", 1e-3)),
    # Soil
    P("triaxial", "drained triaxial test", 234.64, "kPa", deviator, TL),
    P("biaxial_rough", "undrained compression, rough platens", 20.0, "kPa", size("nominal_stress", 1e-3), FBAR),
    P("simple_shear", "simple shear of soil, shear over vertical stress", 0.5, "", lambda r: abs(r.last("probe:sxy") / r.last("probe:syy"))),
    P("footing_strip", "strip footing on clay, q/cu", 2 + pi, "", size("nominal_stress", 1 / 20e3), FBAR, tolerance=0.05),
    P("footing_circular", "circular footing on clay, q/cu", 6.05, "", size("nominal_stress", 1 / 20e3), FBAR, tolerance=0.08),
    P("footing_sand", "strip footing, 20 degrees, q/c", 14.835, "", size("nominal_stress", 1 / 20e3), FBAR, tolerance=0.05),
    P("footing", "footing pushed into clay, q/cu at 0.3 m", 5.30, "", lambda r: abs(r.at("nominal_stress", 0.3)) / 1e4, (*FBAR, "contact.f.stiffness=20"), tolerance=0.1),
    P("trapdoor", "trapdoor in clay, load/cu", 1.90, "", size("nominal_stress", 1e-4), FBAR, tolerance=0.05),
    P("vertical_cut", "vertical cut, factor of safety", 3.7776 * 30 / 100, "", None, FBAR, factor=True),
    P("slope", "slope 2:1, factor of safety", 1.38, "", None, FBAR, factor=True),
    P("wall_active", "smooth wall, active", 2000 * 9.81 * 2 / 3e3 - 2 * 0.1 * 2 / sqrt(3), "kN/m", size("reaction_x:wall", 1e-3), SOFT),
    P("wall_passive", "smooth wall, passive", 2000 * 9.81 * 2 * 3 / 1e3 + 2 * 0.1 * 2 * sqrt(3), "kN/m", size("reaction_x:wall", 1e-3), (*SOFT, *B2)),
    P("silo", "silo, load on the floor", 28.96, "kN/m", size("reaction", 1e-3), tuple(f"contact.{n}.stiffness=20" for n in ("left", "right"))),
    P("tunnel_kirsch", "tunnel, elastic, roof", -2.275, "mm", probe("uy", 1e3), B2),
    P("tunnel_plastic", "tunnel, Mohr-Coulomb, wall", -1e3 * closed_forms.tunnel_wall(1e6, 0.0, 0.2e6, 30.0, 1e9, 0.3, 1.0), "mm", lambda r: 1e3 * (r.last("probe:ur") - r.at("probe:ur", 1.0)), FBAR),
    P("cavity_cylinder", "cylindrical cavity in clay", 1e-3 * closed_forms.cylinder_cavity(1.0, 1.5, 25.0, 1e4, 5e5), "kPa", size("reaction_x:wall", 1e-3 / (2 * pi * 1.5 * 0.1)), FBAR),
    P("cavity_sphere", "spherical cavity in clay, outer face", 1.75, "mm", probe("out", 1e3), FBAR),
    P("sand_column", "column of sand, run-out", 75.0, "mm", lambda r: 1e3 * max(r.last(f"probe:{n}") for n in ("toe", "toe2", "toe3", "toe4", "toe5", "toe6")), (*FBAR, "dynamics.transfer=blend"), fem=False, tolerance=0.2),
    P("true_triaxial", "true triaxial test of a cube", 317.3, "kPa", size("probe:syy", 1e-3), fem=False),
    P("slope_clay", "clay slope on clay, factor of safety", 1.47, "", None, factor=True, fem=False),
    # Concrete
    P("concrete_bar", "concrete bar torn, work", 100.0, "J/m2", last("external_work", 1 / 0.02)),
    P("notched_beam", "notched beam, largest load", 755.0, "N", largest("reaction"), ("solver.integration=impl_ex",), tolerance=0.05),
    P("bending_strip", "four-point bending, pressures", 4.2, "MPa", largest("nominal_stress", 1e-6), ("solver.integration=impl_ex", "steps.error_tolerance=0.002"), tolerance=0.1),
    P("bending_rollers", "four-point bending, rollers", 4.2, "MPa", largest("nominal_stress", 1e-6), ("solver.snap_back=impl_ex",), tolerance=0.1),
    P("interface_crack", "soft bar and concrete in series", 0.300, "MN", largest("reaction", 1e-6), ("solver.integration=impl_ex",), may_stop=True),
    P("concrete_cylinder", "concrete cylinder, compression", 30.0, "MPa", largest("nominal_stress", 1e-6)),
    # Contact
    P("hertz", "cylinder on a plane, stress below over Hertz's", 1.0, "", hertz, B2, tolerance=0.05),
    P("caps_plate", "cap on a rigid plate", 2.33, "MN/m", size("reaction", 1e-6), B2, fem=False, tolerance=0.05),
    P("caps", "two caps", 2.33, "MN/m", size("reaction", 1e-6), B2, fem=False, tolerance=0.05),
    P("contact_small_strain", "blocks apart, small strain", 75.0, "kN/m", size("reaction", 1e-3), fem=False),
    P("contact_total_lagrangian", "block falls on a block, lowest place", FALL, "m", lambda r: float(r["probe:up"].min()), ("model.formulation=updated_lagrangian",), fem=False, tolerance=0.05),
    P("contact_reopened", "contact opened and closed again, force", 0.0, "kN/m", largest("reaction_y:base", 1e-3), B2, fem=False, scale=10.0),
    P("pushed_block", "pushed block with friction", 4.0, "kN/m", size("reaction", 1e-3)),
    P("friction_heat", "stacked blocks, heat of friction over work", 0.0, "", heat_of_friction, fem=False, scale=1.0),
    P("block_above_floor", "block above a floor, way to the touch", -0.07, "m", touch("probe:p", 9.81), B2, fem=False, tolerance=0.08),
    P("friction_floor", "block falls on a rigid floor, way to the touch", -0.03, "m", touch("probe:y", 10.0), ("dynamics.integrator=bossak", "dynamics.transfer=blend"), fem=False, tolerance=0.42),
    P("incline", "block on an incline, way in 1 s", 9.81 * (0.5 - 0.3 * sqrt(0.75)) / 2, "m", lambda r: r.last("probe:ux") - r.at("probe:ux", 1.0)),
    P("colliding_bars", "two bars collide, velocity after", -1.0, "m/s", rebound, CONSISTENT, fem=False),
    P("shaken_box", "shaken box of sand, time reached", 1.0, "s", last("time"), ("dynamics.integrator=bossak",), fem=False, tolerance=0.001),
    P("block_dragged", "block dragged over a block", 1.104, "kN/m", size("reaction_x:push", 1e-3), fem=False),
    P("block_on_block", "block slides on a block, way in 0.5 s", 0.2571, "m", probe("ux"), fem=False),
    P("disc_rolling", "disc rolls down a slope", 1.118, "m", probe("ux"), fem=False),
    P("up_and_back", "block up and back on an incline", 0.545, "m", probe("ux"), fem=False),
    P("ball", "elastic ball, height of its rebound", 0.199, "m", height_after(0.2), tolerance=0.05, fem=False),
    P("discs_collide", "two discs collide, velocity of the second", 1.0, "m/s", last_velocity("probe:ub"), tolerance=0.05, fem=False),
    # Motion
    P("free_fall", "free fall", -9.81 / 8, "m", probe("uy")),
    P("spinning", "spinning square, energy after a turn", 3289.9, "J", energy_left, CONSISTENT),
    P("apic_bar", "free bar, APIC, energy gained", 1.0, "times", energy_gained, ("dynamics.transfer=flip",), fem=False),
    P("apic_block", "free block, APIC, energy gained", 1.0, "times", energy_gained, ("dynamics.transfer=flip",), fem=False),
    P("bar_vibrating", "bar that swings along its axis", 0.159155, "m", probe("tip"), CONSISTENT),
    P("beam_vibrating", "cantilever that swings", closed_forms.timoshenko_frequency(10.0, 1.0, 1e7, 0.0, 1000.0), "Hz", frequency("probe:tip"), (*B2, *CONSISTENT)),
    P("wave_bar", "wave in a bar", 10.0, "mm", probe("middle", 1e3), CONSISTENT),
    P("wave_column_3d", "wave in a column", -0.10206, "mm", lambda r: 1e3 * r.at("probe:mid", 0.06), CONSISTENT, fem=False),
    P("water_tank", "water at rest, pressure", 5.0, "kPa", lambda r: 1e-3 * water_pressure(r), ("dynamics.transfer=apic",), fem=False),
    P("dam_break", "dam break, way of the front", 76.0, "mm", probe("front", 1e3), fem=False, tolerance=0.15),
    P("pendulum", "pendulum, period", 1.890, "s", period_of_swing, fem=False),
    P("sudden_weight", "column under sudden weight", 98.1, "mm", largest("probe:top", 1e3)),
    P("sloshing", "sloshing of a tank", 1 / 1.182, "Hz", frequency_fitted("probe:ux", 0.6, 1.1), fem=False),
]
