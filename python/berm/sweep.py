"""Runs variants of cases and compares them.

    python3 -m berm.sweep SWEEP.toml [--only NAME,NAME] [--berm PATH] [--out DIR] [--jobs N] [--short] [--force]

The format of SWEEP.toml is in docs/output.md. Every variant runs in DIR/NAME (default: out/<name of the sweep file>), as by
`berm run`, which replaces the results of a run that came to its end only with --force.
Prints the metrics of all, writes DIR/sweep.csv and DIR/report.html.
Exit code 1: a variant failed; 2: the input is wrong.
"""

import argparse
import concurrent.futures
import csv
import json
import os
import re
import sys
import tomllib

from berm import words
from berm.errors import ResultError
from berm.files import may_never_end, new_file
from berm.program import end_runs_with_the_tool, find_berm, run_case
from berm.report import write_report
from berm.results import Run

TOOL = "berm sweep"
KEYS = {"case": str, "set": list, "short": list}
NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")
OWN_FILES = (".csv", ".html", ".png", ".gif")  # of the sweep itself, beside the folders of its variants


def check_variant(name, variant):
    """A ResultError says what is wrong with an entry of a sweep file, and where."""
    shown = json.dumps(name, ensure_ascii=False)  # with \n and the like in one line
    if not NAME.fullmatch(name):
        raise ResultError(
            f"the name {shown} of a variant must be made of letters, digits, _, - and dots, and not begin with a dot: "
            "it is that of a folder"
        )
    if name.endswith(OWN_FILES):
        ending = os.path.splitext(name)[1]
        raise ResultError(f"the name {shown} of a variant must not end with {ending}: the sweep writes such files")
    if not isinstance(variant, dict):
        raise ResultError(f"the variant {name} must be a table: [variant.{name}]")
    for key, value in variant.items():
        if key not in KEYS:
            raise ResultError(f"unknown key {key} in [variant.{name}] (known: {', '.join(KEYS)})")
        if not isinstance(value, KEYS[key]) or (KEYS[key] is list and not all(isinstance(v, str) for v in value)):
            kind = "a string" if KEYS[key] is str else "a list of strings"
            raise ResultError(f"{key} in [variant.{name}] must be {kind}")
    if "case" not in variant:
        raise ResultError(f"[variant.{name}] has no case")


def check_content(content):
    unknown = set(content) - {"title", "variant"}
    if unknown:
        raise ResultError(f"unknown key {sorted(unknown)[0]} (known: title, variant)")
    if not isinstance(content.get("title", ""), str):
        raise ResultError("title must be a string")
    variants = content.get("variant")
    if not variants:
        raise ResultError("no [variant.NAME]")
    if not isinstance(variants, dict):
        raise ResultError("variants must be tables with names: [variant.NAME]")
    for name, variant in variants.items():
        check_variant(name, variant)


def read_sweep(path):
    """(title, {name: {case, set, short}}), case paths resolved against the file."""
    if may_never_end(path):
        raise ResultError(f"{path}: is not a file")
    try:
        with open(path, "rb") as file:
            content = tomllib.load(file)
    except (OSError, ValueError, RecursionError) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    try:
        check_content(content)
    except ResultError as error:
        raise ResultError(f"{path}: {error}") from None
    folder, variants = os.path.dirname(path), content["variant"]
    return content.get("title", os.path.basename(path)), {
        name: {**variant, "case": os.path.join(folder, variant["case"])} for name, variant in variants.items()
    }


def run_variant(berm, variant, out, options):
    """Runs one variant; returns "" or why it failed."""
    overrides = variant.get("set", []) + (variant.get("short", []) if options.short else [])
    result = run_case(berm, variant["case"], out, overrides, options.force)
    if result.returncode != 0:
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        return f"exit code {result.returncode}" + (f": {lines[-1]}" if lines else "")
    return shortcoming(out)


def shortcoming(out):
    """Why the results in a folder are none; "" if they are."""
    try:
        status, reason = (Run(out).summary.get(key, "") for key in ("status", "reason"))
    except ResultError as error:
        return str(error)
    return f"status {status or 'missing'}: {reason}" if status not in ("done", "stopped") else ""


def metrics_table(runs):
    """(header, rows): one row a run, one column a metric of summary.json."""
    keys = []
    for run in runs.values():
        keys += [key for key in run.summary.get("metrics", {}) if key not in keys]
    header = ["variant", "status", *keys, "wall_seconds [s]"]
    rows = []
    for name, run in runs.items():
        metrics = run.summary.get("metrics", {})
        rows.append(
            [name, run.summary.get("status", ""), *(metrics.get(key) for key in keys), run.summary.get("wall_seconds")]
        )
    return header, rows


def print_table(header, rows):
    """Metrics down, variants across: names of metrics are long and variants are few."""
    text = lambda value: (
        "-" if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)
    )  # noqa: E731
    lines = [[header[k], *(text(row[k]) for row in rows)] for k in range(len(header))]
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    for line in lines:
        print("  ".join([line[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(line[1:], widths[1:]))]))


def sweep(options):
    title, variants = read_sweep(options.sweep)
    all_names = list(variants)
    if options.only:
        wanted = options.only.split(",")
        missing = [name for name in wanted if name not in variants]
        if missing:
            raise ResultError(f"{options.sweep}: no variant {missing[0]} (there are: {', '.join(variants)})")
        variants = {name: variants[name] for name in wanted}
    berm = find_berm(options.berm)
    out = options.out or os.path.join("out", os.path.splitext(os.path.basename(options.sweep))[0])

    failures, runs = {}, {}
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        jobs = {
            name: pool.submit(run_variant, berm, v, os.path.join(out, name), options) for name, v in variants.items()
        }
        try:
            for name, job in jobs.items():
                reason = job.result()
                print(f"{name}: {'failed, ' + reason if reason else 'done'}", flush=True)
                if reason:
                    failures[name] = reason
                else:
                    runs[name] = Run(os.path.join(out, name))
        except BaseException:  # Ctrl-C ends the sweep, not only the variants that are running
            pool.shutdown(cancel_futures=True)
            raise
    for name in all_names:  # those that were run before stay in the table
        if name not in runs and not shortcoming(os.path.join(out, name)):
            runs[name] = Run(os.path.join(out, name))
    runs = {name: runs[name] for name in all_names if name in runs}
    if runs:
        header, rows = metrics_table(runs)
        print()
        print_table(header, rows)
        with new_file(os.path.join(out, "sweep.csv")) as file:
            csv.writer(file, lineterminator="\n").writerows(
                [header, *(["nan" if v is None else v for v in row] for row in rows)]
            )
        print()
        print(write_report([run.path for run in runs.values()], os.path.join(out, "report.html"), title=title))
    for name, reason in failures.items():
        print(f"error: {name} failed: {reason}", file=sys.stderr)
    return 1 if failures else 0


def main(arguments=None):
    parser = argparse.ArgumentParser(prog=TOOL, description="Runs variants of cases and compares them.")
    parser.add_argument("sweep", metavar="SWEEP.toml")
    parser.add_argument("--only", type=words.given, metavar="NAME,NAME", help="these variants only")
    parser.add_argument(
        "--berm", metavar="PATH", help="the program (default: build/release/berm of the source tree, else from PATH)"
    )
    parser.add_argument("--out", type=words.given, metavar="DIR", help="default: out/<name of the sweep file>")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="variants at the same time (default 1)")
    parser.add_argument("--short", action="store_true", help="apply the `short` overrides of the variants")
    parser.add_argument("--force", action="store_true", help="replace the results of runs that came to their end")
    options = parser.parse_args(arguments)
    end_runs_with_the_tool()
    if options.jobs < 1:
        parser.error("--jobs must be at least 1")
    try:
        return sweep(options)
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    words.run(main, TOOL)
