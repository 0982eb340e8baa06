"""Bodies on matplotlib axes."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.patches import Circle

from ..recording.life import RINGS, Life, Pose
from .colours import ACCENT, INK, QUIET, SECOND, activation_colours, unit_rgb
from .palettes import DEFAULT

DIAMETER = 1.0  # m, of a cell
_LEAST = 0.75  # of its size, to which a text shrinks before it gets lines


def draw_pose(
    axes: Axes, pose: Pose, springs: np.ndarray, outline: np.ndarray | tuple = (), chambers: Sequence[np.ndarray] = (),
    palette: str = DEFAULT,
) -> None:
    """Draw a body: chambers below, cells as discs coloured by e - c, springs and the outline above."""
    position, rgb = pose.position, activation_colours(pose.activation, palette) / 255
    span = np.ptp(axes.get_xlim()) or 1.0
    point = span / (axes.get_window_extent().width * 72 / axes.figure.dpi)  # m of a typographic point
    thin = np.clip(0.04 / point, 0.25, 1.6)  # lines thin out as the body gets small
    if len(chambers):
        tint = [0.6 + 0.4 * rgb[chamber].mean(axis=0) for chamber in chambers]
        axes.add_collection(PolyCollection([position[chamber] for chamber in chambers], facecolors=tint, linewidths=0, zorder=1))
    size = np.full(len(position), DIAMETER)
    discs = EllipseCollection(
        size, size, np.zeros(len(position)), units="xy", offsets=position, transOffset=axes.transData,
        facecolors=rgb, edgecolors="white", linewidths=0.5 * thin, zorder=2,
    )
    axes.add_collection(discs)
    for pairs, width in ((springs, thin), (outline, 2.2 * thin)):
        if len(pairs):
            lines = LineCollection(position[pairs], colors=[unit_rgb(INK)], linewidths=width, capstyle="round", zorder=3)
            axes.add_collection(lines)


def draw_world(axes: Axes, life: Life, step: int, size: float = 6.0) -> None:
    """Draw ground and ceiling as far as the axes reach, a tick at every metre, and what touches at a control step.

    Args: size: points, of the triangles where cells touch.
    """
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    for line, edge in zip(life.surfaces(left, right), (bottom, top)):
        x, y = line.T
        axes.fill_between(x, y, edge, color="0.93", linewidth=0, zorder=0)
        axes.plot(x, y, color=unit_rgb(QUIET), linewidth=1.2, zorder=0.5)
        for metre in range(int(np.ceil(left)), int(right) + 1):
            y = np.interp(metre, *line.T)
            long = 0.3 if metre % 5 == 0 else 0.15
            axes.plot([metre, metre], [y, y + np.sign(edge - y) * long], color=unit_rgb(QUIET), linewidth=0.8, zorder=0.5)
    touching = life.contact[step]
    axes.plot(*life.position[step, touching].T, "^", color=unit_rgb(ACCENT), mec="white", mew=0.1 * size, ms=size, zorder=6)


def draw_swim(axes: Axes, life: Life, step: int, palette: str = DEFAULT) -> None:
    """Draw the body at a control step in its world, with the trail of its centre of mass."""
    draw_world(axes, life, step)
    draw_pose(axes, life.pose(step), life.springs, life.outline, life.chambers, palette)
    if len(life.target) and np.isfinite(life.target[step]).all():
        draw_target(axes, life.target[step], life.reach)
    axes.plot(*life.centre[: step + 1].T, color=unit_rgb(ACCENT), linewidth=1.5, solid_capstyle="round", zorder=4)


def draw_target(axes: Axes, target: Any, reach: float) -> None:
    """Draw a target, and rings around it where its scent has fallen by another fifth.  To be called when `frame` was.

    Args: reach: m to where the scent ends; 0 if not known, then without rings.
    """
    limits = axes.get_xlim(), axes.get_ylim()
    colour = unit_rgb(SECOND)
    for ring in np.arange(1, RINGS + 1) / RINGS * reach if reach else ():
        axes.add_patch(Circle(target, ring, fill=False, edgecolor=colour, linewidth=0.7, alpha=0.35, zorder=0, clip_on=True))
    axes.plot(*target, "*", color=colour, mec="white", mew=0.8, ms=12, zorder=7)
    axes.set(xlim=limits[0], ylim=limits[1])


def frame(axes: Axes, low: np.ndarray, high: np.ndarray) -> None:
    """Show [low, high] (2,) m in equal scales, centred, without any decoration.  To be called before anything is drawn."""
    box = axes.get_window_extent()
    centre, size = (np.asarray(low) + high) / 2, np.subtract(high, low)
    scale = max(size[0] / box.width, size[1] / box.height)
    axes.set(
        xlim=centre[0] + np.array((-0.5, 0.5)) * box.width * scale, ylim=centre[1] + np.array((-0.5, 0.5)) * box.height * scale,
        aspect="equal",
    )
    axes.axis("off")


def fit(text: Any, width: float, lines: int = 1) -> None:
    """Make a matplotlib text fit a width, inches: smaller down to _LEAST of its size, then in lines, the last of which is cut short.
    Its $ and backslashes are letters as all others."""
    text.set_parse_math(False)
    whole, size = text.get_text(), text.get_fontsize()
    over = _times_as_wide(text, width)
    if over > 1.0:
        text.set_fontsize(size * max(_LEAST, 0.99 / over))
    letters, over = len(whole), _times_as_wide(text, width)
    while over > 1.0 and letters > 2:
        letters = max(2, int(letters * min(0.95, 1.0 / over)))
        text.set_text("\n".join(textwrap.wrap(whole, letters, max_lines=lines, placeholder=" …")))
        over = _times_as_wide(text, width)


def _times_as_wide(text, width: float) -> float:
    return text.get_window_extent().width / text.figure.dpi / width


def shortened(name: str, letters: int = 48) -> str:
    """A name of at most as many letters, so that what a title says after it is seen."""
    return name if len(name) <= letters else f"{name[: letters - 1]}…"


def bounds(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rectangle around discs at position (..., 2), m, with a margin."""
    points = position.reshape(-1, 2)
    return points.min(axis=0) - 0.6 * DIAMETER, points.max(axis=0) + 0.6 * DIAMETER


def scale_bar(axes: Axes, metres: float) -> None:
    """A bar of some metres, i.e. cell diameters, above the axes on the right."""
    right, (bottom, top) = axes.get_xlim()[1], axes.get_ylim()
    y = top + 0.17 * axes.figure.dpi * (top - bottom) / axes.get_window_extent().height
    axes.plot([right - metres, right], [y, y], color=unit_rgb(INK), linewidth=2, solid_capstyle="butt", clip_on=False)
    style: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": 8.5, "color": "0.35", "annotation_clip": False}
    axes.annotate(f"{metres:g} m", (right - metres, y), (-6, 0), textcoords="offset points", **style)


def round_length(metres: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is not above `metres`."""
    power = 10.0 ** np.floor(np.log10(metres))
    return float(max(step * power for step in (1, 2, 5) if step * power <= metres * (1 + 1e-9)))
