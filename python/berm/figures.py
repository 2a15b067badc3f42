"""The figures of the report. Each function returns a matplotlib figure."""

import math
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import LinearSegmentedColormap  # noqa: E402

from berm.raster import paint  # noqa: E402

DPI = 150
RUN_COLOURS = ("#0b5394", "#c0504d", "#3a7d44", "#8e6bb0", "#b8860b", "#4f8a8b", "#7f4f24", "#5b5b5b")
REFERENCE_STYLES = ("--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
FRACTURE = LinearSegmentedColormap.from_list("fracture", ["#f1efe9", "#f6c57b", "#d9502b", "#5c0a1d"])

plt.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 8.5,
        "axes.titlesize": 9,
        "axes.labelsize": 8.5,
        "axes.linewidth": 0.6,
        "axes.edgecolor": "#444444",
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#e3e3e3",
        "grid.linewidth": 0.5,
        "lines.linewidth": 1.4,
        "legend.fontsize": 8,
        "legend.frameon": False,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "figure.dpi": DPI,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.formatter.useoffset": False,
        "hatch.linewidth": 0.4,
    }
)

SCALES = {
    "Pa": ((1e9, "GPa"), (1e5, "MPa"), (1e2, "kPa"), (0.0, "Pa")),
    "N": ((1e6, "MN"), (1e3, "kN"), (0.0, "N")),
    "m": ((2.0, "m"), (1e-4, "mm"), (0.0, "µm")),
    "J": ((1e4, "kJ"), (1.0, "J"), (0.0, "mJ")),
}
FACTORS = {
    "GPa": 1e9,
    "MPa": 1e6,
    "kPa": 1e3,
    "Pa": 1.0,
    "MN": 1e6,
    "kN": 1e3,
    "N": 1.0,
    "m": 1.0,
    "mm": 1e-3,
    "µm": 1e-6,
    "kJ": 1e3,
    "J": 1.0,
    "mJ": 1e-3,
}


def unit_for(base, largest):
    """(factor, unit) that makes numbers up to `largest` readable: stress_in_MPa = stress / factor."""
    for least, unit in SCALES[base]:
        if largest >= least:
            return FACTORS[unit], unit
    return 1.0, base  # NaN


def largest(arrays):
    values = [np.nanmax(np.abs(a)) for a in arrays if a.size and np.isfinite(a).any()]
    return max(values, default=0.0)


@dataclass
class Axis:
    column: str
    label: str
    base: str  # unit in the history; "" for strains, shown in 1e-3


STRESS_STRAIN = (Axis("nominal_strain", "Nominal strain", ""), Axis("nominal_stress", "Nominal stress", "Pa"))
LOAD_DISPLACEMENT = (Axis("imposed_displacement", "Imposed displacement", "m"), Axis("reaction", "Load", "N"))


def curve_figure(runs, labels, references, axes):
    """Runs and reference curves in one diagram; None if no run has both columns with values."""
    drawn = [
        (run, label, k)
        for k, (run, label) in enumerate(zip(runs, labels))
        if all(a.column in run.history for a in axes)
    ]
    if not any(largest([run.history[a.column]]) > 0.0 for run, _, _ in drawn for a in axes[1:]):
        return None
    overlaid = [curve for curve in references if all(a.column in curve.columns for a in axes)]
    factors, names = [], []
    for axis in axes:
        arrays = [run.history[axis.column] for run, _, _ in drawn] + [c.columns[axis.column] for c in overlaid]
        factor, unit = unit_for(axis.base, largest(arrays)) if axis.base else (1e-3, "10⁻³")
        factors.append(factor)
        names.append(f"{axis.label} [{unit}]")
    figure, plot = plt.subplots(figsize=(5.6, 3.9), layout="constrained")
    for k, curve in enumerate(overlaid):
        x, y = (curve.columns[a.column] / f for a, f in zip(axes, factors))
        plot.plot(
            x,
            y,
            color="#222222",
            linestyle=REFERENCE_STYLES[k % len(REFERENCE_STYLES)],
            linewidth=1.1,
            label=curve.label,
            marker="o" if len(x) <= 30 else None,
            markersize=3,
            markerfacecolor="white",
            markeredgewidth=0.8,
        )
    for run, label, k in drawn:
        x, y = (run.history[a.column] / f for a, f in zip(axes, factors))
        colour = RUN_COLOURS[k % len(RUN_COLOURS)]
        plot.plot(x, y, color=colour, label=label)
        peak = run.peak_row()
        if peak is not None:
            plot.plot(x[peak], y[peak], "o", color=colour, markersize=4, markeredgecolor="white", markeredgewidth=0.6)
    plot.set_xlabel(names[0])
    plot.set_ylabel(names[1])
    plot.axhline(0.0, color="#444444", linewidth=0.5)
    plot.margins(x=0.02)
    entries = len(overlaid) + len(drawn)
    if entries <= 4:
        plot.legend(loc="best")
    else:  # would hide the curves
        figure.set_figheight(3.9 + 0.2 * math.ceil(entries / 3))
        plot.legend(loc="upper center", bbox_to_anchor=(0.48, -0.14), ncols=3, columnspacing=1.5)
    return figure


ENERGIES = (
    ("external_work", "External work", "#222222", "-"),
    ("elastic_energy", "Elastic", "#0b5394", "-"),
    ("dissipated_energy", "Dissipated", "#c0504d", "-"),
)


def energy_figure(runs, labels):
    """Energies over time, a panel a run; None without energies."""
    drawn = [(run, label) for run, label in zip(runs, labels) if all(c in run.history for c, *_ in ENERGIES)]
    top = largest([run.history[c] for run, _ in drawn for c, *_ in ENERGIES])
    if top == 0.0:
        return None
    factor, unit = unit_for("J", top)
    columns = 2 if len(drawn) == 4 else min(len(drawn), 3)
    rows = math.ceil(len(drawn) / columns)
    width = 5.6 if columns == 1 else 3.7 * columns
    figure, panels = plt.subplots(
        rows, columns, figsize=(width, 3.3 * rows), sharex=True, sharey=True, squeeze=False, layout="constrained"
    )
    for panel, (run, label) in zip(panels.flat, drawn):
        time = run.history["time"]
        for column, name, colour, style in ENERGIES:
            panel.plot(time, run.history[column] / factor, color=colour, linestyle=style, label=name)
        inner = run.history["elastic_energy"] + run.history["dissipated_energy"]
        panel.plot(
            time, inner / factor, color="#e69f00", linestyle=(0, (4, 2)), linewidth=1.2, label="Elastic + dissipated"
        )
        panel.set_title(label, loc="left")
        panel.margins(x=0.01)
    for panel in list(panels.flat)[len(drawn) :]:
        panel.set_visible(False)
    for panel in list(panels.flat)[max(0, len(drawn) - columns) : len(drawn)]:  # nothing below
        panel.set_xlabel("Time [s]")
        panel.tick_params(labelbottom=True)
    for panel in panels[:, 0]:
        panel.set_ylabel(f"Energy [{unit}]")
    panels[0, 0].legend(loc="best")
    return figure


@dataclass
class Field:
    """A map: its name, what to show of a frame, its unit in the file and its colours."""

    name: str
    label: str
    base: str
    kind: str  # "fraction" 0..1, "opening", "magnitude", "signed"
    array: str
    component: int | None = None  # -1: magnitude

    def of(self, frame):
        """Values at the points; None if the frame does not have them."""
        values = frame.get(self.array)
        if values is None:
            return None
        if self.component is None:
            return np.asarray(values, dtype=float)
        return np.linalg.norm(values, axis=1) if self.component == -1 else values[:, self.component]


MAPS = (
    Field("damage", "Damage", "", "fraction", "damage"),
    Field("crack_opening", "Crack opening", "m", "opening", "crack_opening"),
    Field("stress_xx", "Stress σxx", "Pa", "signed", "stress", 0),
    Field("stress_yy", "Stress σyy", "Pa", "signed", "stress", 1),
    Field("stress_xy", "Stress σxy", "Pa", "signed", "stress", 3),
    Field("displacement", "Displacement", "m", "magnitude", "displacement", -1),
)


def colour_limits(kind, arrays):
    """Common limits of all runs, robust against a few extreme points."""
    if kind == "fraction":
        return 0.0, 1.0
    if kind == "signed":
        limit = max(np.abs(np.nanpercentile(a, (1.0, 99.0))).max() for a in arrays)
        limit = limit or largest(arrays)
        return -limit, limit
    if kind == "magnitude":
        return 0.0, largest(arrays)
    positive = [a[a > 0.0] for a in arrays if (a > 0.0).any()]
    return 0.0, max((np.percentile(a, 99.5) for a in positive), default=0.0)


def map_figure(scenes, field, heading, notes):
    """One field, runs side by side, one colour scale; None if no run has it."""
    pairs = [(scene, note, field.of(scene.frame)) for scene, note in zip(scenes, notes)]
    pairs = [(s, n, v) for s, n, v in pairs if v is not None]
    if not pairs:
        return None
    arrays = [v for _, _, v in pairs]
    low, high = colour_limits(field.kind, arrays)
    factor, unit = unit_for(field.base, max(abs(low), abs(high))) if field.base else (1.0, "-")
    if high <= low:
        high = low + factor  # a field of zeros
    figure, panels, bar_axes = _panels(pairs[0][0].extent, len(pairs))
    colours = {"fraction": FRACTURE, "opening": FRACTURE, "magnitude": "viridis", "signed": "RdBu_r"}
    length_factor, length_unit = unit_for("m", max(np.abs(pairs[0][0].extent)))
    for panel, (scene, note, values) in zip(panels, pairs):
        image = panel.imshow(
            paint(scene.picture, values) / factor,
            origin="lower",
            extent=np.divide(scene.extent, length_factor),
            vmin=low / factor,
            vmax=high / factor,
            cmap=colours[field.kind],
            aspect="equal",
        )
        scene.draw_bodies(panel, length_factor)
        panel.set_xlim(np.array(scene.extent[:2]) / length_factor)
        panel.set_ylim(np.array(scene.extent[2:]) / length_factor)
        panel.grid(False)
        panel.set_title(f"{scene.label}\n{note}", loc="left", fontsize=8)
        panel.set_xlabel(f"x [{length_unit}]\n{span_text(values, factor, unit)}")
        panel.locator_params(nbins=4, axis="x")
        if panel.get_ylabel():
            panel.set_ylabel(f"y [{length_unit}]")
    top, bottom = max(a.max() for a in arrays), min(a.min() for a in arrays)
    extend = {(False, False): "neither", (True, False): "max", (False, True): "min", (True, True): "both"}[
        (top > high * (1 + 1e-9), bottom < low * (1 + 1e-9) and low < 0.0)
    ]
    bar = figure.colorbar(image, cax=bar_axes, extend=extend)
    bar.set_label(f"{field.label} [{unit}]")
    bar.outline.set_linewidth(0.5)
    figure.text(
        LEFT / figure.get_figwidth(),
        1.0 - 0.08 / figure.get_figheight(),
        f"{field.label}, {heading}",
        va="top",
        fontsize=9.5,
        fontweight="bold",
    )
    return figure


def span_text(values, factor, unit):
    """The extremes of a map; what is a billionth of the larger one is zero."""
    ends = np.array([values.min(), values.max()]) / factor
    ends[np.abs(ends) < 1e-9 * np.abs(ends).max()] = 0.0
    low, high = (f"{end:.4g}".replace("-", "−") for end in ends)
    return f"{low} to {high}" + ("" if unit == "-" else f" {unit}")


# Margins of the map figures [inch]: fixed, so that panels keep the body's shape whatever their number.
LEFT, RIGHT, HEADING, ABOVE, BELOW, GAP = 0.65, 0.95, 0.3, 0.42, 0.58, 0.28


def _panels(extent, count):
    """(figure, axes of `count` panels of that shape, axes of the colour bar)."""
    width, height = extent[1] - extent[0], extent[3] - extent[2]
    columns = 2 if count == 4 else min(count, 3)
    rows = math.ceil(count / columns)
    scale = min(4.2 / height, {1: 6.5, 2: 4.6, 3: 3.4}[columns] / width)
    panel_width, panel_height = scale * width, scale * height
    cell_width, cell_height = max(panel_width, 2.25) + GAP, ABOVE + panel_height + BELOW
    total_width, total_height = LEFT + columns * cell_width + RIGHT, HEADING + rows * cell_height
    figure = plt.figure(figsize=(total_width, total_height))

    def axes(left, top, across, down):
        return figure.add_axes(
            (left / total_width, 1.0 - (top + down) / total_height, across / total_width, down / total_height)
        )

    panels = []
    for k in range(count):
        row, column = divmod(k, columns)
        panel = axes(LEFT + column * cell_width, HEADING + row * cell_height + ABOVE, panel_width, panel_height)
        panel.tick_params(labelleft=column == 0)
        panel.set_ylabel("y" if column == 0 else "")
        panels.append(panel)
    bar_height = max(1.0, 0.92 * panel_height)
    middle = HEADING + ABOVE + 0.5 * panel_height
    bar = axes(LEFT + columns * cell_width - GAP + 0.25, middle - 0.5 * bar_height, 0.13, bar_height)
    return figure, panels, bar
