#!/usr/bin/env python3
"""Runs `berm check` on every malformed file here: run.py BERM

Every file of expected.tsv must end with exit code 2 and the expected message on stderr, in a bounded time, without a
crash and without a word from a sanitizer; the good*.toml must pass, so that each failure is due to what was changed.
"""

import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SANITIZER = re.compile(r"Sanitizer|runtime error:|terminate called|Assertion|Segmentation")
PLACE = re.compile(r"^\S+\.toml:\d+:\d+: ", re.MULTILINE)


def check(berm, name, expected):
    """Empty if the file fails as it should, else what is wrong."""
    try:
        done = subprocess.run([berm, "check", name], cwd=HERE, capture_output=True, timeout=120)
    except subprocess.TimeoutExpired:
        return "no answer after 120 s"
    errors = done.stderr.decode("utf-8", "replace")
    everything = errors + done.stdout.decode("utf-8", "replace")
    wanted_code = 2 if expected else 0
    if SANITIZER.search(everything):
        return "crash or sanitizer report:\n" + everything
    if done.returncode != wanted_code:
        return f"exit code {done.returncode}, not {wanted_code}:\n{everything}"
    if not re.search(".*".join(re.escape(part) for part in expected.split(" ... ")), errors):
        return f"expected: {expected}\n     got: {errors.strip()}"
    if re.search(r"\.toml:\d", expected) and not PLACE.search(errors):
        return f"no file:line:column in: {errors.strip()}"
    return ""


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    berm = str(pathlib.Path(sys.argv[1]).resolve())
    lines = (HERE / "expected.tsv").read_text(encoding="utf-8").splitlines()
    table = [line.split("\t") for line in lines if line and not line.startswith("#")]
    good = ["good.toml", "good_solid.toml", "good_references.toml"]
    listed = {name for name, _ in table} | {*good, "base_cycle_2.toml"}
    cases = [(name, "") for name in good] + table
    failures = [(name, why) for name, text in cases if (why := check(berm, name, text))]
    failures += [(p.name, "not in expected.tsv") for p in sorted(HERE.glob("*.toml")) if p.name not in listed]
    for name, why in failures:
        print(f"FAILED {name}: {why}")
    print(f"{len(cases) - len(failures)} passed, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
