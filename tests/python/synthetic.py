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
