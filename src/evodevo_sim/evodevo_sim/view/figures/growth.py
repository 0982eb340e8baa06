"""Embryos, a row each: from one cell to as many as it gets, springs drawn (paper, Fig. 2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...recording import RecordingError
from ..drawing import bounds, draw_pose, frame, round_length
from ..picture import FRAMES, growth_steps
from ..sources import Shown
from .sheet import Sheet, bar, caption

_HEAD, _ROW, _FOOT, _MOST = 10.0, 12.0, 2.0, 46.0  # mm


def draw(sources: Sequence[Shown], sheet: Sheet) -> None:
    for one in sources:
        if not any(len(pose.position) for pose in one.life.growth):
            raise RecordingError(f"{one.name} holds no growth, only what a body did: draw gait or traces of it, or film it, instead")
    wide = (sheet.width - 4) / FRAMES
    rows, talls = [], []
    for one in sources:
        steps = growth_steps(one.life)
        sizes = [np.subtract(*bounds(one.life.growth[k].position)[::-1]) for k in steps]
        half = np.max(sizes, axis=0) / 2
        rows.append((one, steps, half))
        talls.append(float(np.clip(wide * half[1] / half[0], 14.0, _MOST)))
    sheet.begin(_HEAD + sum(talls) + _ROW * len(rows) - 6.0 + _FOOT)
    sheet.colours(sheet.width - 43, 1.5)
    top = _HEAD
    for k, ((one, steps, half), tall) in enumerate(zip(rows, talls)):
        sheet.label(k, len(rows), 2, top - 5.5, f"{one.name}: growth", sheet.width - 60)
        for number, step in enumerate(steps):
            axes = sheet.axes(2 + number * wide, top, wide - 1, tall)
            pose = one.life.growth[step]
            middle = np.mean(bounds(pose.position), axis=0)
            frame(axes, middle - half, middle + half)
            draw_pose(axes, pose, one.life.growth_springs[step], palette=sheet.palette)
            caption(axes, f"step {step}, {len(pose.position)} cell{'s' * (len(pose.position) > 1)}")
            if number == len(steps) - 1:
                bar(axes, round_length(np.ptp(axes.get_xlim()) / 4), pose.position)
        top += tall + _ROW
