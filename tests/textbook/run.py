#!/usr/bin/env python3
"""Runs textbook problems with default settings, with the best ones and with finite elements, beside the right values.

    run.py BERM [NAME ...] [--best] [--fem] [--no-default] [--jobs 1] [--limit 180] [--out out/textbook] [--markdown docs/defaults.md]
    run.py BERM --write-before tests/textbook/before.csv      what is in --out becomes the column "before"

Problems are in problems.py. Runs and their values stay in --out, so that single rows can be renewed; the table is that of
all that is there. A run that fails is a row with its reason.
"""

import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from problems import PROBLEMS  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
BEFORE = HERE / "before.csv"
MODES = ("default", "best", "fem")

HEAD = """# Defaults

Textbook problems as a user would write them, run with nothing chosen: no option of the shape functions, the volumetric strain, the formulation, the
integration in time, the solver or the stiffness of contact. Beside them: the options that serve best, and the same file with finite elements.
Written by `tests/textbook/run.py`; files and sources of the right values are in [`tests/textbook/`](../tests/textbook).

*Before* is version 0.1.0. A value is right if it is within the tolerance (3 % unless the problem says otherwise) and the run came to its end. Seconds are those of the
processor.

```sh
tests/textbook/run.py build/release/berm --best --fem --markdown docs/defaults.md
```

What is not right with defaults in November 2026, and why: `bar_drawn` tears off at a stretch of 1.95 (boxes of cpGIMP; `cpdi` and `b2gimp` hold, and the run says that it
stopped); `footing_sand`, `vertical_cut` (F-bar on these cells: 6 to 7 % on the unsafe side); `footing` (the edge of a rigid footing: contact);
`bending_strip`, `bending_rollers` (cells of 10 mm: 4.58 and 4.30 MPa with 5 mm; beams under a constant moment have many equilibria, [damage](theory/damage.md)); `contact_small_strain`, `contact_total_lagrangian`
(contact acts at nodes, not on the surface; the last is refused with its remedy); `dam_break` (no numerical damping: 25 % ahead of a test with gate and friction).

The fifteen problems without a value *before* were posed by somebody who had not built the program, with defaults only. What was wrong then (a block that was dragged over
another one jammed: normals at its ends; heat of friction of a block that chatters: 14 % missing) is mended.

Retaining walls with defaults, Rankine's values, 20 cells a height (`tests/textbook/walls.py`; second half of the movement, last value, largest jump of the reaction in a step):

| wall | angle | c [kPa] | right [kN/m] | second half | last | largest jump |
|---|---|---|---|---|---|---|
| active | 20 | 0.1 | 18.96 | -0.7 % | -0.9 % | 0.0 % |
| active | 20 | 5 | 5.2 to 7.78 | 6.53 | 6.52 | 0.1 % |
| active | 30 | 0.1 | 12.85 | +0.5 % | +0.6 % | 0.2 % |
| active | 30 | 5 | 1.5 to 4.08 | 3.19 | 3.17 | 1.4 % |
| active | 40 | 0.1 | 8.35 | +11.6 % | +11.3 % | 2.1 % |
| active | 40 | 5 | 0 to 1.75 | 1.54 | 1.34 | 11.8 % |
| passive | 20 | 0.1 | 80.61 | +2.4 % | +3.4 % | 1.9 % |
| passive | 20 | 5 | 108.60 | +2.3 % | +2.9 % | 3.5 % |
| passive | 30 | 0.1 | 118.41 | +0.2 % | +1.5 % | 3.8 % |
| passive | 30 | 5 | 152.36 | +0.1 % | +0.5 % | 3.9 % |
| passive | 40 | 0.1 | 181.32 | -1.5 % | stops at 74 % | 3.4 % |
| passive | 40 | 5 | 223.35 | -4.5 % | -7.9 % | 3.3 % |

With a cohesion of 5 kPa the active force lies between that of soil that bears tension, $K_a \\gamma H^2/2 - 2c\\sqrt{K_a}H$, and of soil that bears none. The sand does not dilate: at 40 degrees
that is far from associated flow, for which alone Rankine's force is the only one (active, 40, 0.1 kPa with `dilatancy_angle = 40`: -0.5 % to the end).

Energy at the end of the dynamic examples as ./test runs them (`energy_error`; what the transfer between points and grid took, over the largest energy): dam D0 0.0 and 0.0 %, D1 0.4 and 6 %
(B-splines 0.8 and 8, CPDI 0.4 and 7), D1 thrown 0.7 and 16, dam in space 0.1 and 0.0, columns of aluminium bars 4 to 5 and 8 to 9, dam break 1.2 and 3 %.

"""


class Run:
    """history.csv of a run, by names without units."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        with open(self.folder / "history.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        names = [re.sub(r"\s*\[[^\]]*\]$", "", n) for n in rows[0]]
        data = np.array([[float(v or "nan") for v in row] for row in rows[1:] if len(row) == len(names)])
        self.columns = dict(zip(names, data.T)) if len(data) else {n: np.array([math.nan]) for n in names}
        summary = self.folder / "summary.json"
        self.summary = json.loads(summary.read_text(encoding="utf-8")) if summary.is_file() else {"status": "running"}

    def __getitem__(self, name):
        return self.columns[name]

    def last(self, name):
        return float(self[name][-1])

    def at(self, name, time):
        """Linear between rows; nan before the first and after the last."""
        return float(np.interp(time, self["time"], self[name], left=math.nan, right=math.nan))

    def highest(self, name):
        return float(np.nanmax(self[name]))


def execute(command, limit, log):
    """(seconds of processor, exit code or None if the limit of these was reached, or six times that on the clock)."""
    with open(log, "wb") as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5)))
        late = threading.Event()

        def kill():
            late.set()
            os.killpg(process.pid, signal.SIGKILL)

        timer = threading.Timer(6 * limit, kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, None if late.is_set() or process.returncode == -signal.SIGXCPU else process.returncode


def last_words(log):
    lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines or ["no output"])[-1][-160:]


def run(berm, problem, mode, out, limit):
    """{value, seconds, reason}: reason is empty if the run came to its end."""
    folder = out / problem.name / mode
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    case = HERE / problem.file
    sets = {"default": (), "best": problem.best or (), "fem": ("method=fem", *problem.fem_sets)}[mode]
    words = [word for s in sets for word in ("--set", s)]
    log = folder / "terminal.txt"
    command = [str(berm), "run", str(case), "--quiet", "--out", str(folder), *words]
    if problem.factor:
        command = [str(berm), "factor_of_safety", str(case), "--berm", str(berm), "--out", str(folder), *words]
    seconds, code = execute(command, limit, log)
    result = {"value": None, "seconds": round(seconds, 1), "reason": ""}
    try:
        if code is None:
            result["reason"] = f"not finished after {limit:g} s"
        if problem.factor:
            found = re.search(r"^factor of safety ([0-9.]+)", log.read_text(encoding="utf-8"), re.M)
            result["value"] = float(found[1]) if found else None
            result["reason"] = result["reason"] or ("" if found else last_words(log))
            return result
        done = Run(folder)
        value = float(problem.read(done))
        result["value"] = value if math.isfinite(value) else None
        if not result["reason"] and not problem.may_stop and (code or done.summary["status"] != "done"):
            result["reason"] = f"stops at t = {done.last('time'):.3g}"
    except Exception as error:  # noqa: BLE001  whatever is wrong with a run belongs to its row
        result["reason"] = result["reason"] or (last_words(log) if log.stat().st_size else f"{type(error).__name__}: {error}")
    for frame in folder.glob("*.*vtu"):
        frame.unlink()
    return result


def deviation(problem, value):
    return None if value is None else (value - problem.right) / (problem.scale or problem.right)


def is_right(problem, result):
    off = deviation(problem, result["value"])
    return off is not None and not result["reason"] and abs(off) <= problem.tolerance


def number(value):
    return "-" if value is None else f"{value:.4g}"


def shown(problem, result, with_seconds=False):
    if result is None:
        return ""
    off = deviation(problem, result["value"])
    text = number(result["value"])
    if result["reason"]:  # the value is that of the last step that was found
        text = (text + ", " if off is not None else "") + result["reason"].replace("|", "/")
    elif off is not None:
        text += f" ({100 * off:+.1f} %)"
    return text + (f", {result['seconds']:.0f} s" if with_seconds else "")


def read_before():
    if not BEFORE.is_file():
        return {}
    with open(BEFORE, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {r["name"]: {"value": float(r["value"]) if r["value"] else None, "seconds": float(r["seconds"]), "reason": r["reason"]} for r in rows}


def write_before(path, results, version):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["name", "value", "deviation", "seconds", "reason", "version"])
        for p in PROBLEMS:
            r = results.get(p.name, {}).get("default")
            if r:
                off = deviation(p, r["value"])
                writer.writerow([p.name, r["value"] if r["value"] is not None else "", f"{off:.4f}" if off is not None else "", r["seconds"], r["reason"], version])


def verdict(problem, before, rows):
    now = rows.get("default")
    if not now:
        return "" if before is None else ("right" if is_right(problem, before) else "wrong")
    return "right" if is_right(problem, now) else "wrong"


def table(results, before):
    lines = ["| problem | right | before | default | best | FEM | verdict |", "|---|---|---|---|---|---|---|"]
    for p in PROBLEMS:
        rows = results.get(p.name, {})
        old = before.get(p.name)
        best = shown(p, rows.get("best")) + (f": {', '.join(p.best)}" if p.best and rows.get("best") else "")
        tolerance = "" if p.tolerance == 0.03 else f" ± {100 * p.tolerance:g} %"
        zero = f" (of {number(p.scale)})" if p.scale and not p.right else ""
        lines.append(
            f"| [{p.name}](../tests/textbook/{p.file}): {p.what} | {number(p.right)} {p.unit}{zero}{tolerance} | {shown(p, old, True)} | "
            f"{shown(p, rows.get('default'), True)} | {best} | {shown(p, rows.get('fem')) if p.fem else ''} | {verdict(p, old, rows)} |"
        )
    counts = []
    for title, pick in (("before", lambda p: before.get(p.name)), *((m, lambda p, m=m: results.get(p.name, {}).get(m)) for m in MODES)):
        chosen = [(p, pick(p)) for p in PROBLEMS if pick(p)]
        if chosen:
            counts.append(f"{title}: {sum(is_right(p, r) for p, r in chosen)} of {len(chosen)} right")
    return lines, "; ".join(counts)


def main():
    parser = argparse.ArgumentParser(description="Runs textbook problems beside their right values.")
    parser.add_argument("berm", metavar="BERM", help="the program")
    parser.add_argument("names", nargs="*", metavar="NAME", help="problems (default: all)")
    parser.add_argument("--best", action="store_true", help="with the best options too")
    parser.add_argument("--fem", action="store_true", help="with finite elements too")
    parser.add_argument("--no-default", action="store_true", help="leave out the default settings")
    parser.add_argument("--missing", action="store_true", help="only runs that are not in --out yet")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=180.0, help="seconds of the processor a run may take")
    parser.add_argument("--out", default="out/textbook")
    parser.add_argument("--markdown", metavar="FILE")
    parser.add_argument("--write-before", metavar="FILE")
    parser.add_argument("--release", default="0.1.0", help="of the program, for --write-before (default 0.1.0)")
    options = parser.parse_intermixed_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    berm = pathlib.Path(options.berm).resolve()
    known = {p.name: p for p in PROBLEMS}
    unknown = [n for n in options.names if n not in known]
    if unknown:
        sys.exit(f"no problem {', '.join(unknown)}; there are {', '.join(known)}")
    out = pathlib.Path(options.out).resolve()
    out.mkdir(parents=True, exist_ok=True)
    store = out / "results.json"
    results = json.loads(store.read_text()) if store.is_file() else {}

    if not options.write_before:
        modes = [m for m, on in zip(MODES, (not options.no_default, options.best, options.fem)) if on]
        jobs = [
            (known[n], m)
            for n in options.names or known
            for m in modes
            if (m != "fem" or known[n].fem) and (m != "best" or known[n].best is not None)
            and not (options.missing and m in results.get(n, {}))
        ]
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            runs = {pool.submit(run, berm, p, m, out, options.limit): (p, m) for p, m in jobs}
            for job in concurrent.futures.as_completed(runs):
                p, m = runs[job]
                if store.is_file():  # another run may have written meanwhile
                    results = json.loads(store.read_text())
                results.setdefault(p.name, {})[m] = job.result()
                store.write_text(json.dumps(results, indent=1))
                r = results[p.name][m]
                print(f"{p.name:24s} {m:8s} right {number(p.right):>10s}  {'ok   ' if is_right(p, r) else 'WRONG'} {shown(p, r, True)}", flush=True)

    if options.write_before:
        write_before(options.write_before, results, options.release)
    lines, counts = table(results, read_before())
    if options.markdown:
        pathlib.Path(options.markdown).write_text("\n".join([HEAD, f"{len(PROBLEMS)} problems; {counts}.", "", *lines, ""]), encoding="utf-8")
    print(counts)


if __name__ == "__main__":
    main()
