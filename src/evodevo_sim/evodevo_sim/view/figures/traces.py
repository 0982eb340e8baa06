"""What the muscles of two cells do over time, below the body that has them, a column each (paper, Fig. 5)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...analysis.stretches import holes
from ...recording.life import contrasting_cells, period_of
from ..drawing import bounds, draw_pose, frame, round_length
from ..sources import Shown, need_life
from .common import gait_of
from .sheet import Sheet, bar, spot, stroke

_PERIODS = 4.0
_COLUMNS = 3
_BODY, _PLOT, _HEAD, _AXIS = 38.0, 26.0, 9.0, 11.0  # mm


def draw(sources: Sequence[Shown], sheet: Sheet) -> None:
    for one in sources:
        need_life(one, one.name, "traces of muscles", growth=False)
    columns = min(_COLUMNS, len(sources))
    rows = -(-len(sources) // columns)
    tall = _HEAD + _BODY + _PLOT + _AXIS
    sheet.begin(6 + rows * tall)
    sheet.colours(sheet.width - 43, 1.5)
    wide = sheet.width / columns
    for k, one in enumerate(sources):
        left, top, life = k % columns * wide, 6 + k // columns * tall, one.life
        cells = contrasting_cells(life.activation)
        seconds = life.time - life.time[0]
        gait = gait_of(one)
        sheet.label(k, len(sources), left + 2, top + 1, one.name + ("" if gait is None else f": {gait.name}"), wide - 4)
        body = sheet.axes(left + 2, top + _HEAD - 2, wide - 4, _BODY)
        frame(body, *bounds(life.position[-1]))
        draw_pose(body, life.pose(len(life.time) - 1), life.springs, life.outline, life.chambers, sheet.palette)
        bar(body, round_length(np.ptp(body.get_xlim()) / 5), life.position[-1])
        axes = sheet.axes(left + 11, top + _HEAD + _BODY + 1, wide - 15, _PLOT)
        late = seconds >= seconds[-1] - _PERIODS * period_of(life, cells)
        gaps = holes(seconds[late]) + 1
        for number, cell in enumerate(cells):
            spot(body, life.position[-1, cell], number, "AB"[number])
            values = np.insert(life.activation[late, cell], gaps, np.nan)
            axes.plot(np.insert(seconds[late], gaps, np.nan), values, label=f"cell {'AB'[number]}", **stroke(number))
        axes.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
        axes.set(xlabel="time since birth, s", ylim=(-1.05, 1.05), yticks=(-1, 0, 1))
        if k % columns == 0:
            axes.set_ylabel("e − c", labelpad=1)
        axes.legend(ncols=2, loc="lower left", bbox_to_anchor=(0.0, 0.98), borderaxespad=0.0, handlelength=2.2, columnspacing=1.2)
