"""The line of a champion in one picture: bodies on the way, fitness of all ancestors, what changed whom, and how much there is of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from evodevo_sim.recording.life import Pose
from evodevo_sim.view.colours import ACCENT, INK, QUIET, SECOND, THIRD, unit_rgb
from evodevo_sim.view.drawing import bounds, draw_pose, fit, frame
from evodevo_sim.view.figure_file import save_figure
from evodevo_sim.view.picture import STYLE, caption
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .lineage import Lineage

BODIES = 8  # at the most
_WIDTH, _LEFT, _RIGHT = 12.8, 1.05, 0.3  # inches
_COLUMN = (_WIDTH - 0.4 - _RIGHT) / BODIES
_TALLEST, _CAPTION, _FITNESS, _LANE, _SIZES, _HEAD, _FOOT, _GAP = 2.2, 0.4, 3.2, 0.2, 0.95, 1.0, 0.55, 0.42
_ORDER = ("given", "random", "scatter", "crossover", "duplicate", "delete", "points", "flip", "scent")
_COLOURS = {"crossover": ACCENT, "duplicate": THIRD, "delete": SECOND, "points": INK, "flip": (196, 64, 84)}


@dataclass(frozen=True, eq=False)
class Ancestor:
    """A body to show: its place in the lineage; position (N, 2) m; edges (E, 2): pairs of cells."""

    place: int
    position: np.ndarray
    edges: np.ndarray


def save_descent(
    found: Lineage, bodies: Sequence[Ancestor], best: np.ndarray, median: np.ndarray, title: tuple[str, str], path: str | os.PathLike
) -> None:
    """Draw a lineage and save the picture.

    Args: best, median (G,): fitness of each generation of the run; title: a name, and a line of facts; path: its ending names the format.
    """
    lanes = [name for name in _ORDER if name in found.counts()] + sorted(set(found.counts()) - set(_ORDER))
    talls = [_FITNESS, _LANE * len(lanes) + 0.1, _SIZES]
    shown = _height(bodies)
    total = _HEAD + shown + sum(talls) + _GAP * 3 + _FOOT
    with matplotlib.rc_context(STYLE):
        figure = Figure((_WIDTH, total), dpi=125, facecolor="white")
        _head(figure, title)
        top = total - _HEAD
        _draw_bodies(figure, found, bodies, top)
        top -= shown + _GAP
        rows = []
        for tall in talls:
            box = (_LEFT / _WIDTH, (top - tall) / total, (_WIDTH - _LEFT - _RIGHT) / _WIDTH, tall / total)
            rows.append(figure.add_axes(box))
            top -= tall + _GAP
        _draw_fitness(rows[0], found, bodies, best, median)
        _draw_lanes(rows[1], found, lanes)
        _draw_sizes(rows[2], found)
        low, high = found.generation[found.line[[0, -1]]]
        pad = 0.012 * max(1, high - low)
        for axes in rows:
            axes.set_xlim(low - pad, high + pad)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        for axes in rows[:-1]:
            axes.tick_params(labelbottom=False)
        rows[-1].set_xlabel("generation")
        save_figure(figure, path)


def _head(figure: Figure, title: tuple[str, str]) -> None:
    total = figure.get_figheight()
    name = figure.text(0.4 / _WIDTH, 1 - 0.45 / total, title[0], fontsize=17, fontweight="bold")
    fit(name, _WIDTH - 0.8)
    facts = figure.text(0.4 / _WIDTH, 1 - 0.6 / total, title[1], fontsize=9.5, color="0.35", va="top")
    fit(facts, _WIDTH - 0.8, lines=2)


def _half(bodies: Sequence[Ancestor]) -> np.ndarray:
    """Half of the sides of the rectangle that each of the bodies fits, (2,) m."""
    return np.max([np.subtract(*bounds(one.position)[::-1]) for one in bodies], axis=0) / 2


def _height(bodies: Sequence[Ancestor]) -> float:
    """Of the row of bodies, inches, with its captions."""
    if not bodies:
        return 0.0
    width, height = _half(bodies)
    return min(_TALLEST, 0.94 * _COLUMN * height / width) + _CAPTION


def _draw_bodies(figure: Figure, found: Lineage, bodies: Sequence[Ancestor], top: float) -> None:
    total, tall = figure.get_figheight(), _height(bodies) - _CAPTION
    for k, one in enumerate(bodies):
        size = _half(bodies)
        axes = figure.add_axes(((0.4 + k * _COLUMN) / _WIDTH, (top - tall) / total, 0.94 * _COLUMN / _WIDTH, tall / total))
        low, high = bounds(one.position)
        frame(axes, (low + high) / 2 - size, (low + high) / 2 + size)
        draw_pose(axes, Pose(one.position, np.zeros(len(one.position))), one.edges)
        caption(axes, f"$\\bf{{{_letter(k)}}}$  generation {found.generation[one.place]}\n{found.fitness[one.place]:.3g} m")


def _letter(k: int) -> str:
    return "abcdefghijklmnopqrstuvwxyz"[k]


def _draw_fitness(axes: Axes, found: Lineage, bodies: Sequence[Ancestor], best: np.ndarray, median: np.ndarray) -> None:
    generations = np.arange(len(best))
    most = max(float(np.max(best)), 1e-9)
    floor = -0.05 * most  # failures lie far below, and would press everything else flat
    low = np.maximum(found.fitness, floor)
    axes.plot(generations, np.maximum(best, floor), color="0.72", linewidth=1.0, drawstyle="steps-post", label="best of the population")
    axes.plot(generations, np.maximum(median, floor), color="0.82", linewidth=1.0, linestyle=(0, (3, 2)), label="median")
    points = np.stack((found.generation, low), axis=-1)
    if len(found.links):
        thin = LineCollection(list(points[found.links]), colors=[unit_rgb(QUIET)], linewidths=0.5, alpha=0.35, zorder=2)
        axes.add_collection(thin)
    aside = np.setdiff1d(np.arange(len(low)), found.line)
    axes.plot(*points[aside].T, ".", color=unit_rgb(QUIET), ms=3, alpha=0.6, zorder=2.5, label="other ancestors, by crossover")
    axes.plot(*points[found.line].T, color=unit_rgb(ACCENT), linewidth=1.8, zorder=3, label="the champion's line")
    axes.plot(*points[found.line].T, ".", color=unit_rgb(ACCENT), ms=5 if len(found.line) < 200 else 3, zorder=3.5)
    for k, one in enumerate(bodies):
        axes.plot(*points[one.place], "o", color="white", mec=unit_rgb(INK), mew=1.2, ms=7, zorder=4)
        style: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "fontsize": 9, "fontweight": "bold", "zorder": 5}
        axes.annotate(_letter(k), points[one.place], (0, 7), **style)
    axes.set(title="Fitness, m", ylim=(floor - 0.02 * most, 1.12 * most))
    axes.legend(ncols=4, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.5, columnspacing=1.2)


def _draw_lanes(axes: Axes, found: Lineage, lanes: Sequence[str]) -> None:
    counts, generation = found.counts(), found.generation[found.line]
    for k, name in enumerate(lanes):
        made = np.array([name in found.operators[place] for place in found.line])
        width = 1.6 if len(found.line) < 200 else 0.8
        axes.vlines(generation[made], -k - 0.38, -k + 0.38, color=unit_rgb(_COLOURS.get(name, QUIET)), linewidth=width)
    axes.set(title="What made each of the line", ylim=(-len(lanes) + 0.4, 0.6), yticks=[-k for k in range(len(lanes))])
    axes.set_yticklabels([f"{name} {counts[name]}" for name in lanes], fontsize=8.5)
    axes.grid(False, axis="y")
    axes.tick_params(axis="y", length=0)


def _draw_sizes(axes: Axes, found: Lineage) -> None:
    generation = found.generation[found.line]
    for values, colour, name in ((found.elements, THIRD, "genetic elements"), (found.cells, SECOND, "cells")):
        axes.plot(generation, values[found.line], color=unit_rgb(colour), label=name, marker="o" if len(generation) == 1 else "")
    axes.set(title="Size of genome and body")
    axes.set_ylim(bottom=0.0, top=1.08 * float(max(found.elements[found.line].max(), 1)))
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.5, columnspacing=1.2)
