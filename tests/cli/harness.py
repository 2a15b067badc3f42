"""What the tests of the command line share: a case, the program started on it, and what is wrong with how it ended."""

import json
import os
import pathlib
import re
import subprocess
import time

CASE = """
title = "block"
grid = { origin = [-0.25, -0.25], cell_size = 0.25, cells = [6, 6] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[boundary.base]
where.box = { max = [9.0, 1e-6] }
ux = 0.0
uy = 0.0
[boundary.top]
where.box = { min = [-9.0, 0.9999], max = [9.0, 1.0001] }
uy = -0.001
[steps]
count = 4
"""
LONG = CASE.replace("count = 4", "count = 10000000\nadaptive = false")
NOISE = re.compile(r"PETSC ERROR|MPI_ABORT|mpirun|mpiexec noticed|ORTE|PMIX|terminate called|Traceback|Segmentation|Caught signal")
BERM = os.environ["BERM"]
tests = []


def test(function):
    """Marks one of them. It runs in a folder of its own and returns what is wrong ("" if nothing is)."""
    tests.append(function)
    return function


def berm(*words, text=CASE, **more):
    """Writes the case and starts the program on it; returns what subprocess.run does."""
    pathlib.Path("case.toml").write_text(text)
    return subprocess.run([BERM, *words], **{"capture_output": True, "text": True, "timeout": 120, **more})


def wrong(done, code, *expected, absent=()):
    """What is wrong with how the program ended and what it said."""
    said = (done.stdout or "") + (done.stderr or "")
    if done.returncode != code:
        return f"ended with {done.returncode}, not {code}: {said[-600:]}"
    if NOISE.search(said):
        return "words of others: " + said[-600:]
    missing = [w for w in expected if w not in said]
    found = [w for w in absent if w in said]
    return (f"does not say {missing}: {said[-600:]}" if missing else "") + (f"says {found}" if found else "")


def status(folder="out/case"):
    return json.loads((pathlib.Path(folder) / "summary.json").read_text())["status"]


def files(folder):
    return sorted(p.name for p in pathlib.Path(folder).iterdir())


def rows(folder):
    try:
        return max(0, (pathlib.Path(folder) / "history.csv").read_text().count("\n") - 1)
    except OSError:
        return 0


def until(condition, process):
    end = time.monotonic() + 60
    while not condition():
        if process.poll() is not None or time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def begun(folder, *words):
    """The program, started, once the run that it makes in the folder has steps behind it."""
    process = subprocess.Popen([BERM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    if not until(lambda: rows(folder) > 2, process):
        process.kill()
        raise RuntimeError(f"{words} did not begin: {process.communicate()}")
    return process


def end_of(process):
    """As subprocess.run tells it."""
    out, errors = process.communicate(timeout=60)
    return subprocess.CompletedProcess(process.args, process.returncode, out, errors)


def shell(line):
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, timeout=120, env={**os.environ, "BERM": BERM})
