"""A run in Rerun, on the timeline `generation`: fitness, diversity, descent, and a gallery of its champions.

    evolution/best, median, diversity, worst; evolution/chart/*    curves; the chart is on every timeline
    evolution/shared                                               descent: genes that a champion has from the one before
    gallery/cells, springs, names                                  the body of each champion as it was born
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..analysis.growth_story import born, shared_genes
from ..parameters import Task
from ..ros.messages import genome_from_message
from .colours import ACCENT, INK, PAPER, QUIET, SECOND, THIRD, activation_colours
from .entities import BEFORE, DISC, log_curve, space
from .palettes import DEFAULT

_BARS = 50  # at the most, in the chart of fitness
_COLUMNS, _GAP = 6, 2.5  # of the gallery; m between bodies
MOST = 60  # champions in the gallery: the last ones


def log_evolution(stream: rr.RecordingStream, statistics: Sequence[Any]) -> None:
    """Curves of GenerationStatistics, and a chart of the best."""
    generation = [s.generation for s in statistics]
    for name, colour in (("best", ACCENT), ("median", SECOND), ("diversity", QUIET)):
        values = [getattr(s, name) for s in statistics]
        log_curve(stream, f"evolution/{name}", [rr.TimeColumn("generation", sequence=generation)], values, name, colour)
    # Curves show one timeline at a time; a bar chart is there on all of them.
    every = -(-len(statistics) // _BARS)
    best = [max(s.best for s in statistics[k : k + every]) for k in range(0, len(statistics), every)]
    bars = rr.BarChart(best, abscissa=generation[::every], widths=np.full(len(best), 0.9 * every), color=ACCENT)
    stream.log("evolution/chart", bars, static=True)


class Gallery:
    """The champions of a run, one beside the other, the best last.  Args: task: of the run; palette: of cells."""

    def __init__(self, stream: rr.RecordingStream, task: Task, palette: str = DEFAULT):
        self._stream, self._task, self._palette = stream, task, palette
        self._cells: list[np.ndarray] = []
        self._colours: list[np.ndarray] = []
        self._ends: list[np.ndarray] = []
        self._places: list[np.ndarray] = []
        self._names: list[str] = []
        self._last: Any = None

    def __len__(self) -> int:
        """Champions in it."""
        return len(self._cells)

    def add(self, champion: Any, show: bool = True) -> None:
        """Take a Champion message; show: whether the gallery is logged with it, from its generation on."""
        genome = genome_from_message(champion.genome)
        position, activation, edges = born(genome, self._task)
        self._stream.set_time("generation", sequence=champion.generation)
        if self._last is not None:
            self._stream.log("evolution/shared", rr.Scalars(shared_genes(self._last, genome)))
        self._last = genome
        if not len(position):
            return
        place = self._place(len(self._cells))
        centred = position - (position.min(axis=0) + position.max(axis=0)) / 2 + place
        self._cells.append(centred)
        self._colours.append(activation_colours(activation, self._palette))
        self._ends.append(centred[edges])
        self._places.append(place - (0.0, self._size / 2 + 0.8))
        self._names.append(f"{champion.generation}: {champion.evaluation.fitness:.2f}")
        if show:
            self.show()

    def show(self) -> None:
        """Log the gallery as it is, at the last generation."""
        if not self._cells:
            return
        cells, stream = np.concatenate(self._cells), self._stream
        discs = rr.Cylinders3D.from_fields(
            centers=space(cells, 0.0), radii=0.5, lengths=np.full(len(cells), DISC, np.float32), colors=np.concatenate(self._colours),
            fill_mode="solid", show_labels=False,
        )
        stream.log("gallery/cells", discs)
        stream.log("gallery/springs", rr.LineStrips3D(space(np.concatenate(self._ends), BEFORE), radii=0.03, colors=INK))
        names = rr.Points3D(space(self._places, BEFORE), labels=self._names, radii=0.01, colors=PAPER, show_labels=True)
        stream.log("gallery/names", names)

    @property
    def _size(self) -> float:
        return _GAP + 1.2 * self._task.development.max_cells**0.5 * 1.3

    def _place(self, number: int) -> np.ndarray:
        return self._size * np.array([number % _COLUMNS, -1.15 * (number // _COLUMNS)])

    def bounds(self, champions: int) -> tuple[np.ndarray, np.ndarray]:
        """The rectangle of so many, m."""
        rows, columns = -(-max(champions, 1) // _COLUMNS), min(max(champions, 1), _COLUMNS)
        half = self._size / 2 + 1.0
        return np.array([-half, -half - 1.15 * self._size * (rows - 1) - 1.0]), np.array([half + self._size * (columns - 1), half])


def log_run(stream: rr.RecordingStream, recording: Any, task: Task, palette: str = DEFAULT) -> Gallery:
    """Log a whole run."""
    log_evolution(stream, recording.statistics)
    style(stream)
    gallery = Gallery(stream, task, palette)
    for champion in recording.champions[-MOST:]:
        gallery.add(champion)
    stream.reset_time()
    return gallery


def style(stream: rr.RecordingStream) -> None:
    """Names and colours of curves that are logged point by point."""
    named = {
        "best": ("best", ACCENT), "median": ("median", SECOND), "diversity": ("diversity", QUIET),
        "shared": ("genes kept from the champion before", THIRD),
    }
    for entity, (name, colour) in named.items():
        stream.log(f"evolution/{entity}", rr.SeriesLines(names=name, colors=colour, widths=1.5), static=True)
    stream.log("evolution/shared", rr.SeriesPoints(colors=THIRD, marker_sizes=3.0, names=named["shared"][0]), static=True)


def blueprint(gallery: Gallery, champions: int) -> rrb.Blueprint:
    """The gallery above, curves below, text beside.  Args: champions: how many the gallery has room for."""
    low, high = gallery.bounds(champions)
    x, y = (low + high) / 2
    height = 1.15 * max((high - low)[0] / 1.9, (high - low)[1], 6.0)
    legend = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
    bodies = rrb.Spatial3DView(
        origin="/gallery", name="Champions as they are born, with generation: fitness", background=[*PAPER],
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital, position=(x, y, height), look_target=(x, y, 0.0), eye_up=(0.0, 1.0, 0.0)
        ),
    )
    curves = rrb.Horizontal(
        rrb.TimeSeriesView(
            origin="/evolution", contents=["/evolution/best", "/evolution/median"], name="Fitness by generation", plot_legend=legend
        ),
        rrb.TimeSeriesView(
            origin="/evolution/diversity", name="Diversity", plot_legend=legend, axis_y=rrb.ScalarAxis(range=(0.0, 1.05))
        ),
        rrb.TimeSeriesView(
            origin="/evolution/shared", name="Descent: genes kept", plot_legend=rrb.PlotLegend(visible=False),
            axis_y=rrb.ScalarAxis(range=(0.0, 1.05)),
        ),
    )
    text = rrb.TextDocumentView(origin="/summary", name="Summary")
    return rrb.Blueprint(
        rrb.Horizontal(rrb.Vertical(bodies, curves, row_shares=[3, 2]), text, column_shares=[5, 2]),
        rrb.TimePanel(state="collapsed", timeline="generation", play_state="following"),
        rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden"), auto_views=False,
    )
