"""What the defaults of a case cost and keep: every example with them, and with those of version 0.1.0 in their place.

    python3 bench/defaults.py build/release/berm [case.toml ...] [--out folder] [--limit 600]

Cases and their shorter forms are those of examples/ci.txt unless named. Only what `berm check` says was chosen differs: linear
functions, each point's own volumetric strain, updated Lagrangian, lumped mass. Seconds of the processor, largest memory, balance of
energy and what the transfer between points and grid took, over the largest energy of the run.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests")]
from berm.results import ResultError, Run  # noqa: E402
from examples import read_list  # noqa: E402

OLD = {
    "grid.shape_functions": "linear",
    "model.volumetric": "standard",
    "model.formulation": "updated_lagrangian",
    "dynamics.mass": "lumped",
}


def chosen(berm, case, sets):
    """Keys that the case leaves open and that are not as they were: {key: value now}."""
    text = subprocess.run([berm, "check", case, *sets], capture_output=True, text=True, check=False).stdout
    found = {}
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["chosen"] and words[1] in OLD and "as the case says" not in line:
            found[words[1]] = line.split('"')[1]
    return {key: value for key, value in found.items() if value != OLD[key]}


def measure(berm, case, sets, out, limit):
    """(seconds, MB, energy error, transfer) or the reason why not."""
    with open(f"{out}.log", "w", encoding="utf-8") as log:
        process = subprocess.Popen(["timeout", str(limit), berm, "run", case, "--force", "--out", out, *sets], stdout=log, stderr=log)
        _, status, usage = os.wait4(process.pid, 0)
    try:
        run = Run(out)
    except ResultError as error:
        return str(error)
    h = run.history
    kinetic = h["kinetic_energy"] if "kinetic_energy" in h else np.zeros_like(h["time"])
    largest = max(np.abs(h["external_work"]).max(), (kinetic + h["elastic_energy"] + h["dissipated_energy"]).max()) or 1.0
    transfer = abs(h["transfer_energy"][-1]) / largest if "transfer_energy" in h else float("nan")
    ended = "" if os.waitstatus_to_exitcode(status) == 0 else f", ends at t = {h['time'][-1]:.3g}"
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, h["energy_error"][-1], transfer, ended


def text_of(r):
    if isinstance(r, str):
        return r
    seconds, memory, error, transfer, ended = r
    lost = "" if np.isnan(transfer) else f", transfer {100 * transfer:.2g} %"
    return f"{seconds:.0f} s, {memory:.0f} MB, balance {100 * error:.2g} %{lost}{ended}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("berm")
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--out")
    parser.add_argument("--limit", type=float, default=600.0)
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    berm = str(pathlib.Path(options.berm).resolve())
    out = pathlib.Path(options.out or tempfile.mkdtemp()).resolve()
    out.mkdir(parents=True, exist_ok=True)
    print("| case | chosen | before | now | seconds | memory |\n|---|---|---|---|---|---|")
    for name, words in read_list().items():
        if options.cases and name not in options.cases:
            continue
        case = str(ROOT / "examples" / name)
        if "_fem" in name or "/fem" in name:
            continue
        sets = [w for word in words for w in ("--set", word)]
        now = chosen(berm, case, sets)
        if not now:
            continue
        folder = str(out / name.replace("/", "_").removesuffix(".toml"))
        old = [w for key in now for w in ("--set", f"{key}={OLD[key]}")]
        before, after = (measure(berm, case, [*sets, *more], folder + tail, options.limit) for more, tail in ((old, "_before"), ([], "")))
        ratios = ["", ""]
        if not isinstance(before, str) and not isinstance(after, str):
            ratios = [f"x {after[k] / before[k]:.2f}" for k in (0, 1)]
        print(f"| {name} | {', '.join(now.values())} | {text_of(before)} | {text_of(after)} | {ratios[0]} | {ratios[1]} |", flush=True)


if __name__ == "__main__":
    main()
