"""Meshes of a few elements as Gmsh 2.2 writes them, in text."""


def mesh_22(places, cells):
    """Quads of places (x, y), or tetrahedra of places (x, y, z); cells: numbers of places from 1 on."""
    kind = 3 if len(places[0]) == 2 else 4
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(places)}\n"
    text += "".join(f"{k} {' '.join(map(str, (*place, 0)[:3]))}\n" for k, place in enumerate(places, 1))
    text += f"$EndNodes\n$Elements\n{len(cells)}\n"
    text += "".join(f"{k} {kind} 2 1 1 {' '.join(map(str, cell))}\n" for k, cell in enumerate(cells, 1))
    return text + "$EndElements\n"
