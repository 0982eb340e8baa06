"""The calibration of a body: which channel and which marker is which cell, and what levels and marks mean (docs/guide/hardware.md).

    name: eel
    position: [[0, 0], [1, 0], [0.5, 0.87]]   # m, of each cell at rest, as it grew: which body this is
    channel: [0, 1, 2]                        # of each cell
    marker: [0, 1, 2]                         # likewise
    levels: {vent: 10, rest: 30, span: 20, least: 10, most: 50, rate: 400}   # each one number, or one for each cell
    pressure: {most: 60}
    frame: {scale: 1, angle: 0, x: 0, y: 0}   # m for a unit of the markers; rad, m: of their frame in that of the body
    patience: {command: 0.1, state: 0.1}      # s

`levels` are in the unit of the firmware, e.g. kPa of air or mm of cable; `rate` is of that a second.  A cell is told rest + span (e - c).
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import yaml

from ..development.shape import farthest_cell
from ..inputs import InputError, shown
from ..text_file import check_keys, parsed, read_text
from .protocol import MOST_CHANNELS

_KEYS = ("name", "position", "channel", "marker", "levels", "pressure", "frame", "patience")
_BIG = 1e9
# section: {key: (least, most, default)}
_SECTIONS: dict[str, dict[str, tuple[float, float, float | None]]] = {
    "levels": {
        "vent": (-_BIG, _BIG, 0.0), "rest": (-_BIG, _BIG, None), "span": (-_BIG, _BIG, None), "least": (-_BIG, _BIG, None),
        "most": (-_BIG, _BIG, None), "rate": (1e-9, _BIG, None),
    },
    "pressure": {"most": (-_BIG, _BIG, None)},
    "frame": {"scale": (1e-9, _BIG, 1.0), "angle": (-1e3, 1e3, 0.0), "x": (-_BIG, _BIG, 0.0), "y": (-_BIG, _BIG, 0.0)},
    "patience": {"command": (0.01, 60.0, 0.1), "state": (0.01, 60.0, 0.1)},
}
SAME_PLACE = 0.1  # m, cell diameters: farthest that a grown cell may be from the calibrated one


class CalibrationError(InputError, ValueError):
    """A calibration that cannot be; the message names the key, the channel or cell, and the mend."""


_check_keys = partial(check_keys, CalibrationError)


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration file says, of N cells.

    Attributes: position (N, 2) m; channel, marker (N,): whole numbers; vent, rest, span, least, most, rate (N,): in the unit of the
    firmware; most_pressure: likewise; scale: m for a unit of the markers; angle rad, origin (2,) m: of the markers' frame; command_within,
    state_within: s without commands, or states, after which the body is vented.
    """

    name: str
    position: np.ndarray = field(repr=False)
    channel: np.ndarray = field(repr=False)
    marker: np.ndarray = field(repr=False)
    vent: np.ndarray = field(repr=False)
    rest: np.ndarray = field(repr=False)
    span: np.ndarray = field(repr=False)
    least: np.ndarray = field(repr=False)
    most: np.ndarray = field(repr=False)
    rate: np.ndarray = field(repr=False)
    most_pressure: float
    scale: float = 1.0
    angle: float = 0.0
    origin: tuple[float, float] = (0.0, 0.0)
    command_within: float = 0.1
    state_within: float = 0.1

    @property
    def cells(self) -> int:
        return len(self.channel)

    def levels_of(self, activation: np.ndarray) -> np.ndarray:
        """Levels (N,), by cell, for an activation (N,) of e - c, before limits."""
        return self.rest + self.span * activation

    def activation_of(self, levels: np.ndarray) -> np.ndarray:
        """Activation (N,) of cells that have these levels (N,)."""
        return (levels - self.rest) / self.span

    def by_channel(self, levels: np.ndarray) -> np.ndarray:
        """Levels (N,) of cells as the firmware takes them, (N,) float32 by channel."""
        told = np.empty(self.cells, np.float32)
        told[self.channel] = levels
        return told

    def by_cell(self, values: np.ndarray) -> np.ndarray:
        """What the firmware says of channels (N,), by cell."""
        return np.asarray(values, float)[self.channel]

    def seen(self, marker: np.ndarray) -> np.ndarray:
        """Positions (N, 2) m of cells, of markers (N, 2) in their own unit and frame."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[cosine, -sine], [sine, cosine]])
        return self.scale * np.asarray(marker, float)[self.marker] @ turn.T + np.array(self.origin)

    def marks(self, position: np.ndarray) -> np.ndarray:
        """The other way: markers (N, 2) of cells at `position` (N, 2) m."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[cosine, -sine], [sine, cosine]])
        found = np.empty((self.cells, 2))
        found[self.marker] = (position - np.array(self.origin)) @ turn / self.scale
        return found

    def why_not(self, position: np.ndarray) -> str:
        """Why a body whose cells grew at `position` (M, 2) m is not this one, or nothing.  It may stand elsewhere, but not turned."""
        if len(position) != self.cells:
            return f"it grows {len(position)} cells, and the body {shown(self.name, 40)} has {self.cells}"
        worst, far = farthest_cell(position, self.position)
        if far > SAME_PLACE:
            where = f"{far:.2g} m from where the body {shown(self.name, 40)} has it"
            return f"its cell {worst} grows {where}, more than {SAME_PLACE:g} m"
        return ""


def calibration_of(position: np.ndarray, name: str = "body") -> Calibration:
    """A calibration of N cells with channels and markers in their order, and round numbers: where one of your own begins."""
    cells = len(position)
    one = np.ones(cells)
    order = np.arange(cells)
    return Calibration(
        name, np.array(position), order, order, 10.0 * one, 30.0 * one, 20.0 * one, 10.0 * one, 50.0 * one, 2400.0 * one, 60.0,
    )


def save_calibration(calibration: Calibration, file: Any) -> None:
    """Write it to an open text file, as `load_calibration` reads it."""
    c = calibration
    levels = {name: _short(getattr(c, name)) for name in _SECTIONS["levels"]}
    document = {
        "name": c.name, "position": [[float(x), float(y)] for x, y in c.position], "channel": c.channel.tolist(),
        "marker": c.marker.tolist(), "levels": levels, "pressure": {"most": c.most_pressure},
        "frame": {"scale": c.scale, "angle": c.angle, "x": c.origin[0], "y": c.origin[1]},
        "patience": {"command": c.command_within, "state": c.state_within},
    }
    yaml.safe_dump(document, file, sort_keys=False, default_flow_style=None, width=120)


def _short(values: np.ndarray) -> float | list[float]:
    return float(values[0]) if (values == values[0]).all() else values.tolist()


def load_calibration(path: str | os.PathLike) -> Calibration:
    """Read a calibration file.  Raises CalibrationError that names file, key and mend."""
    text = read_text(path, CalibrationError, "the path of a calibration file, YAML or JSON")
    try:
        return make_calibration(parsed(text, CalibrationError))
    except CalibrationError as error:
        raise CalibrationError(f"{path}: {error}") from None


def make_calibration(document: Any) -> Calibration:
    """The calibration of a file's contents.  Raises CalibrationError."""
    _check_keys(document, _KEYS, "")
    for key in ("position", "channel", "levels", "pressure"):
        if document.get(key) is None:
            raise CalibrationError(f"{key} is missing: docs/guide/hardware.md shows a whole file")
    name = document.get("name", "body")
    if not isinstance(name, str) or not 0 < len(name) <= 60:
        raise CalibrationError(f"name is {shown(name)}: give a word of up to 60 characters")
    channel = _places(document["channel"], "channel", None)
    cells = len(channel)
    marker = _places(document.get("marker", list(range(cells))), "marker", cells)
    position = _position(document["position"], cells)
    given = {section: document.get(section) or {} for section in _SECTIONS}
    for section, keys in _SECTIONS.items():
        _check_keys(given[section], tuple(keys), section)
    levels = {key: _each(given["levels"], key, cells) for key in _SECTIONS["levels"]}
    scalars = {
        (section, key): _number(given[section].get(key), section, key) for section in ("pressure", "frame", "patience")
        for key in _SECTIONS[section]
    }
    made = Calibration(
        name, position, channel, marker, **levels, most_pressure=scalars["pressure", "most"], scale=scalars["frame", "scale"],
        angle=scalars["frame", "angle"], origin=(scalars["frame", "x"], scalars["frame", "y"]),
        command_within=scalars["patience", "command"], state_within=scalars["patience", "state"],
    )
    _check_levels(made)
    return made


def _check_levels(c: Calibration) -> None:
    for i in range(c.cells):
        where = f"of cell {i}, channel {c.channel[i]},"
        if not c.least[i] < c.most[i]:
            raise CalibrationError(f"levels: {where} least {c.least[i]:g} is not below most {c.most[i]:g}: exchange them")
        if not c.least[i] <= c.rest[i] <= c.most[i]:
            raise CalibrationError(f"levels: {where} rest {c.rest[i]:g} is not within least {c.least[i]:g} and most {c.most[i]:g}")
        if c.span[i] == 0.0:
            raise CalibrationError(f"levels: {where} span is 0, so that nothing would move: give the change of level for e - c of 1")
        if c.most[i] > c.most_pressure:
            raise CalibrationError(f"levels: {where} most {c.most[i]:g} is above pressure.most {c.most_pressure:g}, at which all is vented")


def _places(value: Any, key: str, cells: int | None) -> np.ndarray:
    """Which channel, or marker, each cell has: every one from 0 on, once."""
    if not isinstance(value, list) or not 0 < len(value) <= MOST_CHANNELS:
        raise CalibrationError(f"{key} is {shown(value)}: give a list with one for each of 1 to {MOST_CHANNELS} cells")
    if cells is not None and len(value) != cells:
        raise CalibrationError(f"{key} has {len(value)} entries, and channel has {cells}: give one for each cell")
    seen: dict[int, int] = {}
    for i, one in enumerate(value):
        if isinstance(one, bool) or not isinstance(one, int) or not 0 <= one < len(value):
            raise CalibrationError(f"{key}[{i}] is {shown(one)}: give a whole number from 0 to {len(value) - 1}")
        if one in seen:
            missing = min(set(range(len(value))) - set(value))
            raise CalibrationError(f"{key}[{i}] is {one}, as {key}[{seen[one]}] is, and no cell has {missing}: give each once")
        seen[one] = i
    return np.array(value, np.int64)


def _position(value: Any, cells: int) -> np.ndarray:
    if not isinstance(value, list) or len(value) != cells:
        count = len(value) if isinstance(value, list) else shown(value)
        raise CalibrationError(f"position has {count} entries, and channel has {cells}: give [x, y] for each cell")
    for i, row in enumerate(value):
        if not isinstance(row, list) or len(row) != 2 or not all(_finite(number) for number in row):
            raise CalibrationError(f"position[{i}] is {shown(row)}: give two numbers, [x, y], in m")
    return np.array(value, float)


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= _BIG


def _number(value: Any, section: str, key: str, where: str = "") -> float:
    low, high, default = _SECTIONS[section][key]
    if value is None and default is not None:
        return default
    if not _finite(value) or not low <= value <= high:
        raise CalibrationError(f"{section}.{key}{where} is {shown(value)}: give a number from {low:g} to {high:g}")
    return float(value)


def _each(section: dict, key: str, cells: int) -> np.ndarray:
    value = section.get(key)
    if not isinstance(value, list):
        return np.full(cells, _number(value, "levels", key))
    if len(value) != cells:
        raise CalibrationError(f"levels.{key} has {len(value)} entries, and channel has {cells}: give one number, or one for each cell")
    return np.array([_number(one, "levels", key, f"[{i}]") for i, one in enumerate(value)])
