"""Factor of safety of a case by reduction of the strength.

    python3 -m berm.factor_of_safety CASE.toml [--tolerance 0.02] [--most 10.0] [--jump 3.0]
                                     [--material NAME] [--set KEY=VALUE] [--berm PATH] [--out DIR]

The case is run with cohesion / F and atan(tan(friction angle) / F) in place of its strength; the factor of safety is
the largest F at which it stands. A run has failed if it finds no equilibrium with the smallest step that the case
allows, or if something moves by more than a tenth of the height of all bodies (their smallest extent), or more than JUMP
times as far as in the run with the lowest F that stands. F grows or falls from 1 until the answer lies between two values, and their distance is halved until it is at most twice TOLERANCE.

Every trial is a run in DIR/F_1.2000 (default: out/<name of the case>_safety), in the place of that of an earlier search.
Writes DIR/factor_of_safety.csv, a row a trial as they come, and .png.
Exit code 1: no factor was found; 2: the input is wrong.
"""

import argparse
import csv
import math
import os
import re
import sys
import tomllib
from dataclasses import dataclass

import numpy as np

from berm import words
from berm.errors import ResultError
from berm.files import new_file
from berm.program import end_runs_with_the_tool, find_berm, run_case
from berm.results import UNITS, Run, find_unit

TOOL = "berm factor_of_safety"
LAWS = ("mohr_coulomb", "drucker_prager")
NO_CUT_OFF = 1e30  # tensile_strength of a case without a tension cut-off
LEAST_TOLERANCE = 1e-4
GROWTH = 1.25  # of F while no run has failed
RUN_OUT = 0.1  # of the smallest extent of all bodies: what moves farther has come down, not settled


class NoFactor(Exception):
    """The search ended without an answer."""


@dataclass
class Trial:
    factor: float
    stands: bool
    share: float  # of the run's time that was reached
    displacement: float  # largest of any point at the end [m]
    reason: str
    folder: str
    warnings: list  # of the run


def quantity(value, dimension, key):
    """A number of a case file in the bare unit: 10000.0, "10 kPa" -> 10000.0."""
    if isinstance(value, (int, float)):
        return float(value)
    match = isinstance(value, str) and re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.+?)\s*", value)
    found = match and find_unit(match[2])
    if not found or found[0] != dimension:
        raise ResultError(f"cannot read {key} = {value!r} (units: {', '.join(UNITS[dimension])})")
    return float(match[1]) * found[1]


def reduced_angle(degrees, factor):
    return math.degrees(math.atan(math.tan(math.radians(degrees)) / factor))


def reduced(name, material, factor):
    """Overrides that divide the strength of a material by a factor. Dilatancy stays, up to the friction angle."""

    def read(key, dimension, default=-1.0):
        return quantity(material.get(key, default), dimension, f"material.{name}.{key}")

    changes = {
        "cohesion": read("cohesion", "stress") / factor,
        "friction_angle": reduced_angle(read("friction_angle", "angle"), factor),
    }
    changes["dilatancy_angle"] = min(read("dilatancy_angle", "angle", 0.0), changes["friction_angle"])
    cut_off = read("tensile_strength", "stress", NO_CUT_OFF)
    if cut_off < NO_CUT_OFF:
        changes["tensile_strength"] = cut_off / factor
    residual_friction = read("residual_friction_angle", "angle")
    if read("residual_cohesion", "stress") >= 0.0:
        changes["residual_cohesion"] = read("residual_cohesion", "stress") / factor
    if residual_friction >= 0.0:
        changes["residual_friction_angle"] = reduced_angle(residual_friction, factor)
    weakest = min(changes["friction_angle"], changes.get("residual_friction_angle", changes["friction_angle"]))
    if read("residual_dilatancy_angle", "angle") >= 0.0:
        changes["residual_dilatancy_angle"] = min(read("residual_dilatancy_angle", "angle"), weakest)
    else:
        changes["dilatancy_angle"] = min(changes["dilatancy_angle"], weakest)
    return [f"material.{name}.{key}={value:.12g}" for key, value in changes.items()]


def smallest_extent(run):
    """Of the points of all bodies at the start [m]."""
    sides = np.ptp(run.frame(0)["position"], axis=0)
    return float(min(side for side in sides if side > 0.0))


def version_of(path):
    """What tells a file from the one that it replaces; None if there is none."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_ino, status.st_mtime_ns


class Search:
    def __init__(self, options, berm, out):
        self.options, self.berm, self.out = options, berm, out
        self.materials = {}  # {name: table} of what is reduced, known from the first run on
        self.trials = []

    def read_materials(self, folder):
        """What is to be reduced, from the resolved case of the run with F = 1: base and overrides are in it."""
        with open(os.path.join(folder, "case.toml"), "rb") as file:
            tables = tomllib.load(file).get("material", {})
        names = self.options.material or [name for name, table in tables.items() if table.get("law") in LAWS]
        for name in names:
            if tables.get(name, {}).get("law") not in LAWS:
                raise ResultError(f"the case has no material {name} with one of the laws {', '.join(LAWS)}")
        if not names:
            raise ResultError(f"the case has no material with one of the laws {', '.join(LAWS)}")
        self.materials = {name: tables[name] for name in names}

    def run(self, folder, overrides):
        """Runs the case; with the program's words ResultError if it refuses the case, NoFactor if it comes to no results."""
        summary = os.path.join(folder, "summary.json")
        before = version_of(summary)
        done = run_case(self.berm, self.options.case, folder, [*self.options.set, *overrides], force=True)
        said = done.stderr.strip() or f"exit code {done.returncode}"
        if done.returncode == 2:
            raise ResultError(said)
        # One of an earlier search says nothing of this run.
        if done.returncode not in (0, 1) or version_of(summary) in (None, before):
            raise NoFactor(f"no results in {folder}: {said}")
        return Run(folder), [line for line in said.splitlines() if line.startswith("warning: ")]

    def attempt(self, factor):
        """Runs the case with its strength divided by a factor; the first one is the case itself. Does it stand?"""
        folder = os.path.join(self.out, f"F_{factor:.4f}")
        run, warnings = self.run(folder, [o for name, table in self.materials.items() for o in reduced(name, table, factor)])
        if not self.materials:
            self.read_materials(folder)
        status, reason = run.summary.get("status"), run.summary.get("reason", "")
        if status != "done" and not reason.startswith("no equilibrium found"):
            raise NoFactor(f"the run with F = {factor:.4f} ended early: {status}: {reason}")
        displacement = float(np.linalg.norm(run.last()["displacement"], axis=1).max())
        share = float(run.history["time"][-1]) / self.duration(folder)
        trial = Trial(factor, status == "done", share, displacement, reason.split(" (")[0], folder, warnings)
        if trial.stands and (moved := self.too_far(displacement, smallest_extent(run))):
            trial.stands, trial.reason = False, moved
        self.trials.append(trial)
        self.write_table()
        verdict = "stands" if trial.stands else f"fails at {100 * share:.1f} % of the run"
        print(f"F = {factor:.4f}: {verdict}, largest displacement {displacement:.4g} m", flush=True)
        return trial.stands

    def too_far(self, displacement, height):
        """Why something that has found equilibrium has failed all the same; empty: it has not."""
        if displacement > RUN_OUT * height:
            return f"displacement {displacement / height:.2g} times the height of the bodies"
        standing = min((t for t in self.trials if t.stands), key=lambda t: t.factor, default=None)
        if standing and displacement > self.options.jump * standing.displacement:
            return f"displacement {displacement / standing.displacement:.1f} times that of F = {standing.factor:g}"
        return ""

    @staticmethod
    def duration(folder):
        with open(os.path.join(folder, "case.toml"), "rb") as file:
            case = tomllib.load(file)
        stages = case.get("stage", {}).values() or [case.get("steps", {})]
        return sum(quantity(stage.get("duration", 1.0), "time", "duration") for stage in stages)

    def bracket(self):
        """(largest F that stands, smallest that fails), a step of GROWTH apart."""
        factor, most = 1.0, self.options.most
        up = self.attempt(factor)
        while True:
            following = min(factor * GROWTH, most) if up else max(factor / GROWTH, 1.0 / most)
            if following == factor:
                raise NoFactor(f"the case still {'stands' if up else 'fails'} at F = {factor:.4g}; see --most")
            if self.attempt(following) != up:
                return (factor, following) if up else (following, factor)
            factor = following

    def find(self):
        low, high = self.bracket()
        while high - low > 2.0 * self.options.tolerance:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.attempt(middle) else (low, middle)
        return low, high

    def rows(self):
        return sorted(self.trials, key=lambda t: t.factor)

    def write_table(self):
        with new_file(os.path.join(self.out, "factor_of_safety.csv")) as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["factor [-]", "stands [-]", "share_of_run [-]", "largest_displacement [m]", "reason"])
            for t in self.rows():
                writer.writerow([f"{t.factor:.6g}", int(t.stands), f"{t.share:.6g}", f"{t.displacement:.6g}", t.reason])

    def write_figure(self, low, high):
        figure = safety_figure(self.rows(), low, high)
        with new_file(os.path.join(self.out, "factor_of_safety.png"), binary=True) as file:
            figure.savefig(file, format="png")


def safety_figure(trials, low, high):
    """Largest displacement over F."""
    from berm.figures import RUN_COLOURS, plt, unit_for

    factor, unit = unit_for("m", max(t.displacement for t in trials))
    figure, plot = plt.subplots(figsize=(5.6, 3.9), layout="constrained")
    plot.axvspan(low, high, color="#e3e3e3", linewidth=0)
    for stands, colour, label in ((True, RUN_COLOURS[0], "stands"), (False, RUN_COLOURS[1], "fails")):
        chosen = [t for t in trials if t.stands == stands]
        style = "o-" if stands else "x"
        x, y = [t.factor for t in chosen], [t.displacement / factor for t in chosen]
        plot.plot(x, y, style, color=colour, label=label)
    plot.set_xlabel("Factor on the strength F")
    plot.set_ylabel(f"Largest displacement [{unit}]")
    plot.set_ylim(bottom=0.0)
    plot.set_title(f"Factor of safety {0.5 * (low + high):.3f} ± {0.5 * (high - low):.3f}", loc="left")
    plot.legend(loc="best")
    return figure


def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog=TOOL, description="Factor of safety of a case by reduction of its strength."
    )
    parser.add_argument("case", metavar="CASE.toml")
    parser.add_argument("--tolerance", type=words.positive, default=0.02, help="half of what is left open (default 0.02)")
    parser.add_argument(
        "--most", type=words.positive, default=10.0, metavar="F", help="the search ends at F and 1/F (default 10)"
    )
    parser.add_argument(
        "--jump", type=words.positive, default=3.0, metavar="TIMES", help="more displacement than this is failure (default 3)"
    )
    parser.add_argument("--material", action="append", metavar="NAME", help="reduce this one only; may be repeated")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of the case")
    parser.add_argument(
        "--berm", metavar="PATH", help="the program (default: build/release/berm of the source tree, else from PATH)"
    )
    parser.add_argument("--out", type=words.given, metavar="DIR", help="default: out/<name of the case>_safety")
    options = parser.parse_args(arguments)
    if options.tolerance < LEAST_TOLERANCE:
        parser.error(f"--tolerance must be at least {LEAST_TOLERANCE}: trials are told apart by four digits")
    if options.most <= 1.0:
        parser.error("--most must be larger than 1: the search goes from 1/F to F")
    if not os.path.isfile(options.case):
        parser.error(f"{options.case}: is not a file (every trial reads it)")
    end_runs_with_the_tool()
    name = os.path.splitext(os.path.basename(options.case))[0]
    try:
        search = Search(options, find_berm(options.berm), options.out or os.path.join("out", f"{name}_safety"))
        low, high = search.find()
        search.write_figure(low, high)
    except NoFactor as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for line in next(trial.warnings for trial in search.trials if trial.factor == low):
        print(f"the run that stands at F = {low:.4g}: {line}", file=sys.stderr)
    print(f"factor of safety {0.5 * (low + high):.3f} +- {0.5 * (high - low):.3f}")
    print(os.path.join(search.out, "factor_of_safety.csv"))
    return 0


if __name__ == "__main__":
    words.run(main, TOOL)
