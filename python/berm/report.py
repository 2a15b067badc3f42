"""report.html of one or several runs.

    python3 -m berm.report OUT [OUT2 ...] [--out FILE] [--reference CSV] [--scale FACTOR] [--title TEXT]

Writes FILE (default: report.html in the first folder), self-contained, and its pictures as PNG files next to it.
Exit code 1: the report cannot be written; 2: a folder is not the output of a run, or a file cannot be read.
"""

import argparse
import base64
import html
import io
import math
import os
import sys

import numpy as np

from berm import words
from berm.errors import ResultError
from berm.files import new_file
from berm.results import Curve, Run, split_unit

TOOL = "berm report"
LONGEST_LABEL = 60  # of a run, in legends and tables
STYLE = """
body { font: 15px/1.5 "Segoe UI", "Helvetica Neue", Arial, sans-serif; color: #222;
       max-width: 1180px; margin: 2.2em auto; padding: 0 1.5em; }
h1 { font-size: 1.5em; font-weight: 600; margin: 0 0 .2em; }
h2 { font-size: 1.1em; font-weight: 600; margin: 2em 0 .6em; padding-bottom: .25em; border-bottom: 1px solid #ccc; }
p.note, figcaption { color: #666; font-size: .88em; margin: .3em 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .93em; }
th, td { padding: .22em 1.1em .22em 0; text-align: right; border-bottom: 1px solid #eee; vertical-align: top; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 1px solid #888; }
td.bad { color: #a61c1c; font-weight: 600; }
.figures { display: flex; flex-wrap: wrap; gap: 1.2em; align-items: flex-start; }
figure { margin: 0; max-width: 100%; }
img { max-width: 100%; height: auto; }
pre { background: #f6f6f4; padding: .8em 1em; overflow-x: auto; font-size: .85em; }
"""


def run_labels(runs):
    """Short distinct names: the folder (its path where folders share a name), and the method where that hides it."""
    names = [run.name for run in runs]
    if len(set(names)) < len(names):
        names = [words.readable(os.path.normpath(run.path)) for run in runs]
    names = [name if len(name) <= LONGEST_LABEL else "…" + name[1 - LONGEST_LABEL :] for name in names]
    if len(set(names)) < len(names):
        names = [f"{number} {name}" for number, name in enumerate(names, 1)]
    labels = []
    for run, name in zip(runs, names):
        if name.startswith("_"):  # matplotlib leaves such labels out of legends
            name = os.path.join(".", name)
        method = run.summary.get("method", "")
        labels.append(name if not method or method in name.lower() else f"{name} ({method.upper()})")
    return labels


def figure_text(value, unit):
    """A number with four digits in a readable unit: 35230000, "Pa" -> "35.23 MPa"."""
    from berm.figures import SCALES, unit_for

    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, str):
        return value
    if isinstance(value, int) and unit in ("", "-"):
        return f"{value:,}".replace(",", " ")
    factor = 1.0
    if unit in SCALES and value != 0:
        factor, unit = unit_for(unit, abs(value))
    text = f"{value / factor:.4g}"
    return text if unit in ("", "-") else f"{text} {unit}"


MODEL_ROWS = (
    ("Method", "method"),
    ("Case", "case"),
    ("Status", "status"),
    ("Degrees of freedom", "dofs"),
    ("Points", "points"),
    ("Steps", "steps"),
    ("Wall time [s]", "wall_seconds"),
)
NAMES = {
    "peak_stress": "Peak nominal stress",
    "peak_load": "Peak load",
    "displacement_at_peak": "Displacement at peak",
    "stiffness_10_40": "Stiffness, 10–40 % of the peak",
    "dissipated_energy": "Dissipated energy",
    "energy_error": "Energy error",
    "max_damage": "Largest damage",
    "stress_noise": "Stress noise",
    "stress_error": "Estimated error of the stress",
    "cut_steps": "Cut steps",
    "newton_iterations": "Newton iterations",
    "points_lost": "Points lost",
}


def metric_rows(runs):
    """[(name, unit, values)]: metrics of summary.json, first those of NAMES in that order; then energies at the end."""
    keys = []
    for run in runs:
        keys += [key for key in run.summary.get("metrics", {}) if key not in keys]
    order = list(NAMES)
    keys.sort(key=lambda k: order.index(split_unit(k)[0]) if split_unit(k)[0] in order else len(order))
    rows = []
    for key in keys:
        name, unit = split_unit(key)
        values = [run.summary.get("metrics", {}).get(key) for run in runs]
        if any(value is not None for value in values):
            rows.append((NAMES.get(name, name.replace("_", " ")), unit, values))
    for column, name in (
        ("external_work", "External work at the end"),
        ("elastic_energy", "Elastic energy at the end"),
    ):
        rows.append((name, "J", [float(run.history[column][-1]) if column in run.history else None for run in runs]))
    return rows


def difference_text(values):
    a, b = values
    if not all(isinstance(v, (int, float)) and math.isfinite(v) for v in values) or a == 0:
        return "–"
    return f"{100.0 * (b - a) / abs(a):+.2f} %"


def table_html(runs, labels):
    compare = len(runs) == 2
    cell = lambda text, css="": f"<td{css}>{html.escape(text)}</td>"  # noqa: E731
    head = "".join(f"<th>{html.escape(label)}</th>" for label in labels) + ("<th>Difference</th>" if compare else "")
    rows = []
    for name, key in MODEL_ROWS:
        cells = []
        for run in runs:
            value = run.summary.get(key)
            text = figure_text(value.upper() if key == "method" and value else value, "")
            if key == "status" and run.summary.get("reason"):
                text += f": {run.summary['reason']}"
            bad = key == "status" and value not in ("done", "stopped")
            cells.append(cell(text, ' class="bad"' if bad else ""))
        rows.append((name, "".join(cells) + ("<td></td>" if compare else "")))
    for name, unit, values in metric_rows(runs):
        cells = "".join(cell(figure_text(v, unit)) for v in values)
        rows.append((name, cells + (cell(difference_text(values)) if compare else "")))
    body = "\n".join(f"<tr><td>{html.escape(name)}</td>{cells}</tr>" for name, cells in rows)
    return f"<table><thead><tr><th></th>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


class Pictures:
    """Saves figures next to the report and embeds them."""

    def __init__(self, folder):
        self.folder = folder

    def html(self, figure, name, alt, caption=""):
        from berm.plotting import plt

        buffer = io.BytesIO()
        figure.savefig(buffer, format="png")
        width = round(figure.get_figwidth() * 96)
        plt.close(figure)
        with new_file(os.path.join(self.folder, f"{name}.png"), binary=True) as file:
            file.write(buffer.getvalue())
        data = base64.b64encode(buffer.getvalue()).decode()
        note = f"<figcaption>{caption}</figcaption>" if caption else ""
        return (
            f'<figure><img width="{width}" alt="{html.escape(alt)}" src="data:image/png;base64,{data}">{note}</figure>'
        )


    def animation_html(self, data, name, alt, caption):
        with new_file(os.path.join(self.folder, f"{name}.gif"), binary=True) as file:
            file.write(data)
        text = base64.b64encode(data).decode()
        return (
            f'<figure><img alt="{html.escape(alt)}" src="data:image/gif;base64,{text}">'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        )


def curves_html(runs, labels, references, pictures):
    from berm.figures import curve_figure, diagrams

    parts = []
    for name, alt, axes in diagrams(references):
        figure = curve_figure(runs, labels, references, axes)
        if figure:
            parts.append(pictures.html(figure, name, alt))
    if not parts:
        return ""
    sources = "".join(
        f"<p class='note'>{html.escape(c.label)}: {html.escape(c.source or 'no source given')}</p>" for c in references
    )
    note = "<p class='note'>Dots mark the largest nominal stress.</p>"
    return f'<h2>Load curves</h2><div class="figures">{"".join(parts)}</div>{note}{sources}'


def times_html(runs, labels, pictures):
    from berm.figures import time_figure, time_groups

    parts = [
        pictures.html(time_figure(runs, labels, title, columns, unit), name, f"{title} over time")
        for name, title, columns, unit in time_groups(runs)
    ]
    return f'<h2>Over time</h2><div class="figures">{"".join(parts)}</div>' if parts else ""


def energies_html(runs, labels, pictures):
    from berm.figures import energy_figure

    figure = energy_figure(runs, labels)
    if not figure:
        return ""
    note = (
        "External work and the sum of what is stored, dissipated and in motion (less what was in motion at the start) "
        "coincide when the energy balance holds."
    )
    return (
        f'<h2>Energies</h2><div class="figures">{pictures.html(figure, "energies", "Energies over time", note)}</div>'
    )


def motion_html(runs, labels, pictures):
    """Moving pictures of the plane runs with motion."""
    from berm.animation import animate

    parts = []
    for number, (run, label) in enumerate(zip(runs, labels)):
        if "kinetic_energy" not in run.history:
            continue
        data, shown = animate(run)
        if data:
            name = "motion" if len(runs) == 1 else f"motion_{number + 1}"
            parts.append(pictures.animation_html(data, name, f"Motion of {label}", f"{label}: {shown}"))
    return f'<h2>Motion</h2><div class="figures">{"".join(parts)}</div>' if parts else ""


def frame_indices(runs):
    """(at peak, last): frames by run, None for runs without points. Every peak in its last frame: (None, last)."""
    last = [len(run.frames) - 1 if run.frames else None for run in runs]
    peak = []
    for run in runs:
        row = run.peak_row()
        peak.append(run.frame_at(run.history["time"][row]) if run.frames and row is not None else None)
    return (None if all(p is None or p == l for p, l in zip(peak, last)) else peak), last


def frame_note(scene):
    """ "t = 0.5 s, u = 0.3 mm, 46 % of peak": when the frame is, and its part of the largest nominal stress."""
    time, history = scene.frame["time"], scene.run.history
    text = f"t = {time:.3g} s"
    if "imposed_displacement" in history and np.any(history["imposed_displacement"]):
        displacement = np.interp(time, history["time"], history["imposed_displacement"])
        text += f", u = {figure_text(float(f'{displacement:.3g}'), 'm')}"
    peak = scene.run.peak_row()
    if peak is not None:
        stress = history["nominal_stress"]
        text += f", {100.0 * np.interp(time, history['time'], stress) / stress[peak]:.0f} % of peak"
    return text


def maps_html(runs, labels, scale, pictures, prefix=""):
    """Maps of 2D runs, all of them in a plane or all of them axisymmetric."""
    from berm.figures import AXISYMMETRIC_MAPS, MAPS, fields_of, map_figure
    from berm.scene import make_scenes

    axisymmetric = any(run.axisymmetric for run in runs)
    maps = AXISYMMETRIC_MAPS if axisymmetric else MAPS
    peak, last = frame_indices(runs)
    parts = []
    for name, heading, indices in (("peak", "frame closest to the peak", peak), ("last", "last frame", last)):
        if indices is None:
            continue
        scenes = make_scenes(runs, labels, indices, scale)
        if not scenes:
            continue
        fields = fields_of([scene.frame for scene in scenes], maps, any(run.damaged for run in runs))
        figures = [(field, map_figure(scenes, field, heading, [frame_note(s) for s in scenes])) for field in fields]
        images = "".join(
            pictures.html(f, f"{prefix}{name}_{field.name}", f"{field.label}, {heading}") for field, f in figures if f
        )
        title = "Maps at the peak" if name == "peak" else "Maps of the last frame"
        note = (
            f"Points on the deformed body, displacements × {scale:g}; thin lines: outline at the start; "
            "hatched: rigid bodies; white inside a body: it has opened by more than the side of a point. "
            "Stresses: tension positive, "
            "Cauchy; colours span the 1st to 99th percentile, those of crack openings and plastic strains all but the largest "
            "values, which hold a tenth of the sum; below each map are the extremes."
        )
        if axisymmetric:
            note += (
                " Axisymmetric: r and z are x and y of the files, σrr, σzz, σθθ, σrz their xx, yy, zz, xy; "
                "the left half mirrors the right one, stresses are those of the right half."
            )
        if name == "peak":
            note += " " + peak_note(scenes)
        parts.append(f'<h2>{title}</h2><p class="note">{note}</p><div class="figures">{images}</div>')
    return "".join(parts)


def peak_note(scenes):
    """Tells the reader that the frames closest to the peaks need not be the peaks."""
    offs = [f"{s.label}: {s.run.history['time'][s.run.peak_row()]:.4g} s" for s in scenes]
    return html.escape("Shown is the frame written closest to the peak (time of the peak: " + ", ".join(offs) + ").")


def elastic_frames(runs):
    """The last frame before half of the peak load, by run; None for runs without one that is loaded."""
    found = []
    for run in runs:
        row, last = run.peak_row(), None
        if row is not None:
            stress, time = np.abs(run.history["nominal_stress"]), run.history["time"]
            before = time[int(np.argmax(stress >= 0.5 * stress[row]))]
            loads = [np.interp(t, time, stress) / stress[row] for t, _ in run.frames]
            # The unloaded frame at the start shows nothing. Without another one: the first before the peak.
            loaded = [k for k, (t, _) in enumerate(run.frames) if loads[k] > 0.02 and t < time[row]]
            last = max((k for k in loaded if run.frames[k][0] <= before), default=loaded[0] if loaded else None)
        found.append(last)
    return found if any(k is not None for k in found) else None


def load_note(scene):
    """frame_note with the load, in two lines: "t = 0.5 s, u = 0.3 mm" and "F = 61 kN, 46 % of peak"."""
    above = frame_note(scene).split(", ")
    below = [above.pop()] if above[-1].endswith("of peak") else []
    history = scene.run.history
    if "reaction" in history and np.any(history["reaction"]):
        load = np.interp(scene.frame["time"], history["time"], history["reaction"])
        below.insert(0, f"F = {figure_text(float(f'{load:.3g}'), 'N')}".replace("-", "−"))
    return "\n".join(", ".join(line) for line in (above, below) if line)


def millimetres(length, least):
    """A length [m] in mm; what is a thousandth of `least` is zero."""
    return f"{1e3 * length if abs(length) > 1e-3 * least else 0.0:.4g} mm".replace("-", "−")


SOLID_FRAMES = (
    ("elastic", "elastic range", "Stress in the elastic range"),
    ("peak", "at the peak", "Stress and damage at the peak"),
    ("last", "last frame", "Damage of the last frame"),
)


def solids_html(runs, labels, scale, pictures, prefix=""):
    """Pictures of 3D runs: sections through the middle and, with pyvista, the bodies themselves."""
    from berm.body import loading_direction, make_bodies, make_sections, section_axes
    from berm.figures import MAPS, level_field, map_figure
    from berm.solid import can_draw, solid_figure, why_not

    peak, last = frame_indices(runs)
    elastic = elastic_frames(runs)
    shown = next(((run, k) for run, k in zip(runs, elastic or last) if k is not None), None)
    if not shown:
        return ""
    loading = loading_direction(*shown)
    stress, (damage, opening) = level_field(loading), MAPS[:2]
    # Where the peak is the last frame, that one shows the stress too.
    fields = {"elastic": (stress,), "peak": (stress, damage), "last": (damage, opening) if peak else (stress, damage)}
    damaged = any(run.damaged for run in runs)
    if not damaged:
        fields = dict.fromkeys(fields, (stress,))
    missing = why_not()
    parts, bare = [], []
    for (name, heading, title), indices in zip(SOLID_FRAMES, (elastic, peak, last)):
        if indices is None:
            continue
        bodies = make_bodies(runs, labels, indices, scale)
        if not bodies:
            continue
        notes = [load_note(body) for body in bodies]
        images = []
        bare = [body.label for body in bodies if not can_draw(body)]
        for field in () if missing or len(bare) == len(bodies) else [f for f in fields[name] if f is not opening]:
            figure = solid_figure(bodies, field, heading, notes, loading)
            if figure:
                alt = f"{field.label}, {heading}, in space"
                images.append(pictures.html(figure, f"{prefix}{name}_{field.name}_3d", alt))
        for axes in section_axes(loading):
            sections = make_sections(bodies, *axes)
            normal = "xyz"[axes[0]]
            plane = f"plane {normal} = {millimetres(bodies[0].middle()[axes[0]], bodies[0].spacing)}"
            for field in fields[name]:
                figure = map_figure(sections, field, f"{heading}, {plane}", notes)
                if figure:
                    alt = f"{field.label}, {heading}, {plane}"
                    images.append(pictures.html(figure, f"{prefix}{name}_{field.name}_{normal}", alt))
        title = title if damaged else f"Stress, {heading}"
        parts.append(f'<h2>{title}</h2><div class="figures">{"".join(images)}</div>')
        if name == "peak":
            parts.append(f'<p class="note">{peak_note(bodies)}</p>')
    text = (
        f"Bodies are deformed, displacements × {scale:g}. Sections: every place has the value of the nearest point; "
        "white inside a body: it has opened by more than the side of a point; hatched: rigid bodies. "
        "Stresses: Cauchy, tension positive; colours span the 1st to 99th percentile of all runs in a picture, those of "
        "crack openings all but the largest values, which hold a tenth of the sum; below each map are the extremes."
    )
    if not missing:
        text += (
            " Pictures in space: above the surface, below with the front quarter taken out along the middle planes; "
            "fem: means of the elements, mpm: means of the points within 1.5 spacings, weighted by distance; "
            "grey lines: rigid bodies."
        )
    sentences = [text, missing]
    if bare and not missing:
        sentences.append(f"Not drawn in space, as summary.json names no body_surfaces: {', '.join(bare)}.")
    return "".join(f'<p class="note">{html.escape(t)}</p>' for t in sentences if t) + "".join(parts)


KINDS = (
    ("", lambda run: run.dimension == 2 and not run.axisymmetric, maps_html),
    ("axisymmetric_", lambda run: run.dimension == 2 and run.axisymmetric, maps_html),
    ("solid_", lambda run: run.dimension == 3, solids_html),
)


def fields_html(runs, labels, scale, pictures):
    """Maps and pictures of the runs, those of one kind together. Only with several kinds their files get a prefix."""
    groups = []
    for prefix, belongs, content in KINDS:
        members = [(run, label) for run, label in zip(runs, labels) if belongs(run)]
        if members:
            groups.append((prefix, content, members))
    return "".join(
        content(*map(list, zip(*members)), scale, pictures, prefix if len(groups) > 1 else "")
        for prefix, content, members in groups
    )


def inputs_html(runs, labels):
    parts = []
    for run, label in zip(runs, labels):
        for name, title in (("log.txt", "warnings"), ("case.toml", "case")):
            path = os.path.join(run.path, name)
            if not os.path.isfile(path):
                continue
            with open(path, encoding="utf-8", errors="replace") as file:
                lines = file.read().splitlines()
            if title == "warnings":
                lines = [line for line in lines if line.startswith("warning: ")]
            if lines:
                text = html.escape("\n".join(lines))
                parts.append(f"<details><summary>{html.escape(label)}: {title}</summary><pre>{text}</pre></details>")
    return f"<h2>Input and warnings</h2>{''.join(parts)}" if parts else ""


def read_curves(runs, files):
    """([Curve], [why a curve is missing]). Those of the cases may be missing, not those that were asked for now."""
    curves, refused = [Curve(file) for file in files], []
    of_cases = []
    for run in runs:
        of_cases += [r for r in run.summary.get("references", []) if r not in of_cases and r not in files]
    for reference in of_cases:
        try:
            curves.append(Curve(reference))
        except ResultError as error:
            refused.append(f"reference curve {error}")
            print(f"warning: reference curve {error}", file=sys.stderr)
    return curves, refused


PAGE_BEGINS = "<!doctype html>"


def refuse_target(out):
    """Before the pictures, which go to the same folder."""
    folder = os.path.dirname(out) or "."
    if not os.path.isdir(folder):
        raise ResultError(f"cannot write {out}: there is no folder {folder} (create it, or name another file with --out)")
    if os.path.isdir(out):
        raise ResultError(f"cannot write {out}: it is a folder (name a file in it with --out)")
    if not out.endswith((".html", ".htm")):
        raise ResultError(f"cannot write {out}: a report is a page of HTML (name a file that ends with .html with --out)")
    if os.path.isfile(out) and not os.path.islink(out):  # a link is replaced, not what it points to
        with open(out, encoding="utf-8", errors="replace") as file:
            if file.read(len(PAGE_BEGINS)) not in ("", PAGE_BEGINS):
                raise ResultError(f"cannot write {out}: it holds something that is not a report (name another file with --out)")


def write_report(paths, out=None, references=(), scale=1.0, title=None):
    """Writes the report and returns its path. Raises ResultError for unusable folders and files."""
    runs = [Run(path) for path in paths]
    for run in runs:
        if not len(run.history.get("time", ())):
            raise ResultError(f"{run.path}/history.csv has no rows of time: the run ended before its first step")
    labels = run_labels(runs)
    curves, refused = read_curves(runs, references)
    out = out or os.path.join(paths[0], "report.html")
    refuse_target(out)
    pictures = Pictures(os.path.dirname(out) or ".")
    title = title or runs[0].summary.get("title") or runs[0].name
    content = "\n".join(
        (
            f'{PAGE_BEGINS}<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>',
            f"<style>{STYLE}</style></head><body>",
            f"<h1>{html.escape(title)}</h1><h2>Summary</h2>{table_html(runs, labels)}",
            "".join(f"<p class='note'>Not drawn: {html.escape(text)}</p>" for text in refused),
            curves_html(runs, labels, curves, pictures),
            times_html(runs, labels, pictures),
            energies_html(runs, labels, pictures),
            motion_html(runs, labels, pictures),
            fields_html(runs, labels, scale, pictures),
            inputs_html(runs, labels),
            "</body></html>\n",
        )
    )
    with new_file(out) as file:
        file.write(words.readable(content))
    return out


def main(arguments=None):
    parser = argparse.ArgumentParser(prog=TOOL, description="Writes report.html of one or several runs.")
    parser.add_argument("folders", nargs="+", type=words.given, metavar="OUT", help="output folder of a run")
    parser.add_argument("--out", type=words.given, metavar="FILE", help="default: report.html in the first folder")
    parser.add_argument(
        "--reference", action="append", default=[], metavar="CSV", help="curve to overlay; may be repeated"
    )
    parser.add_argument(
        "--scale", type=words.positive, default=1.0, metavar="FACTOR", help="factor on displacements in maps (default 1)"
    )
    parser.add_argument("--title", help="default: the title of the first run")
    options = parser.parse_args(arguments)
    try:
        print(write_report(options.folders, options.out, options.reference, options.scale, options.title))
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    words.run(main, TOOL)
