"""Targets to chase: along a path drawn in a file, one after the other at random, or as a recording has them."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

import numpy as np
import yaml

from ..parameters import ParameterError

_HOW = "give a line `x,y` in metres for each target, or in YAML a list of [x, y]"
MOST_POINTS = 1_000_000


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
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ParameterError(f"{path}: {error.strerror}: {_HOW}") from None
    except UnicodeDecodeError:
        raise ParameterError(f"{path} is not text: {_HOW}") from None
    rows = _from_yaml(path, text) if path.suffix in (".yaml", ".yml") else _from_csv(text)
    points = []
    for where, row in rows:
        try:
            x, y = (float(value) for value in row)
        except (TypeError, ValueError):
            raise ParameterError(f"{path}: {where}: {row!r} is no point: {_HOW}") from None
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ParameterError(f"{path}: {where}: ({x}, {y}) is not finite: {_HOW}")
        points.append((x, y))
    if not 0 < len(points) <= MOST_POINTS:
        raise ParameterError(f"{path}: {len(points)} points: {_HOW}, 1 to {MOST_POINTS:,} in all")
    return np.array(points)


def _from_yaml(path, text):
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        raise ParameterError(f"{path}: {f'line {mark.line + 1}: ' if mark else ''}no YAML: {_HOW}") from None
    if not isinstance(data, list):
        raise ParameterError(f"{path} holds no list: {_HOW}")
    return [(f"point {k + 1}", row) for k, row in enumerate(data)]


def _from_csv(text):
    rows = [(f"line {k + 1}", row) for k, row in enumerate(csv.reader(text.splitlines())) if row and not row[0].startswith("#")]
    return rows[1:] if rows and [name.strip() for name in rows[0][1]] == ["x", "y"] else rows
