#!/usr/bin/env python3
"""Checks who includes whom: a file may include its own module and modules of a lower level (docs/architecture.md).

    check_layers.py [ROOT]        checks ROOT/src (default: this source tree)
    check_layers.py --self-test   checks the checker on trees with and without violations
"""

import pathlib
import re
import sys
import tempfile

LEVELS = {
    "base": 0,
    "comm": 1,
    "law": 1,
    "mesh": 1,
    "io": 1,
    "shape": 2,
    "method": 3,
    "points": 3,
    "bc": 4,
    "fem": 4,
    "la": 4,
    "transfer": 4,
    "sim": 5,
    "case": 6,
}
# Single headers that stand lower than their module: case.hpp is the plain data that a case file becomes; the others tell where
# it came from and what two of its texts say differently.
HEADER_LEVELS = {"case/case.hpp": 2, "case/places.hpp": 3, "case/differences.hpp": 3}

# The FEM reference must be able to disagree with MPM.
FORBIDDEN = {"fem": ("points/", "transfer/", "shape/linear.hpp")}

# Foreign headers, and the only files that may see them.
FOREIGN = (
    (re.compile(r"gmshc?\.h(_cwrap)?$"), re.compile(r"mesh/gmsh\w*\.cpp$"), "Gmsh belongs to src/mesh/gmsh*.cpp"),
    (re.compile(r"toml\+\+"), re.compile(r"case/"), "toml++ belongs to src/case"),
    (re.compile(r"petsc\w*\.h$"), re.compile(r"la/"), "PETSc belongs to src/la"),
    (re.compile(r"(comm/mpi\.hpp|mpi\.h)$"), re.compile(r"(la|comm)/"), "MPI belongs to src/la and src/comm"),
    (re.compile(r"(zoltan\w*|hdf5)\.h$"), re.compile(r"comm/"), "Zoltan and HDF5 belong to src/comm"),
    (re.compile(r"CLI/"), re.compile(r"$^"), "CLI11 belongs to apps/berm/main.cpp"),
)
WRITING = re.compile(r"\b(std::)?(ofstream|fopen|fwrite|freopen)\b|std::fstream\b|gmsh::write\b")

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def level(path):
    """Level of a file of src/ given as module/name; None for an unknown module."""
    return HEADER_LEVELS.get(path, LEVELS.get(path.split("/")[0]))


def include_problem(name, quote, target):
    """Why the file `name` must not include `target`, or ""."""
    for header, allowed, why in FOREIGN:
        if header.match(target) and not allowed.match(name):
            return f"includes {target}: {why}"
    if quote == "<" or "/" not in target:
        return ""
    module = name.split("/")[0]
    for forbidden in FORBIDDEN.get(module, ()):
        if target.startswith(forbidden):
            return f"includes {target}: {module}/ must not know it"
    if level(target) is None:
        return f"includes {target}: the module has no level in tools/check_layers.py"
    same_module = target.split("/")[0] == module and name not in HEADER_LEVELS
    if not same_module and level(target) >= level(name):
        return f"(level {level(name)}) includes {target} (level {level(target)})"
    return ""


def file_problems(name, text):
    """[(line, what is wrong)] of one file of src/."""
    if level(name) is None:
        return [(1, "its module has no level in tools/check_layers.py")]
    problems = []
    for number, line in enumerate(text.splitlines(), 1):
        include = INCLUDE.match(line)
        if include:
            problem = include_problem(name, *include.groups())
            if problem:
                problems.append((number, problem))
        elif not name.startswith("io/") and WRITING.search(line.split("//")[0]):
            problems.append((number, "writes a file: only src/io does"))
    return problems


def check(root):
    """All problems of root/src as lines of text, and the number of files."""
    source = root / "src"
    files = sorted(p for p in source.rglob("*") if p.suffix in (".hpp", ".cpp"))
    problems = []
    for file in files:
        name = file.relative_to(source).as_posix()
        for line, text in file_problems(name, file.read_text(encoding="utf-8")):
            problems.append(f"src/{name}:{line}: {text}")
    return problems, len(files)


# name, content, expected words ("" for none)
SELF_TEST = (
    ("law/a.hpp", '#include "base/tensor.hpp"\n#include "law/b.hpp"\n#include <vector>\n', ""),
    ("law/up.hpp", '#include "mesh/mesh.hpp"\n', "includes mesh/mesh.hpp (level 1)"),
    ("base/up.cpp", '  #  include "sim/run.hpp"\n', "(level 0) includes sim/run.hpp (level 5)"),
    ("bc/data.hpp", '#include "case/case.hpp"\n', ""),
    ("law/data.hpp", '#include "case/case.hpp"\n', "(level 1) includes case/case.hpp (level 2)"),
    ("sim/reader.cpp", '#include "case/read_case.hpp"\n', "(level 5) includes case/read_case.hpp (level 6)"),
    ("case/case.hpp", '#include "case/table.hpp"\n', "(level 2) includes case/table.hpp (level 6)"),
    ("case/table.cpp", '#include "case/table.hpp"\n#include <toml++/toml.h>\n', ""),
    ("fem/good.cpp", '#include "shape/quadrature.hpp"\n', ""),
    ("fem/kernel.cpp", '#include "shape/linear.hpp"\n', "fem/ must not know it"),
    ("fem/points.cpp", '#include "points/seeding.hpp"\n', "fem/ must not know it"),
    ("fem/transfer.cpp", '#include "transfer/mpm.hpp"\n', "fem/ must not know it"),
    ("mesh/gmsh_x.cpp", "#include <gmsh.h>\n", ""),
    ("mesh/grid.cpp", "#include <gmsh.h>\n", "Gmsh belongs to"),
    ("io/toml.cpp", "#include <toml++/toml.h>\n", "toml++ belongs to"),
    ("la/good.cpp", '#include <petscsnes.h>\n#include <mpi.h>\n#include "comm/mpi.hpp"\n', ""),
    ("comm/good.cpp", '#include <mpi.h>\n#include <zoltan.h>\n#include <hdf5.h>\n#include "comm/mpi.hpp"\n', ""),
    ("comm/petsc.cpp", "#include <petscksp.h>\n", "PETSc belongs to"),
    ("comm/up.cpp", '#include "mesh/mesh.hpp"\n', "(level 1) includes mesh/mesh.hpp (level 1)"),
    ("method/halo.hpp", '#include "comm/halo.hpp"\n', ""),
    ("law/comm.cpp", '#include "comm/comm.hpp"\n', "(level 1) includes comm/comm.hpp (level 1)"),
    ("sim/petsc.cpp", "#include <petscksp.h>\n", "PETSc belongs to"),
    ("sim/mpi.cpp", "#include <mpi.h>\n", "MPI belongs to"),
    ("sim/handle.cpp", '#include "comm/mpi.hpp"\n', "MPI belongs to"),
    ("fem/zoltan.cpp", "#include <zoltan_partition_tree.h>\n", "Zoltan and HDF5 belong to"),
    ("sim/checkpoint.cpp", "#include <hdf5.h>\n", "Zoltan and HDF5 belong to"),
    ("la/hdf5.cpp", "#include <hdf5.h>\n", "Zoltan and HDF5 belong to"),
    ("sim/cli.cpp", "#include <CLI/CLI.hpp>\n", "CLI11 belongs to"),
    ("io/write.cpp", 'std::ofstream out("x");\n', ""),
    ("sim/write.cpp", 'std::ofstream out("x");\n', "only src/io does"),
    ("sim/read.cpp", 'std::ifstream in("x");  // no std::ofstream\n', ""),
    ("attic/new.hpp", "int x;\n", "has no level"),
    ("sim/attic.cpp", '#include "attic/new.hpp"\n', "has no level"),
)


def self_test():
    """Number of files of SELF_TEST that are judged wrongly."""
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, content, _ in SELF_TEST:
            path = pathlib.Path(folder) / "src" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content, encoding="utf-8")
        problems, _ = check(pathlib.Path(folder))
    for name, _, words in SELF_TEST:
        own = [p for p in problems if p.startswith(f"src/{name}:")]
        if len(own) != bool(words) or (words and words not in own[0]):
            wrong += 1
            print(f"{name}: expected {words or 'no problem'!r}, got {own}")
    print(f"{len(SELF_TEST) - wrong} passed, {wrong} failed")
    return wrong


def main():
    if sys.argv[1:] == ["--self-test"]:
        return 1 if self_test() else 0
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    problems, files = check(root)
    print("\n".join([*problems, f"{files} files, {len(problems)} problems"]))
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
