"""A run that goes on: what its checkpoint says, with limits that may be raised and nothing else changed."""

from __future__ import annotations

import argparse
import dataclasses
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evodevo_sim.genetics.genome import GenomeError
from evodevo_sim.genetics.genome_file import load_genome
from evodevo_sim.hardware.rig import plant_settings
from evodevo_sim.inputs import shown
from evodevo_sim.parameters import ParameterError, preset, setting_of, with_settings
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.worlds import with_world

from evodevo_sim import Task

from ..evolution import Evolution
from ..individual import Individual, individual_of_plain
from ..settings import Settings
from .checkpoint import read_checkpoint, settings_hash, task_of_plain
from .errors import ResumeError
from .limits import RAISED, Limits
from .lock import refuse_if_held

_LIMITS = tuple(field.name for field in dataclasses.fields(Limits))
_ONLY = "leave it out: only --generations, --patience, --evaluations and --hours may be raised"


@dataclass(frozen=True)
class Resumed:
    """A run as its checkpoint has it, with its limits raised.

    Attributes: champion: the one recorded last, of the generation `champion_generation`, or None; history: what its history has not
    written; notes: what must be known, a line each.
    """

    directory: Path
    task: Task
    evolution: Evolution
    limits: Limits
    sources: tuple[str, ...]
    champion: Individual | None
    champion_generation: int
    history: dict[str, Any]
    notes: tuple[str, ...] = ()
    rig: str = ""  # namespace of the driver whose body evaluates, if it is one


def resumed(directory: Path, given: Mapping[str, Any] = {}) -> Resumed:
    """Read a run to go on with.

    Args: given: flags of `evolve` that were given, by their names in the parser.
    Raises ResumeError or ParameterError where there is no such run, it still goes on, or a flag would change what it does.
    """
    refuse_if_held(directory)
    run, notes = read_checkpoint(directory)
    try:
        task = task_of_plain(run["task"])
        evolution = Evolution.resumed(run["evolution"], task)
        limits, champion = Limits(**run["limits"]), run["champion"]
        best = None if champion["individual"] is None else individual_of_plain(champion["individual"])
        found = Resumed(
            directory, task, evolution, limits, tuple(map(str, run["sources"])), best, int(champion["generation"]), run["history"],
            tuple(notes), str(run["rig"]),
        )
        told = run["settings_hash"]
    except (ParameterError, GenomeError) as error:
        raise ResumeError(f"{directory}: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ResumeError(f"{directory}: its checkpoint lacks what it should hold ({shown(error)}): restore the directory") from None
    if told != settings_hash(evolution, task):
        raise ResumeError(f"{directory}: its settings do not fit their hash: resume it with the version that it was begun with")
    _refuse_changes(found, given)
    return dataclasses.replace(found, limits=_raised_limits(found, given))


def _raised_limits(found: Resumed, given: Mapping[str, Any]) -> Limits:
    """The limits of a run, raised; those of its settings are raised in place."""
    numbers = {name: given[name] for name in RAISED if name in given}
    for name, value in numbers.items():
        _refuse_less(name, value, getattr(found.evolution.settings, name))
    if numbers:
        settings = dataclasses.replace(found.evolution.settings, **numbers)
        found.evolution.settings = found.evolution.search.settings = settings
    budgets = {name: given[name] for name in _LIMITS if name in given}
    for name, value in budgets.items():
        _refuse_less(name, value, getattr(found.limits, name))
    return dataclasses.replace(found.limits, **budgets)


def _refuse_less(name: str, value: float, before: float | None) -> None:
    if before is not None and value < before:
        raise ParameterError(f"--{name} is {value:g}, less than the run's {before:g}: give as much or more")


def _refuse_changes(found: Resumed, given: Mapping[str, Any]) -> None:
    """Raises ParameterError that names a flag by which the run would be another one."""
    over = {name.removeprefix("task.") for name in pairs(given.get("set", []))}  # --set goes over --preset and --plant
    for name, value in given.items():
        before = _before(found, name, value, over)
        if before is not None:
            flag = f"--{name.replace('_', '-')}"
            raise ParameterError(f"{flag} is {_said(value)}, and the run in {found.directory} has {before}: {_ONLY}")


def _said(value: Any) -> str:
    return shown(" ".join(value) if isinstance(value, list) else value)


def _before(found: Resumed, name: str, value: Any, over: Collection[str] = ()) -> str | None:
    """What the run has where a flag says something else; None where it says the same, or is none of those that a run's bits depend on."""
    evolution, task = found.evolution, found.task
    if name in RAISED or name in _LIMITS:
        return None
    same: dict[str, Any] = {
        **{field.name: getattr(evolution.settings, field.name) for field in dataclasses.fields(Settings)},
        "task": task.name, "cells": task.development.max_cells, "starts": task.starts, "seed": evolution.seed, "scheme": evolution.scheme,
        "rig": found.rig,
    }
    if name in same:
        return None if value == same[name] else shown(same[name])
    if name == "out":
        return None if os.path.realpath(value) == os.path.realpath(found.directory) else f"the directory {found.directory}"
    if name == "start":
        genomes = [load_genome(Path(place, "champion.yaml") if os.path.isdir(place) else place) for place in value]
        return None if genomes == list(evolution.start) else (", ".join(found.sources) or "none")
    if name == "world":
        return None if with_world(task, value) == task else "another one"
    if name in ("set", "preset", "plant"):
        changes = dict(pairs(value)) if name == "set" else preset(value) if name == "preset" else plant_settings(value, True)
        for setting, new in changes.items():
            if (name == "set" or setting not in over) and with_settings(task, {setting: new}) != task:
                return f"{setting} = {shown(setting_of(task, setting.removeprefix('task.')))}"
    return None


def explicit(parser: argparse.ArgumentParser, arguments: list[str]) -> dict[str, Any]:
    """The flags that a command line gives, without defaults."""
    nothing = argparse.Namespace(**{action.dest: None for action in parser._actions})
    return {name: value for name, value in vars(parser.parse_args(arguments, nothing)).items() if value is not None}
