"""A recording as Rerun entities, on the timelines `time` (growth, then swim) and `generation`.

    animat/cells, animat/springs, animat/chambers, animat/outline, animat/trail     the body, in m, in the plane z = 0
    animat/world, animat/contacts                                                   ground and ceiling of a walker; cells that touch them
    animat/target, animat/scent                                                     the target, and rings of its scent
    animat/centre, animat/metres                                                    frame at the centre of mass; a grid of 1 m
    plots/activation/cell_*, plots/distance, plots/target_distance                the swim in curves
    evolution/best, median, diversity; evolution/chart/*                            a run; the chart is on every timeline
    summary                                                                         settings and champion
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import rerun as rr

from ..recording import Recording
from ..recording.life import RINGS, Life, contrasting_cells
from ..ros.drawn import fan
from .colours import ACCENT, INK, QUIET, SECOND, THIRD, activation_colours
from .entities import at, log_curve, log_discs, log_lines, space
from .evolve_view import log_evolution
from .palettes import DEFAULT
from .summary import markdown

_TRAIL_UPDATES = 200  # a trail has up to as many points, and is logged as often
_GRID, _BEHIND, _TRAIL = -0.04, -0.02, 0.04  # m, heights of what lies below and above the cells' discs
_GRID_LINES = 80  # at the most, in each direction


def log_recording(
    stream: rr.RecordingStream, recording: Recording, life: Life, step: Callable[[str], None] = lambda part: None, palette: str = DEFAULT
) -> None:
    """Log everything that a recording holds.  Args: step: called with the name of each part before it is logged."""
    stream.log("summary", rr.TextDocument(markdown(recording, life, palette), media_type=rr.MediaType.MARKDOWN), static=True)
    step("cells")
    log_cells(stream, life, palette)
    step("springs")
    log_springs(stream, life)
    if len(life.time):
        step("chambers")
        _log_chambers(stream, life, palette)
        step("curves")
        log_lines(stream, "animat/outline", [life.time], [life.position], [life.outline], INK, 0.045)
        _log_trail(stream, life)
        _log_world(stream, life)
        _log_curves(stream, life)
        _log_target(stream, life)
    if recording.statistics:
        log_evolution(stream, recording.statistics)


def log_cells(stream: Any, life: Life, palette: str) -> None:
    growth = life.growth
    lengths = [len(pose.position) for pose in growth] + [life.position.shape[1]] * len(life.time)
    if not lengths:
        return
    position = np.concatenate([pose.position for pose in growth] + [life.position.reshape(-1, 2)])
    activation = np.concatenate([pose.activation for pose in growth] + [life.activation.ravel()])
    times = np.concatenate((life.growth_time, life.time))
    log_discs(stream, "animat/cells", at(times), lengths, position, activation_colours(activation, palette))
    first = np.cumsum([0, *lengths[:-1]])
    centre = np.add.reduceat(position, first) / np.array(lengths)[:, None]
    stream.send_columns("animat/centre", at(times), rr.Transform3D.columns(translation=space(centre, 0.0)))
    _log_metres(stream, position)


def _log_metres(stream, position) -> None:
    """Lines a metre apart below all that moves; farther apart where there would be too many."""
    low, high = np.floor(position.min(axis=0)) - 8, np.ceil(position.max(axis=0)) + 8
    step = 10 ** max(0, np.ceil(np.log10(max(high - low) / _GRID_LINES)))
    x, y = (np.arange(np.floor(a / step), np.ceil(b / step) + 1) * step for a, b in zip(low, high))
    lines = [((v, y[0]), (v, y[-1])) for v in x] + [((x[0], v), (x[-1], v)) for v in y]
    strips = rr.LineStrips3D(space(np.array(lines), _GRID), radii=rr.Radius.ui_points(0.5), colors=(222, 224, 226))
    stream.log("animat/metres", strips, static=True)


def log_springs(stream: Any, life: Life) -> None:
    times, positions = [np.array([t]) for t in life.growth_time], [pose.position[None] for pose in life.growth]
    springs = [*life.growth_springs, life.springs]
    log_lines(stream, "animat/springs", [*times, life.time], [*positions, life.position], springs, INK, 0.02)


def _log_chambers(stream, life: Life, palette: str) -> None:
    triangles = [triangle for chamber in life.chambers for triangle in fan(life.position[0], chamber)]
    if not triangles:
        return
    stream.log("animat/chambers", rr.Mesh3D.from_fields(triangle_indices=np.array(triangles, np.uint32)), static=True)
    steps, cells = life.activation.shape
    tint = 0.6 * 255 + 0.4 * activation_colours(life.activation.ravel(), palette)
    columns = rr.Mesh3D.columns(
        vertex_positions=space(life.position.reshape(-1, 2), _BEHIND), vertex_colors=tint.astype(np.uint8)
    )
    stream.send_columns("animat/chambers", at(life.time), columns.partition([cells] * steps))


def _log_trail(stream, life: Life) -> None:
    """Where the centre of mass came along, longer and longer."""
    ends = np.unique(np.linspace(0, len(life.time) - 1, _TRAIL_UPDATES).astype(int))
    trails = [space(life.centre[ends[: k + 1]], _TRAIL) for k in range(1, len(ends))]
    stream.log("animat/trail", rr.LineStrips3D.from_fields(radii=0.05, colors=ACCENT), static=True)
    if trails:
        stream.send_columns("animat/trail", at(life.time[ends[1:]]), rr.LineStrips3D.columns(strips=trails))


def _log_world(stream, life: Life) -> None:
    """Ground and ceiling, and dots on the cells that touch them."""
    low, high = life.position[..., 0].min() - 20.0, life.position[..., 0].max() + 20.0
    lines = [space(line, _BEHIND) for line in life.surfaces(low, high)]
    if not lines:
        return
    stream.log("animat/world", rr.LineStrips3D.from_fields(radii=0.06, colors=QUIET), static=True)
    stream.send_columns("animat/world", at(life.time[:1]), rr.LineStrips3D.columns(strips=lines).partition([len(lines)]))  # from birth on
    contact = life.contact
    stream.log("animat/contacts", rr.Points3D.from_fields(radii=0.14, colors=ACCENT), static=True)
    columns = rr.Points3D.columns(positions=space(life.position[contact], _TRAIL))
    stream.send_columns("animat/contacts", at(life.time), columns.partition(contact.sum(axis=1)))


def _log_curves(stream, life: Life) -> None:
    for cell, colour in zip(contrasting_cells(life.activation), (ACCENT, SECOND)):
        entity = f"plots/activation/cell_{cell}"
        log_curve(stream, entity, at(life.time), life.activation[:, cell], f"cell {cell}", colour)
    log_curve(stream, "plots/distance", at(life.time), life.distance, "centre of mass", THIRD)


def _log_target(stream, life: Life) -> None:
    """The target where it changes, its scent in rings, and how far the centre of mass is from it."""
    if not len(life.target):
        return
    known = np.isfinite(life.target).all(axis=1)
    log_curve(stream, "plots/target_distance", at(life.time[known]), life.target_distance[known], "to the target", SECOND)
    changed = np.flatnonzero(known & np.r_[True, (life.target[1:] != life.target[:-1]).any(axis=1)])
    points = space(life.target[changed], _TRAIL)
    stream.log("animat/target", rr.Points3D.from_fields(radii=0.4, colors=SECOND), static=True)
    stream.send_columns("animat/target", at(life.time[changed]), rr.Points3D.columns(positions=points))
    if life.reach:
        rings = [scent_rings(target, life.reach) for target in life.target[changed]]
        stream.log("animat/scent", rr.LineStrips3D.from_fields(radii=rr.Radius.ui_points(1.0), colors=(206, 196, 228)), static=True)
        strips = rr.LineStrips3D.columns(strips=[strip for ring in rings for strip in ring])
        stream.send_columns("animat/scent", at(life.time[changed]), strips.partition([RINGS] * len(rings)))


def scent_rings(target: Any, reach: float) -> np.ndarray:
    """(RINGS, 97, 3): rings around a target, where its scent has fallen by another fifth."""
    angle = np.linspace(0.0, 2.0 * np.pi, 97)
    ring = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    radii = np.arange(1, RINGS + 1)[:, None, None] / RINGS * reach
    return space(np.asarray(target) + radii * ring, _BEHIND)
