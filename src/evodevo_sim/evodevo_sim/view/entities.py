"""What Rerun entities are made of: discs, lines and curves, in the plane z = 0 of m."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr

DISC = 0.01  # m, thickness
BEFORE = 0.02  # m, height of lines above the cells' discs


def at(seconds: Any) -> list[rr.TimeColumn]:
    """The timeline `time`.  Args: seconds (T,)."""
    return [rr.TimeColumn("time", duration=seconds)]


def space(plane: Any, z: float) -> np.ndarray:
    """Points (..., 2) in the plane as points (..., 3) in space, float32."""
    plane = np.asarray(plane)
    return np.concatenate((plane, np.full((*plane.shape[:-1], 1), z)), axis=-1, dtype=np.float32)


def log_discs(
    stream: rr.RecordingStream, entity: str, index: list[rr.TimeColumn], lengths: Sequence[int], position: np.ndarray, colours: np.ndarray
) -> None:
    """Cells at each instant.  Args: lengths (T,): how many; position (sum, 2) m; colours (sum, 3) uint8."""
    # Flat cylinders: points are drawn as spheres, and lines would sink into them.  Where discs overlap, the later cell is above.
    ranks = np.concatenate([np.arange(n) / n for n in lengths])[:, None] * DISC
    stream.log(entity, rr.Cylinders3D.from_fields(radii=0.5, fill_mode="solid", show_labels=False), static=True)
    columns = rr.Cylinders3D.columns(
        centers=np.concatenate((position, ranks), axis=1, dtype=np.float32), colors=colours,
        lengths=np.full(len(position), DISC, np.float32),
    )
    stream.send_columns(entity, index, columns.partition(lengths))


def log_lines(
    stream: rr.RecordingStream, entity: str, times: list[np.ndarray], positions: list[np.ndarray], pairs: Sequence[np.ndarray],
    colour: Sequence[int], radius: float,
) -> None:
    """Lines between pairs of cells.  Args: of each stretch in time: times (T,), positions (T, N, 2), pairs (E, 2)."""
    import pyarrow as pa

    ends = [space(position[:, pair].reshape(-1, 2), BEFORE) for position, pair in zip(positions, pairs)]
    lengths = np.concatenate([np.full(len(time), len(pair)) for time, pair in zip(times, pairs)])
    if not lengths.sum():
        return
    # Strips of two points each, given to Rerun as the Arrow array that it would make one by one.
    points = rr.encodings.Vec3DBatch(np.concatenate(ends)).as_arrow_array()
    kind = rr.components.LineStrip3DBatch([]).as_arrow_array().type
    offsets = pa.array(np.arange(0, len(points) + 1, 2), pa.int32())
    strips = pa.ListArray.from_arrays(offsets, points, type=kind)
    stream.log(entity, rr.LineStrips3D.from_fields(radii=radius, colors=colour), static=True)
    columns = rr.LineStrips3D.columns(strips=strips).partition(lengths)
    stream.send_columns(entity, at(np.concatenate(times)), columns)


def log_curve(
    stream: rr.RecordingStream, entity: str, index: list[rr.TimeColumn], values: Any, name: str, colour: Sequence[int]
) -> None:
    """A curve over a timeline."""
    stream.log(entity, rr.SeriesLines(names=name, colors=colour, widths=1.5), static=True)
    stream.send_columns(entity, index, rr.Scalars.columns(scalars=values))
