"""Targets to chase: along a path drawn in a file, one after the other at random, or as a recording has them."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Iterable
from itertools import islice

import numpy as np

from ..inputs import decimal, shown
from ..parameters import ParameterError
from ..text_file import parsed, read_text

_HOW = "give a line `x,y` in metres for each target, or in YAML a list of [x, y]"
MOST_POINTS = 100_000


class Drawn:
    """Targets at given points (K, 2) m, in their order."""

    def __init__(self, points: Iterable):
        self._points = [tuple(point) for point in np.asarray(points, float).tolist()]

    def following(self, centre: np.ndarray) -> tuple[float, float] | None:
        """The next target for an animat at `centre` (2,) m, or None when there is none."""
        return self._points.pop(0) if self._points else None


class Random:
    """Targets without end, each at a random distance in any direction from where the animat is then.

    Args: seed: equal seeds give equal angles and distances; nearest, farthest: m.
    """

    def __init__(self, seed: int, nearest: float, farthest: float):
        if not 0.0 < nearest <= farthest <= 1e6:
            raise ParameterError(f"distances of {nearest:g} to {farthest:g} m: give two numbers above 0, the nearer first")
        self._rng, self._range = np.random.default_rng(seed), (nearest, farthest)

    def following(self, centre: np.ndarray) -> tuple[float, float]:
        """The next target for an animat at `centre` (2,) m."""
        angle, distance = self._rng.uniform(-math.pi, math.pi), self._rng.uniform(*self._range)
        return float(centre[0] + distance * math.cos(angle)), float(centre[1] + distance * math.sin(angle))


def load_points(path: str | os.PathLike) -> np.ndarray:
    """The points (K, 2) m of a CSV or YAML file.  Raises ParameterError that names the line and how to mend it."""
    text = read_text(path, ParameterError, _HOW.removeprefix("give "))
    rows = _from_yaml(text) if os.fspath(path).endswith((".yaml", ".yml", ".json")) else _from_csv(text)
    try:
        points = [_point(where, row) for where, row in islice(rows, MOST_POINTS + 1)]
        if not 0 < len(points) <= MOST_POINTS:
            raise ParameterError(f"{f'more than {MOST_POINTS:,}' if points else 'no'} points")
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}: {_HOW}") from None
    return np.array(points, float)


def _point(where, row):
    if not (isinstance(row, list) and len(row) == 2 and all(type(value) in (int, float) for value in row)):
        raise ParameterError(f"{where}: {shown(row)} is no point")
    if not all(map(math.isfinite, row)):
        raise ParameterError(f"{where}: {shown(row)} is not finite")
    return row


def _from_yaml(text):
    data = parsed(text, ParameterError)
    if not isinstance(data, list):
        raise ParameterError("holds no list")
    yield from ((f"point {k + 1}", row) for k, row in enumerate(data))


def _from_csv(text):
    """Rows with their places; of what spells a number, the number."""
    lines, first = csv.reader(io.StringIO(text)), True
    try:
        for row in lines:
            if not row or row[0].startswith("#"):
                continue
            if not first or [name.strip() for name in row[:3]] != ["x", "y"]:
                yield f"line {lines.line_num}", [_read(cell) for cell in row] if len(row) == 2 else row
            first = False
    except csv.Error as error:
        raise ParameterError(f"line {lines.line_num}: {error}") from None


def _read(cell):
    number = decimal(cell.strip())
    return cell if number is None else number
