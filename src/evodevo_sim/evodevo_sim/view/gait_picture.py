"""A gait in one picture (paper, Fig. 5): two unlike cells' muscles over time, phases over the body, a film strip of one period."""

from __future__ import annotations

import os

import matplotlib
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ..analysis.gait.analysis import Analysis
from ..analysis.gait.contact import Contact
from ..analysis.gait.table import headline
from ..recording.life import Pose, contrasting_cells
from .colours import ACCENT, INK, QUIET, SECOND, unit_rgb
from .drawing import DIAMETER, bounds, draw_pose, fit, frame, round_length, scale_bar, shortened
from .figure_file import save_figure
from .palettes import DEFAULT, legend_of
from .picture import STYLE, caption, legend

_FRAMES = 6  # of the film strip
_CYCLES = 4.0  # periods of the traces
_PHASES = "twilight_shifted"  # a colour map that runs round
_WIDTH, _DPI = 12.8, 125  # inches
_STRIP, _CURVES, _LEFT, _TOP, _GAP = 2.3, 2.6, 0.4, 1.05, 0.75  # inches


def save_gait(analysis: Analysis, name: str, path: str | os.PathLike, palette: str = DEFAULT) -> None:
    """Draw a gait and save it as a picture.  Args: name: of what has it; path: its ending names the format."""
    contact = analysis.contact
    walks = contact is not None
    with matplotlib.rc_context(STYLE):
        height = _TOP + _STRIP + _GAP + _CURVES + (_GAP + 1.3 if walks else 0.0) + 0.6
        figure = Figure((_WIDTH, height), dpi=_DPI, facecolor="white")
        says = f"{shortened(name)}: {headline(analysis.gait)}"
        title = figure.text(_LEFT / _WIDTH, 1 - 0.42 / height, says, fontsize=15, fontweight="bold")
        facts = figure.text(_LEFT / _WIDTH, 1 - 0.56 / height, _facts(analysis), fontsize=9.5, color="0.35", va="top")
        fit(title, _WIDTH - 2 * _LEFT)
        fit(facts, _WIDTH - 2 * _LEFT, lines=2)

        def place(left, top, wide, tall):
            return figure.add_axes((left / _WIDTH, (height - top - tall) / height, wide / _WIDTH, tall / height))

        _film(place, analysis, palette)
        top = _TOP + _STRIP + _GAP
        _traces(place(_LEFT + 0.25, top, 6.6, _CURVES), analysis)
        _phases(place(8.0, top, 3.9, _CURVES), place(11.95, top + 0.3, 0.12, _CURVES - 0.6), analysis)
        if contact is not None:
            _contacts(place(_LEFT + 0.25, top + _CURVES + _GAP, 11.8, 1.3), analysis, contact)
        save_figure(figure, path)


def _facts(analysis: Analysis) -> str:
    g = analysis.gait
    parts = [g.why, f"phase {g.gradient_along:.2f} rad/m along, {g.gradient_across:.2f} across"]
    if np.isfinite(g.cost_of_transport):
        parts.append(f"cost of transport {g.cost_of_transport:.0f} J/(kg m)")
    return "  ·  ".join(parts)


def _span(analysis: Analysis, periods: float) -> np.ndarray:
    """Frames of the last periods, or all where there is no rhythm."""
    time, frequency = analysis.half.time, analysis.gait.frequency
    begin = time[-1] - periods / frequency if np.isfinite(frequency) else time[0]
    return np.flatnonzero(time >= begin - 1e-9)


def _film(place, analysis: Analysis, palette: str) -> None:
    half, span = analysis.half, _span(analysis, 1.0)
    steps = span[np.linspace(0, len(span) - 1, _FRAMES + 1).astype(int)][:-1]
    wide = (_WIDTH - 2 * _LEFT) / _FRAMES
    low, high = bounds(half.position[steps])
    for number, step in enumerate(steps):
        axes = place(_LEFT + number * wide, _TOP + 0.15, wide - 0.1, _STRIP - 0.3)
        frame(axes, low, high)
        pose = Pose(half.position[step], half.activation[step])
        draw_pose(axes, pose, half.springs, half.outline, half.chambers, palette)
        if half.ground is not None:
            left, right = axes.get_xlim()
            x = np.linspace(left, right, 200)
            axes.plot(x, half.ground(x), color=unit_rgb(QUIET), linewidth=1.2, zorder=0)
        caption(axes, f"{half.time[step] - half.time[steps[0]]:.2f} s")
        if number == 0:
            axes.set_title(f"One period; e − c: {legend_of(palette)}")
            for cell, colour in zip(_cells(analysis), (ACCENT, SECOND)):
                axes.plot(*half.position[step, cell], "o", color=unit_rgb(colour), mec="white", mew=1, ms=6, zorder=6)
    scale_bar(axes, round_length(np.ptp(axes.get_xlim()) / 4))


def _cells(analysis: Analysis) -> list[int]:
    return contrasting_cells(analysis.half.activation)


def _traces(axes, analysis: Analysis) -> None:
    half, span = analysis.half, _span(analysis, _CYCLES)
    for cell, colour in zip(_cells(analysis), (ACCENT, SECOND)):
        axes.plot(half.time[span], half.activation[span, cell], color=unit_rgb(colour), label=f"cell {cell}")
    axes.axhline(0.0, color="0.75", linewidth=0.8, zorder=1)
    axes.set(title="Actuation e − c of two cells", xlabel="time, s", ylim=(-1.05, 1.05))
    legend(axes)


def _phases(axes, bar, analysis: Analysis) -> None:
    """The mean shape, forward to the right: hue is phase, size is amplitude."""
    shape, wave = analysis.frame.shape, analysis.rhythm.wave
    frame(axes, *bounds(shape))
    phase = np.angle(wave * np.conj(wave.sum()), deg=True) if wave.any() else np.zeros(len(wave))
    size = DIAMETER * np.sqrt(np.clip(np.abs(wave) / max(np.abs(wave).max(), 1e-12), 0.04, 1.0))
    discs = EllipseCollection(
        size, size, np.zeros(len(size)), units="xy", offsets=shape, transOffset=axes.transData, cmap=_PHASES,
        norm=Normalize(-180, 180), array=phase, edgecolors="white", linewidths=0.6, zorder=2,
    )
    axes.add_collection(LineCollection(shape[analysis.half.springs], colors=[unit_rgb(QUIET)], linewidths=0.6, zorder=1))
    axes.add_collection(discs)
    for cell, colour in zip(_cells(analysis), (ACCENT, SECOND)):
        axes.plot(*shape[cell], "o", color=unit_rgb(colour), mec="white", mew=1, ms=5, zorder=6)
    axes.set_title("Phase over the body, forward to the right")
    colours = axes.figure.colorbar(discs, cax=bar, ticks=(-180, 0, 180))
    colours.outline.set_visible(False)
    bar.set_ylabel("degrees", fontsize=8)


def _contacts(axes, analysis: Analysis, contact: Contact) -> None:
    """Which cells are on the ground, from the rear (below) to the front."""
    span = _span(analysis, 2 * _CYCLES)
    time = analysis.half.time[span]
    order = analysis.frame.shape[:, 0].argsort()
    order = order[contact.duty[order] > 0]
    touching = contact.touching[np.ix_(span, order)].T
    axes.pcolormesh(time, np.arange(len(order)), touching, cmap="Greys", vmin=0, vmax=1.4, shading="nearest")
    axes.set(title="On the ground, rear to front", xlabel="time, s", yticks=np.arange(len(order)))
    axes.set_yticklabels(order, fontsize=6, color=unit_rgb(INK))
    axes.grid(False)
