"""Processes, signals and streams: how runs and tools are started, watched and ended."""

import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import time

from harness import BERM, CASE, LONG, begun, berm, end_of, files, rows, shell, status, test, until, wrong


@test
def too_many_processes():
    """Numbers just beyond what is allowed, so that a program which starts them does no harm."""
    cores = len(os.sched_getaffinity(0))
    return (wrong(berm("run", "case.toml", "-n", str(cores + 1)), 2, f"has {cores} core", "--oversubscribe")
            or wrong(berm("run", "case.toml", "-n", str(64 * cores + 1), "--oversubscribe"), 2, "64 a core")
            or wrong(berm("run", "case.toml", "-n", str(cores + 1), "--oversubscribe", "--quiet"), 0)
            or wrong(berm("run", "case.toml", "-n", "0"), 2))


@test
def fewer_cells_than_processes():
    """Zoltan fails on some of the processes; the others waited for them for ever."""
    top = "min = [-9.0, 0.9999], max = [9.0, 1.0001]"
    for columns in (1, 2, 3):
        small = CASE.replace("max = [1.0, 1.0] }", f"max = [{0.25 * columns}, 0.25] }}", 1).replace(top, "min = [-9.0, 0.2499], max = [9.0, 0.2501]")
        for n in ("2", "4"):
            if why := wrong(berm("run", "case.toml", "--quiet", "--force", "-n", n, "--oversubscribe", text=small, timeout=60), 0):
                return f"{columns} cells, -n {n}: {why}"
    return ""


@test
def no_path():
    environment = {k: v for k, v in os.environ.items() if k not in ("PATH", "TMPDIR")}
    for path in ({}, {"PATH": ""}, {"PATH": "/nowhere"}):
        for n in ("1", "2"):
            if why := wrong(berm("run", "case.toml", "--quiet", "--force", "-n", n, "--oversubscribe", env={**environment, **path}), 0):
                return f"{path}, -n {n}: {why}"
    return ""


def stopped_by(number, *words):
    pathlib.Path("long.toml").write_text(LONG)
    shutil.rmtree("out", ignore_errors=True)
    process = begun("out/long", "run", "long.toml", "--quiet", *words)
    process.send_signal(number)
    done = end_of(process)
    why = wrong(done, 1, "stopped by a signal", "--restart out/long/checkpoint.h5")
    if not why and (status("out/long") != "stopped" or len(done.stderr.splitlines()) != 1 or "stopped by a signal" not in pathlib.Path("out/long/log.txt").read_text()):
        why = f"status {status('out/long')}, said {done.stderr}"
    if not why:
        why = wrong(berm("run", "long.toml", "--restart", "out/long/checkpoint.h5", "--set", "steps.count=4", "--quiet"), 0)
    return why and f"{number.name} {words}: {why}"


@test
def signals():
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGXCPU):
        if why := stopped_by(number):
            return why
    return stopped_by(signal.SIGHUP, "-n", "2", "--oversubscribe") or stopped_by(signal.SIGUSR1, "-n", "2", "--oversubscribe")


def catches(pid, number):
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    return bool(int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16) >> (number - 1) & 1)


@test
def signals_at_the_start():
    """While the case is read, MPI begins and the model is built."""
    pathlib.Path("long.toml").write_text(LONG)
    for words in ([], ["-n", "2", "--oversubscribe"]):
        for delay in (0.0, 0.1, 0.25, 0.5):
            shutil.rmtree("out", ignore_errors=True)
            process = subprocess.Popen([BERM, "run", "long.toml", "--quiet", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            if not until(lambda: catches(process.pid, signal.SIGTERM), process):
                return f"{words}: does not listen"
            time.sleep(delay)
            process.terminate()
            out, errors = process.communicate(timeout=60)
            if why := wrong(subprocess.CompletedProcess([], process.returncode, out, errors), 1, "stopped by a signal", "--restart out/long/checkpoint.h5"):
                return f"{words} after {delay} s: {why}"
    return ""


@test
def faults():
    """A fault has a line and the exit code of its signal."""
    pathlib.Path("long.toml").write_text(LONG)
    for number in (signal.SIGSEGV, signal.SIGFPE, signal.SIGBUS):
        shutil.rmtree("out", ignore_errors=True)
        process = begun("out/long", "run", "long.toml", "--quiet")
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        if process.returncode != -number or "a fault of the program" not in said or "PETSC" in said or len(said.splitlines()) > 1:
            return f"{number}: {process.returncode}, {said}"
    return ""


@test
def nohup():
    """A run that is not to hear of the end of its session goes on."""
    pathlib.Path("long.toml").write_text(LONG)
    process = subprocess.Popen([BERM, "run", "long.toml", "--quiet"], preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    begun = until(lambda: rows("out/long") > 2, process)
    process.send_signal(signal.SIGHUP)
    n = rows("out/long")
    lives = begun and until(lambda: rows("out/long") > n + 5, process)
    process.kill()
    process.wait()
    return "" if lives else "ended with SIGHUP"


@test
def reader_that_has_gone():
    pathlib.Path("case.toml").write_text(CASE)
    for n in ("1", "2"):
        done = shell(f'"$BERM" run case.toml --force -n {n} --oversubscribe | head -n 1 >/dev/null; exit ${{PIPESTATUS[0]}}')
        if why := wrong(done, 0) or ("" if status() == "done" else status()):
            return f"-n {n}: {why}"
        if "berm report" not in pathlib.Path("out/case/log.txt").read_text():
            return f"-n {n}: the log has not the last words"
    return wrong(shell('(sleep 0.5; exec "$BERM" schema) | true; exit ${PIPESTATUS[0]}'), 1)


@test
def full_and_closed_output():
    pathlib.Path("case.toml").write_text(CASE)
    for words in ("schema", "check case.toml", "version", "--version", "--help", "completion bash", "report --help", "sweep --help"):
        for target in ("> /dev/full", ">&-"):
            if why := wrong(shell(f'"$BERM" {words} {target}'), 1, "standard output: ", "No space left" if "full" in target else "Bad file descriptor"):
                return f"{words} {target}: {why}"
    for target in ("> /dev/full", ">&-", ">&- 2>&- <&-"):
        why = wrong(shell(f'"$BERM" run case.toml --force {target}'), 0)
        if why or status() != "done" or "berm report" not in pathlib.Path("out/case/log.txt").read_text():
            return f"run {target}: {why}"
    return ""


@test
def mpi_that_does_not_start():
    """Open MPI's own words are kept from the user: ours say how to see them. On a busy machine Open MPI loses some of them itself: several tries."""
    words = ("run", "case.toml", "-n", "2", "--oversubscribe", "--force")
    of_another = os.environ | {"OMPI_MCA_btl": "foo", "OPAL_PREFIX": "/nonexistent", "OMPI_MCA_coll": "foo", "OMPI_MCA_mca_base_component_path": "/nonexistent"}
    return (wrong(berm("run", "case.toml", env=of_another), 0)  # one process needs none of it
            or wrong(berm(*words, env=os.environ | {"OPAL_PREFIX": "/nonexistent"}), 1, "OPAL_PREFIX=/nonexistent")
            or wrong(berm(*words, env=os.environ | {"OMPI_MCA_btl": "foo"}), 1, "has not started the processes", "OMPI_MCA_orte_execute_quiet=0", "OMPI_MCA_btl=foo")
            or ("" if any("Component: foo" in berm(*words, env=os.environ | {"OMPI_MCA_btl": "foo", "OMPI_MCA_orte_execute_quiet": "0"}).stderr for _ in range(5)) else "does not show why")
            or wrong(berm(*words, "--set", "material.m.density=x"), 2, absent=["has not started"]))


def children(pid):
    """Of a process, and theirs."""
    found = [int(p) for p in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return found + [p for child in found for p in children(child)]


def is_berm(pid):
    try:
        return os.path.samefile(f"/proc/{pid}/exe", BERM)
    except OSError:
        return False


@test
def process_that_is_killed():
    """As the system does where memory runs out."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet", "-n", "2", "--oversubscribe")
    os.kill([p for p in children(process.pid) if is_berm(p)][-1], signal.SIGKILL)
    return wrong(end_of(process), 1, "ended by signal 9 (Killed)", "--restart")


@test
def little_memory():
    """Between what the program itself takes and what the linear algebra wants beside it."""
    sizes = [n << 20 for n in range(200, 1000, 50)]
    ends = []
    for size in sizes:
        done = berm("run", "case.toml", "--force", timeout=60, preexec_fn=lambda size=size: resource.setrlimit(resource.RLIMIT_AS, (size, size)))
        ends.append((size >> 20, done.returncode, done.stderr[-200:]))
        if done.returncode == 0:
            break
    said = [text for _, code, text in ends if code == 1 and "raise its limit (ulimit -v" in text]
    if not said or ends[-1][1] != 0:
        return str(ends)
    # With threads of its own OpenBLAS waits for them at the end.
    without = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    return wrong(berm("run", "case.toml", "--force", timeout=60, env=without, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (100_000_000, 100_000_000))), 1, "ulimit -d")


@test
def few_open_files():
    """Fewer than Open MPI needs: raised where that is allowed, else said."""
    def limited(soft, hard):
        return lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return (wrong(berm("run", "case.toml", "--quiet", preexec_fn=limited(10, 256)), 0)
            or wrong(berm("run", "case.toml", "--force", preexec_fn=limited(10, 10)), 1, "raise its limit (ulimit -n)")
            or wrong(berm("run", "case.toml", "--force", "-n", "2", timeout=60, preexec_fn=limited(24, 24)), 1, "raise its limit (ulimit -n)"))  # mpiexec hung


@test
def tool_that_is_ended():
    """The runs of a sweep end with it."""
    pathlib.Path("long.toml").write_text(LONG)
    pathlib.Path("sweep.toml").write_text('[variant.a]\ncase = "long.toml"\n[variant.b]\ncase = "long.toml"\n')
    for number in (signal.SIGTERM, signal.SIGHUP):
        shutil.rmtree("swept", ignore_errors=True)
        process = begun("swept/a", "sweep", "sweep.toml", "--out", "swept")
        process.send_signal(number)
        why = wrong(end_of(process), 1, "interrupted")
        if why or status("swept/a") != "stopped" or pathlib.Path("swept/b").exists():
            return f"{number.name}: {why} {status('swept/a')} {files('swept')}"
    soil = LONG.replace("linear_elastic", "mohr_coulomb").replace("poisson_ratio = 0.3", "poisson_ratio = 0.3\ncohesion = 1e5\nfriction_angle = 30.0")
    pathlib.Path("soil.toml").write_text(soil)
    process = begun("safe/F_1.0000", "factor_of_safety", "soil.toml", "--out", "safe")
    process.terminate()
    why = wrong(end_of(process), 1, "interrupted")
    return why or ("" if status("safe/F_1.0000") == "stopped" else "the run of factor_of_safety has not ended in order")


@test
def progress():
    """A line at least every five seconds, also of a run of slow steps."""
    pathlib.Path("long.toml").write_text(LONG)
    process = subprocess.Popen([BERM, "run", "long.toml"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(6.5)
    process.terminate()
    out, _ = process.communicate(timeout=60)
    return "" if re.search(r"step +\d+ +0\.\d %.* left", out) else out
