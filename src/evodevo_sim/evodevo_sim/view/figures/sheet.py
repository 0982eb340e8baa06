"""A sheet of paper: sizes in mm, axes by their place on it, lines that grey tells apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..colours import INK, SERIES, activation_colours, unit_rgb
from ..drawing import fit
from ..picture import STYLE

MM = 1 / 25.4  # inches
DPI = 300
PRINT: Any = STYLE | {
    "font.size": 7, "axes.titlesize": 7.5, "axes.labelsize": 7, "xtick.labelsize": 6.5, "ytick.labelsize": 6.5, "legend.fontsize": 6.5,
    "lines.linewidth": 1.1, "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.major.size": 2.5,
    "ytick.major.size": 2.5, "axes.titlepad": 4, "grid.linewidth": 0.5,
}
LINES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 1.5, 1, 1.5)))


@dataclass
class Sheet:
    """width: mm; palette: of cells; say: called with lines that the user must know.  figure: made by `begin`."""

    width: float
    palette: str = "safe"
    say: Callable[[str], None] = lambda line: None
    height: float = 0.0
    figure: Figure = field(default_factory=Figure)

    def begin(self, height: float) -> None:
        """Args: height: mm."""
        self.height = height
        self.figure = Figure((self.width * MM, height * MM), dpi=DPI, facecolor="white")

    def axes(self, left: float, top: float, wide: float, tall: float) -> Axes:
        """Axes at a place, mm from the left and upper edge."""
        return self.figure.add_axes((left / self.width, 1 - (top + tall) / self.height, wide / self.width, tall / self.height))

    def text(self, left: float, top: float, said: str, wide: float = 0.0, **style: Any) -> None:
        """A text whose upper left corner is at a place, mm; it shrinks to fit `wide`, and is cut in the end."""
        made = self.figure.text(left / self.width, 1 - top / self.height, said, **({"va": "top"} | style))
        if wide:
            fit(made, wide * MM)

    def label(self, k: int, many: int, left: float, top: float, said: str, wide: float) -> None:
        """The head of a part: a letter where there are several, and what it is."""
        if many > 1:
            self.text(left, top, f"({chr(ord('a') + k % 26)})", fontweight="bold")
        self.text(left + (5.5 if many > 1 else 0.0), top, said, wide - 6)

    def colours(self, left: float, top: float, wide: float = 40.0) -> None:
        """The scale of activation, with words."""
        scale = self.axes(left, top, wide, 2.2)
        scale.imshow(activation_colours(np.linspace(-1, 1, 201), self.palette)[None], aspect="auto", extent=(-1, 1, 0, 1))
        scale.set(yticks=[], xticks=(-1, 0, 1))
        scale.set_xticklabels(("−1 contracting", "0", "expanding +1"), fontsize=6)
        scale.tick_params(length=0, pad=1.5)
        scale.spines[:].set_visible(False)
        scale.grid(False)
        left_label, _, right_label = scale.get_xticklabels()
        left_label.set_horizontalalignment("left")
        right_label.set_horizontalalignment("right")
        scale.text(-1.04, 0.5, "e − c", ha="right", va="center", fontsize=6.5)


def stroke(k: int) -> dict[str, Any]:
    """The colour and dashes of the k-th of several curves."""
    return {"color": unit_rgb(SERIES[k % len(SERIES)]), "linestyle": LINES[(k + k // len(SERIES)) % len(LINES)]}


def caption(axes: Axes, said: str) -> None:
    """A line below axes."""
    axes.text(0.5, -0.03, said, transform=axes.transAxes, ha="center", va="top", fontsize=6.5, color="0.3")


def spot(axes: Axes, at: Any, k: int, letter: str) -> None:
    """Mark a cell, in the colour of the k-th curve, with a letter."""
    x, y = at
    axes.plot(x, y, "o", color=unit_rgb(SERIES[k]), mec="white", mew=0.7, ms=6.5, zorder=8)
    axes.text(x, y, letter, color="white", fontsize=5, ha="center", va="center_baseline", zorder=9, fontweight="bold")


def bar(axes: Axes, metres: float, around: np.ndarray | None = None) -> None:
    """A bar of some metres at the lower right of axes without decoration, or at the first other corner where no cell is in its way.

    Args: around (N, 2) m: centres of cells.
    """
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    figure, tall = axes.get_figure(), top - bottom
    assert figure is not None
    text = tall * 8.0 / (axes.get_window_extent().height * 72.0 / figure.dpi)  # of 6 points, with some room
    cells, clear = np.empty((0, 2)) if around is None else np.asarray(around), (metres / 2 + 0.6, text / 2 + 0.6)
    places = [(x, y) for x in (right, left + metres) for y in (bottom + 0.02 * tall, top - text - 0.02 * tall)]
    free = (at for at in places if not np.any(np.all(np.abs(cells - (at[0] - metres / 2, at[1] + text / 2)) <= clear, axis=1)))
    right_end, y = next(free, places[0])
    axes.plot([right_end - metres, right_end], [y, y], color=unit_rgb(INK), linewidth=1.2, solid_capstyle="butt", clip_on=False, zorder=9)
    axes.text(right_end - metres / 2, y + 0.025 * tall, f"{metres:g} m", ha="center", va="bottom", fontsize=6)
    axes.set(xlim=(left, right), ylim=(bottom, top))
