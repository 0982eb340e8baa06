"""Growth in Rerun, on the timeline `time`: divisions, lineage, clones, morphogens.

    animat/cells, animat/springs     the embryo, by activation e - c
    clones/cells                     the same, each cell in the colour of the one of the first four that it comes from
    morphogen/cells                  the same, by the morphogen that differs most between cells when growth ends
    lineage/*                        who is whose daughter: time runs down, a line a cell
    plots/cells, plots/morphogens/*  how many there are; what one cell in the middle perceives
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..analysis.growth_story import GrowthStory, Lineage, story_of_growth
from ..recording import Recording
from ..recording.life import Life
from ..ros.messages import genome_from_message, task_from_message
from .colours import ACCENT, INK, PAPER, SECOND, THIRD
from .entities import at, log_curve, log_discs, log_lines
from .palettes import DEFAULT
from .rerun_log import log_cells, log_springs
from .views import from_above

# Of the palette of Okabe and Ito, which the colour-blind tell apart.
CLONES = np.array([(0, 114, 178), (230, 159, 0), (0, 158, 115), (204, 121, 167)], np.uint8)
_LOW, _HIGH = np.array((236, 236, 240)), np.array((122, 24, 120))  # of a morphogen, from none to the most
_CURVES = 3  # morphogens in curves
_NARROW = 0.75  # width of a view of the embryo, in heights
_TALL = 0.45  # of the tree, in its widths


def log_growth(stream: rr.RecordingStream, recording: Recording, life: Life, palette: str = DEFAULT) -> GrowthStory | None:
    """Log growth.  Returns its story, or None where the recording holds no genome that grew it."""
    cells = life.position.shape[1]
    life = replace(life, time=life.time[:0], position=np.empty((0, cells, 2)), activation=np.empty((0, cells)))  # growth alone
    log_cells(stream, life, palette)
    log_springs(stream, life)
    counts = [len(pose.position) for pose in life.growth]
    index = at(life.growth_time)
    log_curve(stream, "plots/cells", index, counts, "cells", ACCENT)
    story = _story(recording, counts)
    if story is None:
        return None
    position = np.concatenate([pose.position for pose in life.growth])
    clones = story.lineage.clones()
    colours = np.concatenate([CLONES[clones[:n] % len(CLONES)] for n in counts])
    log_discs(stream, "clones/cells", index, counts, position, colours)
    springs = [np.array([t]) for t in life.growth_time], [pose.position[None] for pose in life.growth], life.growth_springs
    log_lines(stream, "clones/springs", *springs, INK, 0.02)
    _log_tree(stream, story.lineage, life.growth_time)
    if len(story.morphogens):
        _log_morphogens(stream, story, life)
    return story


def _story(recording: Recording, counts: list[int]) -> GrowthStory | None:
    if not recording.champions or recording.settings is None:
        return None
    genome, task = genome_from_message(recording.champions[-1].genome), task_from_message(recording.settings.task)
    story = story_of_growth(genome, task, counts)
    same = all(values.shape[1] == counts[step] for step, values in zip(story.steps, story.perceived))
    return story if same and (story.lineage.mother[1:] >= 0).all() else None


def _log_tree(stream, lineage: Lineage, time: np.ndarray) -> None:
    """Time runs down; a line for each cell, which leaves its mother's where it was born."""
    place, cells = lineage.order(), len(lineage.mother)
    last = min(len(time) - 1, int(1.15 * lineage.born.max()) + 1)  # soon after the last division
    tall = _TALL * cells * np.minimum(np.arange(len(time)) / last, 1.0)
    colours = CLONES[lineage.clones() % len(CLONES)]
    strips = []
    for cell, (mother, born) in enumerate(zip(lineage.mother, lineage.born)):
        begin = [(place[mother], tall[born])] if mother >= 0 else []
        strips.append([*begin, (place[cell], tall[born]), (place[cell], tall[-1])])
    stream.log("lineage/cells", rr.LineStrips2D(strips, radii=rr.Radius.ui_points(1.2), colors=colours), static=True)
    ticks = np.linspace(0, last, 5).astype(int)
    names = [f"{time[k] - time[0]:.1f} s" for k in ticks]
    marks = rr.Points2D([(-2.5, tall[k]) for k in ticks], labels=names, radii=0.01, colors=PAPER, show_labels=True)
    stream.log("lineage/time", marks, static=True)
    stream.log("lineage/now", rr.LineStrips2D.from_fields(radii=rr.Radius.ui_points(1.0), colors=ACCENT), static=True)
    lines = [[(-1.0, y), (cells, y)] for y in tall]
    stream.send_columns("lineage/now", at(time), rr.LineStrips2D.columns(strips=lines).partition([1] * len(time)))


def _log_morphogens(stream, story: GrowthStory, life: Life) -> None:
    """Discs by the first morphogen; curves of what the cell in the middle perceives of the first few."""
    counts = [values.shape[1] for values in story.perceived]
    position = np.concatenate([life.growth[step].position for step in story.steps])
    most = max(float(max(values[0].max() for values in story.perceived)), 1e-12)
    share = np.concatenate([values[0] for values in story.perceived])[:, None] / most
    times = life.growth_time[story.steps]
    log_discs(stream, "morphogen/cells", at(times), counts, position, np.rint(_LOW + share * (_HIGH - _LOW)).astype(np.uint8))
    for k, colour in zip(range(min(_CURVES, len(story.morphogens))), (SECOND, THIRD, ACCENT)):
        unit = int(story.morphogens[k])
        for name, of, wide in (("most", np.max, 1.5), ("least", np.min, 0.8)):
            entity = f"plots/morphogens/u{unit}_{name}"
            stream.log(entity, rr.SeriesLines(names=f"u{unit}, {name}", colors=colour, widths=wide), static=True)
            stream.send_columns(entity, at(times), rr.Scalars.columns(scalars=[float(of(values[k])) for values in story.perceived]))


def blueprint(life: Life, story: GrowthStory | None) -> rrb.Blueprint:
    """Embryo, clones and morphogen side by side, the tree below, curves and text beside."""
    points = np.concatenate([pose.position for pose in life.growth])
    bodies: list[Any] = [from_above("Embryo, by activation", "/animat", points, landscape=_NARROW)]
    below: list[Any] = []
    legend = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
    curves: list[Any] = [rrb.TimeSeriesView(origin="/plots/cells", name="Cells", plot_legend=rrb.PlotLegend(visible=False))]
    if story is not None:
        bodies.append(from_above("Clones of the first four cells", "/clones", points, "/clones/**", _NARROW))
        cells = len(story.lineage.mother)
        bounds = rrb.VisualBounds2D(x_range=(-5.0, cells + 1.0), y_range=(-1.0, _TALL * cells + 1.0))
        below.append(rrb.Spatial2DView(origin="/lineage", name="Lineage, time runs down", background=[*PAPER], visual_bounds=bounds))
        if len(story.morphogens):
            bodies.append(from_above(f"Morphogen u{int(story.morphogens[0])}", "/morphogen", points, "/morphogen/**", _NARROW))
            curves.append(
                rrb.TimeSeriesView(origin="/plots/morphogens", name="Morphogens: most, least", plot_legend=legend)
            )
    above = rrb.Horizontal(*bodies)
    text = rrb.TextDocumentView(origin="/summary", name="Summary")
    left = rrb.Vertical(above, *below, row_shares=[3, 2][: 1 + len(below)])
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*curves, text, row_shares=[*[1] * len(curves), 2]), column_shares=[7, 2]),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden"), auto_views=False,
    )
