"""What is given to a run: cases, meshes, options and surroundings that nobody should be harmed by."""

import os
import pathlib
import re
import resource

from gmsh_text import mesh_22
from harness import CASE, berm, files, test, wrong


@test
def mesh_that_has_changed():
    """A checkpoint belongs to the mesh that it was written with."""
    text = re.sub(r"grid = .*\n", "", CASE)
    text = 'method = "fem"\n' + re.sub(r"shape\.[^\n]*", 'file = "square.msh"', text)
    pathlib.Path("square.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1), (0, 1)], [(1, 2, 3, 4)]))
    why = wrong(berm("run", "case.toml", "--set", "checkpoint.every_steps=2", text=text), 0)
    why = why or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5", "--out", "again", text=text), 0)
    pathlib.Path("square.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1.01), (0, 1)], [(1, 2, 3, 4)]))
    return why or wrong(berm("run", "case.toml", "--restart", "out/case/checkpoint.h5", "--out", "other", text=text), 2, "the file of body.a.file has changed since the checkpoint was written")


@test
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


@test
def environment_of_others():
    """Settings of PETSc, Python and matplotlib in the folder or the environment are not those of a run."""
    os.mkfifo(".petscrc")
    os.mkfifo("matplotlibrc")
    for name in ("json", "numbers", "csv", "berm"):
        pathlib.Path(f"{name}.py").write_text("raise RuntimeError('not ours')\n")
    odd = os.environ | {"PETSC_OPTIONS": "-fp_trap -options_file /nonexistent", "PETSC_OPTIONS_YAML": "{pc_type: foo}", "MPLBACKEND": "none", "BERM_PYTHON": "", "PYTHONPATH": ""}
    of_another = odd | dict.fromkeys(("PYTHONHOME", "PYTHONIOENCODING", "PYTHONMALLOC", "PYTHONHASHSEED", "PYTHONPLATLIBDIR"), "foo") | {"PYTHONINSPECT": "1"}
    os.mkdir("broken")
    pathlib.Path("broken/numpy.py").write_text("raise RuntimeError('not ours')\n")
    return (wrong(berm("run", "case.toml", timeout=60, env=odd), 0, "warning: PETSC_OPTIONS in the environment is not read")
            or wrong(berm("run", "case.toml", "--force", "-n", "2", "--oversubscribe", timeout=60, env=odd), 0)
            or wrong(berm("report", "out/case", timeout=100, env=of_another), 0)
            or wrong(berm("report", "out/case", timeout=100, env=odd | {"PYTHONPATH": "broken"}), 1, "berm report: RuntimeError: not ours"))


@test
def boundary_too_narrow():
    """Gmsh throws through its parallel regions."""
    narrow = CASE.replace("max = [1.0, 1.0] }", 'max = [1.0, 0.000000000001] }\nmesh = { kind = "triangles", size = 0.02 }', 1)
    return wrong(berm("check", "case.toml", "--set", "method=fem", text=narrow), 2, "case.toml:9:7: [body.a]: Gmsh cannot mesh it")


@test
def cells_in_one_another():
    """A grid from a file, of two squares of which one half is in both."""
    pathlib.Path("twice.msh").write_text(mesh_22([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (2, 0), (2, 1), (0.5, 1)], [(1, 2, 3, 4), (5, 6, 7, 8)]), encoding="ascii")
    lying = CASE.replace("grid = { origin = [-0.25, -0.25], cell_size = 0.25, cells = [6, 6] }", 'grid.file = "twice.msh"').replace("max = [1.0, 1.0] }", "max = [0.4, 0.4] }", 1)
    return wrong(berm("check", "case.toml", text=lying), 2, "twice.msh: two cells of the grid lie in one another near (0.5, 0.5)")


PRESSED = '[pressure.p]\nbody = "a"\nwhere.box.min = [0.9999, -9.0]\nvalue = 1e3\n'


@test
def values_and_places_out_of_reach():
    """Each with its key: a function that loses its value in a step, a place beyond what a square can be taken of, a name that no file can have."""
    lost = CASE.replace("uy = -0.001", 'uy = "1e-3*sqrt((t - 0.4125)^2 - 1e-6)"').replace("count = 4", "count = 80")
    far = CASE + "[gauge.g]\nfrom = [0.5, 0.5]\nto = [1e300, 0.5]\n"
    return (wrong(berm("run", "case.toml", text=lost), 1, '"uy" in [boundary.top]: "1e-3*sqrt((t - 0.4125)^2 - 1e-6)" is', "at t = 0.4125 s")
            or wrong(berm("check", "case.toml", text=far), 2, "case.toml:21:8: [gauge.g]: the point (1e+300, ")
            or wrong(berm("run", "case.toml", text=far.replace("0.5, 0.5", "0.1, 0.0").replace("1e300, 0.5", "0.9, 0.0") + PRESSED + '[control]\nkind = "gauge"\ngauge = "g"\ntarget = -1e-4\n'), 1,
                     "[gauge.g]: both ends are where all nodes are held")
            or wrong(berm("check", "case.toml", text=far.replace("1e300, 0.5", "0.9, 0.5") + PRESSED.replace("1e3", '"1e3*(t < 0.5)"') + '[control]\nkind = "gauge"\ngauge = "g"\ntarget = -1e-4\n'), 2,
                     "case.toml:27:1: ", "changes with the time")
            or wrong(berm("check", "case.toml", text=CASE + PRESSED), 0)
            or wrong(berm("check", "case.toml", "--set", "pressure.p.traction=[1.0, 0.0]", text=CASE + PRESSED), 2, 'leave "value" out of the case')
            or wrong(berm("check", "case.toml", "--set", "method=fem", text=CASE.replace("max = [1.0, 1.0] }", "max = [1.0, 1e-14] }\nmesh = { kind = \"quads\", size = 1.0, structured = true }", 1), timeout=60), 2,
                     "case.toml:9:7: ", "elements are only")
            or wrong(berm("check", "case.toml", text=CASE.replace("body.a", "body." + 101 * "a")), 2, "case.toml:9:7: name", "at most 100"))


@test
def shapes_out_of_reach():
    """What crashed, or kept Gmsh for ever, far from the origin or where its places are lost in rounding."""
    solid = re.sub(r"(min|max|origin) = \[([-0-9.e]+), ([-0-9.e]+)\]", r"\1 = [\2, \3, \3]", CASE.replace("cells = [6, 6]", "cells = [6, 6, 6]")) + "[model]\ndimension = 3\n"
    plane = ("disc = { centre = [1e300, 0.5], radius = 0.5 }", "box = { min = [-1e308, -1e308], max = [1e308, 1e308] }", "disc = { centre = [0.5, 0.5], radius = 1e300 }",
             "disc = { centre = [1e9, 0.5], radius = 1e-7 }", "polygon = [[1e300, 0], [2e300, 0], [1e300, 1e300]]")
    space = ("sphere = { centre = [1e300, 0.5, 0.5], radius = 0.5 }", "cylinder = { from = [0, 0, 0], to = [0, 0, 1e300], radius = 0.5 }", "box = { min = [1e300, 0, 0], max = [2e300, 1, 1] }")
    for text, shapes in ((CASE, plane), (solid, space)):
        for shape in shapes:
            if why := wrong(berm("check", "case.toml", text=re.sub(r"shape\.box = .*", "shape." + shape, text), timeout=60), 2, '"shape" in [body.a]'):
                return f"{shape}: {why}"
    return ""


@test
def factors_without_end():
    return (wrong(berm("factor_of_safety", "case.toml", "--tolerance", "1e-18", timeout=60), 2, "--tolerance must be at least 0.0001")
            or wrong(berm("factor_of_safety", "-", timeout=60), 2, "-: is not a file"))


@test
def options_of_petsc():
    """Those that could write, connect, crash or never end, and wrong values of others: refused with the key; allowed if the user says so."""
    refused = ("-log_view :F", "-ksp_view_mat binary:F", "-options_file F", "-malloc_dump", "-info :F", "-ksp_monitor ascii:F", "-ksp_monitor ascii::ascii_matlab", "-ksp_view_diagonal_scale",
               "-snes_monitor_fields", "-ksp_plot_eigenvalues", "-mg_levels_ksp_type preonly", "-ksp_guess_type fischer", "-prefix_push x", "-mat_mumps_ooc_tmpdir F",
               "-mat_mumps_icntl_7 77", "-ksp_type python", "-pc_type shell", "-pc_type foo", "-pc_type", "-pc_bjacobi_blocks 1000000", "-ksp_rtol 1e-3x", "-ksp_max_it 1 2", "F")
    for options in refused:
        told = "a value without an option" if options == "F" else "--allow-petsc-files"
        if why := wrong(berm("run", "case.toml", text=CASE + f'[solver]\npetsc = "{options}"\n'), 2, 'case.toml:22:9: "petsc" in [solver]: "', told):
            return f"{options}: {why}"
    if "F" in files("."):
        return "wrote F"
    taken = CASE + '[solver]\npetsc = "-ksp_view -newton_snes_monitor -ksp_rtol 1e-8"\n'
    return (wrong(berm("run", "case.toml", text=taken.replace("rtol", "rtl")), 2, 'did you mean "-ksp_rtol"?')
            or wrong(berm("run", "case.toml", text=taken), 0, 'warning: case.toml:22:9: "petsc" in [solver]', "-newton_snes_monitor", absent=["for -ksp_view"])
            or wrong(berm("run", "case.toml", "--force", "--allow-petsc-files", text=CASE + '[solver]\npetsc = "-pc_type foo"\n'), 1, "PC type foo")
            or wrong(berm("run", "case.toml", "--allow-petsc-files", "--force", text=CASE + '[solver]\npetsc = "-ksp_view ascii:F"\n'), 0)
            or ("" if "F" in files(".") else "did not write F"))


@test
def odd_files():
    os.mkdir("folder")
    for base, why in (("folder", "is a folder"), ("/proc/self/mem", "cannot be read"), ("/dev/null", "is not a file")):
        wanted = f'case file "{base}" {why}'
        if said := wrong(berm("check", base), 2, wanted) or wrong(berm("check", "case.toml", text=f'base = "{base}"\n'), 2, "case.toml:1:8: " + wanted):
            return said
    return ""


@test
def standard_input():
    pathlib.Path("base.toml").write_text(CASE)
    based = 'base = "base.toml"\ntitle = "from standard input"\n'
    for n in ("1", "2"):
        done = berm("run", "-", "-n", n, "--oversubscribe", "--force", input=based)
        if why := wrong(done, 0, "from standard input", "berm report out/stdin"):
            return f"-n {n}: {why}"
    return (wrong(berm("check", "-", input=based + "typo = 1\n"), 2, 'stdin:3:1: unknown key "typo"') or wrong(berm("check", "-", input=based), 0)
            or wrong(berm("run", "-", "--out", "elsewhere", input=based), 0) or ("" if "history.csv" in files("elsewhere") else "not in --out"))


@test
def waits_for_nothing():
    """What a run or a tool would wait for, or loop on, for ever: refused at once."""
    os.mkfifo("pipe")
    odd = {"steps.duration=5e-324": "must be 1e-100 <= value", "solver.petsc=-pc_type mg": "gamg", "solver.petsc=-mat_mumps_icntl_22 1": "--allow-petsc-files"}
    return (wrong(berm("run", "case.toml", "--force", "--restart", "pipe", timeout=60), 2, "pipe: is not a file")
            or wrong(berm("sweep", "/dev/zero", timeout=60), 2, "/dev/zero: is not a file")
            or wrong(berm("run", "case.toml", "--force", timeout=60, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (150_000_000, 150_000_000))), 1, "ulimit -d")
            or next((why for change, words in odd.items() if (why := wrong(berm("check", "case.toml", "--set", change, timeout=60), 2, words))), ""))
