#!/usr/bin/env python3
"""The same run twice, and a run that was stopped: same.py BERM [--processes 1 2 3 4] [--kills N] [--signals N] [--short] [--markdown FILE]

On the same number of processes the same case gives the same history and the same points, to the bit; so does a run that goes
on from a checkpoint. Checksums of both are compared. Ends with 1 if any differ.
"""

import argparse
import contextlib
import hashlib
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile

import runs

ITERATIVE = [*runs.SMALL, "solver.linear=iterative", "steps.count=4"]
TWICE = {
    "snap-back: disc by its gauge": ("disc", []),
    "contact: block that slides": ("sliding", []),
    "dam that slumps": ("slump", []),
    "mixed u-p": ("drawn", runs.MIXED),
    "space, multigrid": ("cylinder", ITERATIVE),
}
RESTARTED = {
    "cracks in space, IMPL-EX": ("cylinder", [*runs.SMALL, "steps.count=20"]),
    "gauge control past the peak": ("disc", []),
    "contact that opens": ("unilateral", ["steps.count=40"]),
    "friction, following pressure": ("sliding", ["steps.count=60"]),
    "held surface, CPDI": ("held", ["grid.shape_functions=cpdi"]),
    "domains that split": ("stretched", ["grid.shape_functions=cpdi"]),
    "mixed u-p, points that travel": ("drawn", runs.MIXED),
    "stages with motion": ("thrown", []),
    "bodies on each other": ("stacked", []),
    "ties between bodies": ("joined", []),
    "FEM in space": ("fem_solid", ["steps.count=30"]),
}


def checksum(folder):
    """Of the history and of the points at the end, without what differs by design: nothing."""
    digest = hashlib.sha256((folder / "history.csv").read_bytes())
    for _, path in runs.Run(folder).frames[-1:]:
        files = sorted(pathlib.Path(path).parent.glob(pathlib.Path(path).stem + "*.vtu"))
        for file in files:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def run(name, label, processes, overrides, more=()):
    out = runs.fresh(label)
    return complete(name, out, processes, overrides, more)


def complete(name, out, processes, overrides, more=()):
    done = runs.call(runs.command(name, out, processes, overrides, more))
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(done.args)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return out


def twice(name, overrides, n):
    a, b = (checksum(run(name, f"{name}_{n}_{k}", n, overrides)) for k in "ab")
    return a, b


def stopped(name, overrides, n, seed):
    """Checksums of a whole run, and of one that goes on from a checkpoint of any step in its second half."""
    whole = run(name, f"{name}_{n}_whole", n, overrides)
    steps = runs.rows(whole) - 1
    at = random.Random(f"{name}{n}{seed}").randrange(steps // 2 + 1, max(steps // 2 + 2, steps))
    out = run(name, f"{name}_{n}_half", n, [*overrides, f"checkpoint.every_steps={at}"])
    complete(name, out, n, overrides, ["--restart", str(out / "checkpoint.h5")])
    return checksum(whole), checksum(out)


def ended(name, overrides, n, rng, seconds, number):
    """Checksums of a whole run and of one that gets a signal at a random time, and is gone on with then: from its last checkpoint, or anew.

    A run that is not killed says in one line that it was stopped, and how to go on, unless it has not begun."""
    overrides = [*overrides, "checkpoint.every_steps=3"]
    whole = checksum(run(name, f"{name}_{n}_alive", n, overrides))
    out = runs.fresh(f"{name}_{n}_ended")
    process = runs.start(runs.command(name, out, n, overrides))
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(rng.uniform(0.0, seconds))
    killed = number == signal.SIGKILL
    for pid in [*reversed(runs.descendants(process.pid)), process.pid] if killed else [process.pid]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)
    said = "".join(process.communicate(timeout=runs.TIMEOUT))
    begun = (out / "history.csv").exists()
    if begun and process.returncode != 0 and not killed and (process.returncode != 1 or "stopped by a signal" not in said or "--restart" not in said):
        return whole, f"{process.returncode}: {said[-500:]}"
    file = out / "checkpoint.h5"
    complete(name, out, n, overrides, ["--restart", str(file)] if file.exists() else ["--force"])
    return whole, checksum(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("berm")
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2, 3, 4])
    parser.add_argument("--short", action="store_true", help="two cases each on two processes")
    parser.add_argument("--kills", type=int, default=0, help="so many runs are killed at random times, on one and on two processes")
    parser.add_argument("--signals", type=int, default=0, help="so many runs get each of the signals that stop them, likewise")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--markdown", type=pathlib.Path)
    a = parser.parse_args()
    runs.BERM = str(pathlib.Path(a.berm).resolve())
    runs.FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="berm_same_"))
    counts = [2] if a.short else a.processes
    keep = slice(0, 2) if a.short else slice(None)
    lines, failed = [], 0
    for title, cases, work in (("the same run twice", TWICE, twice), ("stopped and gone on", RESTARTED, None)):
        lines += ["", f"| {title} | " + " | ".join(f"{n} process{'es' if n > 1 else ''}" for n in counts) + " |",
                  "|---|" + "---|" * len(counts)]
        for what, (name, overrides) in list(cases.items())[keep]:
            cells = []
            for n in counts:
                first, second = work(name, overrides, n) if work else stopped(name, overrides, n, a.seed)
                failed += first != second
                cells.append(f"{first} =" if first == second else f"{first} ≠ {second}")
            lines.append(f"| {what} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    rng = random.Random(a.seed)
    sent = {signal.SIGKILL: a.kills, **dict.fromkeys((signal.SIGHUP, signal.SIGINT, signal.SIGTERM, signal.SIGUSR1), a.signals)}
    for number, times in sent.items():
        for k in range(times):
            name, overrides = rng.choice(list(RESTARTED.values()))
            first, second = ended(name, overrides, 1 + k % 2, rng, 4.0, number)
            failed += first != second
            lines.append(f"{number.name} {k + 1}: {name} on {1 + k % 2}: " + ("equal" if first == second else f"DIFFERS: {second}"))
            print(lines[-1], flush=True)
    if a.markdown:
        a.markdown.write_text("\n".join(lines) + "\n", encoding="utf-8")
    shutil.rmtree(runs.FOLDER, ignore_errors=True)
    print(f"{failed} differ")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
