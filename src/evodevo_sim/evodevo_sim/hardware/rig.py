"""A rig in one file, `plant.yaml`: what actuators, sensors and line do to what they are told (docs/guide/hardware.md).

    actuators: {lag: 0.15, dead_time: 0.03, rate: 4.0, resolution: 0.01, dead: [3, 7]}
    sensors: {noise: 0.01, delay: 0.02, lost: 0.001, resolution: 0.001}
    line: {lost: 0.01, damaged: 0.01}
    events: [{at: 2.0, what: unplug, for: 0.5}, {at: 5.0, what: fail, cells: [4], count: 2}]
    seed: 1

Whatever is left out does nothing.  A simulated body has the same actuators and sensors by the settings `rig.*` of its task.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from ..inputs import InputError, decimal, shown
from ..parameters import MOST_CELLS, Checked, ParameterError, parameter
from ..parameters import Rig as Settings
from ..text_file import check_keys, parsed, read_text

MOST_EVENTS = 1000
KINDS = ("unplug", "restart", "fail", "stop", "pressure", "silence", "garbage")


class RigError(InputError, ValueError):
    """A rig that cannot be; the message names the key, the value and the mend."""


_check_keys = partial(check_keys, RigError)


def _like(name: str) -> Any:
    """A field that is documented where the settings of a task have it."""
    same = Settings.__dataclass_fields__[name]
    return field(default=same.default, metadata=same.metadata)


@dataclass(frozen=True)
class Actuators(Checked):
    """From the activation that is asked for, e - c, to the one that a muscle has."""

    lag: float = _like("lag")
    dead_time: float = _like("dead_time")
    rate: float = _like("rate")
    resolution: float = _like("resolution")
    dead: tuple[int, ...] = ()  # cells whose actuators do nothing


@dataclass(frozen=True)
class Sensors(Checked):
    """From where a cell is to where its marker is seen."""

    noise: float = _like("sensor_noise")
    delay: float = _like("sensor_delay")
    resolution: float = _like("sensor_resolution")
    lost: float = _like("sensor_lost")


@dataclass(frozen=True)
class Line(Checked):
    """What a serial line does to frames, in both directions."""

    lost: float = parameter(0.0, 0.0, 1.0, "", "probability of a frame not to arrive")
    damaged: float = parameter(0.0, 0.0, 1.0, "", "probability of a frame to arrive with one byte changed")


@dataclass(frozen=True)
class Event:
    """What happens at a time, s from the start: one of KINDS, for so many s; where it is `fail`, to cells, and to so many drawn by lot."""

    at: float
    what: str
    lasts: float = 0.0
    cells: tuple[int, ...] = ()
    count: int = 0


@dataclass(frozen=True)
class Rig:
    """A rig.  seed: of noise and of what the line loses; equal seeds, equal rigs."""

    actuators: Actuators = Actuators()
    sensors: Sensors = Sensors()
    line: Line = Line()
    events: tuple[Event, ...] = ()
    seed: int = 0

    @property
    def ideal(self) -> bool:
        """Whether muscles do at once what they are told, and cells are seen where they are."""
        return self.actuators == Actuators() and self.sensors == Sensors() and not self.events


_PARTS: dict[str, Any] = {"actuators": Actuators, "sensors": Sensors, "line": Line}
_KEYS = (*_PARTS, "events", "seed")


def load_rig(path: str | os.PathLike, cells: int | None = None) -> Rig:
    """Read a rig's file.  Args: cells: of the body, where it is known.  Raises RigError that names file, key and mend."""
    text = read_text(path, RigError, "the path of a rig's file, YAML or JSON")
    try:
        return make_rig(parsed(text, RigError), cells)
    except RigError as error:
        raise RigError(f"{path}: {error}") from None


def make_rig(document: Any, cells: int | None = None) -> Rig:
    """The rig of a file's contents.  Raises RigError."""
    document = {} if document is None else document
    _check_keys(document, _KEYS, "")
    parts = {name: _part(kind, document.get(name), name, cells) for name, kind in _PARTS.items()}
    seed = document.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise RigError(f"seed is {shown(seed)}: give a whole number from 0 to 2^63 - 1")
    events = document.get("events") or []
    if not isinstance(events, list) or len(events) > MOST_EVENTS:
        raise RigError(f"events is {shown(events)}: give a list of at most {MOST_EVENTS}, each with at, what, for, cells")
    made = tuple(sorted((_event(one, f"events[{k}]", cells) for k, one in enumerate(events)), key=lambda one: one.at))
    return Rig(events=made, seed=seed, **parts)


def settings_of(rig: Rig) -> dict[str, object]:
    """The settings of a task whose simulated body has this rig, for `parameters.with_settings`.  Raises RigError where there are none."""
    fails = [event for event in rig.events if event.what == "fail"]
    times = sorted({event.at for event in fails})
    if len(times) > 1:
        raise RigError(f"events: cells fail at {times[0]:g} s and at {times[1]:g} s: a simulated life has one time, give all the same")
    failing = tuple(dict.fromkeys(cell for event in fails for cell in event.cells))
    a, s = rig.actuators, rig.sensors
    values = {
        "lag": a.lag, "dead_time": a.dead_time, "rate": a.rate, "resolution": a.resolution, "dead_cells": a.dead, "failing_cells": failing,
        "failures": sum(event.count for event in fails), "fail_at": times[0] if times else 0.0,
        "sensor_noise": s.noise, "sensor_delay": s.delay, "sensor_resolution": s.resolution, "sensor_lost": s.lost,
    }
    return {f"rig.{name}": value for name, value in values.items()}


def rig_of(settings: Settings) -> Rig:
    """The other way: a rig of the settings of a task."""
    s = settings
    events = (Event(s.fail_at, "fail", 0.0, s.failing_cells, s.failures),) if s.failing_cells or s.failures else ()
    actuators = Actuators(s.lag, s.dead_time, s.rate, s.resolution, s.dead_cells)
    return Rig(actuators, Sensors(s.sensor_noise, s.sensor_delay, s.sensor_resolution, s.sensor_lost), events=events)


def plant_settings(path: str | os.PathLike, scent: bool, say: Callable[[str], None] = lambda line: None) -> dict[str, object]:
    """The settings of a task whose simulated body has the rig of a file.

    Args: scent: whether there is one, the only thing that depends on where cells are seen; say: called with a line about what has no part
    in simulation.  Raises ParameterError that names file, key and mend.
    """
    try:
        rig = load_rig(path)
        found = settings_of(rig)
    except RigError as error:
        named = str(error) if str(error).startswith(str(path)) else f"{path}: {error}"
        raise ParameterError(named) from None
    idle = [f"event {what}" for what in dict.fromkeys(event.what for event in rig.events) if what != "fail"]
    idle += ["line"] * (rig.line != Line()) + ["seed"] * (rig.seed != 0)
    idle += ["sensors (there is no scent)"] * (not scent and rig.sensors != Sensors())
    if idle:
        say(f"{path}: of no part in this simulation: {', '.join(idle)}")
    return found


def event_of_line(line: str, cells: int | None = None) -> Event:
    """The event of a line such as `unplug 0.5` or `fail 3 4`: what, and for how many s, or of which cells.  Raises RigError."""
    what, *rest = line.split() or [""]
    numbers = [decimal(word) for word in rest]
    if what == "fail":
        return _event({"at": 0, "what": what, "cells": numbers}, "the line", cells)
    if len(numbers) > 1:
        raise RigError(f"the line {shown(line)} has {len(numbers)} numbers: give one, the seconds that it lasts")
    return _event({"at": 0, "what": what, "for": numbers[0] if numbers else 0.0}, "the line", cells)


def _part(kind: Any, given: Any, name: str, cells: int | None) -> Any:
    given = {} if given is None else given
    names = tuple(field.name for field in dataclasses.fields(kind))
    _check_keys(given, names, name)
    values = dict(given)
    if "dead" in values:
        values["dead"] = _cells(values["dead"], f"{name}.dead", cells)
    try:
        return kind(**values)
    except ParameterError as error:
        raise RigError(str(error)) from None


def _event(given: Any, where: str, cells: int | None) -> Event:
    _check_keys(given, ("at", "what", "for", "cells", "count"), where)
    what = given.get("what")
    if what not in KINDS:
        raise RigError(f"{where}.what is {shown(what)}: choose one of {', '.join(KINDS)}")
    at, lasts = (_seconds(given.get(key, default), f"{where}.{key}") for key, default in (("at", None), ("for", 0.0)))
    count, most = given.get("count", 0), MOST_CELLS if cells is None else cells
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= most:
        raise RigError(f"{where}.count is {shown(count)}: give how many cells fail, 0 to {most}")
    return Event(at, what, lasts, _cells(given.get("cells", []), f"{where}.cells", cells), count)


def _seconds(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= 1e9 or not math.isfinite(value):
        raise RigError(f"{where} is {shown(value)}: give seconds from 0 to 1e9")
    return float(value)


def _cells(value: Any, where: str, cells: int | None) -> tuple[int, ...]:
    most = (cells if cells is not None else MOST_CELLS) - 1
    if not isinstance(value, (list, tuple)):
        raise RigError(f"{where} is {shown(value)}: give a list of cells, each from 0 to {most}")
    for k, one in enumerate(value):
        if isinstance(one, bool) or not isinstance(one, int) or not 0 <= one <= most:
            raise RigError(f"{where}[{k}] is {shown(one)}: give the number of a cell, 0 to {most}")
        if one in value[:k]:
            raise RigError(f"{where}[{k}] is {one} again: give each cell once")
    return tuple(value)
