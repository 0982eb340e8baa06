"""Turning maps: each cell's mean activation in a turn, minus that on the way without a target, which points up (paper, Fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize

from ...analysis.turning import Turning, turning
from ...parameters import ParameterError
from ...recording.champion import Champion
from ..colours import INK, unit_rgb
from ..drawing import DIAMETER, bounds, frame, round_length
from .sheet import Sheet, bar

_MAP = "RdBu_r"  # blue lower, white no change, red higher, which the colour-blind tell apart; signs tell it in grey
_SIGN, _DARK = 0.3, 0.65  # of the most, from which a cell has a sign, and a dark colour
_HEAD, _TALL, _FOOT, _PAIRS = 13.0, 40.0, 7.0, 2  # mm; pairs of maps in a row


def draw(sources: Sequence[Champion], sheet: Sheet) -> None:
    found: list[tuple[str, Turning]] = []
    for one in sources:
        if not one.task.has_target:
            raise ParameterError(f"{one.name} is of the task {one.task.name}, which has no target to turn to: draw gait, traces, growth "
                                 "or fitness of it instead")
        try:
            found.append((one.name, turning(one.genome, one.task, one.seed)))
        except ParameterError as error:
            raise ParameterError(f"{one.name}: {error}") from None
    columns = min(_PAIRS, len(found))
    sheet.begin(-(-len(found) // columns) * (_HEAD + _TALL + _FOOT))
    wide = sheet.width / columns
    for k, (name, turn) in enumerate(found):
        left, top = k % columns * wide, k // columns * (_HEAD + _TALL + _FOOT)
        sheet.label(k, len(found), left + 2, top + 2, f"{name}: {turn.control}, contracts the {turn.side} side", wide - 4)
        _pair(sheet, turn, left, top + _HEAD, wide)


def _pair(sheet: Sheet, one: Turning, left: float, top: float, wide: float) -> None:
    up = np.array([(one.heading[1], -one.heading[0]), one.heading])  # rows: to the right, ahead
    place = (one.place - one.start) @ up.T
    most = max(float(np.abs(one.change).max()), 1e-3)
    map_wide = (wide - 18) / 2
    for side, said in enumerate(("target on the left", "target on the right")):
        axes = sheet.axes(left + 2 + side * (map_wide + 1), top, map_wide, _TALL)
        frame(axes, *bounds(place))
        discs = EllipseCollection(
            np.full(len(place), DIAMETER), np.full(len(place), DIAMETER), np.zeros(len(place)), units="xy", offsets=place,
            transOffset=axes.transData, cmap=_MAP, norm=Normalize(-most, most), edgecolors=[unit_rgb(INK)], linewidths=0.4,
        )
        discs.set_array(one.change[side])
        axes.add_collection(discs)
        size = min(7.0, 0.6 * map_wide / 25.4 * 72 / np.ptp(axes.get_xlim()))
        for (x, y), change in zip(place, one.change[side]):
            if abs(change) >= _SIGN * most:
                ink = "white" if abs(change) > _DARK * most else "black"
                axes.text(x, y, "+" if change > 0 else "−", fontsize=size, color=ink, ha="center", va="center", zorder=5)
        axes.set_title(said, fontsize=6.5, fontweight="normal", loc="center", pad=2)
        if side:
            bar(axes, round_length(np.ptp(axes.get_xlim()) / 4), place)
            scale = sheet.figure.colorbar(discs, cax=sheet.axes(left + wide - 13, top + 6, 2, _TALL - 12))
            scale.outline.set_visible(False)
            scale.ax.tick_params(labelsize=6, width=0.5, length=2)
            scale.ax.set_title("change of\ne − c", fontsize=6, fontweight="normal", loc="center", pad=3)
