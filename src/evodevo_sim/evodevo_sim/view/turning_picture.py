"""Turning maps as in the paper's Fig. 6: each cell's mean activation in a turn, minus that on the way without a target."""

from __future__ import annotations

import os

import matplotlib
import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from ..analysis.turning import Turning
from .colours import ACCENT, INK, QUIET, SECOND, THIRD, unit_rgb
from .drawing import DIAMETER, bounds, fit, frame, round_length, scale_bar, shortened
from .figure_file import save_figure
from .palettes import DEFAULT, PALETTES
from .picture import STYLE

_COLUMN, _ROW = 4.2, 3.9  # inches


def save_turning(found: list[tuple[str, Turning]], path: str | os.PathLike, palette: str = DEFAULT) -> None:
    """Draw champions, a row each: the map of a turn to the left, of one to the right, and the three paths; save a picture."""
    with matplotlib.rc_context(STYLE):
        figure = Figure((3 * _COLUMN, _ROW * len(found) + 1.1), dpi=125, facecolor="white")
        grid = figure.subplots(len(found), 3, squeeze=False)
        figure.subplots_adjust(
            left=0.02, right=0.97, top=1 - 0.75 / figure.get_figheight(), bottom=0.5 / figure.get_figheight(), hspace=0.3
        )
        for axes, (name, one) in zip(grid, found):
            _champion(axes, name, one, _colour_map(palette))
        title = "Change of mean activation in a turn; the way without a target points up"
        figure.suptitle(title, fontsize=13, fontweight="bold", y=1 - 0.12 / figure.get_figheight())
        save_figure(figure, path)


def _colour_map(palette: str):
    """The colour map of changes, by name or itself."""
    chosen = PALETTES[palette]
    return chosen.change or LinearSegmentedColormap.from_list(palette, [unit_rgb(stop) for stop in chosen.stops])


def _champion(axes, name: str, one: Turning, colour_map) -> None:
    up = np.array([(one.heading[1], -one.heading[0]), one.heading])  # rows: to the right, ahead
    place = (one.place - one.start) @ up.T
    most = max(float(np.abs(one.change).max()), 1e-3)
    low, high = bounds(place)
    for side in (0, 1):
        frame(axes[side], low - 0.5, high + 0.5)
        discs = EllipseCollection(
            np.full(len(place), DIAMETER), np.full(len(place), DIAMETER), np.zeros(len(place)), units="xy", offsets=place,
            transOffset=axes[side].transData, cmap=colour_map, norm=Normalize(-most, most), edgecolors=[unit_rgb(INK)], linewidths=0.6,
        )
        discs.set_array(one.change[side])
        axes[side].add_collection(discs)
        title = f"{shortened(name)}: target on the left" if side == 0 else f"target on the right; contracts the {one.side} side"
        fit(axes[side].set_title(title, fontsize=9.5), 0.85 * _COLUMN, lines=2)
        bar = axes[side].figure.colorbar(discs, ax=axes[side], fraction=0.035, pad=0.02)
        bar.ax.tick_params(labelsize=7.5)
        bar.outline.set_visible(False)
    _paths(axes[2], one, up)


def _paths(axes, one: Turning, up) -> None:
    paths, targets = (one.paths - one.start) @ up.T, (one.targets - one.start) @ up.T
    low, high = bounds(np.concatenate((paths.reshape(-1, 2), targets)))
    frame(axes, low, high)
    for path, colour, label in zip(paths, (SECOND, THIRD, QUIET), ("target on the left", "target on the right", "no target")):
        axes.plot(*path.T, color=unit_rgb(colour), label=label)
    for target, colour in zip(targets, (SECOND, THIRD)):
        axes.plot(*target, "*", color=unit_rgb(colour), ms=13, mec="white")
    axes.plot(0, 0, "o", color=unit_rgb(ACCENT), ms=5)
    axes.set_title(one.control, fontsize=9.5)
    axes.legend(fontsize=8, loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.12), handlelength=1.2, columnspacing=1.0)
    scale_bar(axes, round_length(np.ptp(axes.get_xlim()) / 4))
