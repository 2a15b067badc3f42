"""The output folder of a run as numpy arrays.

run = Run("out/case")
run.history["nominal_stress"]          # numpy array, units in run.units
run.summary["metrics"]["peak_load [N]"]
run.last()["damage"]                   # point fields of the last points_NNNN.vtu
"""

import csv
import json
import os
import re
import tomllib
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


def read_points(path):
    """Point fields of a .vtu as {name: array}, positions as "position" (n, 3)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
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
    grid = reader.GetOutput()
    data = grid.GetPointData()
    fields = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
    points = grid.GetPoints()
    fields["position"] = vtk_to_numpy(points.GetData()) if points else np.zeros((0, 3))
    return fields


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
        series = os.path.join(self.path, "points.pvd")
        self.frames = read_series(series) if os.path.isfile(series) else []

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
        """{name of a rigid body: its displacement [m] at that time} by case.toml; empty without that file.

        Motions are given at load factor 1 and grow with it (docs/case_reference.md).
        """
        path = os.path.join(self.path, "case.toml")
        if not os.path.isfile(path):
            return {}
        try:
            with open(path, "rb") as file:
                bodies = tomllib.load(file).get("body", {})
        except (OSError, tomllib.TOMLDecodeError) as error:
            raise ResultError(f"cannot read {path}: {error}") from None
        factor = np.interp(time, self.history["time"], self.history.get("load_factor", self.history["time"]))
        rigid = {name: body for name, body in bodies.items() if body.get("rigid")}
        return {name: factor * np.array(body.get("displacement", (0.0, 0.0)), float) for name, body in rigid.items()}

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
