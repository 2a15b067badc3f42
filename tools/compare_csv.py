#!/usr/bin/python3
"""Compares a run with the values that it must reproduce.

    compare_csv.py RUN expected.csv

The quantities of expected.csv are described in docs/output.md. Prints a table.
Exit code 1: a value is off; 2: a file is missing or wrong.
"""

import argparse
import csv
import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python"))

from berm.results import ResultError, Run  # noqa: E402

COLUMNS = ["quantity", "value", "tolerance", "kind", "source"]


def column(run, name):
    if name not in run.history:
        raise ResultError(f"{run.path}/history.csv has no column {name} (there are: {', '.join(run.history)})")
    if not len(run.history[name]):
        raise ResultError(f"{run.path}/history.csv has no rows")
    return run.history[name]


def quantity(run, text):
    """The value that the run has for a quantity of expected.csv."""
    kind, found, name = text.partition(":")
    if found and kind == "max":
        return float(np.nanmax(column(run, name)))
    if found and kind == "last":
        return float(column(run, name)[-1])
    if found and kind == "max_before_peak":
        peak = run.peak_row()
        if peak is None:
            raise ResultError(f"{text}: {run.path} has no load, so no peak")
        return float(np.nanmax(column(run, name)[: peak + 1]))
    if found and kind == "history":
        name, at, time = name.rpartition("@")
        try:
            time = float(time)
        except ValueError:
            at = ""
        if not at:
            raise ResultError(f"{text}: expected history:COLUMN@TIME")
        times = column(run, "time")
        if not times[0] <= time <= times[-1]:
            return math.nan  # the run did not get there
        return float(np.interp(time, times, column(run, name)))
    metrics = run.summary.get("metrics", {})
    if not any(text in (key, key.split(" [")[0]) for key in metrics):
        raise ResultError(
            f"{text} is neither a metric of {run.path}/summary.json ({', '.join(metrics)}) "
            "nor history:, max:, last:, max_before_peak:"
        )
    value = run.metric(text)
    return math.nan if value is None else float(value)


def read_expected(path):
    """[(quantity, value, tolerance, kind, source)]"""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(line for line in file if line.strip() and not line.startswith("#"))
            if reader.fieldnames != COLUMNS:
                raise ResultError(f"{path}: the header must be {','.join(COLUMNS)}")
            rows = list(reader)
    except OSError as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    expected = []
    for row in rows:
        if None in row or None in row.values():
            raise ResultError(
                f"{path}: {row['quantity']}: every row needs {len(COLUMNS)} cells (quote a source that has commas)"
            )
        try:
            value, tolerance = float(row["value"]), float(row["tolerance"])
        except ValueError:
            raise ResultError(f"{path}: {row['quantity']}: value and tolerance must be numbers") from None
        if row["kind"] not in ("relative", "absolute"):
            raise ResultError(f"{path}: {row['quantity']}: kind must be relative or absolute")
        if not row["source"].strip():
            raise ResultError(f"{path}: {row['quantity']}: say where the value is from")
        expected.append((row["quantity"], value, tolerance, row["kind"], row["source"]))
    if not expected:
        raise ResultError(f"{path} expects nothing")
    return expected


def compare(run, expected):
    """Prints the table; True if every value is within its tolerance."""
    good = True
    print(f"{'quantity':40} {'run':>14} {'expected':>14} {'deviation':>11} {'allowed':>11}")
    for name, value, tolerance, kind, _ in expected:
        actual = quantity(run, name)
        deviation = actual - value
        if kind == "relative":
            deviation = deviation / abs(value) if value else math.copysign(math.inf, deviation) if deviation else 0.0
        within = abs(deviation) <= tolerance  # false for NaN
        good = good and within
        print(
            f"{name:40} {actual:14.7g} {value:14.7g} {deviation:+11.3e} {tolerance:11.3e}  {'ok' if within else 'OFF'}"
        )
    return good


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Compares a run with the values that it must reproduce.")
    parser.add_argument("run", metavar="RUN", help="output folder")
    parser.add_argument("expected", metavar="expected.csv")
    options = parser.parse_args(arguments)
    try:
        return 0 if compare(Run(options.run), read_expected(options.expected)) else 1
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
