"""How the Rerun viewer lays out a recording: the blueprint that goes with it."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from ..recording import Recording
from ..recording.life import Life, contrasting_cells, period_of
from .colours import PAPER

_HEIGHT = 1.1  # of the eye, per metre from the lowest to the highest that it has to see: the viewer's field of view, and a margin
_LEAST = 4.0  # m from the lowest to the highest, that are seen of an egg
_BEATS = 8  # of the muscles, that the view of activation shows at a time
_LANDSCAPE = 1.6  # width of the view, as far as we can know it, in heights


def blueprint(recording: Recording, life: Life) -> rrb.Blueprint:
    """The body beside curves and text.  What the recording does not hold has no view."""
    text = rrb.TextDocumentView(origin="/summary", name="Summary")
    bodies, curves, evolution = _bodies(life), _curves(life), _evolution(recording)
    if not bodies:  # then the timeline is the one of the curves
        evolution = evolution[1:] + evolution[:1]
    left: list[rrb.Container] = [rrb.Tabs(*bodies)] if bodies else []
    if curves:
        left.append(rrb.Horizontal(*curves))
    right = rrb.Vertical(text, rrb.Tabs(*evolution), row_shares=[3, 2]) if evolution else text
    layout = rrb.Horizontal(rrb.Vertical(*left, row_shares=[3, 1][: len(left)]), right, column_shares=[5, 2]) if left else right
    timeline = "time" if left else "generation"
    return rrb.Blueprint(
        layout,
        rrb.TimePanel(state="collapsed", timeline=timeline, play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )


def _bodies(life: Life) -> list:
    if not len(life.time) and not life.growth:
        return []
    views = []
    grown = life.growth[-1:] if not len(life.time) else []
    points = np.concatenate([pose.position for pose in grown] + [life.position.reshape(-1, 2)])
    points = np.concatenate((points, life.target[np.isfinite(life.target).all(axis=1)]))
    if len(life.time):
        about = (life.position - life.centre[:, None]).reshape(-1, 2)
        views.append(from_above("Body", "/animat/centre", about))
    views.append(from_above("Whole path" if len(life.time) else "Growth", "/animat", points))
    return views


def from_above(
    name: str, origin: str, points: np.ndarray, contents: str = "/animat/**", landscape: float = _LANDSCAPE,
) -> rrb.Spatial3DView:
    """A view along -z, in which y points up (a 2D view would turn it over).

    Args: points (K, 2) m that it has to hold; landscape: its width, as far as we can know it, in heights.
    """
    low, high = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    x, y = (low + high) / 2
    height = _HEIGHT * max(_LEAST, *(high - low) / (landscape, 1.0))
    return rrb.Spatial3DView(
        origin=origin, contents=contents, name=name, background=[*PAPER],
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital, position=(x, y, height), look_target=(x, y, 0.0), eye_up=(0.0, 1.0, 0.0)
        ),
    )


def _curves(life: Life) -> list:
    if not len(life.time):
        return []
    legend = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
    away = life.target_distance[np.isfinite(life.target).all(axis=1)] if len(life.target) else np.empty(0)
    farthest = max(1.0, 1.05 * float(np.concatenate((life.distance, away)).max()))
    return [
        rrb.TimeSeriesView(
            origin="/plots/activation", name="Activation e - c of two cells", plot_legend=legend,
            axis_x=some_beats(life), axis_y=rrb.ScalarAxis(range=(-1.05, 1.05)),
        ),
        rrb.TimeSeriesView(
            origin="/plots", contents=["/plots/distance", "/plots/target_distance"],
            name="Distance from birth and target, m" if len(life.target) else "Distance from birth, m",
            plot_legend=legend, axis_y=rrb.ScalarAxis(range=(0.0, farthest)),
        ),
    ]


def some_beats(life: Life) -> rrb.TimeAxis | None:
    """A window of _BEATS periods of the muscles, which follows the time shown; None, the whole life, where that is no longer."""
    half = _BEATS / 2 * period_of(life, contrasting_cells(life.activation))
    if not 2 * half < life.time[-1] - life.time[0]:
        return None
    ends = (rrb.TimeRangeBoundary.cursor_relative(seconds=seconds) for seconds in (-half, half))
    return rrb.TimeAxis(view_range=rrb.TimeRange(*ends))


def _evolution(recording: Recording) -> list:
    if not recording.statistics:
        return []
    fitness = rrb.TimeSeriesView(
        origin="/evolution", contents=["/evolution/best", "/evolution/median"], name="By generation"
    )
    diversity = rrb.TimeSeriesView(origin="/evolution/diversity", name="Diversity")
    chart = rrb.BarChartView(origin="/evolution/chart", name="Best fitness", plot_legend=rrb.PlotLegend(visible=False))
    return [chart, fitness, diversity]
