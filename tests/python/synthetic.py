"""Output folders with made-up but plausible results of the concrete prism, for the tests of what reads them."""

import csv
import json
import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_VERTEX, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

COLUMNS = (
    "step [-]",
    "time [s]",
    "imposed_displacement [m]",
    "reaction [N]",
    "nominal_stress [Pa]",
    "nominal_strain [-]",
    "load_factor [-]",
    "max_damage [-]",
    "external_work [J]",
    "elastic_energy [J]",
    "dissipated_energy [J]",
    "energy_error [-]",
    "newton_iterations [-]",
    "residual [-]",
    "extrapolation_error [-]",
    "integration [-]",
    "gauge:lateral [m]",
)
WIDTH, HEIGHT, TRAVEL = 0.15, 0.30, 6e-4
PEAK_AT = 2.85e-4


def nominal_stress(u):
    """Linear to the peak, then a drop and a slow fall."""
    peak = 124.4e9 * PEAK_AT
    return np.where(u <= PEAK_AT, 124.4e9 * u, peak * (0.32 + 0.15 * np.exp(-(u - PEAK_AT) / 1e-4)))


def write_grid(path, position, kind, cells, point_data=None, cell_data=None):
    """A .vtu: position (n, 3) [m]; cells (m, k) of the VTK type `kind`; {name: array}."""
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(position, dtype=float), deep=True))
    grid.SetPoints(points)
    for cell in cells:
        grid.InsertNextCell(kind, len(cell), [int(node) for node in cell])
    for target, data in ((grid.GetPointData(), point_data or {}), (grid.GetCellData(), cell_data or {})):
        for name, values in data.items():
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(name)
            target.AddArray(array)
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(path)
    writer.SetInputData(grid)
    writer.Write()


def write_points(path, fields):
    data = {name: values for name, values in fields.items() if name != "position"}
    write_grid(path, fields["position"], VTK_VERTEX, np.arange(len(fields["position"]))[:, None], data)


def write_pieces(path, sources):
    """A .pvtu that names its pieces; what else such a file says, berm does not read."""
    pieces = "".join(f'<Piece Source="{source}"/>' for source in sources)
    with open(path, "w", encoding="utf-8") as file:
        file.write(
            '<?xml version="1.0"?><VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="0">'
            f"{pieces}</PUnstructuredGrid></VTKFile>"
        )


def write_series(path, entries):
    """A .pvd of [(time [s], file)]."""
    sets = "".join(f'<DataSet timestep="{time}" part="0" file="{file}"/>' for time, file in entries)
    with open(path, "w", encoding="utf-8") as file:
        file.write(
            f'<?xml version="1.0"?><VTKFile type="Collection" version="1.0"><Collection>{sets}</Collection></VTKFile>'
        )


def split_frames(folder, processes, seed=0):
    """Rewrites the points of a run as `processes` processes do: pieces in any order, ids of all points."""
    from berm.results import read_points, read_series

    series = read_series(os.path.join(folder, "points.pvd"))
    random, entries = np.random.default_rng(seed), []
    for k, (time, file) in enumerate(series):
        fields = read_points(file)
        order = random.permutation(len(fields["position"]))
        os.remove(file)
        sources = []
        for rank, part in enumerate(np.array_split(order, processes)):
            sources.append(f"points_{k:04d}_{rank}.vtu")
            write_points(os.path.join(folder, sources[-1]), {name: v[part] for name, v in fields.items()})
        entries.append((time, f"points_{k:04d}.pvtu"))
        write_pieces(os.path.join(folder, entries[-1][1]), sources)
    write_series(os.path.join(folder, "points.pvd"), entries)


def point_fields(time, cell, noise, seed):
    """Gauss points of a regular grid, an X of damage after the peak, stresses in tension and compression."""
    g = 0.5 / np.sqrt(3.0)

    def line(length):
        return ((np.arange(round(length / cell))[:, None] + [0.5 - g, 0.5 + g]) * cell).ravel()

    x, y = (a.ravel() for a in np.meshgrid(line(WIDTH) - 0.5 * WIDTH, line(HEIGHT)))
    n, u = len(x), TRAVEL * time
    stress_yy = -float(nominal_stress(np.array(u))) * np.ones(n)
    band = np.exp(-(((np.abs(x) - 0.5 * np.abs(y - 0.15)) / 0.008) ** 2))
    damage = np.clip(2.5 * band * (u > PEAK_AT), 0.0, 0.995) * np.clip((u - PEAK_AT) / 1e-4, 0.0, 1.0)
    displacement = np.stack([0.2 * u * x / HEIGHT, -u * y / HEIGHT, 0.0 * x], 1)
    stress = np.zeros((n, 6))
    random = np.random.default_rng(seed)
    stress[:, 1] = stress_yy * (1.0 - 0.8 * damage) * (1.0 + noise * random.standard_normal(n))
    stress[:, 0] = (
        2.5e6 * np.sin(np.pi * y / HEIGHT) * np.cos(np.pi * x / WIDTH) * time - 3e6 * np.exp(-y / 0.02) * time
    )
    stress[:, 3] = 3e6 * np.sin(2 * np.pi * x / WIDTH) * np.cos(np.pi * y / HEIGHT) * time
    stress[0, 0] = 1e9  # an outlier must not spoil the colours
    return {
        "position": np.stack([x, y, 0.0 * x], 1) + displacement,
        "displacement": displacement,
        "stress": stress,
        "strain": np.zeros((n, 6)),
        "damage": damage,
        "volume": np.full(n, 0.25 * cell**2),
        "body": np.zeros(n, dtype=np.int32),
        "id": np.arange(n, dtype=np.int64),
        "crack_opening": 3e-4 * damage * (u > PEAK_AT),
        "released_energy_fraction": damage**2,
    }


def write_run(folder, method="mpm", factor=1.0, cell=0.005, steps=300, frames=4, noise=0.03, references=()):
    """Fills the folder as docs/output.md describes. `factor` scales the loads."""
    os.makedirs(folder, exist_ok=True)
    time = np.linspace(0.0, 1.0, steps + 1)
    u = TRAVEL * time
    stress = factor * nominal_stress(u)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (stress[1:] + stress[:-1]) * WIDTH * np.diff(u))])
    elastic = 0.5 * stress * WIDTH * u * np.where(u > PEAK_AT, PEAK_AT / np.maximum(u, 1e-9), 1.0)
    with open(os.path.join(folder, "history.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for k in range(steps + 1):
            writer.writerow(
                [
                    k,
                    time[k],
                    u[k],
                    stress[k] * WIDTH,
                    stress[k],
                    u[k] / HEIGHT,
                    1,
                    0,
                    work[k],
                    elastic[k],
                    work[k] - elastic[k],
                    0.001,
                    3,
                    1e-9,
                    0,
                    0,
                    0.2 * u[k],
                ]
            )
    entries = []
    for k, t in enumerate(np.linspace(0.0, 1.0, frames)):
        entries.append((t, f"points_{k:04d}.vtu"))
        write_points(os.path.join(folder, entries[-1][1]), point_fields(t, cell, noise, k))
    write_series(os.path.join(folder, "points.pvd"), entries)
    half = 0.5 * WIDTH
    ring = [[-half, 0.0], [half, 0.0], [half, HEIGHT], [-half, HEIGHT]]
    summary = {
        "title": "Concrete prism <0.15 x 0.30 m> in compression",
        "method": method,
        "case": f"{method}.toml",
        "status": "done",
        "reason": "",
        "dofs": 3720,
        "points": 7200,
        "steps": steps,
        "cut_steps": 0,
        "newton_iterations": 3 * steps,
        "wall_seconds": 12.3,
        "thickness": 1.0,
        "references": list(references),
        "body_rings": {"specimen": [ring]},
        "metrics": {
            "peak_load [N]": stress.max() * WIDTH,
            "peak_stress [Pa]": stress.max(),
            "displacement_at_peak [m]": u[stress.argmax()],
            "stiffness_10_40 [Pa]": factor * 124.4e9 * HEIGHT,
            "stress_noise [-]": None,
            "energy_error [-]": 0.001,
            "dissipated_energy [J]": work[-1] - elastic[-1],
            "max_damage [-]": 0.995,
            "cut_steps [-]": 0,
            "newton_iterations [-]": 3 * steps,
            "points_lost [-]": 0,
        },
    }
    with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
        json.dump(summary, file)
    return folder


def write_reference(path):
    with open(path, "w", encoding="utf-8") as file:
        file.write(
            "# source: a made-up test, figure 3\n# label: Experiment\nnominal_strain [permille],nominal_stress [MPa]\n"
            "0,0\n0.5,16\n1.0,28\n1.5,34\n2.0,30\n"
        )
    return path


RADIUS, LENGTH, PUSH = 0.025, 0.1, 4e-4
PUSH_AT_PEAK = 2.2e-4


def cylinder_fields(start, push, axis):
    """Fields of a compressed cylinder at places (n, 3) [m]: the stress along the axis differs from the middle to the
    side and from the ends to half the height; beyond the peak there is an inclined band of damage.
    """
    across = start[:, [d for d in range(3) if d != axis]]
    height, radius = start[:, axis], np.linalg.norm(across, axis=1)
    band = np.exp(-(((height - 0.5 * LENGTH - 1.3 * across[:, 0]) / 0.004) ** 2))
    damage = np.clip(2.0 * band * np.clip((push - PUSH_AT_PEAK) / 1e-4, 0.0, 1.0), 0.0, 0.99)
    stress = np.zeros((len(start), 6))
    level = -30e9 * min(push, PUSH_AT_PEAK) / LENGTH
    stress[:, axis] = level * (1.0 + 0.25 * (radius / RADIUS) ** 2 * np.cos(2 * np.pi * height / LENGTH)) * (1 - damage)
    displacement = 0.2 * push * start / LENGTH
    displacement[:, axis] = -push * height / LENGTH
    return {
        "displacement": displacement,
        "stress": stress,
        "strain": np.zeros((len(start), 6)),
        "damage": damage,
        "crack_opening": 1e-4 * damage,
    }


def disc_grid(count):
    """(nodes (count + 1)^2 in the unit disc, quadrilaterals): a square of cells, mapped."""
    line = np.linspace(-1.0, 1.0, count + 1)
    u, v = (a.ravel() for a in np.meshgrid(line, line))
    nodes = np.stack([u * np.sqrt(1.0 - 0.5 * v**2), v * np.sqrt(1.0 - 0.5 * u**2)], axis=1)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    return nodes, first[:, None] + [0, 1, count + 2, count + 1]


def turned(points, axis):
    """Bodies are made along z; this makes them stand along `axis`."""
    return np.roll(points, axis - 2, axis=1)


def cylinder_surface(segments=32):
    """(points, triangles): long slivers along the side, fans at the ends, as a coarse surface has them."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = RADIUS * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    points = np.vstack([ring, ring + [0.0, 0.0, LENGTH], [[0.0, 0.0, 0.0], [0.0, 0.0, LENGTH]]])
    a = np.arange(segments)
    b, n = (a + 1) % segments, segments
    low, high = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    sets = [(a, b, b + n), (a, b + n, a + n), (b, a, low), (a + n, b + n, high)]
    return points, np.vstack([np.stack(s, axis=1) for s in sets])


def box_surface(low, high):
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) * np.subtract(high, low) + low
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, np.array([t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))])


def write_cylinder(
    folder, method="mpm", axis=2, spacing=0.005, steps=40, times=(0.0, 0.25, 0.55, 1.0), noise=0.0, pieces=1
):
    """A 3D run: a cylinder compressed along `axis` by a rigid platen; a known field of stress (cylinder_fields).

    fem: hexahedra with a Gauss point each; with `pieces` the mesh files are those of as many processes.
    """
    os.makedirs(folder, exist_ok=True)
    count = max(2, round(2 * RADIUS / spacing))
    layers = round(LENGTH / spacing)
    if method == "mpm":
        line = (np.arange(count) + 0.5) * spacing - RADIUS
        x, y, z = (a.ravel() for a in np.meshgrid(line, line, (np.arange(layers) + 0.5) * spacing))
        inside = np.hypot(x, y) < RADIUS
        start = np.stack([x, y, z], axis=1)[inside]
        volume = np.full(len(start), spacing**3)
    else:
        disc, quads = disc_grid(count)
        disc = RADIUS * disc
        nodes = np.vstack([np.column_stack([disc, np.full(len(disc), k * spacing)]) for k in range(layers + 1)])
        cells = np.vstack([np.hstack([quads, quads + len(disc)]) + k * len(disc) for k in range(layers)])
        start = nodes[cells].mean(axis=1)
        sides = disc[quads]
        area = 0.5 * np.abs(np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1]))
        volume = np.tile(area, layers) * spacing
        nodes = turned(nodes, axis)
    start = turned(start, axis)
    random = np.random.default_rng(1)
    points, meshes = [], []
    for k, time in enumerate(times):
        fields = cylinder_fields(start, PUSH * time, axis)
        fields["stress"][:, axis] *= 1.0 + noise * random.standard_normal(len(start))
        points.append((time, f"points_{k:04d}.vtu"))
        more = {
            "position": start + fields["displacement"],
            "volume": volume,
            "body": np.zeros(len(start), dtype=np.int32),
            "id": np.arange(len(start), dtype=np.int64),
        }
        write_points(os.path.join(folder, points[-1][1]), {**fields, **more})
        if method == "fem":
            moved = cylinder_fields(nodes, PUSH * time, axis)["displacement"]
            names = [f"mesh_{k:04d}_{r}.vtu" for r in range(pieces)] if pieces > 1 else [f"mesh_{k:04d}.vtu"]
            for name, part in zip(names, np.array_split(np.arange(len(cells)), pieces)):
                used, own = np.unique(cells[part], return_inverse=True)
                data = {field: fields[field][part] for field in ("stress", "damage")}
                places, own = (nodes + moved)[used], own.reshape(-1, 8)
                write_grid(os.path.join(folder, name), places, 12, own, {"displacement": moved[used]}, data)
            meshes.append((time, names[0] if pieces == 1 else f"mesh_{k:04d}.pvtu"))
            if pieces > 1:
                write_pieces(os.path.join(folder, meshes[-1][1]), names)
    write_series(os.path.join(folder, "points.pvd"), points)
    if meshes:
        write_series(os.path.join(folder, "mesh.pvd"), meshes)
    bodies = {
        "specimen": cylinder_surface(),
        "platen": box_surface((-0.03, -0.03, LENGTH), (0.03, 0.03, LENGTH + 0.01)),
    }
    for name, (places, triangles) in bodies.items():
        write_grid(os.path.join(folder, f"surface_{name}.vtu"), turned(places, axis), 5, triangles)
    time = np.linspace(0.0, 1.0, steps + 1)
    push = PUSH * time
    stress = 30e9 / LENGTH * np.where(push <= PUSH_AT_PEAK, push, PUSH_AT_PEAK * np.exp((PUSH_AT_PEAK - push) / 1e-4))
    rows = zip(range(steps + 1), time, push, stress * np.pi * RADIUS**2, stress, push / LENGTH, time)
    with open(os.path.join(folder, "history.csv"), "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([COLUMNS[:7], *rows])
    motion = turned(np.array([[0.0, 0.0, -PUSH]]), axis)[0].tolist()
    summary = {
        "rigid_motion": {"platen": [[0.0, 0.0, 0.0, 0.0], [1.0, *motion]]},
        "title": "Cylinder in compression",
        "method": method,
        "status": "done",
        "dimension": 3,
        "axisymmetric": False,
        "processes": pieces,
        "body_rings": {},
        "body_surfaces": {name: f"surface_{name}.vtu" for name in bodies},
        "metrics": {"peak_stress [Pa]": stress.max(), "max_damage [-]": 0.9},
    }
    with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
        json.dump(summary, file)
    return folder
