"""Targets to chase: along a path drawn in a file, one after the other at random, or as a recording has them."""

from __future__ import annotations

import csv
import math
import os

import numpy as np

from .inputs import decimal, shown
from .parameters import ParameterError
from .text_file import parsed, read_text

_HOW = "give a line `x,y` in metres for each target, or in YAML a list of [x, y]"
MOST_POINTS = 100_000


class Drawn:
    """Targets at given points (K, 2) m, in their order."""

    def __init__(self, points):
        self._points = [tuple(point) for point in np.asarray(points, float).tolist()]

    def following(self, centre) -> tuple[float, float] | None:
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

    def following(self, centre) -> tuple[float, float]:
        """The next target for an animat at `centre` (2,) m."""
        angle, distance = self._rng.uniform(-math.pi, math.pi), self._rng.uniform(*self._range)
        return float(centre[0] + distance * math.cos(angle)), float(centre[1] + distance * math.sin(angle))


def load_points(path: str | os.PathLike) -> np.ndarray:
    """The points (K, 2) m of a CSV or YAML file.  Raises ParameterError that names the line and how to mend it."""
    text = read_text(path, ParameterError, "points: " + _HOW.removeprefix("give "))
    try:
        rows = _from_yaml(text) if os.fspath(path).endswith((".yaml", ".yml", ".json")) else _from_csv(text)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}: {_HOW}") from None
    points = []
    for where, row in rows:
        if not (isinstance(row, list) and len(row) == 2 and all(type(value) in (int, float) for value in row)):
            raise ParameterError(f"{path}: {where}: {shown(row)} is no point: {_HOW}")
        if not all(map(math.isfinite, row)):
            raise ParameterError(f"{path}: {where}: {shown(row)} is not finite: {_HOW}")
        points.append(row)
    if not 0 < len(points) <= MOST_POINTS:
        raise ParameterError(f"{path}: {len(points)} points: {_HOW}, 1 to {MOST_POINTS:,} in all")
    return np.array(points, float)


def _from_yaml(text):
    data = parsed(text, ParameterError)
    if not isinstance(data, list):
        raise ParameterError("holds no list")
    return [(f"point {k + 1}", row) for k, row in enumerate(data)]


def _from_csv(text):
    """Rows with their places; of what spells a number, the number."""
    lines = csv.reader(text.splitlines())
    try:
        rows = [(f"line {lines.line_num}", row) for row in lines if row and not row[0].startswith("#")]
    except csv.Error as error:
        raise ParameterError(f"line {lines.line_num}: {error}") from None
    rows = rows[1:] if rows and [name.strip() for name in rows[0][1]] == ["x", "y"] else rows
    return [(where, [value if (number := decimal(value.strip())) is None else number for value in row]) for where, row in rows]
