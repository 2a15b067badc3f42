"""Moving pictures of plane runs: the material points where they are in every frame."""

import io

import numpy as np

# What is shown: the first of these that a run has and that is not zero throughout.
FIELDS = (
    ("plastic_strain", "accumulated plastic strain [-]"),
    ("damage", "damage [-]"),
    ("velocity", "speed [m/s]"),
)
WIDTH = 8.0  # inches
DPI = 80


def _values(frame, name):
    values = np.asarray(frame[name], float)
    return np.linalg.norm(values, axis=1) if values.ndim > 1 else values


def choose_field(frames):
    """(name, label) of what to colour the points by; None if there is nothing."""
    for name, label in FIELDS:
        if all(name in frame for frame in frames) and any(np.any(_values(frame, name) > 0.0) for frame in frames):
            return name, label
    return None


def _marker_area(frame, points_per_metre):
    """Area of a square of the size of a point, in typographic points squared."""
    side = np.sqrt(np.asarray(frame["volume"], float)) * points_per_metre
    return np.maximum(side, 1.0) ** 2


def animate(run, most_frames=60, milliseconds=80):
    """GIF (bytes) of the points of a plane run, and what it shows; (None, "") if it has fewer than three frames or
    nothing to show. Points have the size of their volume at the start."""
    from berm.plotting import plt
    from PIL import Image

    if run.dimension != 2 or len(run.frames) < 3:
        return None, ""
    indices = np.unique(np.linspace(0, len(run.frames) - 1, min(most_frames, len(run.frames))).round().astype(int))
    frames = [run.frame(k) for k in indices]
    field = choose_field(frames)
    if field is None:
        return None, ""
    name, label = field
    places = np.vstack([frame["position"][:, :2] for frame in frames])
    low, high = places.min(axis=0), places.max(axis=0)
    margin = 0.03 * (high - low).max()
    low, high = low - margin, high + margin
    width, height = high - low
    top = max(float(np.percentile(_values(frames[-1], name), 98.0)), 1e-12)
    figure, axes = plt.subplots(figsize=(WIDTH, WIDTH * height / width * 0.85 + 1.1), dpi=DPI)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    figure.subplots_adjust(left=0.08, right=1.0, bottom=0.12, top=0.92)
    dots = axes.scatter([], [], c=[], cmap="viridis", vmin=0.0, vmax=top, marker="s", linewidths=0.0)
    figure.colorbar(dots, ax=axes, label=label, fraction=0.03, pad=0.02)
    figure.canvas.draw()
    points_per_metre = axes.get_window_extent().width / DPI * 72.0 / width
    pictures = []
    for frame in frames:
        dots.set_offsets(frame["position"][:, :2])
        dots.set_array(_values(frame, name))
        dots.set_sizes(_marker_area(frame, points_per_metre))
        axes.set_title(f"t = {frame['time']:.3f} s", fontsize=10)
        figure.canvas.draw()
        pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("P", palette=Image.ADAPTIVE))
    plt.close(figure)
    data = io.BytesIO()
    pictures[0].save(
        data, format="GIF", save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0, optimize=True
    )
    return data.getvalue(), label
