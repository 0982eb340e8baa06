"""Fitness by generation: best and median of each run; of many runs, all bests with their median and quartiles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...recording import RecordingError
from ..colours import SERIES, unit_rgb
from ..sources import Shown
from .sheet import Sheet, stroke

_FEW = 4  # runs that have a colour each
_TALL = 58.0  # mm


def draw(sources: Sequence[Shown], sheet: Sheet) -> None:
    runs = []
    for one in sources:
        statistics = [] if one.recording is None else one.recording.statistics
        if not statistics:
            raise RecordingError(f"{one.name} holds no generations, so it has no fitness by them: draw gait or traces of it instead")
        runs.append((one.name, np.array([(s.generation, s.best, s.median) for s in statistics], float)))
    tasks = {one.recording.settings.task.name for one in sources if one.recording is not None and one.recording.settings is not None}
    if len(tasks) > 1:
        sheet.say(f"the runs are of different tasks ({', '.join(sorted(tasks))}), whose fitness does not compare")
    few = len(runs) <= _FEW
    keys = -(-len(runs) // 2) if few and len(runs) > 1 else 1
    sheet.begin(_TALL + 4 * keys)
    axes = sheet.axes(12, 4 + 4 * keys, sheet.width - 15, _TALL - 15)
    (_few if few else _many)(axes, runs)
    highest = max(values[:, 1].max() for _, values in runs)
    if highest > 0:  # failures lie far below, and would press everything else flat
        axes.set_ylim(-0.06 * highest, 1.06 * highest)
    axes.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
    axes.set(xlabel="generation", ylabel="fitness, m; thin: median" if few and len(runs) > 1 else "fitness, m")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, handlelength=2.6, columnspacing=1.4)


def _few(axes, runs) -> None:
    for k, (name, values) in enumerate(runs):
        marker = "o" if len(values) == 1 else ""
        if len(runs) == 1:
            axes.plot(values[:, 0], values[:, 1], label="best", marker=marker, **stroke(0))
            axes.plot(values[:, 0], values[:, 2], label="median", marker=marker, **stroke(1))
        else:
            axes.plot(values[:, 0], values[:, 1], label=name if len(name) <= 24 else f"{name[:23]}…", marker=marker, **stroke(k))
            axes.plot(values[:, 0], values[:, 2], marker=marker, linewidth=0.6, alpha=0.7, **stroke(k))


def _many(axes, runs) -> None:
    last = int(max(values[-1, 0] for _, values in runs))
    generations = np.arange(last + 1)
    best = np.full((len(runs), last + 1), np.nan)
    for row, (_, values) in zip(best, runs):
        inside = generations >= values[0, 0]
        row[inside] = np.interp(generations[inside], values[:, 0], values[:, 1])  # a run that ended keeps what it had
        axes.plot(values[:, 0], values[:, 1], color="0.75", linewidth=0.5, zorder=1.5)
    low, middle, high = np.nanpercentile(best, (25, 50, 75), axis=0)
    axes.fill_between(generations, low, high, color=unit_rgb(SERIES[3]), alpha=0.5, linewidth=0, label="quartiles")
    axes.plot(generations, middle, label=f"median of {len(runs)} runs", **stroke(0))
