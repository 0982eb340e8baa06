"""Worlds to walk in: presets by name, and files of your own (docs/guide/walk.md).

    ground: [[-50, 0], [4, 0], [4.1, 0.5], [50, 0.5]]     # [x, y] m, x ascending; level beyond both ends
    ceiling: [[-50, 100], [8, 100], [8.1, 3], [50, 3]]    # likewise; none: open sky
    friction: 0.8                                         # Coulomb's coefficient
    gravity: 5.0                                          # m/s^2

In place of ground: `slope: DEGREES`, `steps: {rise, run, level}`, `rough: {seed, spacing, height, level}` or
`bumps: {height, width, apart, level}`, each to both sides of a level start.  All keys may be left out.
"""

from __future__ import annotations

import dataclasses
import os

import numpy as np

from .inputs import nearest, shown
from .parameters import ParameterError, Task
from .text_file import parsed, read_text

_LENGTH = 150.0  # m to each side, that made grounds are long
_WALL = 0.05  # m, run of a wall
_KEYS = ("ground", "ceiling", "friction", "gravity", "slope", "steps", "rough", "bumps")
# key: {name: (default, least, most)}
_MADE = {
    "steps": {"rise": (0.3, -100.0, 100.0), "run": (3.0, 0.2, 100.0), "level": (6.0, 0.0, 100.0)},
    "rough": {"seed": (1, 0, 2**32), "spacing": (1.0, 0.05, 100.0), "height": (0.5, 0.0, 100.0), "level": (6.0, 0.0, 100.0)},
    "bumps": {"height": (0.6, 0.0, 100.0), "width": (1.5, 0.2, 100.0), "apart": (6.0, 0.5, 100.0), "level": (6.0, 0.0, 100.0)},
}
PRESETS = {
    "flat": {},
    "slope": {"slope": 8.0},
    "steps": {"steps": {}},
    "rough": {"rough": {}},
    "obstacles": {"bumps": {}},
    "gap": {"ceiling": [
        [-14.0, 4.0], [-13.0, 4.0], [-12.0, 3.0], [-11.0, 4.0], [-10.0, 100.0],
        [10.0, 100.0], [11.0, 4.0], [12.0, 3.0], [13.0, 4.0], [14.0, 4.0],
    ]},
}


def with_world(task: Task, name: str | os.PathLike) -> Task:
    """A task in the world of a preset's name or of a file.  Raises ParameterError that names what is wrong and the mend."""
    document: object = PRESETS.get(str(name))
    if document is None:
        if not os.path.exists(name):
            near = nearest(name, PRESETS)
            raise ParameterError(f"world {shown(str(name))} is neither a file nor one of {', '.join(PRESETS)}: did you mean {near!r}?")
        document = _read(name)
    if not task.has_ground:
        raise ParameterError(f"a world is for tasks that happen on the ground, such as walk: {task.name} has no ground")
    try:
        return dataclasses.replace(task, scene=dataclasses.replace(task.scene, **scene_of(document)))
    except ParameterError as error:
        raise ParameterError(f"world {name}: {error}") from None


def scene_of(document: object) -> dict:
    """The fields of `parameters.Scene` that a world's document sets.  Raises ParameterError."""
    if not isinstance(document, dict):
        raise ParameterError(f"it is {shown(document)}: give keys and values, e.g. friction: 0.8")
    _check_names(document, _KEYS, "key")
    grounds = [key for key in ("ground", "slope", *_MADE) if key in document]
    if len(grounds) > 1:
        raise ParameterError(f"{' and '.join(grounds)} are both given: choose one ground")
    fields = {key: document[key] for key in ("friction", "gravity") if key in document}
    for key, points in [("ground", _ground(document)), ("ceiling", _points(document, "ceiling"))]:
        if points is not None:
            fields[f"{key}_x"], fields[f"{key}_y"] = (tuple(map(float, column)) for column in zip(*points))
    return fields


def _read(path):
    text = read_text(path, ParameterError, "a file of YAML, e.g. 'friction: 0.8', or the name of a world")
    try:
        return parsed(text, ParameterError)
    except ParameterError as error:
        raise ParameterError(f"world {path}: {error}") from None


def _check_names(given, known, what):
    for name in given:
        if name not in known:
            raise ParameterError(f"{what} {shown(name)} is unknown: did you mean {nearest(name, known)!r}?")


def _number(value, low, high, where):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ParameterError(f"{where} is {shown(value)}: give a number from {low:g} to {high:g}")
    return value


def _points(document, key):
    points = document.get(key)
    if points is None:
        return None
    if not isinstance(points, list) or not points:
        raise ParameterError(f"{key} is {shown(points)}: give a list of points [x, y]")
    for k, point in enumerate(points):
        if not isinstance(point, list) or len(point) != 2:
            raise ParameterError(f"{key}[{k}] is {shown(point)}: give a point [x, y]")
        for value in point:
            _number(value, -1e6, 1e6, f"{key}[{k}]")
    return points


def _ground(document):
    for key, make in (("steps", _steps), ("rough", _rough), ("bumps", _bumps)):
        if key in document:
            given = {} if document[key] is None else document[key]
            if not isinstance(given, dict):
                raise ParameterError(f"{key} is {shown(given)}: give {', '.join(_MADE[key])}")
            _check_names(given, _MADE[key], f"{key}: key")
            whole = {
                name: _number(given.get(name, default), low, high, f"{key}.{name}") for name, (default, low, high) in _MADE[key].items()
            }
            return make(**whole)
    if "slope" in document:
        rise = np.tan(np.radians(_number(document["slope"], -80.0, 80.0, "slope")))
        return [(-_LENGTH, -_LENGTH * rise), (_LENGTH, _LENGTH * rise)]
    return _points(document, "ground")


def _mirrored(right):
    """A ground that is the same to both sides."""
    return [(-x, y) for x, y in reversed(right)] + right


def _steps(rise, run, level):
    run = max(run, 4 * _WALL)
    right, y = [(max(level, 1e-2), 0.0)], 0.0
    while right[-1][0] < _LENGTH:
        x = right[-1][0]
        right += [(x + _WALL, y + rise), (x + run, y + rise)]
        y += rise
    return _mirrored(right)


def _rough(seed, spacing, height, level):
    if isinstance(seed, float):
        raise ParameterError(f"rough.seed is {shown(seed)}: give a whole number")
    x = np.arange(max(level, spacing), _LENGTH, spacing)
    left, right = np.random.default_rng(seed).uniform(0.0, height, (2, len(x)))
    left[0] = right[0] = 0.0
    return [*zip(-x[::-1], left[::-1]), *zip(x, right)]


def _bumps(height, width, apart, level):
    right = []
    for x in np.arange(max(level, 0.1), _LENGTH, width + apart):
        right += [(x, 0.0), (x + _WALL, height), (x + width - _WALL, height), (x + width, 0.0)]
    return _mirrored(right)
