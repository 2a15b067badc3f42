"""The program, started by the tools."""

import os
import shutil
import signal
import subprocess

from berm.errors import ResultError


_running = set()
_ended = False


def end_runs_with_the_tool():
    """SIGTERM and SIGHUP end the tool as Ctrl-C does, and the runs that it has started: these end in order."""

    def end(_number, _frame):
        global _ended
        if _ended:  # a second signal would end the runs at once
            return
        _ended = True
        for process in list(_running):
            process.terminate()
        raise KeyboardInterrupt

    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:  # nohup
            signal.signal(number, end)


def find_berm(given=None):
    """The given program, or that in the build folder of this source tree, or else the one in PATH."""
    built = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "build", "release", "berm")
    berm = given or (os.path.normpath(built) if os.path.isfile(built) else "berm")
    if not shutil.which(berm):
        raise ResultError(f"cannot find the program {berm}: build it, or name it with --berm")
    return berm


def _wait_or_terminate(process, seconds=10.0):
    try:
        process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.terminate()


def run_case(berm, case, out, overrides, force):
    """Runs a case; returns its exit code and what it said to standard error. The program judges what is in the folder: without
    `force` it refuses the results of a run that came to its end, and it replaces nothing but what runs write."""
    # A name that begins with - would be an option, or standard input.
    arguments = [berm, "run", os.path.join(".", case) if case.startswith("-") else case, "--out", out]
    for override in overrides:
        arguments += ["--set", override]
    if any("\0" in word for word in arguments):
        raise ResultError(f"{case!r}, or an override of it, has a character that no command line can have")
    if force:
        arguments.append("--force")
    if _ended:
        raise KeyboardInterrupt
    process = subprocess.Popen(
        arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="surrogateescape"
    )
    _running.add(process)
    if _ended:  # meanwhile
        process.terminate()
    try:
        _, said = process.communicate()
    except BaseException:  # Ctrl-C in a terminal reaches the run too, which ends in order; another signal may not have
        if not _ended:
            _wait_or_terminate(process)
        process.wait()
        raise
    finally:
        _running.discard(process)
    return subprocess.CompletedProcess(arguments, process.returncode, stderr=said)
