"""What an animat's cells think, in Rerun, on the timeline `time`: network, concentrations, muscles, phases.

    network/*                              the genome's network; nodes fill with the concentrations of the picked cell
    plots/concentrations/*                 of the picked cell, those that vary most
    plots/activation/*                     muscles of two unlike cells (paper, Fig. 5)
    phase/*                                phase of each cell's muscle over the mean shape, forward to the right
    animat/*                               the body
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.archetypes import ForceCenter, ForceCollisionRadius, ForceLink, ForceManyBody, ForcePosition

from ..analysis.gait.analysis import Analysis, analyse
from ..analysis.gait.track import GaitError
from ..analysis.thinking import INPUT, OUTPUT, OWN, SENT, Edge, Thoughts, thoughts_of_life
from ..inputs import InputError
from ..recording import Recording, RecordingError
from ..recording.gait import track_of_recording
from ..recording.life import Life, contrasting_cells
from ..ros.messages import genome_from_message, task_from_message
from .colours import ACCENT, PAPER, QUIET, SECOND, THIRD
from .entities import at, log_curve
from .palettes import DEFAULT
from .rerun_log import log_cells, log_springs
from .views import from_above, some_beats

_EDGES = 40  # of the network and of each kind, the strongest
KINDS = ("drives", "holds_back")
_FRAMES = 500  # in which nodes change, at the most
_CURVES = 8  # concentrations in curves
_ROLES = {INPUT: SECOND, OUTPUT: ACCENT, OWN: (70, 110, 190), SENT: THIRD}
_PALE = np.array((238, 238, 240))
_TELLS_APART = 1e-9  # of activation, above which a recording is not what its network does here
_SPACE = 190.0  # of the picture of the network, its radius
_LINES = [(0, 114, 178), (230, 159, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233), (213, 94, 0), (120, 120, 120), (60, 60, 60)]


def log_thoughts(
    stream: rr.RecordingStream, recording: Recording, life: Life, cell: int | None = None, palette: str = DEFAULT
) -> tuple[Thoughts, Analysis | None]:
    """Log what a cell thinks.  Args: cell: which; None is the most active one.  Raises RecordingError where there is no such cell."""
    chosen, run = recording.champions[-1], recording.settings
    assert run is not None
    unlike = contrasting_cells(life.activation)
    cells = life.position.shape[1]
    if cell is not None and not 0 <= cell < cells:
        raise RecordingError(f"--cell is {cell}: give one from 0 to {cells - 1}")
    picked = unlike[0] if cell is None else cell
    try:
        thoughts = thoughts_of_life(
            genome_from_message(chosen.genome), task_from_message(run.task), run.seed, life.position, life.activation, life.target, [picked]
        )
    except InputError as error:
        raise RecordingError(f"{recording.path}: {error}; another version may have recorded it: --show watch shows it") from None
    lived = replace(life, growth_time=life.growth_time[:0], growth=[], growth_springs=[])
    log_cells(stream, lived, palette)
    log_springs(stream, lived)
    _log_network(stream, thoughts, life)
    _log_concentrations(stream, thoughts, life)
    for one, colour in zip(dict.fromkeys((picked, *unlike)), (ACCENT, SECOND, THIRD)):
        log_curve(stream, f"plots/activation/cell_{one}", at(life.time), life.activation[:, one], f"cell {one}", colour)
    try:
        analysis = analyse(track_of_recording(recording, life))
    except GaitError:
        return thoughts, None
    _log_phases(stream, analysis, [picked, *unlike])
    return thoughts, analysis


def trust(thoughts: Thoughts) -> str:
    """What must be known of them, or nothing."""
    if thoughts.error <= _TELLS_APART:
        return ""
    return (
        f"activation was recorded that differs by up to {thoughts.error:.2g} from what the network does here, so concentrations are not "
        "those of this life: it has noise, another version, or another body"
    )


def _places(thoughts: Thoughts) -> np.ndarray:
    """(nodes, 2): inputs on the left, units in a ring, outputs on the right."""
    nodes = thoughts.nodes
    inner = [k for k, node in enumerate(nodes) if node.role in (OWN, SENT)]
    place = np.zeros((len(nodes), 2))
    angle = np.pi + 2 * np.pi * (np.arange(len(inner)) + 0.5) / max(len(inner), 1)
    place[inner] = _SPACE * np.column_stack((np.cos(angle), 0.9 * np.sin(angle)))
    for role, side in ((INPUT, -1.0), (OUTPUT, 1.0)):
        column = [k for k, node in enumerate(nodes) if node.role == role]
        rows = (np.arange(len(column)) - (len(column) - 1) / 2) * 80.0
        place[column] = np.column_stack((np.full(len(column), side * 1.75 * _SPACE), rows))
    return place


def _log_network(stream, thoughts: Thoughts, life: Life) -> None:
    """Two graphs of the same nodes, since edges have no colours: what drives, and what holds back."""
    nodes, frames = thoughts.nodes, np.unique(np.linspace(0, len(life.time) - 1, _FRAMES).astype(int))
    names, place = [node.name for node in nodes], _places(thoughts)
    full = np.array([_ROLES[node.role] for node in nodes])
    level = np.clip(thoughts.concentration[frames, :, 0], 0.0, 1.0)[..., None] ** 0.6
    colours = np.rint(_PALE + level * (full - _PALE)).astype(np.uint8)
    for kind, edges in zip(KINDS, _shown(thoughts)):
        entity = f"network/{kind}"
        pairs = [(names[edge.source], names[edge.target]) for edge in edges]
        stream.log(entity, rr.GraphEdges(pairs, graph_type="directed"), static=True)
        steady = rr.GraphNodes(names, positions=place, labels=names, radii=[14.0] * len(names), show_labels=True)
        stream.log(entity, steady, static=True)
        columns = rr.GraphNodes.columns(colors=colours.reshape(-1, 3)).partition([len(names)] * len(frames))
        stream.send_columns(entity, at(life.time[frames]), columns)


def _shown(thoughts: Thoughts) -> list[list[Edge]]:
    """The strongest edges of each kind, without those from a node to itself."""
    edges = [edge for edge in thoughts.edges if edge.source != edge.target]
    return [[edge for edge in edges if (edge.weight > 0) == above][:_EDGES] for above in (True, False)]


def _log_concentrations(stream, thoughts: Thoughts, life: Life) -> None:
    values = thoughts.concentration[..., 0]
    late = values[len(values) // 2 :]
    units = [k for k, node in enumerate(thoughts.nodes) if node.role != INPUT]
    lively = sorted(units, key=lambda k: -float(np.ptp(late[:, k])))[:_CURVES]
    for k, colour in zip(sorted(lively), _LINES):
        node = thoughts.nodes[k]
        log_curve(stream, f"plots/concentrations/{node.name}", at(life.time), values[:, k], f"{node.name}, {node.role}", colour)


def _log_phases(stream, analysis: Analysis, cells: list[int]) -> None:
    """Hue is phase, size is amplitude; the picked cells have a ring."""
    import matplotlib

    shape, wave = analysis.frame.shape * (1.0, -1.0), analysis.rhythm.wave  # y points down in the view
    phase = np.angle(wave * np.conj(wave.sum())) if wave.any() else np.zeros(len(wave))
    hue = np.rint(255 * matplotlib.colormaps["twilight_shifted"]((phase + np.pi) / (2 * np.pi))[:, :3]).astype(np.uint8)
    size = 0.47 * np.sqrt(np.clip(np.abs(wave) / max(float(np.abs(wave).max()), 1e-12), 0.06, 1.0))
    springs = rr.LineStrips2D(shape[analysis.half.springs], radii=0.02, colors=QUIET, draw_order=0.0)
    stream.log("phase/springs", springs, static=True)
    stream.log("phase/cells", rr.Points2D(shape, radii=size, colors=hue, draw_order=10.0), static=True)
    angle = np.linspace(0.0, 2.0 * np.pi, 41)
    ring = 0.5 * np.column_stack((np.cos(angle), np.sin(angle)))
    chosen = list(dict.fromkeys(cells))
    circles = rr.LineStrips2D([shape[k] + ring for k in chosen], radii=0.06, colors=[ACCENT, SECOND, THIRD][: len(chosen)], draw_order=20.0)
    stream.log("phase/picked", circles, static=True)


def blueprint(life: Life, thoughts: Thoughts, analysis: Analysis | None, cell: int | None = None) -> rrb.Blueprint:
    """The network, the body and its phases on the left; concentrations and muscles on the right."""
    picked = contrasting_cells(life.activation)[0] if cell is None else cell
    legend = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
    wide, high = 2.15 * _SPACE, 1.15 * _SPACE
    graphs = [
        rrb.GraphView(
            origin=f"/network/{kind}", name=f"Network in cell {picked}: what {kind.replace('_', ' ')}, {len(edges)} edges",
            background=rrb.archetypes.GraphBackground(color=[*PAPER]),
            visual_bounds=rrb.VisualBounds2D(x_range=(-wide, wide), y_range=(-high, high)),  # nodes stay where they are put
            force_link=ForceLink(enabled=False), force_many_body=ForceManyBody(enabled=False), force_center=ForceCenter(enabled=False),
            force_collision_radius=ForceCollisionRadius(enabled=False), force_position=ForcePosition(enabled=False),
        )
        for kind, edges in zip(KINDS, _shown(thoughts))
    ]
    about = (life.position - life.centre[:, None]).reshape(-1, 2)
    bodies: list[Any] = [from_above("Body", "/animat/centre", about)]
    if analysis is not None:
        shape = analysis.frame.shape
        low, top = shape.min(axis=0) - 1.0, shape.max(axis=0) + 1.0
        bounds = rrb.VisualBounds2D(x_range=(low[0], top[0]), y_range=(-top[1], -low[1]))
        name = "Phase over the body, forward to the right"
        bodies.append(rrb.Spatial2DView(origin="/phase", name=name, background=[*PAPER], visual_bounds=bounds))
    curves = [
        rrb.TimeSeriesView(
            origin="/plots/concentrations", name=f"Concentrations in cell {picked}", plot_legend=legend, axis_x=some_beats(life),
            axis_y=rrb.ScalarAxis(range=(0.0, 1.02)),
        ),
        rrb.TimeSeriesView(
            origin="/plots/activation", name="Activation e - c of unlike cells", plot_legend=legend, axis_x=some_beats(life),
            axis_y=rrb.ScalarAxis(range=(-1.05, 1.05)),
        ),
    ]
    text = rrb.TextDocumentView(origin="/summary", name="Summary")
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(rrb.Tabs(*graphs), rrb.Horizontal(*bodies), row_shares=[3, 2]), rrb.Vertical(*curves, text), column_shares=[3, 2]
        ),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden"), auto_views=False,
    )
