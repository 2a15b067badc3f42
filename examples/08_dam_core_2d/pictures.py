#!/usr/bin/env python3
"""Pictures of a run of the dam at some times: points in the colour of their body, darker where they have flowed.

    PYTHONPATH=python /usr/bin/python3 examples/08_dam_core_2d/pictures.py out/d1 d1.png 2.3 3.4 3.8 4.1 4.4 4.8
    PYTHONPATH=python /usr/bin/python3 examples/08_dam_core_2d/pictures.py out/valley middle.png 3.4 4.8 --between 0 0.5
"""

import argparse
import tomllib
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from berm.results import Run

COLOURS = {"core": "Reds", "block": "Purples", "upstream": "YlOrBr", "downstream": "YlOrBr", "water": "Blues"}
FLOWED = 0.5  # plastic strain of the darkest points
COLUMNS = 2


def slab(frame, between):
    """The points of a frame that are between two heights z, if any are given."""
    z = np.asarray(frame["position"])[:, 2]
    keep = np.full(len(z), True) if between is None else (z >= between[0]) & (z < between[1])
    return {name: np.asarray(values)[keep] if name != "time" else values for name, values in frame.items()}


def draw(panel, frame, names, points_per_metre, dimension):
    position = frame["position"][:, :2]
    side = frame["volume"] ** (1.0 / dimension) * points_per_metre
    strain = frame["plastic_strain"]
    for number, name in enumerate(names):
        of = frame["body"] == number
        shade = 0.35 + 0.6 * np.clip(strain[of] / FLOWED, 0.0, 1.0)
        colours = plt.get_cmap(COLOURS.get(name, "Greys"))(shade)
        panel.scatter(*position[of].T, c=colours, s=(1.05 * side[of]) ** 2, marker="s", linewidths=0.0)
    panel.set_title(f"t = {frame['time']:.2f} s", fontsize=9, loc="left")


def main(out, picture, times, between):
    run = Run(out)
    names = list(tomllib.loads((Path(out) / "case.toml").read_text())["body"])
    frames = [slab(run.frame(run.frame_at(t)), between) for t in times]
    places = np.vstack([frame["position"][:, :2] for frame in frames])
    low, high = places.min(axis=0) - 0.3, places.max(axis=0) + 0.3
    low[1] = -0.1
    width = 5.6
    rows = -(-len(times) // COLUMNS)
    height = width * (high[1] - low[1]) / (high[0] - low[0])
    figure, panels = plt.subplots(rows, COLUMNS, figsize=(COLUMNS * width, rows * (height + 0.5)), squeeze=False)
    for panel in panels.flat:
        panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        panel.tick_params(labelsize=8)
    figure.tight_layout()
    figure.canvas.draw()
    scale = panels[0, 0].get_window_extent().width / figure.dpi * 72.0 / (high[0] - low[0])
    for panel, frame in zip(panels.flat, frames):
        draw(panel, frame, names, scale, run.dimension)
    for panel in list(panels.flat)[len(frames):]:
        panel.remove()
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", help="folder of the run")
    parser.add_argument("picture", help="file to write")
    parser.add_argument("times", type=float, nargs="+", help="of the pictures [s]")
    parser.add_argument("--between", type=float, nargs=2, metavar="Z", help="of a run in space: only these points [m]")
    arguments = parser.parse_args()
    main(arguments.out, arguments.picture, arguments.times, arguments.between)
