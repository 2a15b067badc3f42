#!/usr/bin/env python3
"""The command line and its habits: run.py BERM [NAMES ...]

Every function of TESTS starts the program in a folder of its own, as a careless user, a script or an attacker would, and returns what is wrong ("" if nothing
is). Exits with 1 if a test fails.
"""

import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from gmsh_text import mesh_22  # noqa: E402

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
BERM = ""


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


# ---- processes

def too_many_processes():
    """Numbers just beyond what is allowed, so that a program which starts them does no harm."""
    cores = len(os.sched_getaffinity(0))
    return (wrong(berm("run", "case.toml", "-n", str(cores + 1)), 2, f"has {cores} core", "--oversubscribe")
            or wrong(berm("run", "case.toml", "-n", str(64 * cores + 1), "--oversubscribe"), 2, "64 a core")
            or wrong(berm("run", "case.toml", "-n", str(cores + 1), "--oversubscribe", "--quiet"), 0)
            or wrong(berm("run", "case.toml", "-n", "0"), 2))


# ---- disks and folders

def limited_files(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def limit_of_file_size():
    """Stands for a full disk: what was good stays, the message names the file, no signal."""
    words = ["run", "case.toml", "--set", "checkpoint.every_steps=1", "--quiet"]
    if why := wrong(berm(*words), 0):
        return why
    whole = os.path.getsize("out/case/checkpoint.h5")
    for size in range(4096, whole, 8192):  # HDF5's own tables do not fit, or the points do not
        why = wrong(berm(*words, "--force", "--set", "output.frames=1", preexec_fn=limited_files(size)), 1, "cannot write out/case/", "ulimit -f")
        if why or "checkpoint.h5.part" in files("out/case") or any(name.endswith(".tmp") for name in files("out/case")):
            return f"{size} bytes: {why} {files('out/case')}"
    return ""


def full_disk():
    """A real one, where the user may mount it: the checkpoint before is whole."""
    os.mkdir("small")
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", "small"], capture_output=True).returncode != 0:
        print("full_disk: only root may mount one; limit_of_file_size stands for it")
        return ""
    try:
        for kilobytes in range(28, 400, 24):
            subprocess.run(["mount", "-o", f"remount,size={kilobytes}k", "small"], check=True)
            subprocess.run("rm -rf small/*", shell=True, check=True)
            done = berm("run", "case.toml", "--out", "small/out", "--set", "checkpoint.every_steps=1", "--quiet")
            if done.returncode == 0:
                return ""
            if why := wrong(done, 1, "cannot write small/out/", "No space left on device (make room"):
                return f"{kilobytes} kB: {why}"
            if "checkpoint.h5" in files("small/out"):
                again = berm("run", "case.toml", "--restart", "small/out/checkpoint.h5", "--out", "again", "--quiet", "--force")
                if why := wrong(again, 0):
                    return f"{kilobytes} kB: the checkpoint is broken: {why}"
        return "never came to its end"
    finally:
        subprocess.run(["umount", "small"], check=True)


def second_run_in_the_folder():
    pathlib.Path("long.toml").write_text(LONG)
    first = subprocess.Popen([BERM, "run", "long.toml", "--out", "shared", "--quiet"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        if not until(lambda: rows("shared") > 2, first):
            return "the first run did not begin"
        why = wrong(berm("run", "case.toml", "--out", "shared", "--force"), 2, "shared: another run is writing to this folder (process", "--out")
        pathlib.Path("alias").symlink_to("shared")
        why = why or wrong(berm("run", "case.toml", "--out", "alias"), 2, "another run is writing")
        if why or first.poll() is not None:
            return why or "the first run ended"
    finally:
        first.kill()
        first.communicate()
    return wrong(berm("run", "case.toml", "--out", "shared"), 0) or ("the lock stays" if ".lock" in files("shared") else "")


def finished_run_is_kept():
    if why := wrong(berm("run", "case.toml"), 0, "berm report out/case"):
        return why
    before = pathlib.Path("out/case/history.csv").read_bytes()
    why = wrong(berm("run", "case.toml", "--set", "steps.count=2"), 2, "out/case: holds the results of a run", "--force", "--out")
    if why or pathlib.Path("out/case/history.csv").read_bytes() != before:
        return why or "changed it all the same"
    return (wrong(berm("run", "case.toml", "--force", "--set", "checkpoint.every_steps=2"), 0)
            or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5"), 0))


def files_of_the_user_are_kept():
    """A case beside the results, a curve of the user under the name of a history, a curve in the folder that is replaced."""
    before = CASE + "# mine\n"
    why = wrong(berm("run", "case.toml", "--out", ".", text=before), 2, 'holds a file "case.toml" that is not of a run', "--out")
    if why or pathlib.Path("case.toml").read_text() != before:
        return why or "case.toml was replaced"
    for name in ("history.csv", "points_0007.vtu", "summary.json", "log.txt"):
        folder = pathlib.Path("own_" + name)
        folder.mkdir()
        (folder / name).write_text("mine\n")
        why = wrong(berm("run", "case.toml", "--out", str(folder), "--force"), 2, f'holds a file "{name}" that is not of a run')
        if why or files(folder) != [name] or (folder / name).read_text() != "mine\n":
            return why or f"{name} was touched"
    folder = pathlib.Path("beside")
    folder.mkdir()
    (folder / "notes.txt").write_text("mine\n")  # no run writes or removes such
    why = wrong(berm("run", "case.toml", "--out", str(folder)), 0)
    curve = CASE + '[output]\nreferences = ["beside/history.csv"]\n'
    return why or wrong(berm("run", "case.toml", "--out", str(folder), "--force", text=curve), 2, "holds the reference curve", "--out")


def mesh_that_has_changed():
    """A checkpoint belongs to the mesh that it was written with."""
    text = re.sub(r"grid = .*\n", "", CASE)
    text = 'method = "fem"\n' + re.sub(r"shape\.[^\n]*", 'file = "square.msh"', text)
    pathlib.Path("square.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1), (0, 1)], [(1, 2, 3, 4)]))
    why = wrong(berm("run", "case.toml", "--set", "checkpoint.every_steps=2", text=text), 0)
    why = why or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5", "--out", "again", text=text), 0)
    pathlib.Path("square.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1.01), (0, 1)], [(1, 2, 3, 4)]))
    return why or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5", "--out", "other", text=text), 2, "the file of body.a.file has changed since the checkpoint was written")


def refused_case_replaces_nothing():
    """Nor a restart that is refused, or one from elsewhere, without --force."""
    if why := wrong(berm("run", "case.toml"), 0):
        return why
    before = {name: pathlib.Path("out/case", name).read_bytes() for name in files("out/case")}
    other = CASE.replace("count = 4", "count = 8\n[checkpoint]\nevery_steps = 4")
    pathlib.Path("other.toml").write_text(other)
    outside = "pin.p={body='a',at=[9.0,9.0],fix='x'}"
    why = (wrong(berm("run", "case.toml", "--force", "--set", outside), 2, "[pin.p]")
           or wrong(berm("run", "other.toml"), 0)
           or wrong(berm("run", "other.toml", "--out", "out/case", "--restart", "out/other/checkpoint.h5"), 2, "--force replaces them")
           or wrong(berm("run", "case.toml", "--out", "out/case", "--force", "--restart", "nothing.h5"), 2, "nothing.h5"))
    lost = [name for name, content in before.items() if name != "log.txt" and (name not in files("out/case") or pathlib.Path("out/case", name).read_bytes() != content)]
    return why or (f"lost: {lost}" if lost else "")


def failed_run_makes_way():
    stops = CASE.replace("uy = -0.001", 'uy = "-0.001*t + 0*sqrt(0.5 - t + 0*x)"')  # what depends on the place is not looked at before
    return wrong(berm("run", "case.toml", text=stops), 1) or wrong(berm("run", "case.toml"), 0)


def links_are_not_followed():
    """Whoever can write to the folder must not choose which other files a run overwrites."""
    out = pathlib.Path("out/case")
    out.mkdir(parents=True)
    secret = pathlib.Path("secret")
    secret.write_text("berm kept")  # as log.txt it makes the folder one of a run
    names = ["history.csv", "log.txt", "case.toml", "case.toml.tmp", "summary.json", "summary.json.tmp", "points_0000.vtu", "points.pvd.tmp", "checkpoint.h5.part"]
    for name in names:
        (out / name).symlink_to(secret.resolve())
    os.link(secret, out / "mesh_0000.vtu")
    if why := wrong(berm("run", "case.toml", "--set", "checkpoint.every_steps=1"), 0):
        return why
    if secret.read_text() != "berm kept":
        return "wrote through a link"
    left = [p.name for p in out.iterdir() if p.is_symlink()]
    if left:
        return f"links are left: {left}"
    (out / "log.txt").unlink()
    (out / "log.txt").symlink_to(secret.resolve())
    why = wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5"), 1, "out/case/log.txt", "remove the link")
    (out / "report.html").symlink_to(secret.resolve())
    why = why or wrong(berm("report", "out/case"), 0) or ("" if secret.read_text() == "berm kept" else "the report wrote through a link")
    pathlib.Path("real").mkdir()
    pathlib.Path("chosen").symlink_to("real")  # a folder is the user's choice
    return why or wrong(berm("run", "case.toml", "--out", "chosen"), 0) or ("" if "history.csv" in files("real") else "the linked folder is empty")


def temporary_folder():
    environment = {**os.environ, "TMPDIR": "/proc/nowhere"}
    return (wrong(berm("run", "case.toml", "--quiet", env=environment), 0)
            or wrong(berm("run", "case.toml", "--quiet", "--force", "-n", "2", "--oversubscribe", env=environment), 0, "temporary files go to", "/proc/nowhere (TMPDIR)"))


def folder_of_mpi():
    """A single process makes none: those of runs side by side would be the same, and the first one that ends would remove it."""
    pathlib.Path("tmp").mkdir()
    pathlib.Path(f"tmp/ompi.{socket.gethostname().split('.')[0]}.{os.getuid()}").write_text("not a folder")
    return wrong(berm("run", "case.toml", env=os.environ | {"TMPDIR": str(pathlib.Path("tmp").resolve())}), 0)


def no_path():
    environment = {k: v for k, v in os.environ.items() if k not in ("PATH", "TMPDIR")}
    for path in ({}, {"PATH": ""}, {"PATH": "/nowhere"}):
        for n in ("1", "2"):
            if why := wrong(berm("run", "case.toml", "--quiet", "--force", "-n", n, "--oversubscribe", env={**environment, **path}), 0):
                return f"{path}, -n {n}: {why}"
    return ""


def pipe_in_the_place_of_a_summary():
    pathlib.Path("out/case").mkdir(parents=True)
    pathlib.Path("out/case/log.txt").write_text("berm 0.1.0\n")
    os.mkfifo("out/case/summary.json")
    return wrong(berm("run", "case.toml", "--quiet", timeout=60), 0)


def folder_that_is_gone():
    pathlib.Path("case.toml").write_text(CASE)
    here = os.getcwd()
    done = shell(f'mkdir gone; cd gone; rmdir ../gone; "$BERM" run {here}/case.toml --out {here}/out')
    return wrong(done, 2, "the current folder cannot be read")


def empty_words():
    """As of a variable in a script that was not set: a run must not begin anew for it."""
    if why := wrong(berm("run", "case.toml", "--set", "checkpoint.every_steps=1"), 0):
        return why
    before = pathlib.Path("out/case/history.csv").read_bytes()
    why = "".join(wrong(berm("run", "case.toml", "--force", option, ""), 2, option, "is empty") for option in ("--restart", "--out", "--set"))
    return why or ("" if pathlib.Path("out/case/history.csv").read_bytes() == before else "began anew")


# ---- signals and streams

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


def tie_that_has_ended():
    """What it held may part in the stages after it."""
    lifted = CASE[:CASE.index("[boundary.top]")] + """[body.plate]
rigid = true
shape.box = { min = [-0.1, 1.0], max = [1.1, 1.2] }
displacement = [0.0, "-0.001*min(t, 1) + 0.2*max(0, t - 1)"]
[contact.c]
body = "a"
rigid = "plate"
kind = "tie"
stages = ["one"]
[stage.one]
count = 2
[stage.two]
count = 2
"""
    return wrong(berm("run", "case.toml", text=lifted), 0, absent=["tears or crushes"])


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


def shell(line):
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, timeout=120, env={**os.environ, "BERM": BERM})


def reader_that_has_gone():
    pathlib.Path("case.toml").write_text(CASE)
    for n in ("1", "2"):
        done = shell(f'"$BERM" run case.toml --force -n {n} --oversubscribe | head -n 1 >/dev/null; exit ${{PIPESTATUS[0]}}')
        if why := wrong(done, 0) or ("" if status() == "done" else status()):
            return f"-n {n}: {why}"
        if "berm report" not in pathlib.Path("out/case/log.txt").read_text():
            return f"-n {n}: the log has not the last words"
    return wrong(shell('(sleep 0.5; exec "$BERM" schema) | true; exit ${PIPESTATUS[0]}'), 1)


def full_and_closed_output():
    pathlib.Path("case.toml").write_text(CASE)
    for words in ("schema", "check case.toml", "version", "--version", "--help", "completion bash", "report --help", "sweep --help"):
        for target in ("> /dev/full", ">&-"):
            if why := wrong(shell(f'"$BERM" {words} {target}'), 1, "No space left" if "full" in target else "Bad file descriptor"):
                return f"{words} {target}: {why}"
    for target in ("> /dev/full", ">&-", ">&- 2>&- <&-"):
        why = wrong(shell(f'"$BERM" run case.toml --force {target}'), 0)
        if why or status() != "done" or "berm report" not in pathlib.Path("out/case/log.txt").read_text():
            return f"run {target}: {why}"
    return ""


# ---- the case

def mpi_that_does_not_start():
    """Open MPI's own words are kept from the user: ours say how to see them."""
    words = ("run", "case.toml", "-n", "2", "--oversubscribe", "--force")
    return (wrong(berm(*words, env=os.environ | {"OMPI_MCA_btl": "foo"}), 1, "has not started the processes", "OMPI_MCA_orte_execute_quiet=0", "OMPI_MCA_btl=foo")
            or ("" if "Component: foo" in berm(*words, env=os.environ | {"OMPI_MCA_btl": "foo", "OMPI_MCA_orte_execute_quiet": "0"}).stderr else "does not show why")
            or wrong(berm(*words, "--set", "material.m.density=x"), 2, absent=["has not started"]))


def folder_that_is_replaced():
    """What has the name of the output folder during the run is not written to."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet")
    os.rename("out/long", "out/moved")
    os.mkdir("other")
    os.symlink("../other", "out/long")
    why = wrong(end_of(process), 1, "out/long: something else has the name of the output folder now", "--restart")
    return why or ("" if not files("other") else f"wrote {files('other')}")


def emptied_folder():
    """Results that something else removes during a run are missed."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet")
    pathlib.Path("out/long/history.csv").unlink()
    return wrong(end_of(process), 1, "out/long/history.csv: something else has removed, replaced or cut this file")


def environment_of_others():
    """Settings of PETSc, Python and matplotlib in the folder or the environment are not those of a run."""
    os.mkfifo(".petscrc")
    os.mkfifo("matplotlibrc")
    for name in ("json", "numbers", "csv", "berm"):
        pathlib.Path(f"{name}.py").write_text("raise RuntimeError('not ours')\n")
    odd = os.environ | {"PETSC_OPTIONS": "-fp_trap -options_file /nonexistent", "PETSC_OPTIONS_YAML": "{pc_type: foo}", "MPLBACKEND": "none", "BERM_PYTHON": "", "PYTHONPATH": ""}
    return (wrong(berm("run", "case.toml", timeout=60, env=odd), 0, "warning: PETSC_OPTIONS in the environment is not read")
            or wrong(berm("run", "case.toml", "--force", "-n", "2", "--oversubscribe", timeout=60, env=odd), 0)
            or wrong(berm("report", "out/case", timeout=100, env=odd), 0))


def boundary_too_narrow():
    """Gmsh throws through its parallel regions."""
    narrow = CASE.replace("max = [1.0, 1.0] }", 'max = [1.0, 0.000000000001] }\nmesh = { kind = "triangles", size = 0.02 }', 1)
    return wrong(berm("check", "case.toml", "--set", "method=fem", text=narrow), 2, "case.toml:9:7: [body.a]: Gmsh cannot mesh it")


def cells_in_one_another():
    """A grid from a file, of two squares of which one half is in both."""
    pathlib.Path("twice.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (2, 0), (2, 1), (0.5, 1)], [(1, 2, 3, 4), (5, 6, 7, 8)]), encoding="ascii")
    lying = CASE.replace("grid = { origin = [-0.25, -0.25], cell_size = 0.25, cells = [6, 6] }", 'grid.file = "twice.msh"').replace("max = [1.0, 1.0] }", "max = [0.4, 0.4] }", 1)
    return wrong(berm("check", "case.toml", text=lying), 2, "twice.msh: two cells of the grid lie in one another near (0.5, 0.5)")


def factors_without_end():
    return (wrong(berm("factor_of_safety", "case.toml", "--tolerance", "1e-18", timeout=60), 2, "--tolerance must be at least 0.0001")
            or wrong(berm("factor_of_safety", "-", timeout=60), 2, "-: is not a file"))


def options_of_petsc():
    for options in ("-log_view :F", "-ksp_view_mat binary:F", "-ksp_view_mat binary", "-options_file F", "-options_monitor", "-malloc_dump", "-info :F", "-ksp_monitor ascii:F",
                    "-prefix_push x", "-mat_mumps_ooc_tmpdir F", "-ksp_type python", "-pc_bjacobi_blocks 1000000", "F"):
        if why := wrong(berm("run", "case.toml", text=CASE + f'[solver]\npetsc = "-ksp_rtol 1e-8 {options}"\n' if options != "F" else CASE + '[solver]\npetsc = "F"\n'),
                        2, 'case.toml:22:9: "petsc" in [solver]: "', "F" if options == "F" else "--allow-petsc-files"):
            return f"{options}: {why}"
    if "F" in files("."):
        return "wrote F"
    if why := wrong(berm("run", "case.toml", "--force", text=CASE + '[solver]\npetsc = "-pc_type foo"\n'), 1, "PC type foo"):
        return why
    misspelt = CASE + '[solver]\npetsc = "-ksp_view -ksp_rtl 1e-8"\n'
    return (wrong(berm("run", "case.toml", text=misspelt), 0, 'warning: case.toml:22:9: "petsc" in [solver]', "-ksp_rtl", absent=["for -ksp_view"])
            or wrong(berm("run", "case.toml", "--force", text=misspelt.replace("-ksp_rtl 1e-8", "::ascii_info_detail")), 0, absent=["nothing asked"])
            or wrong(berm("run", "case.toml", "--allow-petsc-files", "--force", text=CASE + '[solver]\npetsc = "-ksp_view ascii:F"\n'), 0)
            or ("" if "F" in files(".") else "did not write F"))


def odd_files():
    os.mkdir("folder")
    for base, why in (("folder", "is a folder"), ("/proc/self/mem", "cannot be read"), ("/dev/null", "is not a file")):
        wanted = f'case file "{base}" {why}'
        if said := wrong(berm("check", base), 2, wanted) or wrong(berm("check", "case.toml", text=f'base = "{base}"\n'), 2, "case.toml:1:8: " + wanted):
            return said
    return ""


def standard_input():
    pathlib.Path("base.toml").write_text(CASE)
    based = 'base = "base.toml"\ntitle = "from standard input"\n'
    for n in ("1", "2"):
        done = berm("run", "-", "-n", n, "--oversubscribe", "--force", input=based)
        if why := wrong(done, 0, "from standard input", "berm report out/stdin"):
            return f"-n {n}: {why}"
    return (wrong(berm("check", "-", input=based + "typo = 1\n"), 2, 'stdin:3:1: unknown key "typo"') or wrong(berm("check", "-", input=based), 0)
            or wrong(berm("run", "-", "--out", "elsewhere", input=based), 0) or ("" if "history.csv" in files("elsewhere") else "not in --out"))


# ---- habits

def words_of_help():
    return (wrong(berm("--version"), 0, "berm 0") or wrong(berm("rnu", "case.toml"), 2, 'did you mean "run"?') or wrong(berm("version"), 0, "berm 0")
            or wrong(berm("report", "--help"), 0, "--scale") or wrong(berm("sweep", "--help"), 0, "--jobs", "--short")
            or wrong(berm("factor_of_safety", "--help"), 0, "--tolerance") or wrong(berm("run", "--help"), 0, "--oversubscribe", "--force") or wrong(berm(), 2))


def completed(line):
    """What bash offers for the last word of a line."""
    words = line.split(" ")
    listed = " ".join(f"'{w}'" for w in words)
    done = shell(f'eval "$("$BERM" completion bash)"; COMP_WORDS=({listed}); COMP_WORDS[0]=$BERM; COMP_CWORD={len(words) - 1}; _berm; echo "${{COMPREPLY[@]}}"')
    return done.stdout.split()


def completion():
    pathlib.Path("case.toml").write_text(CASE)
    for line, offered in (("berm r", {"run", "report"}), ("berm run --ov", {"--oversubscribe"}), ("berm run c", {"case.toml"}), ("berm schema --format j", {"json"}),
                          ("berm sweep --sh", {"--short"}), ("berm check --fo", set()), ("berm completion b", {"bash"})):
        if set(completed(line)) != offered:
            return f"{line}: {completed(line)}, not {offered}"
    return ""


def origin_of_results():
    for n in ("1", "2"):
        if why := wrong(berm("run", "case.toml", "-n", n, "--oversubscribe", "--force", "--set", 'title="a b"'), 0):
            return why
        summary = json.loads(pathlib.Path("out/case/summary.json").read_text())
        command = f"berm run case.toml -n {n} --oversubscribe --force --set 'title=\"a b\"'"
        head = pathlib.Path("out/case/log.txt").read_text().splitlines()[:2]
        if (summary["command"], summary["processes"], summary["host"]) != (command, int(n), os.uname().nodename) or not summary["version"]:
            return f"-n {n}: {summary}"
        if not head[0].startswith(f"berm {summary['version']}") or f"{n} process" not in head[0] or head[1] != "command: " + command:
            return f"-n {n}: {head}"
    return ""


def children(pid):
    """Of a process, and theirs."""
    found = [int(p) for p in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return found + [p for child in found for p in children(child)]


def is_berm(pid):
    try:
        return os.path.samefile(f"/proc/{pid}/exe", BERM)
    except OSError:
        return False


def process_that_is_killed():
    """As the system does where memory runs out."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet", "-n", "2", "--oversubscribe")
    os.kill([p for p in children(process.pid) if is_berm(p)][-1], signal.SIGKILL)
    return wrong(end_of(process), 1, "ended by signal 9 (Killed)", "--restart")


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
    return "" if said and ends[-1][1] == 0 else str(ends)


def few_open_files():
    """Fewer than Open MPI needs: raised where that is allowed, else said."""
    def limited(soft, hard):
        return lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return (wrong(berm("run", "case.toml", "--quiet", preexec_fn=limited(10, 256)), 0)
            or wrong(berm("run", "case.toml", "--force", preexec_fn=limited(10, 10)), 1, "raise its limit (ulimit -n)")
            or wrong(berm("run", "case.toml", "--force", "-n", "2", timeout=60, preexec_fn=limited(24, 24)), 1, "raise its limit (ulimit -n)"))  # mpiexec hung


def waits_for_nothing():
    """What a run or a tool would wait for, or loop on, for ever: refused at once."""
    os.mkfifo("pipe")
    odd = {"steps.duration=5e-324": "must be >= 1e-100", "solver.petsc=-pc_type mg -pc_mg_levels 2": "-pc_mg_levels", "solver.petsc=-mat_mumps_icntl_22 1": "may write files"}
    return (wrong(berm("run", "case.toml", "--force", "--restart", "pipe", timeout=60), 2, "pipe: is not a file")
            or wrong(berm("sweep", "/dev/zero", timeout=60), 2, "/dev/zero: is not a file")
            or wrong(berm("run", "case.toml", "--force", timeout=60, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (150_000_000, 150_000_000))), 1, "ulimit -d")
            or next((why for change, words in odd.items() if (why := wrong(berm("check", "case.toml", "--set", change, timeout=60), 2, words))), ""))


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


def odd_entries():
    """Links that lead in a circle are nobody's results; a folder with the name of one is not removed."""
    pathlib.Path("out/case").mkdir(parents=True)
    os.symlink("loop", "out/case/loop")
    if why := wrong(berm("run", "case.toml"), 0):
        return why
    pathlib.Path("out/case/checkpoint.h5").unlink(missing_ok=True)
    pathlib.Path("out/case/checkpoint.h5").mkdir()
    before = files("out/case")
    why = wrong(berm("run", "case.toml", "--force"), 2, "out/case/checkpoint.h5: a folder has the name of a result")
    return why or ("" if files("out/case") == before else f"lost: {before}, now {files('out/case')}")


def progress():
    """A line at least every five seconds, also of a run of slow steps."""
    pathlib.Path("long.toml").write_text(LONG)
    process = subprocess.Popen([BERM, "run", "long.toml"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(6.5)
    process.terminate()
    out, _ = process.communicate(timeout=60)
    return "" if re.search(r"step +\d+ +0\.\d %.* left", out) else out


TESTS = [too_many_processes, limit_of_file_size, full_disk, second_run_in_the_folder, finished_run_is_kept, files_of_the_user_are_kept, mesh_that_has_changed, failed_run_makes_way, refused_case_replaces_nothing, links_are_not_followed, pipe_in_the_place_of_a_summary, folder_that_is_gone, empty_words, temporary_folder, folder_of_mpi, no_path,
         signals, signals_at_the_start, tie_that_has_ended, nohup, reader_that_has_gone, full_and_closed_output, mpi_that_does_not_start, folder_that_is_replaced, emptied_folder, environment_of_others, boundary_too_narrow, cells_in_one_another, factors_without_end, options_of_petsc, odd_files, standard_input, words_of_help, completion, origin_of_results, process_that_is_killed,
         little_memory, few_open_files, waits_for_nothing, tool_that_is_ended, odd_entries, progress]


def main():
    global BERM
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    BERM = str(pathlib.Path(sys.argv[1]).resolve())
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    failed = 0
    for test in TESTS:
        if sys.argv[2:] and test.__name__ not in sys.argv[2:]:
            continue
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                why = test()
            except RuntimeError as error:  # a run that did not begin
                why = str(error)
            os.chdir("/")
        failed += bool(why)
        print(f"{test.__name__:28} {time.monotonic() - start:5.1f} s  {'FAILED: ' + why if why else 'as it should'}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
