"""The output folder of a run as numpy arrays.

run = Run("out/case")
run.history["nominal_stress"]          # numpy array, units in run.units
run.summary["metrics"]["peak_load [N]"]
run.last()["damage"]                   # point fields of the last points_NNNN.vtu or .pvtu
"""

import csv
import json
import os
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

TO_SI = {
    "m": 1.0,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "cm": 1e-2,
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "N/mm2": 1e6,
    "N": 1.0,
    "kN": 1e3,
    "MN": 1e6,
    "J": 1.0,
    "kJ": 1e3,
    "s": 1.0,
    "-": 1.0,
    "%": 1e-2,
    "permille": 1e-3,
}


class ResultError(Exception):
    """The folder or file is not what it should be; the message says which and why."""


def split_unit(header):
    """("reaction", "N") for "reaction [N]"; the unit is "" where there is none."""
    match = re.fullmatch(r"\s*(.*?)\s*(?:\[([^\]]*)\])?\s*", header)
    return match.group(1), match.group(2) or ""


def read_table(path):
    """(columns, units, comments) of a CSV file whose header carries units.

    Lines that start with # are comments. A last row cut short by a killed run is dropped.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    rows = [row for row in csv.reader(line for line in lines if line.strip() and not line.startswith("#"))]
    if not rows:
        raise ResultError(f"{path} is empty")
    names = [split_unit(cell) for cell in rows[0]]
    body = rows[1:]
    if body and len(body[-1]) != len(names):
        body = body[:-1]
    try:
        values = np.array([[float(cell) for cell in row] for row in body]).reshape(len(body), len(names))
    except ValueError as error:
        raise ResultError(f"{path}: every row needs {len(names)} numbers ({error})") from None
    columns = {name: values[:, k] for k, (name, _) in enumerate(names)}
    return columns, dict(names), comments


def read_series(path):
    """[(time, file)] of a .pvd, files with their folder."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    folder = os.path.dirname(path)
    return [(float(e.get("timestep")), os.path.join(folder, e.get("file"))) for e in root.iter("DataSet")]


def read_pieces(path):
    """Files of a .pvtu in its order, with their folder; a .vtu is its own only piece."""
    if not path.endswith(".pvtu"):
        return [path]
    if not os.path.isfile(path):
        raise ResultError(f"{path} does not exist")
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    pieces = [os.path.join(os.path.dirname(path), e.get("Source", "")) for e in root.iter("Piece")]
    if not pieces:
        raise ResultError(f"{path} names no pieces")
    for piece in pieces:
        if not os.path.isfile(piece):
            raise ResultError(f"{path} names the piece {piece}, which does not exist")
    return pieces


def read_grid(path):
    """The vtkUnstructuredGrid of one .vtu."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    if not os.path.isfile(path):
        raise ResultError(f"{path} does not exist")
    reader = vtkXMLUnstructuredGridReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(path))
    reader.SetFileName(path)
    reader.Update()
    if errors:
        raise ResultError(f"VTK cannot read {path}")
    return reader.GetOutput()


def read_points(path):
    """Point fields of a .vtu or .pvtu as {name: array}, positions as "position" (n, 3), sorted by "id" if it is there.

    So the results of different numbers of processes have the same points in the same places of the arrays.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    parts = []
    for piece in read_pieces(path):
        grid = read_grid(piece)
        data, points = grid.GetPointData(), grid.GetPoints()
        part = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
        part["position"] = vtk_to_numpy(points.GetData()) if points else np.zeros((0, 3))
        parts.append((piece, part))
    # A process without points may write a piece without fields.
    filled = [(piece, part) for piece, part in parts if len(part["position"])] or parts[:1]
    for piece, part in filled[1:]:
        odd = set(part) ^ set(filled[0][1])
        if odd:
            raise ResultError(f"{path}: {filled[0][0]} and {piece} do not both have the field {sorted(odd)[0]}")
    fields = {name: np.concatenate([part[name] for _, part in filled]) for name in filled[0][1]}
    if "id" in fields:
        order = np.argsort(fields["id"], kind="stable")
        if (np.diff(fields["id"][order]) == 0).any():
            raise ResultError(f"{path}: two points have the same id")
        fields = {name: values[order] for name, values in fields.items()}
    return fields


def read_mesh(path):
    """The vtkUnstructuredGrid of a .vtu or .pvtu. Pieces are put side by side: nodes that they share appear in each."""
    grids = [read_grid(piece) for piece in read_pieces(path)]
    if len(grids) == 1:
        return grids[0]
    from vtkmodules.vtkFiltersCore import vtkAppendFilter

    append = vtkAppendFilter()
    for grid in grids:
        if grid.GetNumberOfCells():  # an empty piece without fields would remove them from all
            append.AddInputData(grid)
    append.Update()
    return append.GetOutput()


def read_surface(path):
    """(points (n, 3) [m], triangles (m, 3)) of the surface of a body; points at the same place are one."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    grid = read_mesh(path)
    if not grid.GetNumberOfCells():
        raise ResultError(f"{path} has no triangles")
    if not grid.IsHomogeneous() or grid.GetCellType(0) != 5:
        raise ResultError(f"{path} must hold triangles only")
    places = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
    size = np.ptp(places, axis=0).max() or 1.0
    _, first, merged = np.unique(np.rint(places / (1e-9 * size)), axis=0, return_index=True, return_inverse=True)
    triangles = merged.reshape(-1)[triangles]
    proper = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return places[first], triangles[proper]


class Curve:
    """A reference curve in SI units: columns of nominal_strain, nominal_stress, imposed_displacement, reaction."""

    NAMES = ("nominal_strain", "nominal_stress", "imposed_displacement", "reaction")

    def __init__(self, path):
        self.path = path
        columns, units, comments = read_table(path)
        notes = dict(c.split(":", 1) for c in comments if ":" in c)
        self.source = notes.get("source", "").strip()
        self.label = notes.get("label", "").strip() or os.path.splitext(os.path.basename(path))[0]
        self.columns = {}
        for name, values in columns.items():
            if name not in self.NAMES:
                continue
            if units[name] not in TO_SI:
                raise ResultError(f'{path}: column "{name}" has unit "{units[name]}"; known: {", ".join(TO_SI)}')
            self.columns[name] = values * TO_SI[units[name]]
        if len(self.columns) < 2:
            raise ResultError(f"{path}: a reference curve needs two of the columns {', '.join(self.NAMES)}")


class Run:
    """One output folder. Raises ResultError if it holds no history.csv."""

    def __init__(self, path):
        self.path = os.fspath(path)
        history = os.path.join(self.path, "history.csv")
        if not os.path.isfile(history):
            raise ResultError(
                f"{self.path} holds no history.csv: not the output folder of a run, or the run never started"
            )
        self.history, self.units, _ = read_table(history)
        self.summary = self._read_summary()
        self.frames, self.mesh_frames = (
            read_series(series) if os.path.isfile(series) else []
            for series in (os.path.join(self.path, name) for name in ("points.pvd", "mesh.pvd"))
        )

    def _read_summary(self):
        path = os.path.join(self.path, "summary.json")
        if not os.path.isfile(path):
            return {}
        try:
            with open(path, encoding="utf-8") as file:
                return json.load(file)
        except (OSError, ValueError) as error:
            raise ResultError(f"cannot read {path}: {error}") from None

    @property
    def name(self):
        return os.path.basename(os.path.normpath(os.path.abspath(self.path)))

    @property
    def dimension(self):
        return int(self.summary.get("dimension") or 2)

    @property
    def axisymmetric(self):
        """x is the radius, y the axis, zz the hoop direction."""
        return bool(self.summary.get("axisymmetric"))

    def surfaces(self):
        """{name of a body: (points (n, 3) [m], triangles (m, 3))} at the start; empty if the run does not tell."""
        files = self.summary.get("body_surfaces") or {}
        return {name: read_surface(os.path.join(self.path, file)) for name, file in files.items()}

    def metric(self, name):
        """A metric of summary.json by its name with or without unit; None if it is not there or not defined."""
        for key, value in self.summary.get("metrics", {}).items():
            if name in (key, split_unit(key)[0]):
                return value
        return None

    def peak_row(self):
        """Row of the history with the largest nominal stress (in size); None without a load."""
        stress = self.history.get("nominal_stress", np.zeros(0))
        if not stress.size or not np.nanmax(np.abs(stress), initial=0.0) > 0.0:
            return None
        return int(np.nanargmax(np.abs(stress)))

    def rigid_displacements(self, time):
        """{name of a rigid body: its displacement [m] at the time of a frame}, from summary.json."""
        moved = {}
        for name, instants in self.summary.get("rigid_motion", {}).items():
            instants = np.array(instants, float).reshape(-1, 4)
            moved[name] = np.array([np.interp(time, instants[:, 0], u) for u in instants.T[1 : 1 + self.dimension]])
        return moved

    def frame(self, index):
        """Point fields of a frame, with its "time" [s]. Negative indices count from the end."""
        if not self.frames:
            raise ResultError(f"{self.path} holds no points.pvd")
        time, file = self.frames[index]
        return {"time": time, **read_points(file)}

    def last(self):
        return self.frame(-1)

    def frame_at(self, time):
        """Number of the frame closest to that time."""
        return int(np.argmin([abs(t - time) for t, _ in self.frames]))

    def mesh_at(self, time):
        """The vtkUnstructuredGrid of mesh.pvd closest to that time; None without such files."""
        if not self.mesh_frames:
            return None
        return read_mesh(min(self.mesh_frames, key=lambda frame: abs(frame[0] - time))[1])
