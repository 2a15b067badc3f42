"""Where the bodies of a frame are in a picture: what all maps of that frame share."""

import numpy as np

import berm.plotting  # noqa: F401  before the rest of matplotlib
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from berm.raster import body_picture


class Drawing:
    """What a map needs: label, run, frame, picture and extent, the names of its axes and the bodies in it."""

    axes = ("x", "y")
    mirrored = False  # draw the part beyond the axis x = 0 too
    outlines, rigid = {}, ()  # {number of a body: its rings [m]}, [rings of a rigid body [m]]

    def draw_bodies(self, panel, unit):
        """Outlines of the bodies with points, and the rigid bodies where they are."""
        sides = (1.0, -1.0) if self.mirrored else (1.0,)
        for side in sides:
            flip = np.array([side, 1.0]) / unit
            for ring in (r for group in self.outlines.values() for r in group):
                panel.plot(*(np.vstack([ring, ring[:1]]) * flip).T, color="#333333", linewidth=0.5, alpha=0.7)
            for rings in self.rigid:
                corners = np.vstack([np.vstack([ring, ring[:1]]) for ring in rings]) * flip
                codes = [c for r in rings for c in [Path.MOVETO] + [Path.LINETO] * (len(r) - 1) + [Path.CLOSEPOLY]]
                style = {"facecolor": "#e4e4e4", "edgecolor": "#8c8c8c", "hatch": "////", "linewidth": 0.5}
                panel.add_patch(PathPatch(Path(corners, codes), **style))


class Scene(Drawing):
    """Where the points of one frame of one run are in the picture; shared by all its maps."""

    def __init__(self, run, label, frame, scale):
        self.run, self.label, self.frame = run, label, frame
        displacement = frame.get("displacement", np.zeros_like(frame["position"]))[:, :2]
        self.shift = scale * displacement
        start = frame["position"][:, :2] - displacement
        self.x, self.y = (start + self.shift).T
        thickness = run.summary.get("thickness") or 1.0
        if run.axisymmetric:
            self.axes, self.mirrored = ("r", "z"), True
            # Volumes are those of rings around the axis.
            thickness = 2.0 * np.pi * np.maximum(start[:, 0], 1e-3 * max(np.ptp(start[:, 0]), 1e-300))
        if "volume" in frame:
            self.side = np.sqrt(np.maximum(frame["volume"], 0.0) / thickness)
        else:
            self.side = np.full(len(self.x), np.sqrt(np.ptp(self.x) * np.ptp(self.y) / max(1, len(self.x))))
        self.body = frame.get("body", np.zeros(len(self.x), dtype=int))
        self.outlines, self.rigid = self._sort_rings(start, scale)
        self.picture, self.extent = None, None

    def _sort_rings(self, start, scale):
        """({number of a body: its rings}, displaced rings of the rigid bodies): these hold no points."""
        outlines, rigid = {}, []
        moved = self.run.rigid_displacements(self.frame["time"])
        for name, rings in self.run.summary.get("body_rings", {}).items():
            if not rings:
                continue
            rings = [np.array(ring) for ring in rings]
            if name in moved:
                rigid.append([ring + scale * moved[name] for ring in rings])
                continue
            low, high = np.vstack(rings).min(axis=0), np.vstack(rings).max(axis=0)
            within = self.body[((start >= low) & (start <= high)).all(axis=1)]
            if len(within):
                outlines.setdefault(int(np.bincount(within).argmax()), []).extend(rings)
        return outlines, rigid

    def bounds(self):
        half = 0.5 * self.side
        rings = [r for group in [*self.outlines.values(), *self.rigid] for r in group]
        low = [np.array([(self.x - half).min(), (self.y - half).min()])] + [r.min(axis=0) for r in rings]
        high = [np.array([(self.x + half).max(), (self.y + half).max()])] + [r.max(axis=0) for r in rings]
        return np.min(low, axis=0), np.max(high, axis=0)

    def render(self, low, high):
        self.extent = (low[0], high[0], low[1], high[1])
        pixel = max(high - low) / 900.0
        nearest = None
        for body in np.unique(self.body):
            of = np.flatnonzero(self.body == body)
            rings = self.outlines.get(int(body), ())
            found, distance = body_picture(
                self.x[of], self.y[of], self.side[of], self.extent, pixel, self.shift[of], rings
            )
            found = np.where(found >= 0, of[found], -1)
            if nearest is None:
                self.picture, nearest = found, distance
            else:
                self.picture = np.where(distance < nearest, found, self.picture)
                nearest = np.minimum(distance, nearest)


def make_scenes(runs, labels, indices, scale):
    """Scenes of the given frames with common bounds; runs without points are left out."""
    scenes = [Scene(run, label, run.frame(i), scale) for run, label, i in zip(runs, labels, indices) if i is not None]
    scenes = [s for s in scenes if len(s.x)]
    if scenes:
        bounds = [s.bounds() for s in scenes]
        low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
        margin = 0.03 * max(high - low)
        low, high = low - margin, high + margin
        if all(scene.mirrored for scene in scenes):
            low[0] = 0.0
        for scene in scenes:
            scene.render(low, high)
    return scenes
