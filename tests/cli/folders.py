"""Disks and folders: what a run writes, replaces, leaves behind and follows."""

import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess

from harness import BERM, CASE, LONG, begun, berm, end_of, files, rows, shell, test, until, wrong


def limited_files(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


@test
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


@test
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


@test
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


@test
def finished_run_is_kept():
    if why := wrong(berm("run", "case.toml"), 0, "berm report out/case"):
        return why
    before = pathlib.Path("out/case/history.csv").read_bytes()
    why = wrong(berm("run", "case.toml", "--set", "steps.count=2"), 2, "out/case: holds the results of a run", "--force", "--out")
    if why or pathlib.Path("out/case/history.csv").read_bytes() != before:
        return why or "changed it all the same"
    return (wrong(berm("run", "case.toml", "--force", "--set", "checkpoint.every_steps=2"), 0)
            or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5"), 0))


@test
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


@test
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


@test
def frames_of_another_run():
    """A restart lists the frames before it where they are of the same run, and no others of their names."""
    def times(folder):
        return [float(t) for t in re.findall(r'timestep="([^"]*)"', pathlib.Path(folder, "points.pvd").read_text())]
    pathlib.Path("other.toml").write_text(CASE.replace("count = 4", "count = 8\n[checkpoint]\nevery_steps = 5"))
    why = wrong(berm("run", "case.toml"), 0) or wrong(berm("run", "other.toml"), 0)
    shutil.copytree("out/other", "copy")
    whole = times("out/other") if not why else []
    for folder, expected in (("out/other", whole), ("copy", whole), ("out/case", [t for t in whole if t > 0.625])):
        shutil.copy("copy/checkpoint.h5", "kept.h5")
        why = why or wrong(berm("run", "other.toml", "--force", "--restart", "kept.h5", "--out", folder), 0)
        if not why and times(folder) != expected:
            return f"{folder} lists {times(folder)}, not {expected}"
    return why


@test
def failed_run_makes_way():
    stops = CASE.replace("uy = -0.001", 'uy = "-0.001*t + 0*sqrt(0.5 - t + 0*x)"')  # what depends on the place is not looked at before
    return wrong(berm("run", "case.toml", text=stops), 1) or wrong(berm("run", "case.toml"), 0)


@test
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


@test
def temporary_folder():
    environment = {**os.environ, "TMPDIR": "/proc/nowhere"}
    return (wrong(berm("run", "case.toml", "--quiet", env=environment), 0)
            or wrong(berm("run", "case.toml", "--quiet", "--force", "-n", "2", "--oversubscribe", env=environment), 0, "temporary files go to", "/proc/nowhere (TMPDIR)"))


@test
def folder_of_mpi():
    """A single process makes none: those of runs side by side would be the same, and the first one that ends would remove it."""
    pathlib.Path("tmp").mkdir()
    pathlib.Path(f"tmp/ompi.{socket.gethostname().split('.')[0]}.{os.getuid()}").write_text("not a folder")
    return wrong(berm("run", "case.toml", env=os.environ | {"TMPDIR": str(pathlib.Path("tmp").resolve())}), 0)


@test
def pipe_in_the_place_of_a_summary():
    pathlib.Path("out/case").mkdir(parents=True)
    pathlib.Path("out/case/log.txt").write_text("berm 0.1.0\n")
    os.mkfifo("out/case/summary.json")
    return wrong(berm("run", "case.toml", "--quiet", timeout=60), 0)


@test
def folder_that_is_gone():
    pathlib.Path("case.toml").write_text(CASE)
    here = os.getcwd()
    done = shell(f'mkdir gone; cd gone; rmdir ../gone; "$BERM" run {here}/case.toml --out {here}/out')
    return wrong(done, 2, "the current folder cannot be read")


@test
def folder_that_is_replaced():
    """What has the name of the output folder during the run is not written to."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet")
    os.rename("out/long", "out/moved")
    os.mkdir("other")
    os.symlink("../other", "out/long")
    why = wrong(end_of(process), 1, "out/long: something else has the name of the output folder now", "--restart")
    return why or ("" if not files("other") else f"wrote {files('other')}")


@test
def emptied_folder():
    """Results that something else removes during a run are missed."""
    pathlib.Path("long.toml").write_text(LONG)
    process = begun("out/long", "run", "long.toml", "--quiet")
    pathlib.Path("out/long/history.csv").unlink()
    return wrong(end_of(process), 1, "out/long/history.csv: something else has removed, replaced or cut this file")


@test
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
