"""The output folder of a run as numpy arrays.

run = Run("out/case")
run.history["nominal_stress"]          # numpy array, units in run.units
run.summary["metrics"]["peak_load [N]"]
run.last()["damage"]                   # point fields of the last points_NNNN.vtu or .pvtu
"""

import codecs
import contextlib
import csv
import math
import os
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

from berm.errors import ResultError
from berm.files import may_never_end
from berm.summary import read_summary
from berm.words import readable

# SI values of the units of columns, by dimension: those of case files (src/case/units.cpp), and parts of one.
UNITS = {
    "strain": {"-": 1.0, "1": 1.0, "%": 1e-2, "permille": 1e-3, "‰": 1e-3},
    "length": {"m": 1.0, "km": 1e3, "dm": 1e-1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "stress": {
        "Pa": 1.0,
        "kPa": 1e3,
        "MPa": 1e6,
        "GPa": 1e9,
        "bar": 1e5,
        "N/m2": 1.0,
        "kN/m2": 1e3,
        "MN/m2": 1e6,
        "N/mm2": 1e6,
        "kN/mm2": 1e9,
    },
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "angle": {"deg": 1.0, "°": 1.0, "rad": 180.0 / math.pi},  # in degrees, as in case files
}
BLANK = " \t\r"


def split_unit(header):
    """("reaction", "N") for "reaction [N]"; the unit is "" where there is none."""
    header = header.strip(BLANK)
    name, bracket, unit = header.rpartition("[")
    if not bracket or not header.endswith("]"):
        return header, ""
    return name.strip(BLANK), unit[:-1].strip(BLANK)


def read_table(path):
    """(columns, units, comments) of a CSV file whose header carries units.

    Lines that start with # are comments. A last row cut short by a killed run is dropped.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            lines = file.read().splitlines()
        rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
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
        entries = [(float(e.get("timestep", "")), e.get("file", "")) for e in root.iter("DataSet")]
    except (OSError, ElementTree.ParseError, ValueError) as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    return [(time, os.path.join(os.path.dirname(path), file)) for time, file in entries]


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


@contextlib.contextmanager
def silent_vtk():
    """Without VTK's own words on standard error: they tell of its sources, not of the file."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(vtkLogger.ConvertToVerbosity(before))


def check_size(path):
    """VTK makes room for as many points and cells as the head of a file names, and ends the process if it cannot."""
    most = 1000 * os.path.getsize(path)  # as many bytes zlib makes of one
    with open(path, "rb") as file:
        head = file.read(4096)
    if any(int(number) > most for number in re.findall(rb'NumberOf(?:Points|Cells)="(\d{1,30})', head)):
        raise ResultError(f"{path}: names more points or cells than it can hold: it is damaged (run the case again)")


def read_grid(path):
    """The vtkUnstructuredGrid of one .vtu."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    if not os.path.isfile(path):
        raise ResultError(f"{path} does not exist")
    check_size(path)
    reader = vtkXMLUnstructuredGridReader()
    errors = []
    for source in (reader, reader.GetExecutive()):
        source.AddObserver("ErrorEvent", lambda *_: errors.append(path))
    reader.SetFileName(os.fsencode(path))  # as text it must be UTF-8
    with silent_vtk():
        reader.Update()
    if errors:
        raise ResultError(f"VTK cannot read {path}: it is damaged or cut off (run the case again)")
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


def find_unit(name):
    """(dimension, SI value of one) of a unit; None if it is not known. "mm²", "mm^2" and "mm 2" are "mm2"."""
    plain = name.translate(str.maketrans({" ": None, "^": None, "²": "2", "³": "3", "µ": "u", "μ": "u"}))
    return next(((dimension, units[plain]) for dimension, units in UNITS.items() if plain in units), None)


def read_lines(path):
    """[(number, text)] of the lines of a text that are not empty; what is no UTF-8 is Latin-1."""
    if may_never_end(path):
        raise ResultError(f"cannot read {path}: it is no regular file (a pipe may never end: save it as CSV)")
    try:
        with open(path, "rb") as file:
            content = file.read()
    except OSError as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    if b"\0" in content:
        raise ResultError(f"{path}: is no text in UTF-8 or Latin-1 (export it as CSV)")
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return [(k, line) for k, line in enumerate(re.split(r"\r\n|\r|\n", text), 1) if line.strip(BLANK)]


def split_cells(line, delimiter):
    """Cells may be quoted, with "" for a quote, exactly as src/case/reference_file.cpp cuts them; the csv module does not."""
    if '"' not in line:
        return line.split(delimiter)
    cells, quoted, k = [""], False, 0
    while k < len(line):
        if quoted and line.startswith('""', k):
            cells[-1] += '"'
            k += 1
        elif line[k] == '"':
            quoted = not quoted
        elif line[k] == delimiter and not quoted:
            cells.append("")
        else:
            cells[-1] += line[k]
        k += 1
    return cells


def find_delimiter(line, given):
    """Commas come last: they may be decimal ones, and stand in names."""
    return given or next((c for c in "\t;|" if len(split_cells(line, c)) > 1), ",")


# What std::from_chars takes.
NUMBER = re.compile(r"-?(?P<digits>[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
NAN = re.compile(r"-?nan(?:\([A-Za-z0-9_]*\))?", re.IGNORECASE)


def find_number(cell):
    """A decimal comma is one; NaN for an empty cell, a gap of the measurement. ValueError for what the reader of cases does not
    take: 1_000, inf, and numbers beyond those of doubles."""
    text = cell.strip(BLANK)
    if "." not in text and text.count(",") == 1:
        text = text.replace(",", ".")
    signless = text.removeprefix("+")
    if not text or NAN.fullmatch(signless):
        return np.nan
    match = NUMBER.fullmatch(signless)
    value = float(signless) if match else np.inf
    if np.isinf(value) or (value == 0.0 and match["digits"].strip("0.")):
        raise ValueError(f"{text} is no number")
    return value


class Curve:
    """A reference curve in SI units: columns of time, nominal_strain, nominal_stress, imposed_displacement, reaction.

    `reference`: a path, or {"file", "x", "y", "delimiter", "label"} as in output.references of a case. By the rules of
    src/case/reference_file.cpp, which has looked at the file before the run.
    """

    DIMENSIONS = {
        "nominal_strain": "strain",
        "nominal_stress": "stress",
        "imposed_displacement": "length",
        "reaction": "force",
    }
    AXES = {
        "x": {"strain": "nominal_strain", "length": "imposed_displacement", "time": "time"},
        "y": {"stress": "nominal_stress", "force": "reaction"},
    }
    FARTHEST_HEADER = 50  # lines of what a testing machine writes before the names of the columns

    def __init__(self, reference):
        about = {"file": reference} if isinstance(reference, (str, os.PathLike)) else reference
        self.path = os.fspath(about["file"])
        self.delimiter = about.get("delimiter", "")[:1]
        lines = read_lines(self.path)
        notes = dict(line[1:].split(":", 1) for _, line in lines if line.startswith("#") and ":" in line)
        notes = {key.strip(): value.strip() for key, value in notes.items()}
        self.source = notes.get("source", "")
        name = os.path.splitext(os.path.basename(self.path))[0]
        self.label = readable(about.get("label") or notes.get("label") or name)
        self.lines = [(number, line) for number, line in lines if not line.startswith("#")]
        if not self.lines:
            raise ResultError(f"{self.path} is empty")
        wanted = [about[key] for key in ("x", "y") if about.get(key)]
        found = self._named_columns(wanted) if wanted else self._standard_columns()
        self.columns = self._read_rows(found)

    def _fail(self, number, text):
        raise ResultError(f"{self.path}:{number}: {text}")

    def _find_header(self, fits):
        """The first line with columns that fit; else the first of the widest."""
        found = None
        for k, (number, line) in enumerate(self.lines[: self.FARTHEST_HEADER]):
            cells = [split_unit(cell) for cell in split_cells(line, find_delimiter(line, self.delimiter))]
            good = fits(cells)
            if good or found is None or len(cells) > len(found[2]):
                found = (k, number, cells)
            if good:
                break
        self.header, self.header_line, self.cells = found

    @staticmethod
    def _matches(cells, name):
        name, unit = split_unit(name)
        return [k for k, (other, its) in enumerate(cells) if other == name and (not unit or not its or unit == its)]

    def _no_column(self, name):
        there = '", "'.join(f"{n} [{u}]" if u else n for n, u in self.cells)
        self._fail(self.header_line, f'no column "{name}"; there are "{there}"')

    def _named_columns(self, wanted):
        """{column of a history: (index, SI value of its unit)}"""
        self._find_header(lambda cells: all(self._matches(cells, name) for name in wanted))
        found = {}
        for axis, name in zip(self.AXES, wanted):
            matches = self._matches(self.cells, name)
            if len(matches) != 1:
                self._fail(self.header_line, f'more than one column is "{name}"') if matches else self._no_column(name)
            unit = split_unit(name)[1] or self.cells[matches[0]][1]
            dimension, factor = find_unit(unit) or (None, 0.0)
            if dimension not in self.AXES[axis]:
                known = ", ".join(u for d in self.AXES[axis] for u in UNITS[d])
                self._fail(self.header_line, f'column "{name}" has the unit "{unit}"; {axis} may have {known}')
            found[self.AXES[axis][dimension]] = (matches[0], factor)
        return found

    def _standard_columns(self):
        self._find_header(lambda cells: len({name for name, _ in cells} & set(self.DIMENSIONS)) >= 2)
        found = {}
        for k, (name, unit) in enumerate(self.cells):
            if name not in self.DIMENSIONS:
                continue
            dimension, factor = find_unit(unit) or (None, 0.0)
            if dimension != self.DIMENSIONS[name]:
                known = ", ".join(UNITS[self.DIMENSIONS[name]])
                self._fail(self.header_line, f'column "{name}" has the unit "{unit}"; known: {known}')
            if name in found:
                self._fail(self.header_line, f'more than one column is "{name}"')
            found[name] = (k, factor)
        if len(found) < 2:
            self._no_column('" or "'.join(self.DIMENSIONS))
        return found

    def _number(self, line, index, cell):
        try:
            return find_number(cell)
        except ValueError:
            self._fail(line, f'"{cell.strip(BLANK)}" in column "{self.cells[index][0]}" is no number')

    def _read_rows(self, found):
        """The rows with numbers in all columns."""
        delimiter = find_delimiter(self.lines[self.header][1], self.delimiter)
        rows, texts = [], ""
        for k, (number, line) in enumerate(self.lines[self.header + 1 :], self.header + 2):
            cells = split_cells(line, delimiter)
            few = len(cells) <= max(index for index, _ in found.values())
            if few and k == len(self.lines):
                break  # cut short by a run that was killed
            if few or any(cell.strip(BLANK) for cell in cells[len(self.cells) :]):
                self._fail(number, f"{len(cells)} cells, where the header has {len(self.cells)}")
            rows.append([self._number(number, index, cells[index]) * factor for index, factor in found.values()])
            texts += "".join(c for index, _ in found.values() for c in cells[index] if c in ".,")
        if "." in texts and "," in texts:
            self._fail(self.header_line, "the file has decimal commas and decimal points")
        values = np.array(rows).reshape(len(rows), len(found))
        values = values[np.isfinite(values).all(axis=1)]
        if not len(values):
            self._fail(self.header_line, "no row below it has numbers in the columns")
        return {name: values[:, k] for k, name in enumerate(found)}


class Run:
    """One output folder. Raises ResultError if it holds no history.csv."""

    def __init__(self, path):
        self.path = os.fspath(path)
        history = os.path.join(self.path, "history.csv")
        if not os.path.isfile(history):
            if os.path.isdir(self.path) and not os.access(self.path, os.R_OK | os.X_OK):
                raise ResultError(f"{self.path} cannot be read: permission denied")
            raise ResultError(
                f"{self.path} holds no history.csv: not the output folder of a run, or the run never started"
            )
        self.history, self.units, _ = read_table(history)
        if not np.isfinite(self.history.get("time", 0.0)).all():
            raise ResultError(f"{history}: a row has no time: it is damaged (run the case again)")
        summary = os.path.join(self.path, "summary.json")
        self.summary = read_summary(summary) if os.path.isfile(summary) else {}
        self.frames, self.mesh_frames = (
            read_series(series) if os.path.isfile(series) else []
            for series in (os.path.join(self.path, name) for name in ("points.pvd", "mesh.pvd"))
        )

    @property
    def name(self):
        return readable(os.path.basename(os.path.normpath(os.path.abspath(self.path))))

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

    @property
    def damaged(self):
        """Something is damaged at some time."""
        worst = self.metric("max_damage")
        return bool(np.nanmax(self.history.get("max_damage", 0.0)) if worst is None else worst)

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
            if not instants:
                continue
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
