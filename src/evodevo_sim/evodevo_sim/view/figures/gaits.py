"""Bodies over one period of their muscles, a row each, walkers on their ground (paper, Figs. 3 and 4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...analysis.gait.table import headline
from ...recording.life import Life, period_of
from ..drawing import DIAMETER, bounds, draw_pose, draw_world, frame, round_length
from ..sources import Shown, need_life
from .common import gait_of
from .sheet import Sheet, bar, caption

_FRAMES = 6
_HEAD, _ROW, _FOOT, _MOST = 10.0, 12.0, 1.5, 46.0  # mm


def draw(sources: Sequence[Shown], sheet: Sheet) -> None:
    for one in sources:
        need_life(one, one.name, "a gait", growth=False)
    wide = (sheet.width - 4) / _FRAMES
    rows, talls = [], []
    for one in sources:
        steps = period_steps(one.life)
        middles, half = _windows(one.life, steps)
        rows.append((one, steps, middles, half))
        talls.append(float(np.clip(wide * half[1] / half[0], 14.0, _MOST)))
    sheet.begin(_HEAD + sum(talls) + _ROW * len(rows) - 6.0 + _FOOT)
    sheet.colours(sheet.width - 43, 1.5)
    top = _HEAD
    for k, ((one, steps, middles, half), tall) in enumerate(zip(rows, talls)):
        gait, life = gait_of(one), one.life
        said = "one period of its muscles" if gait is None else headline(gait)
        sheet.label(k, len(rows), 2, top - 5.5, f"{one.name}: {said}", sheet.width - 60)
        for number, (step, middle) in enumerate(zip(steps, middles)):
            axes = sheet.axes(2 + number * wide, top, wide - 1, tall)
            frame(axes, middle - half, middle + half)
            if life.scene is not None:
                draw_world(axes, life, step, 4.0)
            draw_pose(axes, life.pose(step), life.springs, life.outline, life.chambers, sheet.palette)
            caption(axes, f"{life.time[step] - life.time[steps[0]]:.2f} s")
            if number == len(steps) - 1:
                bar(axes, round_length(np.ptp(axes.get_xlim()) / 4), life.position[step])
        top += tall + _ROW


def period_steps(life: Life) -> np.ndarray:
    """Steps of the last period of the muscles, evenly spaced; of the second half where they have none."""
    period = period_of(life, slice(None))
    begin = life.time[-1] - period if np.isfinite(period) else (life.time[0] + life.time[-1]) / 2
    span = np.flatnonzero(life.time >= begin - 1e-9)
    return np.unique(span[np.linspace(0, len(span) - 1, _FRAMES + 1).astype(int)[:-1]])


def _windows(life: Life, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles (F, 2) of frames that follow the body, and their half size, m: on ground along x alone."""
    if life.scene is None:
        ends = np.array([bounds(life.position[k]) for k in steps])
        return ends.mean(axis=1), (ends[:, 1] - ends[:, 0]).max(axis=0) / 2
    middle = life.position[steps].mean(axis=1)
    low, high = bounds(life.position[steps] - middle[:, None] * (1.0, 0.0))
    low[1] -= 0.3 * DIAMETER
    height = (low[1] + high[1]) / 2
    return np.column_stack((middle[:, 0] + (low[0] + high[0]) / 2, np.full(len(steps), height))), (high - low) / 2
