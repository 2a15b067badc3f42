"""Small files that are right: Gmsh meshes, STL surfaces, and the cases that read them."""

import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from gmsh_text import mesh_22  # noqa: E402

CASE = """
title = "For files that are changed"
method = "{method}"
{grid}
[material.m]
law = "rankine"
density = 2400.0
youngs_modulus = "30 GPa"
poisson_ratio = 0.2
tensile_strength = "3 MPa"
fracture_energy = 1000.0
[body.a]
material = "m"
{body}
[boundary.base]
where.box.{below}
ux = 0.0
uy = 0.0
[boundary.top]
where.box.{above}
uy = 0.0001
[steps]
count = 4
[checkpoint]
every_steps = 2
"""
PLANE = {"below": "max = [9.0, 1e-6]", "above": "min = [-9.0, 0.9999]"}
SOLID = {"below": "max = [9.0, 1e-6, 9.0]\nuz = 0.0", "above": "min = [-9.0, 0.9999, -9.0]"}
GRID = "grid = { origin = [-0.2, -0.2], cell_size = 0.2, cells = [8, 8] }"
SOLID_GRID = "model.dimension = 3\ngrid = { origin = [-0.25, -0.25, -0.25], cell_size = 0.25, cells = [6, 6, 6] }"
BOX = 'shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }\nmesh = { kind = "quads", size = 0.25 }'


def nodes(n):
    return [(i / n, j / n) for j in range(n + 1) for i in range(n + 1)]


def quads(n):
    return [(a, a + 1, a + n + 2, a + n + 1) for j in range(n) for a in (j * (n + 1) + i + 1 for i in range(n))]


def square_22(n=3):
    """Gmsh 2.2: quads, and lines of the group "left"."""
    places, cells = nodes(n), quads(n)
    lines = [(j * (n + 1) + 1, (j + 1) * (n + 1) + 1) for j in range(n)]
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"left\"\n2 2 \"core\"\n$EndPhysicalNames\n"
    text += f"$Nodes\n{len(places)}\n" + "".join(f"{k} {x:.6g} {y:.6g} 0\n" for k, (x, y) in enumerate(places, 1))
    text += f"$EndNodes\n$Elements\n{len(lines) + len(cells)}\n"
    for k, cell in enumerate(lines + cells, 1):
        kind = "1 2 1 1" if len(cell) == 2 else "3 2 2 1"
        text += f"{k} {kind} {' '.join(map(str, cell))}\n"
    return (text + "$EndElements\n").encode()


def square_41(n=3, binary=False):
    """Gmsh 4.1: one surface of triangles, in text or binary."""
    places = nodes(n)
    cells = [t for a, b, c, d in quads(n) for t in ((a, b, c), (a, c, d))]
    if not binary:
        text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 0 0\n$EndEntities\n"
        text += f"$Nodes\n1 {len(places)} 1 {len(places)}\n2 1 0 {len(places)}\n"
        text += "".join(f"{k}\n" for k in range(1, len(places) + 1)) + "".join(f"{x:.6g} {y:.6g} 0\n" for x, y in places)
        text += f"$EndNodes\n$Elements\n1 {len(cells)} 1 {len(cells)}\n2 1 2 {len(cells)}\n"
        text += "".join(f"{k} {a} {b} {c}\n" for k, (a, b, c) in enumerate(cells, 1))
        return (text + "$EndElements\n").encode()
    pack = struct.pack
    out = b"$MeshFormat\n4.1 1 8\n" + pack("<i", 1) + b"\n$EndMeshFormat\n$Entities\n" + pack("<4Q", 0, 0, 1, 0)
    out += pack("<i6dQQ", 1, 0, 0, 0, 1, 1, 0, 0, 0) + b"\n$EndEntities\n$Nodes\n" + pack("<4Q", 1, len(places), 1, len(places))
    out += pack("<3iQ", 2, 1, 0, len(places)) + pack(f"<{len(places)}Q", *range(1, len(places) + 1))
    out += b"".join(pack("<3d", x, y, 0.0) for x, y in places) + b"\n$EndNodes\n$Elements\n"
    out += pack("<4Q", 1, len(cells), 1, len(cells)) + pack("<3iQ", 2, 1, 2, len(cells))
    out += b"".join(pack("<4Q", k, *cell) for k, cell in enumerate(cells, 1))
    return out + b"\n$EndElements\n"


def square_22_binary(n=3):
    """Gmsh 2.2, binary: quads."""
    places, cells = nodes(n), quads(n)
    out = b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n%d\n" % len(places)
    out += b"".join(struct.pack("<i3d", k, x, y, 0.0) for k, (x, y) in enumerate(places, 1)) + b"\n$EndNodes\n$Elements\n%d\n" % len(cells)
    out += struct.pack("<3i", 3, len(cells), 2) + b"".join(struct.pack("<7i", k, 2, 1, *cell) for k, cell in enumerate(cells, 1))
    return out + b"\n$EndElements\n"


def cube_22():
    """Gmsh 2.2: the unit cube in five tetrahedra."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    cells = [(1, 2, 4, 6), (1, 4, 3, 7), (1, 6, 7, 5), (4, 7, 6, 8), (1, 4, 7, 6)]
    return mesh_22(corners, cells).encode()


def cube_triangles():
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    corner = [(float(k & 1), float(k >> 1 & 1), float(k >> 2 & 1)) for k in range(8)]
    return [[corner[k] for k in t] for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def cube_stl(binary):
    triangles = cube_triangles()
    if binary:
        body = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0) for t in triangles)
        return b"cube".ljust(80) + struct.pack("<I", len(triangles)) + body
    text = "solid cube\n"
    for t in triangles:
        text += "  facet normal 0 0 0\n    outer loop\n"
        text += "".join(f"      vertex {x:g} {y:g} {z:g}\n" for x, y, z in t) + "    endloop\n  endfacet\n"
    return (text + "endsolid cube\n").encode()


def read_files():
    """[(name of the file, its content, case that reads it)]"""
    body = 'file = "FILE"\npoints = { per_element = 1 }'
    plane = lambda method: CASE.format(method=method, grid=GRID if method == "mpm" else "", body=body, **PLANE)  # noqa: E731
    if_fem = plane("fem").replace("points = { per_element = 1 }", "")
    grid_file = CASE.format(method="mpm", grid='grid.file = "FILE"', body=BOX, **PLANE)
    solid = CASE.format(method="mpm", grid=SOLID_GRID, body=body.replace("1 }", "4 }"), **SOLID)
    solid_fem = CASE.format(method="fem", grid="model.dimension = 3", body='file = "FILE"', **SOLID)
    surface = CASE.format(method="mpm", grid=SOLID_GRID, body='shape.surface = "FILE"', **SOLID)
    surface_fem = CASE.format(method="fem", grid="model.dimension = 3", body='shape.surface = "FILE"\nmesh = { size = 0.4 }', **SOLID)
    square, triangles, packed = square_22(), square_41(), square_41(binary=True)
    return [
        ("square.msh", square, plane("mpm")),
        ("square.msh", square, if_fem),
        ("square.msh", square, grid_file),
        ("triangles.msh", triangles, plane("mpm")),
        ("triangles.msh", triangles, if_fem),
        ("packed.msh", packed, plane("mpm")),
        ("packed.msh", packed, grid_file),
        ("old.msh", square_22_binary(), plane("mpm")),
        ("cube.msh", cube_22(), solid),
        ("cube.msh", cube_22(), solid_fem),
        ("cube.stl", cube_stl(False), surface),
        ("cube.stl", cube_stl(True), surface),
        ("cube.stl", cube_stl(True), surface_fem),
    ]


def restarted_cases():
    """Cases whose checkpoints are changed."""
    solid = 'shape.box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }\nmesh = { kind = "hexahedra", size = 0.5 }'
    return [
        CASE.format(method="mpm", grid=GRID, body=BOX, **PLANE),
        CASE.format(method="fem", grid="", body=BOX, **PLANE),
        CASE.format(method="mpm", grid=SOLID_GRID, body=solid, **SOLID),
    ]
