"""A life as few bytes: what the player of a page draws, in whole numbers, deflated.

Lengths are in quanta, `scale` of them to a metre.  A series of numbers is kept as its second differences in time, which are small where
motion is smooth, cell by cell, low bytes before high ones: 64 cells in 2,000 steps take about 0.2 MB.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...analysis.stretches import words_of_holes
from ...recording.life import RINGS, Life, Pose
from ..palettes import PALETTES

FORMAT = 1
SCALE = 256  # quanta in a metre: a quarter of a pixel where a cell is 64 pixels wide
LEVELS = 100  # of e - c from 0 to 1
BUDGET = 720_000  # bytes of deflated numbers: with base64 and the player below a million
_MARGIN = 30.0  # m of ground beyond where the body comes


def pack(life: Life, palette: str = "safe", budget: int = BUDGET) -> dict[str, Any]:
    """What the player needs, as JSON takes it: numbers, lists and one text of base64.

    Args: palette: the one that it begins with.
    Where it would not fit into `budget` bytes, steps are left out evenly, growth first, and `notes` say so.
    """
    notes = [line] if (line := words_of_holes(life.time)) else []
    for every in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024):
        blob = _Blob()
        document = {"format": FORMAT, "growth": _growth(life, every, blob), "life": _life(life, every, blob)}
        data = zlib.compress(b"".join(blob.parts), 9)
        if len(data) <= budget:
            break
    if every > 1:
        notes.append(f"one step in {every} is shown, so that the film stays small")
    palettes = {
        name: {"stops": one.stops, "contracting": one.contracting, "rest": one.rest, "expanding": one.expanding}
        for name, one in PALETTES.items()
    }
    return {**document, "notes": notes, "palettes": palettes, "palette": palette, "rings": RINGS, "data": base64.b64encode(data).decode()}


class _Blob:
    """The numbers of a film, one after another."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self._size = 0

    def add(self, data: bytes) -> list[int]:
        """Returns: where they begin, and how many bytes they are."""
        self.parts.append(data)
        self._size += len(data)
        return [self._size - len(data), len(data)]

    def series(self, values: np.ndarray) -> list[int]:
        """Whole numbers (T, K), as second differences in time; their first row is kept by whoever asks."""
        before = np.concatenate((values[:1], values[:1], values))
        second = np.diff(before, n=2, axis=0).T.ravel()
        folded = ((second << 1) ^ (second >> 63)).astype("<u2")
        return self.add(folded.view(np.uint8).reshape(-1, 2).T.tobytes())

    def levels(self, values: np.ndarray) -> list[int]:
        """Numbers (T, K) from -1 to 1, as first differences of their levels, modulo 256."""
        level = np.rint(np.clip(np.nan_to_num(values), -1.0, 1.0) * LEVELS).astype(np.int64)
        first = np.diff(np.concatenate((0 * level[:1], level)), axis=0).T
        return self.add((first & 255).astype(np.uint8).tobytes())


def _motion(position: np.ndarray, blob: _Blob) -> dict[str, Any]:
    """Positions (T, N, 2) m."""
    flat = np.concatenate((position[..., 0], position[..., 1]), axis=1)
    scale: float = SCALE
    while True:
        quanta = np.rint(flat * scale).astype(np.int64)
        second = np.diff(np.concatenate((quanta[:1], quanta[:1], quanta)), n=2, axis=0)
        if np.abs(second).max(initial=0) < 2**15:
            return {"scale": scale, "first": quanta[0].tolist(), "position": blob.series(quanta)}
        scale /= 4


def _growth(life: Life, every: int, blob: _Blob) -> dict[str, Any] | None:
    steps = [k for k in kept(len(life.growth), every) if len(life.growth[k].position)]
    if not steps:
        return None
    poses = [life.growth[k] for k in steps]
    position, activation, count = padded(poses)
    graphs: list[list] = []
    for number, k in enumerate(steps):
        pairs = np.asarray(life.growth_springs[k]).ravel().tolist() if k < len(life.growth_springs) else []
        if not graphs or graphs[-1][1] != pairs:
            graphs.append([number, pairs])
    return {
        **_motion(position, blob), "steps": steps, "cells": position.shape[1], "count": count.tolist(),
        "activation": blob.levels(activation), "graphs": graphs,
    }


def padded(poses: Sequence[Pose]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses of growing bodies as position (S, N, 2) m, activation (S, N) and count (S,) of cells; a cell lies where it will be
    born before it is, and where it was last after it is gone."""
    count = np.array([len(pose.position) for pose in poses])
    most = int(count.max())
    position, activation = np.full((len(poses), most, 2), np.nan), np.zeros((len(poses), most))
    for k, pose in enumerate(poses):
        position[k, : count[k]], activation[k, : count[k]] = pose.position, pose.activation
    for cell in range(most):
        there = np.flatnonzero(count > cell)
        nearest = there[np.clip(np.searchsorted(there, np.arange(len(poses))), 0, len(there) - 1)]
        position[:, cell] = position[nearest, cell]
    return position, activation, count


def _life(life: Life, every: int, blob: _Blob) -> dict[str, Any] | None:
    if not len(life.time):
        return None
    steps = kept(len(life.time), every)
    position = life.position[steps]
    contact = life.contact[steps]
    low, high = position[..., 0].min() - _MARGIN, position[..., 0].max() + _MARGIN
    return {
        **_motion(position, blob), "cells": position.shape[1],
        "milliseconds": np.rint(1e3 * (life.time[steps] - life.time[0])).astype(int).tolist(),
        "activation": blob.levels(life.activation[steps]),
        "contact": blob.add(np.packbits(contact.ravel()).tobytes()) if contact.any() else None,
        "springs": life.springs.ravel().tolist(), "outline": life.outline.ravel().tolist(),
        "chambers": [chamber.tolist() for chamber in life.chambers],
        "surfaces": [np.round(line, 3).tolist() for line in life.surfaces(low, high)],
        "target": _changes(life.target[steps]) if len(life.target) else [], "reach": life.reach,
    }


def kept(count: int, every: int) -> list[int]:
    """Numbers of the steps that are kept of `count`: every so many, and the last one."""
    steps = list(range(0, count, every))
    return steps if not count or steps[-1] == count - 1 else [*steps, count - 1]


def _changes(target: np.ndarray) -> list[list]:
    """[step, x, y] where a target (T, 2) m changes; x and y are None where there is none."""
    found: list[list] = []
    for step, point in enumerate(target):
        now = [None, None] if not np.isfinite(point).all() else [round(float(value), 4) for value in point]
        if not found or found[-1][1:] != now:
            found.append([step, *now])
    return found
