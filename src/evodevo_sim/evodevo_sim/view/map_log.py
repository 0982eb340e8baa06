"""A map of unlike animals as Rerun entities, on the timeline `time`: each moves in its cell.

    map/cells, map/springs      bodies in m, each about the middle of its cell, in the colour of its fitness
    map/tiles, map/words        the cells of the map; fitness and gait of each animal
"""

from __future__ import annotations

import os

import matplotlib
import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from .body_map import COLOURS, BodyMap, shade
from .colours import INK, PAPER, QUIET
from .files import OutputError
from .viewer import switched_on

_TILE, _GROUND, _SPRINGS, _WORDS = -0.04, -0.02, 0.02, 0.04  # m, heights of what lies below and above the cells' discs
_MARGIN = 1.0  # m around the largest motion, of a cell of the map


def save_map_log(found: BodyMap, path: str) -> None:
    """Write a Rerun file of a map.  Raises OutputError where Rerun writes nothing."""
    with switched_on():
        stream = rr.RecordingStream("evodevo_gallery")
        try:
            wide, tall = _sizes(found)
            stream.save(path, default_blueprint=_blueprint(found, wide, tall))
            _log(stream, found, wide, tall)
        finally:
            stream.disconnect()
    if not os.path.getsize(path):
        raise OutputError("Rerun wrote nothing: unset RERUN in the environment, and try again")


def _sizes(found: BodyMap) -> tuple[float, float]:
    """m, of a cell of the map: room for the widest and for the tallest motion."""
    extents = [np.ptp(one.motion.reshape(-1, 2) if one.motion.size else one.position, axis=0) for one in found.animals]
    wide, tall = np.max([*extents, (2.0, 2.0)], axis=0) + 1.0 + _MARGIN
    return float(wide), float(tall + 1.0)


def _log(stream: rr.RecordingStream, found: BodyMap, wide: float, tall: float) -> None:
    animals = list(found.animals)
    frames = max((len(one.motion) for one in animals), default=0) or 1
    colours = (255 * matplotlib.colormaps[COLOURS]([shade(one.fitness, found.most) for one in animals])[:, :3]).astype(np.uint8)
    middles = np.array([((one.column + 0.5) * wide, (one.row + 0.5) * tall) for one in animals])
    moves = [_moved(one.motion if len(one.motion) else one.position[None], frames) + middle for one, middle in zip(animals, middles)]
    cells = np.concatenate(moves, axis=1)  # (T, all cells, 2)
    first = np.cumsum([0, *(len(one.position) for one in animals)])
    times = [rr.TimeColumn("time", duration=np.arange(frames) * found.frame_time)]

    discs = rr.Cylinders3D.from_fields(radii=0.5, lengths=0.01, fill_mode="solid", show_labels=False)
    stream.log("map/cells", discs, static=True)
    owner = np.repeat(colours, np.diff(first), axis=0)
    columns = rr.Cylinders3D.columns(centers=_space(cells.reshape(-1, 2), 0.0), colors=np.tile(owner, (frames, 1)))
    stream.send_columns("map/cells", times, columns.partition([cells.shape[1]] * frames))

    pairs = np.concatenate([one.springs + begin for one, begin in zip(animals, first)])
    stream.log("map/springs", rr.LineStrips3D.from_fields(radii=0.03, colors=INK), static=True)
    ends = _space(cells[:, pairs].reshape(-1, 2), _SPRINGS).reshape(-1, 2, 3)
    stream.send_columns("map/springs", times, rr.LineStrips3D.columns(strips=list(ends)).partition([len(pairs)] * frames))

    tiles = [((k + 0.5) * wide, (j + 0.5) * tall) for k in range(found.x.bins) for j in range(found.y.bins)]
    boxes = rr.Boxes3D(
        centers=_space(np.array(tiles), _TILE), half_sizes=[(0.5 * wide, 0.5 * tall, 0.0)] * len(tiles), colors=QUIET,
        radii=rr.Radius.ui_points(0.5),
    )
    stream.log("map/tiles", boxes, static=True)
    words = [f"{one.fitness:.3g} m {one.gait}{' (audit fails)' if one.stands is False else ''}" for one in animals]
    below = middles - (0.0, 0.5 * tall - 0.6)
    named = rr.Points3D(_space(below, _WORDS), radii=rr.Radius.ui_points(0.0), labels=words, colors=INK, show_labels=True)
    stream.log("map/words", named, static=True)
    text = f"# {found.title}\n\n{found.facts}\n\nAcross: {found.x.title}. Up: {found.y.title}. Colour: fitness, 0 to {found.most:.3g} m."
    stream.log("summary", rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True)


def _moved(motion: np.ndarray, frames: int) -> np.ndarray:
    """A motion (T, N, 2) about the middle of each frame's body, held at its end for as many frames as others have."""
    about = motion - motion.mean(axis=1, keepdims=True)
    return about if len(about) == frames else np.concatenate((about, np.repeat(about[-1:], frames - len(about), axis=0)))


def _space(plane: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack((plane, np.full(len(plane), z))).astype(np.float32)


def _blueprint(found: BodyMap, wide: float, tall: float) -> rrb.Blueprint:
    x, y = 0.5 * wide * found.x.bins, 0.5 * tall * found.y.bins
    height = 1.1 * max(2.0 * x / 1.6, 2.0 * y)
    view = rrb.Spatial3DView(
        origin="/map", name="Map", background=[*PAPER], line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(position=(x, y, height), look_target=(x, y, 0.0), eye_up=(0.0, 1.0, 0.0)),
    )
    return rrb.Blueprint(
        rrb.Horizontal(view, rrb.TextDocumentView(origin="/summary", name="Summary"), column_shares=[5, 1]),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden"), auto_views=False,
    )
