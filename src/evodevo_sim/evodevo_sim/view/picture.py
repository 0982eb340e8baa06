"""One picture that tells a recording's story: growth, swim, muscles, distance, fitness."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..analysis.stretches import holes
from ..recording import Recording
from ..recording.life import Life, contrasting_cells, period_of
from .colours import ACCENT, INK, QUIET, SECOND, THIRD, activation_colours, unit_rgb
from .drawing import bounds, draw_pose, draw_swim, fit, frame, round_length, scale_bar
from .figure_file import save_figure
from .palettes import DEFAULT
from .summary import headline

FRAMES = 6  # of growth and of the swim
_WIDTH, _DPI = 12.8, 125  # inches; 1600 px
_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 0.4, 0.25, 1.25, 0.55, 0.65  # margins and distance of rows, inches
_LEGEND = 2.6  # inches, width of the scale of colours
_TALLEST = {FRAMES: 2.4, FRAMES // 2: 4.6}  # inches, of the swim's frames, by columns
_LINE = 160  # characters below the name
_CYCLES = 8.0  # periods of the muscles to show
STYLE: Any = {
    "font.family": "sans-serif", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "0.93", "axes.axisbelow": True, "axes.edgecolor": "0.6", "axes.titlesize": 10.5, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "axes.titlepad": 9, "text.color": unit_rgb(INK), "axes.labelcolor": unit_rgb(INK),
    "axes.titlecolor": unit_rgb(INK), "xtick.color": "0.35", "ytick.color": "0.35", "legend.frameon": False,
    "lines.linewidth": 1.5, "axes.xmargin": 0.0,
}


def save_story(
    recording: Recording, life: Life, path: str | os.PathLike, step: Callable[[str], None] = lambda part: None, palette: str = DEFAULT
) -> None:
    """Draw the story of a recording and save it as a picture, 12.8 inches wide: 1600 px as a PNG.

    Args: path: its ending names the format; step: called with the name of each part before it is drawn.
    """
    with matplotlib.rc_context(STYLE):
        rows = [*_growth_row(life, palette), *_swim_row(life, palette), *_curves_row(recording, life)]
        height = _TOP + sum(tall for tall, _, _ in rows) + _GAP * max(0, len(rows) - 1) + _BOTTOM
        figure = Figure((_WIDTH, height), dpi=_DPI, facecolor="white")
        _head(figure, recording, life, palette)
        top = height - _TOP
        for tall, name, draw in rows:
            step(name)
            draw(figure, top, tall)
            top -= tall + _GAP
        step("writing")
        save_figure(figure, path)


def save_frame(life: Life, path: str | os.PathLike, step: int = -1, pixels: int = 800) -> None:
    """Draw the body at one control step and save it with a transparent background; as a PNG it is `pixels` wide."""
    low, high = bounds(life.position[step])
    width, height = high - low
    figure = Figure((pixels / 100, pixels / 100 * height / width), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    frame(axes, low, high)
    draw_pose(axes, life.pose(step), life.springs, life.outline, life.chambers)
    save_figure(figure, path, transparent=True)


def _axes(figure, top, tall, columns: int, rows: int = 1, gap: float = 0.1, left: float = _LEFT, under: float = 0.0):
    """Axes in a grid.  Args, in inches: top and tall of the grid; gap between columns; left margin; room under rows."""
    width = (_WIDTH - left - _RIGHT - gap * (columns - 1)) / columns
    height = (tall - under * (rows - 1)) / rows
    total = figure.get_figheight()
    for k in range(columns * rows):
        x, y = left + k % columns * (width + gap), top - (k // columns + 1) * height - k // columns * under
        yield figure.add_axes((x / _WIDTH, y / total, width / _WIDTH, height / total))


def _heading(figure, top, text) -> None:
    figure.text(_LEFT / _WIDTH, (top + 0.12) / figure.get_figheight(), text, fontsize=10.5, fontweight="bold")


def _head(figure, recording: Recording, life: Life, palette: str) -> None:
    total = figure.get_figheight()
    name, facts = headline(recording, life)
    title = figure.text(_LEFT / _WIDTH, 1 - 0.45 / total, name, fontsize=17, fontweight="bold")
    fit(title, _WIDTH - _LEFT - _RIGHT - _LEGEND - 0.8)
    told = figure.text(_LEFT / _WIDTH, 1 - 0.6 / total, facts, fontsize=9.5, color="0.35", va="top")
    fit(told, _WIDTH - _LEFT - _RIGHT, lines=2)
    if not len(life.time) and not life.growth:
        return
    scale = figure.add_axes((1 - (_RIGHT + _LEGEND) / _WIDTH, 1 - 0.36 / total, _LEGEND / _WIDTH, 0.14 / total))
    values = np.linspace(-1, 1, 261)
    scale.imshow(activation_colours(values, palette)[None], aspect="auto", extent=(-1, 1, 0, 1))
    scale.set(yticks=[], xticks=(-1, 0, 1))
    scale.set_xticklabels(("−1 contracting", "0 at rest", "expanding +1"), fontsize=8.5)
    scale.text(-1.03, 0.5, "e − c", ha="right", va="center", fontsize=8.5, color="0.35")
    scale.tick_params(length=0, pad=3)
    for label, side in zip(scale.get_xticklabels(), ("left", "center", "right")):
        label.set_horizontalalignment(side)
    scale.spines[:].set_visible(False)
    scale.grid(False)


def growth_steps(life: Life) -> list[int]:
    """Steps at which the embryo has about 1, 2, 4, ... cells, before it divides again."""
    cells = np.array([len(pose.position) for pose in life.growth])
    wanted = np.unique(np.rint(np.geomspace(cells[0], cells[-1], FRAMES)))
    return sorted({int(np.flatnonzero(cells <= count)[-1]) for count in wanted})


def _growth_row(life: Life, palette: str):
    if not life.growth or not len(life.growth[0].position):
        return
    steps = growth_steps(life)

    def draw(figure, top, tall):
        _heading(figure, top, "Growth")
        size = np.max([np.subtract(*bounds(life.growth[k].position)[::-1]) for k in steps], axis=0) / 2
        for k, axes in zip(steps, _axes(figure, top, tall, FRAMES)):
            pose = life.growth[k]
            low, high = bounds(pose.position)
            frame(axes, (low + high) / 2 - size, (low + high) / 2 + size)
            draw_pose(axes, pose, life.growth_springs[k], palette=palette)
            many = "cell" if len(pose.position) == 1 else "cells"
            caption(axes, f"step {k}, {len(pose.position)} {many}")

    yield 1.9, "growth", draw


def caption(axes: Axes, text: str) -> None:
    """A line below axes."""
    axes.text(0.5, -0.03, text, transform=axes.transAxes, ha="center", va="top", fontsize=8.5, color="0.35")


def _walk_row(life: Life, palette: str):
    """Each frame follows the body."""
    if not len(life.time):
        return
    steps = np.unique(np.linspace(0, len(life.time) - 1, FRAMES).astype(int))
    middle = life.position.mean(axis=1)[:, 0]
    low, high = bounds(life.position[steps] - np.column_stack((middle[steps], 0.0 * steps))[:, None])
    low[1] -= 0.5
    columns = FRAMES // 2
    tall = float(np.clip(_WIDTH / columns * (high - low)[1] / (high - low)[0] * 2, 1.7, _TALLEST[columns]))

    def draw(figure, top, tall):
        _heading(figure, top, "Walk; each frame follows the body, a tick on the ground every metre, triangles where cells touch it")
        for number, (k, axes) in enumerate(zip(steps, _axes(figure, top, tall, columns, 2, under=0.25))):
            shift = np.array((middle[k], 0.0))
            frame(axes, low + shift, high + shift)
            draw_swim(axes, life, k, palette)
            caption(axes, f"{life.time[k] - life.time[0]:.3g} s, x = {middle[k] - middle[0]:.1f} m")
            if number == 0:
                for cell, colour in zip(contrasting_cells(life.activation), (ACCENT, SECOND)):
                    axes.plot(*life.position[k, cell], "o", color=unit_rgb(colour), mec="white", mew=1, ms=6, zorder=6)

    yield tall, "walk", draw


def _swim_row(life: Life, palette: str):
    if not len(life.time):
        return
    if life.scene is not None:
        yield from _walk_row(life, palette)
        return
    seen_targets = life.target[np.isfinite(life.target).all(axis=1)]
    low, high = bounds(np.concatenate((life.position.reshape(-1, 2), seen_targets)))
    width, height = high - low
    # One row, or two where the body is seen a good deal larger so: (height in inches, m that an inch shows), by columns.
    talls = {n: min(_TALLEST[n], max(1.7, _WIDTH / n * height / width * (FRAMES // n))) for n in _TALLEST}
    seen = {n: max(width * n / _WIDTH, height / (tall / (FRAMES // n))) for n, tall in talls.items()}
    one, two = seen
    columns = two if seen[one] > 1.4 * seen[two] else one

    def draw(figure, top, tall):
        _heading(figure, top, "Swim, and the path of the centre of mass" + (" towards the target" if len(seen_targets) else ""))
        steps = np.unique(np.linspace(0, len(life.time) - 1, FRAMES).astype(int))
        grid = _axes(figure, top, tall, columns, FRAMES // columns, under=0.25)
        for number, (k, axes) in enumerate(zip(steps, grid)):
            frame(axes, low, high)
            draw_swim(axes, life, k, palette)
            caption(axes, f"{life.time[k] - life.time[0]:.3g} s")
            if number == 0:
                for cell, colour in zip(contrasting_cells(life.activation), (ACCENT, SECOND)):
                    axes.plot(*life.position[k, cell], "o", color=unit_rgb(colour), mec="white", mew=1, ms=6, zorder=6)
            if number == min(columns, len(steps)) - 1:
                scale_bar(axes, round_length(np.ptp(axes.get_xlim()) / 4))

    yield talls[columns], "swim", draw


def _curves_row(recording: Recording, life: Life):
    curves = []
    if len(life.time):
        curves += [lambda axes: _activation(axes, life), lambda axes: _distance(axes, life)]
    if recording.statistics:
        curves.append(lambda axes: _fitness(axes, recording.statistics))

    def draw(figure, top, tall):
        for curve, axes in zip(curves, _axes(figure, top, tall, len(curves), gap=0.65, left=_LEFT + 0.25)):
            curve(axes)

    if curves:
        yield 2.1, "curves", draw


def _broken(seconds, values):
    """A curve that is not drawn across holes."""
    behind = holes(seconds) + 1
    return np.insert(seconds, behind, np.nan), np.insert(values, behind, np.nan)


def _activation(axes, life: Life) -> None:
    cells, seconds = contrasting_cells(life.activation), life.time - life.time[0]
    shown = seconds >= seconds[-1] - _CYCLES * period_of(life, cells)
    for cell, colour in zip(cells, (ACCENT, SECOND)):
        axes.plot(*_broken(seconds[shown], life.activation[shown, cell]), color=unit_rgb(colour), label=f"cell {cell}")
    most = min(1.05, max(0.25, 1.3 * np.abs(life.activation[np.ix_(shown, cells)]).max()))
    axes.axhline(0.0, color="0.75", linewidth=0.8, zorder=1)
    axes.set(title="Activation e − c", xlabel="time since birth, s", ylim=(-most, most))
    legend(axes)


def _distance(axes, life: Life) -> None:
    seconds, aims = life.time - life.time[0], len(life.target) > 0
    axes.plot(*_broken(seconds, life.distance), color=unit_rgb(THIRD), label="from birth")
    axes.set(title="Distance, m" if aims else "Distance from birth, m", xlabel="time since birth, s")
    if aims:
        axes.plot(*_broken(seconds, life.target_distance), color=unit_rgb(SECOND), label="to target")
        legend(axes)
    axes.set_ylim(bottom=0.0)


def _fitness(axes, statistics) -> None:
    generation = [s.generation for s in statistics]
    median, best = [s.median for s in statistics], [s.best for s in statistics]
    marker = "o" if len(generation) == 1 else ""
    axes.plot(generation, best, color=unit_rgb(ACCENT), label="best", marker=marker)
    axes.plot(generation, median, color=unit_rgb(SECOND), label="median", marker=marker)
    if max(best) > 0:  # failures lie far below, and would press everything else flat
        axes.set_ylim(-0.06 * max(best), 1.08 * max(best))
    axes.axhline(0.0, color=unit_rgb(QUIET), linewidth=0.8, zorder=1)
    axes.set(title="Fitness, m", xlabel="generation")
    axes.xaxis.get_major_locator().set_params(integer=True)
    legend(axes)


def legend(axes: Axes) -> None:
    """In the line of the title."""
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=1.5, columnspacing=1.2)
