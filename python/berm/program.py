"""The program, started by the tools."""

import os
import shutil
import subprocess

from berm.errors import ResultError


def find_berm(given=None):
    """The given program, or that in the build folder of this source tree, or else the one in PATH."""
    built = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "build", "release", "berm")
    berm = given or (os.path.normpath(built) if os.path.isfile(built) else "berm")
    if not shutil.which(berm):
        raise ResultError(f"cannot find the program {berm}: build it, or name it with --berm")
    return berm


def run_case(berm, case, out, overrides, force):
    """Runs a case; returns what subprocess.run does. The program judges what is in the folder: without `force` it refuses the
    results of a run that came to its end, and it replaces nothing but what runs write."""
    arguments = [berm, "run", case, "--out", out]
    for override in overrides:
        arguments += ["--set", override]
    if force:
        arguments.append("--force")
    return subprocess.run(
        arguments,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="surrogateescape",
        check=False,
    )
