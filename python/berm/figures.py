"""The figures of the report. Each function returns a matplotlib figure."""

import math
from dataclasses import dataclass

import numpy as np

from berm.plotting import plt  # before the rest of matplotlib
from berm.raster import paint
from matplotlib.colors import LinearSegmentedColormap

DPI = 150
RUN_COLOURS = ("#0b5394", "#c0504d", "#3a7d44", "#8e6bb0", "#b8860b", "#4f8a8b", "#7f4f24", "#5b5b5b")
REFERENCE_STYLES = ("--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
FRACTURE = LinearSegmentedColormap.from_list("fracture", ["#f1efe9", "#f6c57b", "#d9502b", "#5c0a1d"])

plt.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 8.5,
        "text.parse_math": False,  # a $ in a name is one
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
    "s": ((0.0, "s"),),
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
    "s": 1.0,
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
TIME = Axis("time", "Time", "s")


def diagrams(references):
    """(name, alternative text, axes) of load curves: two kinds, and others that a reference curve is for."""
    found = [
        ("stress_strain", "Nominal stress over nominal strain", STRESS_STRAIN),
        ("load_displacement", "Load over imposed displacement", LOAD_DISPLACEMENT),
    ]
    xs, ys = (STRESS_STRAIN[0], LOAD_DISPLACEMENT[0], TIME), (STRESS_STRAIN[1], LOAD_DISPLACEMENT[1])
    for x, y in ((x, y) for x in xs for y in ys):
        wanted = any(x.column in c.columns and y.column in c.columns for c in references)
        drawn = any(axes == (x, y) for _, _, axes in found)
        if wanted and not drawn:
            found.append((f"{y.column}_{x.column}", f"{y.label} over {x.label.lower()}", (x, y)))
    return found


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
    place_legend(figure, plot)
    return figure


ENERGIES = (
    ("external_work", "External work", "#222222", "-"),
    ("elastic_energy", "Elastic", "#0b5394", "-"),
    ("dissipated_energy", "Dissipated", "#c0504d", "-"),
)
MOTION_ENERGIES = (
    ("kinetic_energy", "Kinetic", "#009e73"),
    ("damping_energy", "Damping", "#999999"),
    ("transfer_energy", "Transfer", "#555555"),
    ("friction_energy", "Friction", "#cc79a7"),
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
        for column, name, colour in MOTION_ENERGIES:
            if column in run.history:
                energy = run.history[column]
                inner = inner + energy
                panel.plot(time, energy / factor, color=colour, linewidth=1.0, label=name)
        if "kinetic_energy" in run.history:
            inner = inner - run.history["kinetic_energy"][0]
        panel.plot(time, inner / factor, color="#e69f00", linestyle=(0, (4, 2)), linewidth=1.2, label="Sum of all but it")
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


def time_groups(runs):
    """[(name, title, [columns], unit)] of gauges, probes by unit, and reactions that the histories have and that ever move."""
    columns = {c: run.units.get(c, "-") for run in runs for c in run.history if ":" in c}
    top = {c: largest([run.history[c] for run in runs if c in run.history]) for c in columns}
    kinds = {"gauge": "Gauges", "probe": "Probes", "reaction": "Reactions"}
    groups = {}
    for column, unit in columns.items():
        kind = column.split(":")[0].split("_")[0]
        if kind in kinds and top[column] > 0.0:
            groups.setdefault((kind, unit), []).append(column)
    found = []
    for (kind, unit), group in groups.items():
        least = 1e-6 * max(top[c] for c in group) if kind == "reaction" else 0.0  # what supports only round off
        several = sum(k == kind for k, _ in groups) > 1
        name = f"{kind}s_{unit.replace('/', '_per_').replace('-', 'plain')}" if several else f"{kind}s"
        found.append((name, kinds[kind], [c for c in group if top[c] > least], unit))
    return found


def column_label(column):
    """"platen, y" for "reaction_y:platen"; the name for gauges and probes."""
    kind, name = column.split(":", 1)
    return f"{name}, {kind[-1]}" if kind.startswith("reaction_") else name


def time_figure(runs, labels, title, columns, unit):
    """Columns of the history over time: colours are columns, lines of different style are runs."""
    arrays = [run.history[c] for run in runs for c in columns if c in run.history]
    factor, shown = unit_for(unit, largest(arrays)) if unit in SCALES else (1.0, unit)
    figure, plot = plt.subplots(figsize=(5.6, 3.9), layout="constrained")
    styles = ("-", *REFERENCE_STYLES)
    for r, (run, label) in enumerate(zip(runs, labels)):
        for k, column in enumerate(columns):
            if column in run.history:
                text = column_label(column) if len(runs) == 1 else f"{column_label(column)}: {label}"
                style = {"color": RUN_COLOURS[k % len(RUN_COLOURS)], "linestyle": styles[r % len(styles)]}
                plot.plot(run.history["time"], run.history[column] / factor, label=text, **style)
    plot.set_xlabel("Time [s]")
    plot.set_ylabel(f"{title} [{shown}]")
    plot.axhline(0.0, color="#444444", linewidth=0.5)
    plot.margins(x=0.01)
    place_legend(figure, plot)
    return figure


def place_legend(figure, plot):
    """Inside; below the diagram where it would hide the curves."""
    entries = len(plot.get_legend_handles_labels()[0])
    if entries <= 4:
        plot.legend(loc="best")
        return
    figure.set_figheight(3.9 + 0.2 * math.ceil(entries / 3))
    plot.legend(loc="upper center", bbox_to_anchor=(0.48, -0.14), ncols=3, columnspacing=1.5)


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


AXISYMMETRIC_MAPS = (
    Field("damage", "Damage", "", "fraction", "damage"),
    Field("crack_opening", "Crack opening", "m", "opening", "crack_opening"),
    Field("stress_xx", "Radial stress σrr", "Pa", "signed", "stress", 0),
    Field("stress_yy", "Axial stress σzz", "Pa", "signed", "stress", 1),
    Field("stress_zz", "Hoop stress σθθ", "Pa", "signed", "stress", 2),
    Field("stress_xy", "Shear stress σrz", "Pa", "signed", "stress", 3),
    Field("displacement", "Displacement", "m", "magnitude", "displacement", -1),
)
PLASTIC_STRAIN = Field("plastic_strain", "Plastic strain", "", "opening", "plastic_strain")


def fields_of(frames, maps, damaged):
    """What to draw of these frames: plastic strain if a law has it; then damage only if there is any, and never if no run
    is damaged at any time.
    """
    plastic = ["plastic_strain" in frame for frame in frames]
    if not damaged or (all(plastic) and not any(np.any(frame.get("damage", 0.0)) for frame in frames)):
        maps = tuple(field for field in maps if field.name not in ("damage", "crack_opening"))
    return (PLASTIC_STRAIN, *maps) if any(plastic) else maps


COLOURS = {
    "fraction": FRACTURE,
    "opening": FRACTURE,
    "magnitude": "viridis",
    "signed": "RdBu_r",
    "tension": "viridis_r",  # the largest stress is dark
    "compression": "viridis",
}


def level_field(axis):
    """The normal stress in direction 0, 1 or 2."""
    name = 2 * "xyz"[axis]
    return Field(f"stress_{name}", f"Stress σ{name}", "Pa", "level", "stress", axis)


def level_limits(arrays):
    """(low, high, kind) of a stress: about 0 where it has both signs, else its range, at least 30 % of its size."""
    ends = np.array([np.percentile(a, (1.0, 99.0)) for a in arrays if a.size])
    low, high = ends[:, 0].min(), ends[:, 1].max()
    if low < 0.0 < high and min(-low, high) > 0.02 * max(-low, high):
        return *colour_limits("signed", arrays), "signed"
    kind = "tension" if high > -low else "compression"
    low, high = (max(low, 0.0), high) if kind == "tension" else (low, min(high, 0.0))
    least = 0.3 * max(abs(low), abs(high))
    if high - low < least:
        middle = 0.5 * (low + high)
        low, high = middle - 0.5 * least, middle + 0.5 * least
    return low, high, kind


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
    return 0.0, max((heavy_value(a[a > 0.0]) for a in arrays), default=0.0)


def heavy_value(values, share=0.1):
    """Values above it hold that share of the sum: a crack in less than a hundredth of the points counts, faint ones do not."""
    if not values.size:
        return 0.0
    falling = np.sort(values)[::-1]
    return falling[np.searchsorted(np.cumsum(falling), share * falling.sum())]


@dataclass
class Colours:
    """The colour scale that all runs of a figure share. low, high: in the unit of the file."""

    low: float
    high: float
    factor: float  # shown = value / factor
    unit: str
    cmap: object
    extend: str  # which ends of the bar have a tip: there are values beyond

    @classmethod
    def of(cls, field, arrays):
        """For the values of a field in all runs."""
        low, high, kind = level_limits(arrays) if field.kind == "level" else (*colour_limits(field.kind, arrays), "")
        factor, unit = unit_for(field.base, max(abs(low), abs(high))) if field.base else (1.0, "-")
        if high <= low:
            high = low + factor  # a field of zeros
        top, bottom = max(a.max() for a in arrays), min(a.min() for a in arrays)
        hair = 1e-9 * max(abs(low), abs(high))
        over, under = top > high + hair, bottom < low - hair
        extend = ("neither", "max", "min", "both")[over + 2 * under]
        return cls(low, high, factor, unit, COLOURS[kind or field.kind], extend)

    def limits(self):
        return {"vmin": self.low / self.factor, "vmax": self.high / self.factor, "cmap": self.cmap}

    def bar(self, figure, image, axes, label):
        bar = figure.colorbar(image, cax=axes, extend=self.extend)
        bar.set_label(f"{label} [{self.unit}]")
        bar.outline.set_linewidth(0.5)


def heading_text(figure, text):
    figure.text(
        LEFT / figure.get_figwidth(),
        1.0 - 0.08 / figure.get_figheight(),
        text,
        va="top",
        fontsize=9.5,
        fontweight="bold",
    )


def map_figure(scenes, field, heading, notes):
    """One field, runs side by side, one colour scale; None if no run has it."""
    pairs = [(scene, note, field.of(scene.frame)) for scene, note in zip(scenes, notes)]
    pairs = [(s, n, v) for s, n, v in pairs if v is not None]
    if not pairs:
        return None
    colours = Colours.of(field, [v for _, _, v in pairs])
    x0, x1, y0, y1 = pairs[0][0].extent
    extent = (-x1, x1, y0, y1) if pairs[0][0].mirrored else (x0, x1, y0, y1)
    lines = max(note.count("\n") for note in notes)
    figure, panels, bar_axes = _panels(extent, len(pairs), ABOVE + 0.14 * lines)
    length_factor, length_unit = unit_for("m", max(np.abs(extent)))
    for panel, (scene, note, values) in zip(panels, pairs):
        painted = paint(scene.picture, values) / colours.factor
        if scene.mirrored:
            painted = np.ma.hstack([painted[:, ::-1], painted])
        image = panel.imshow(
            painted,
            origin="lower",
            extent=np.divide(extent, length_factor),
            aspect="equal",
            **colours.limits(),
        )
        scene.draw_bodies(panel, length_factor)
        if scene.mirrored:
            panel.axvline(0.0, color="#333333", linewidth=0.5, linestyle=(0, (8, 3, 1, 3)))
            panel.xaxis.set_major_formatter(lambda radius, _: f"{abs(radius):g}")
        panel.set_xlim(np.array(extent[:2]) / length_factor)
        panel.set_ylim(np.array(extent[2:]) / length_factor)
        panel.grid(False)
        panel.set_title(f"{scene.label}\n{note}", loc="left", fontsize=8)
        span = span_text(values, colours.factor, colours.unit)
        panel.set_xlabel(f"{scene.axes[0]} [{length_unit}]\n{span}")
        panel.locator_params(nbins=4, axis="x")
        if panel.get_ylabel():
            panel.set_ylabel(f"{scene.axes[1]} [{length_unit}]")
    colours.bar(figure, image, bar_axes, field.label)
    heading_text(figure, f"{field.label}, {heading}")
    return figure


def span_text(values, factor, unit):
    """The extremes of a map; what is a billionth of the larger one is zero."""
    ends = np.array([values.min(), values.max()]) / factor
    ends[np.abs(ends) < 1e-9 * np.abs(ends).max()] = 0.0
    low, high = (f"{end:.4g}".replace("-", "−") for end in ends)
    return f"{low} to {high}" + ("" if unit == "-" else f" {unit}")


# Margins of the map figures [inch]: fixed, so that panels keep the body's shape whatever their number.
LEFT, RIGHT, HEADING, ABOVE, BELOW, GAP = 0.65, 0.95, 0.3, 0.42, 0.58, 0.28


def _panels(extent, count, above=ABOVE):
    """(figure, axes of `count` panels of that shape, axes of the colour bar). above: room for a title [inch]."""
    width, height = extent[1] - extent[0], extent[3] - extent[2]
    columns = 2 if count == 4 else min(count, 3)
    rows = math.ceil(count / columns)
    scale = min(4.2 / height, {1: 6.5, 2: 4.6, 3: 3.4}[columns] / width)
    panel_width, panel_height = scale * width, scale * height
    cell_width, cell_height = max(panel_width, 2.25) + GAP, above + panel_height + BELOW
    total_width, total_height = LEFT + columns * cell_width + RIGHT, HEADING + rows * cell_height
    figure = plt.figure(figsize=(total_width, total_height))

    def axes(left, top, across, down):
        return figure.add_axes(
            (left / total_width, 1.0 - (top + down) / total_height, across / total_width, down / total_height)
        )

    panels = []
    for k in range(count):
        row, column = divmod(k, columns)
        panel = axes(LEFT + column * cell_width, HEADING + row * cell_height + above, panel_width, panel_height)
        panel.tick_params(labelleft=column == 0)
        panel.set_ylabel("y" if column == 0 else "")
        panels.append(panel)
    bar_height = max(1.0, 0.92 * panel_height)
    middle = HEADING + above + 0.5 * panel_height
    bar = axes(LEFT + columns * cell_width - GAP + 0.25, middle - 0.5 * bar_height, 0.13, bar_height)
    return figure, panels, bar
