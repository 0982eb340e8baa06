"""A map of unlike animals in one picture: a grid over two measures, each animal in its cell, with its fitness, gait and audit."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PatchCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .colours import ACCENT, INK, unit_rgb
from .drawing import DIAMETER, fit
from .figure_file import save_figure
from .picture import STYLE

COLOURS = "cividis"  # from dark blue to yellow, the same to the colour-blind, lighter all the way
_WIDTH, _DPI = 12.8, 125  # inches
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.95, 1.2, 1.0, 0.75  # inches, of margins
_WIDEST, _SHAPE = 2.0, 0.82  # inches, of a cell; height over width
_MARGIN, _LINE = 0.06, 0.16  # shares of a cell's width and height: about a body; of the lines above and below it
_READABLE = 0.55  # inches of a cell, from which on there is room for its gait
_LIGHT = 0.55  # share of the colours, from which on ink is read better than white


@dataclass(frozen=True)
class Axis:
    """An axis of a map.  title: with its unit; edges: (bins + 1,) values of what the title says, ascending."""

    title: str
    edges: tuple[float, ...]

    @property
    def bins(self) -> int:
        return len(self.edges) - 1


@dataclass(frozen=True, eq=False)
class Shown:
    """An animal of a map.

    Attributes: column, row: of its cell; fitness, m; position (N, 2) m, forward to the right; springs (E, 2); gait: its name, or empty;
        stands: whether its audit stands, None: it had none; motion (T, N, 2) m, in frames evenly spaced, or empty.
    """

    column: int
    row: int
    fitness: float
    position: np.ndarray
    springs: np.ndarray
    gait: str = ""
    stands: bool | None = None
    motion: np.ndarray = field(default_factory=lambda: np.empty((0, 0, 2)))


@dataclass(frozen=True, eq=False)
class BodyMap:
    """title; facts: a line below it; x, y; animals, at the most one in a cell; frame_time: s between frames of motions."""

    title: str
    facts: str
    x: Axis
    y: Axis
    animals: Sequence[Shown]
    frame_time: float = 0.0

    @property
    def most(self) -> float:
        """m, the fitness at the upper end of the colours."""
        return max((one.fitness for one in self.animals), default=0.0) or 1.0


def gaits_in(animals: Sequence[Shown]) -> str:
    """How many have which gait, the commonest first."""
    counts = Counter(one.gait for one in animals if one.gait)
    return ", ".join(f"{name} {count}" for name, count in sorted(counts.items(), key=lambda of: (-of[1], of[0])))


def shade(fitness: float, most: float) -> float:
    """The place of a fitness among the colours, 0 to 1."""
    return min(1.0, max(0.0, fitness / most))


def save_map(found: BodyMap, path: str | os.PathLike) -> None:
    """Draw a map and save it as a picture.  Args: path: its ending names the format."""
    wide = min(_WIDEST, (_WIDTH - _LEFT - _RIGHT) / found.x.bins)
    tall = wide * _SHAPE
    across, up = wide * found.x.bins, tall * found.y.bins
    total = _TOP + up + _BOTTOM
    with matplotlib.rc_context(STYLE):
        figure = Figure((_WIDTH, total), dpi=_DPI, facecolor="white")
        title = figure.text(0.4 / _WIDTH, 1 - 0.45 / total, found.title, fontsize=17, fontweight="bold")
        fit(title, _WIDTH - 0.8)
        facts = figure.text(0.4 / _WIDTH, 1 - 0.6 / total, found.facts, fontsize=9.5, color="0.35", va="top")
        fit(facts, _WIDTH - 0.8, lines=2)
        axes = figure.add_axes((_LEFT / _WIDTH, _BOTTOM / total, across / _WIDTH, up / total))
        axes.set(xlim=(0, across), ylim=(0, up))
        _draw_cells(axes, found, wide, tall)
        for one in found.animals:
            _draw_animal(axes, one, found.most, wide, tall)
        _draw_best(axes, found, wide, tall)
        _label(axes.xaxis, found.x, wide)
        _label(axes.yaxis, found.y, tall)
        axes.grid(False)
        axes.spines[:].set_visible(False)
        bar = figure.add_axes(((_LEFT + across + 0.3) / _WIDTH, (_BOTTOM + 0.1 * up) / total, 0.14 / _WIDTH, 0.8 * up / total))
        colours = figure.colorbar(ScalarMappable(Normalize(0.0, found.most), COLOURS), cax=bar)
        colours.outline.set_visible(False)
        bar.set_ylabel("fitness, m", fontsize=8.5)
        save_figure(figure, path)


def _draw_cells(axes: Axes, found: BodyMap, wide: float, tall: float) -> None:
    every = [Rectangle((k * wide, j * tall), wide, tall) for k in range(found.x.bins) for j in range(found.y.bins)]
    axes.add_collection(PatchCollection(every, facecolor="0.955", edgecolor="white", linewidth=1.2, zorder=0))
    full = [Rectangle((one.column * wide, one.row * tall), wide, tall) for one in found.animals]
    colours = matplotlib.colormaps[COLOURS]([shade(one.fitness, found.most) for one in found.animals])
    axes.add_collection(PatchCollection(full, facecolors=colours, edgecolor="white", linewidth=1.2, zorder=1))


def _draw_animal(axes: Axes, one: Shown, most: float, wide: float, tall: float) -> None:
    """The body as large as its cell lets it be, a line of words above and one below."""
    words = wide >= _READABLE
    room = wide * (1 - 2 * _MARGIN), tall * (1 - (2 * _LINE if words else 2 * _MARGIN))
    low, high = one.position.min(axis=0) - 0.5 * DIAMETER, one.position.max(axis=0) + 0.5 * DIAMETER
    scale = min(room[0] / (high - low)[0], room[1] / (high - low)[1], 0.22 * wide)
    at = (np.array((one.column + 0.5, one.row + 0.5)) * (wide, tall)) + (one.position - (low + high) / 2) * scale
    size = np.full(len(at), scale * DIAMETER)
    thin = min(1.0, 4.0 * scale)
    discs = EllipseCollection(
        size, size, np.zeros(len(at)), units="xy", offsets=at, transOffset=axes.transData, facecolors=(1, 1, 1, 0.88),
        edgecolors=[(*unit_rgb(INK), 0.8)], linewidths=0.5 * thin, zorder=2,
    )
    axes.add_collection(discs)
    axes.add_collection(LineCollection(at[one.springs], colors=[unit_rgb(INK)], linewidths=0.9 * thin, zorder=3))
    if not words:
        return
    colour = unit_rgb(INK) if shade(one.fitness, most) > _LIGHT else (1.0, 1.0, 1.0)
    style: dict[str, Any] = {"color": colour, "fontsize": min(9.0, 7.4 * math.sqrt(wide)), "zorder": 4, "parse_math": False}
    left, bottom, pad = one.column * wide, one.row * tall, 0.05 * wide
    axes.text(left + pad, bottom + tall - 0.02 * tall, f"{one.fitness:.3g}", va="top", **style)
    axes.text(left + 0.5 * wide, bottom + 0.035 * tall, one.gait, ha="center", va="bottom", **style)
    if one.stands is False:
        axes.text(left + wide - pad, bottom + tall - 0.02 * tall, "fails", ha="right", va="top", fontweight="bold", **style)


def _draw_best(axes: Axes, found: BodyMap, wide: float, tall: float) -> None:
    if found.animals:
        best = max(found.animals, key=lambda one: one.fitness)
        ring = Rectangle((best.column * wide, best.row * tall), wide, tall, fill=False, edgecolor=unit_rgb(ACCENT), linewidth=2.4, zorder=5)
        axes.add_patch(ring)


def _label(axis: Any, given: Axis, size: float) -> None:
    """Every edge by its value, or every second, third, ... where they are close."""
    every = max(1, math.ceil(0.42 / size))
    shown = range(0, given.bins + 1, every)
    axis.set_ticks([k * size for k in shown], [f"{given.edges[k]:.3g}" for k in shown])
    axis.set_tick_params(length=2)
    axis.set_label_text(given.title)
