#!/usr/bin/env python3
"""Runs or checks the cases of examples/ and compares the runs with their expected values.

    examples.py BERM [--out DIR] [NN_name/case.toml ...]     default: all of examples/*/*.toml
    examples.py BERM --check-list                            only whether examples/ci.txt fits the files

A case listed in examples/ci.txt is run and compared with expected_<case>.csv beside it (docs/output.md); every other one is
only built and validated by `berm check`. A line of ci.txt is a path, and after it, if wanted, overrides for the run:

    02_brazilian_disc/mpm.toml steps.count=50

Sweep files (with [variant.*]) have each of their variants checked.
"""

import argparse
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
COMPARE = ROOT / "tools" / "compare_csv.py"


def read_list():
    """{path in examples/: overrides} of ci.txt"""
    lines = (EXAMPLES / "ci.txt").read_text(encoding="utf-8").splitlines()
    words = [shlex.split(line, comments=True) for line in lines]
    return {w[0]: w[1:] for w in words if w}


def expected_file(name):
    path = EXAMPLES / name
    return path.parent / f"expected_{path.stem}.csv"


def list_problems(listed):
    """What is wrong with ci.txt and the expected files."""
    problems = []
    for name in listed:
        if not (EXAMPLES / name).is_file():
            problems.append(f"examples/ci.txt lists {name}, which does not exist")
        elif not expected_file(name).is_file():
            problems.append(f"examples/ci.txt lists {name}, but there is no {expected_file(name).name}")
    for path in sorted(EXAMPLES.glob("*/expected*.csv")):
        case = path.parent / (path.stem.removeprefix("expected_") + ".toml")
        if not case.is_file():
            problems.append(f"{path.relative_to(EXAMPLES)} belongs to no case: there is no {case.name}")
    return problems


def call(command):
    """Empty if the command succeeds, else its last words."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    text = done.stdout.decode("utf-8", "replace").strip()
    if done.returncode == 0:
        return ""
    return f"{shlex.join(str(c) for c in command)}\nended with {done.returncode}:\n" + text[-3000:]


def sets(overrides):
    return [word for o in overrides for word in ("--set", o)]


def check_sweep(berm, path, variants):
    for name, variant in variants.items():
        why = call([berm, "check", path.parent / variant["case"], *sets(variant.get("set", []))])
        if why:
            return f"variant {name}: {why}"
    return ""


def test_case(berm, name, listed, out):
    """Empty if the case does what it should, else what is wrong."""
    path = EXAMPLES / name
    with open(path, "rb") as file:
        variants = tomllib.load(file).get("variant")
    if variants:
        return check_sweep(berm, path, variants)
    if name not in listed:
        return call([berm, "check", path])
    folder = pathlib.Path(out) / pathlib.Path(name).with_suffix("")
    return call([berm, "run", path, "--quiet", "--force", "--out", folder, *sets(listed[name])]) or call(
        [sys.executable, COMPARE, folder, expected_file(name)]
    )


def main():
    parser = argparse.ArgumentParser(description="Runs or checks the cases of examples/.")
    parser.add_argument("berm", metavar="BERM", help="the program")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="path in examples/")
    parser.add_argument("--out", metavar="DIR", help="where the runs go (default: a temporary folder)")
    parser.add_argument("--check-list", action="store_true", help="only check examples/ci.txt")
    options = parser.parse_intermixed_args()
    berm = pathlib.Path(options.berm).resolve()
    listed = read_list()
    if options.check_list:
        problems = list_problems(listed)
        print("\n".join(problems) or f"{len(listed)} cases listed")
        return 1 if problems else 0

    names = options.cases or sorted(str(p.relative_to(EXAMPLES)) for p in EXAMPLES.glob("*/*.toml"))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    failed = 0
    with tempfile.TemporaryDirectory() as temporary:
        for name in names:
            why = test_case(berm, name, listed, options.out or temporary)
            failed += bool(why)
            print(f"{'FAILED' if why else 'ok'} {name}{': ' + why if why else ''}", flush=True)
    print(f"{len(names) - failed} passed, {failed} failed")
    return 1 if failed or not names else 0


if __name__ == "__main__":
    sys.exit(main())
