"""What was set in a run beyond the defaults, and the command that repeats it."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from evodevo_sim.parameters import PROFILES, Task, default_task, with_settings
from evodevo_sim.worlds import PRESETS, with_world

from ..schemes import default_scheme, scheme
from ..settings import UNLIMITED, Settings
from ..usual import usual_task

_CELLS = 32  # of `evolve` without --cells


@dataclass(frozen=True)
class Difference:
    """name; value; default: what `evolve --task` of the same task takes; meaning, with its unit."""

    name: str
    value: str
    default: str
    meaning: str


def differences(task: Task, settings: Settings, chosen: str) -> list[Difference]:
    """What differs from `evolve --task` of the same task.  Args: chosen: the scheme, or nothing where it is not recorded."""
    usual = default_scheme(task.name)
    usual_settings = _settings(usual, task.name)
    found = [Difference("scheme", chosen, usual, "the way to search")] if chosen and chosen != usual else []
    for name, value, default, meaning in _fields(settings, usual_settings):
        found.append(Difference(name, _shown(value), _shown(default), meaning))
    world = world_of(task)
    profiles = {f"scene.{name}" for name in PROFILES}
    for name, value, default, meaning in _fields(task, _usual_task(task.name)):
        if name not in profiles:
            found.append(Difference(name, _shown(value), _shown(default), meaning))
    if world != "flat" and any(getattr(task.scene, name) for name in PROFILES):
        found.append(Difference("world", world or "of a file", "flat", "ground and ceiling"))
    return found


def _settings(name: str, task: str) -> Settings:
    """The numbers of a scheme."""
    numbers: dict[str, Any] = dict(scheme(name, task))
    return Settings(**numbers)


def _usual_task(name: str, scheme: str = "") -> Task:
    return with_settings(usual_task(name, scheme), {"development.max_cells": _CELLS})


def world_of(task: Task) -> str:
    """The name of the world of a task, flat where it has no ground; nothing where it is of no preset."""
    if not task.has_ground:
        return "flat"
    own = [getattr(task.scene, name) for name in PROFILES]
    for name in PRESETS:
        if [getattr(with_world(default_task(task.name), name).scene, profile) for profile in PROFILES] == own:
            return name
    return ""


def world_text(task: Task) -> str:
    """The file of a world of one's own."""
    s = task.scene
    lines = [
        f"{name}: {[[x, y] for x, y in zip(xs, ys)]}"
        for name, xs, ys in (("ground", s.ground_x, s.ground_y), ("ceiling", s.ceiling_x, s.ceiling_y)) if xs
    ]
    return "\n".join([*lines, f"friction: {s.friction!r}", f"gravity: {s.gravity!r}"]) + "\n"


def command(task: Task, settings: Settings, seed: int, chosen: str, files: Mapping[str, str] | None = None) -> str:
    """The command line that repeats a run.

    Args: chosen: the scheme, or nothing; files: names of files by what they are: "world", and "start", those of genomes to begin from.
    """
    files = files or {}
    given = ["--task", task.name, "--seed", str(seed)]
    name = chosen or "panmictic"  # to which numbers of layers and niches can be given, too
    given += ["--scheme", name]
    if task.development.max_cells != _CELLS:
        given += ["--cells", str(task.development.max_cells)]
    base = _usual_task(task.name, name)
    world = world_of(task)
    if world != "flat":
        given += ["--world", world or files.get("world", "world.yaml")]
        base = dataclasses.replace(base, scene=dataclasses.replace(base.scene, **_world_fields(task, world)))
    for flag, value, default, _ in _fields(settings, _settings(name, task.name)):
        if value != UNLIMITED or default != UNLIMITED:
            given += [f"--{flag.replace('_', '-')}", repr(value)]
    for setting, value, _, _ in _fields(task, base):
        if setting != "development.max_cells":
            given += ["--set", f"{setting}={_spelt(value)}"]
    if files.get("start"):
        given += ["--start", *files["start"].split()]
    return shlex.join(["ros2", "run", "evodevo_ga", "evolve", *given])


def _world_fields(task: Task, world: str) -> dict[str, Any]:
    scene = with_world(default_task(task.name), world).scene if world else task.scene
    return {name: getattr(scene, name) for name in (*PROFILES, "friction", "gravity")}


def _fields(value: Any, default: Any, prefix: str = "") -> Iterator[tuple[str, Any, Any, str]]:
    """(dotted name, value, default, meaning) of each field that differs."""
    for field in dataclasses.fields(value):
        one, other = getattr(value, field.name), getattr(default, field.name)
        if dataclasses.is_dataclass(one):
            yield from _fields(one, other, f"{prefix}{field.name}.")
        elif one != other:
            told = field.metadata
            unit = f" ({told['unit']})" if told.get("unit") else ""
            yield f"{prefix}{field.name}", one, other, f"{told.get('meaning', '')}{unit}".strip()


def _spelt(value: Any) -> str:
    """A value as `--set` takes it."""
    return ",".join(map(str, value)) if isinstance(value, tuple) else value if isinstance(value, str) else repr(value)


def _shown(value: Any) -> str:
    if value == UNLIMITED:
        return "without limit"
    return f"{value:g}" if isinstance(value, float) else (_spelt(value) or "none") if isinstance(value, tuple) else str(value)
