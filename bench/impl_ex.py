"""Largest load (bar: dissipated energy) with IMPL-EX over that of implicit steps: specimens x tolerances x steps, for docs/theory/damage.md.

    python3 bench/impl_ex.py build/release/berm [name ...] [--out folder]

Twenty minutes on one core. A run that stops past its largest load counts; its steps are those that it took.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))
from berm.results import ResultError, Run  # noqa: E402

SPECIMENS = {
    "softening bar": ("tests/textbook/concrete_bar.toml", ()),
    "notched beam": ("tests/textbook/notched_beam.toml", ()),
    "bending, pressures": ("tests/textbook/bending_strip.toml", ()),
    "bending, rollers": ("tests/textbook/bending_rollers.toml", ()),
    "compression": ("examples/03_compression/mpm.toml", ("grid.cell_size=0.01", "steps.count=100")),
    "Brazilian disc": ("examples/02_brazilian_disc/mpm.toml", ("steps.count=200",)),
}
TOLERANCES = (0.02, 0.01, 0.005, 0.002)
TIMES = (1, 4)


def result(berm, case, sets, out):
    """(largest load [N] or dissipated energy [J], steps, seconds, whether the run came to its end)"""
    words = [berm, "run", str(ROOT / case), "--force", "--out", str(out)]
    for s in sets:
        words += ["--set", s]
    start = time.time()
    done = subprocess.run(words, capture_output=True, text=True, timeout=600, check=False)
    try:
        run = Run(out)
        value = max(abs(run.history["reaction"])) or run.history["dissipated_energy"][-1]
        return value, len(run.history["time"]) - 1, time.time() - start, done.returncode == 0
    except ResultError as error:
        raise SystemExit(f"{case}: {error}\n{done.stderr}") from None


def count_of(case, sets):
    for s in sets:
        if s.startswith("steps.count="):
            return int(s.split("=")[1])
    return tomllib.loads((ROOT / case).read_text(encoding="utf-8"))["steps"]["count"]


def of(steps, seconds, ended):
    return f"{steps}, {seconds:.0f} s{'' if ended else ', stopped'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("berm")
    parser.add_argument("names", nargs="*", metavar="name")
    parser.add_argument("--out", default=None)
    options = parser.parse_args()
    folder = pathlib.Path(options.out or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    print("| specimen | steps | implicit [N, J] | " + " | ".join(f"{t}" for t in TOLERANCES) + " |")
    print("|---" * (3 + len(TOLERANCES)) + "|")
    for name, (case, sets) in SPECIMENS.items():
        if options.names and name not in options.names:
            continue
        for times in TIMES:
            count = f"steps.count={times * count_of(case, sets)}"
            out = folder / f"{name.replace(' ', '_').replace(',', '')}_{times}"
            right, *taken = result(options.berm, case, (*sets, count, "solver.integration=implicit"), out)
            cells = []
            for tolerance in TOLERANCES:
                more = ("solver.integration=impl_ex", f"steps.error_tolerance={tolerance}", "steps.min_fraction=1e-3")
                value, *steps = result(options.berm, case, (*sets, count, *more), out)
                cells.append(f"{100.0 * (value / right - 1.0):+.1f} % ({of(*steps)})")
            print(f"| {name} | x {times} | {right:.4g} ({of(*taken)}) | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
