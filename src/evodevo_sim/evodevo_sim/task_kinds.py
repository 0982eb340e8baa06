"""What a task is, in one type, and the table of all tasks.  Whoever needs to know what a task does asks here, not for its name.

    register(TaskKind("climb", "gain height on steps", run="my_tasks.climb:run", ...))      # docs/guide/task.md

Functions may be named as "module:function", so that this table loads nothing until somebody needs it.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

PLUGINS = "evodevo_sim.tasks"  # entry points, each a module that registers tasks when it is imported
VARIABLE = "EVODEVO_TASKS"  # environment variable: more such modules, separated by commas

Reference = Callable[..., Any] | str


@dataclass(frozen=True)
class TaskKind:
    """A kind of task.

    Attributes:
        name: as `--task` takes it; what: it asks for, in a few words.
        run(genome, task, seed, finer, track, activations) -> Evaluation: see `tasks.swim.fitness.run`; finer: a float.
        begin(genome, task, seed) -> (status, brain.controller.Controller, plant.Plant): an animat at its birth, for a life step by step.
        audit(genome, task, seed, first, most_change, quick) -> Audit: whether a fitness stands, see `tasks.audit`; None: it has none yet.
        kernel: module.function of the kernel that takes longest to compile; audit_kernel: the same of what audits need beyond it.
        defaults: settings that differ from those of `Task`, as `with_settings` takes them.
        has_ground: whether it happens on the ground of its scene, with gravity; has_target: whether there is a scent.
        fitnesses: what may be counted, as `task.fitness` names it, the usual one first.
        unused: settings that must stay 0, and why.
        needed: settings of which one must be above 0, and why.
        search: numbers of the genetic algorithm that differ for it; scheme: the search that suits it, by name; refining: that
            which suits it where genomes to begin from are given, empty: the same.
    """

    name: str
    what: str
    run: Reference
    begin: Reference
    kernel: str
    audit: Reference | None = None
    audit_kernel: str = ""
    defaults: Mapping[str, object] = field(default_factory=dict)
    has_ground: bool = False
    has_target: bool = False
    fitnesses: tuple[str, ...] = ("sustained",)
    unused: Mapping[str, str] = field(default_factory=dict)
    needed: tuple[str, ...] = ()
    needed_because: str = ""
    search: Mapping[str, float] = field(default_factory=dict)
    scheme: str = "panmictic"
    refining: str = ""

    def __post_init__(self):
        for name in ("defaults", "unused", "search"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def function(self, name: str) -> Callable[..., Any]:
        """One of run, begin and audit, imported where it is given by name."""
        given = getattr(self, name)
        if not isinstance(given, str):
            return given
        module, _, attribute = given.partition(":")
        return getattr(importlib.import_module(module), attribute)


_FLUID = ("scene.drag_normal", "scene.drag_tangential")
_NO_FLUID = "without a fluid nothing can swim"
_HERE = f"{__package__}.tasks"
_REPEAT = "replayed_motion.repeat"
_kinds: dict[str, TaskKind] = {}
_loaded: set[str] = set()


def register(kind: TaskKind) -> None:
    """Add a kind of task.  Raises ValueError where another one has its name."""
    if kind.name in _kinds and _kinds[kind.name] != kind:
        raise ValueError(f"a task {kind.name!r} is registered already: choose another name")
    _kinds[kind.name] = kind


def names() -> tuple[str, ...]:
    """The names of all tasks, those of this package first."""
    _load_plugins()
    return tuple(_kinds)


def kind_of(name: str) -> TaskKind | None:
    """The kind of a name, or None."""
    if name not in _kinds:
        _load_plugins()
    return _kinds.get(name)


def _load_plugins() -> None:
    """Import the modules that register further tasks, each once."""
    from importlib.metadata import entry_points  # a tenth of a second that those who need no other task do not wait

    wanted = [name.strip() for name in os.environ.get(VARIABLE, "").split(",") if name.strip()]
    for module in [*(entry.module for entry in entry_points(group=PLUGINS)), *wanted]:
        if module not in _loaded:
            _loaded.add(module)
            importlib.import_module(module)


register(TaskKind(
    "swim", "swim far, and on to the end",
    run=f"{_HERE}.swim.fitness:run", begin=f"{_HERE}.swim.fitness:begin",
    audit=f"{_HERE}.swim.audit:audit", kernel="kernel.swim", audit_kernel=_REPEAT, needed=_FLUID, needed_because=_NO_FLUID, scheme="archive",
    fitnesses=("sustained", "distance"),
))
register(TaskKind(
    "walk", "walk far from where it came to rest",
    run=f"{_HERE}.walk.fitness:run", begin=f"{_HERE}.walk.fitness:begin",
    audit=f"{_HERE}.walk.audit:audit", kernel="kernel.walk", scheme="archive",
    defaults={"scene.drag_normal": 0.0, "scene.drag_tangential": 0.0, "scene.gravity": 5.0, "scene.friction": 0.8},
    has_ground=True, fitnesses=("sustained", "distance"), unused={"noise.sensing": "which has no scent"},
    needed=("scene.gravity",), needed_because="a walker would never come to rest on the ground",
))
register(TaskKind(
    "chemotaxis", "swim to targets on either side",
    run=f"{_HERE}.chemotaxis.fitness:run", begin=f"{_HERE}.swim.fitness:begin",
    audit=f"{_HERE}.chemotaxis.audit:audit", kernel="kernel.trials", audit_kernel=_REPEAT, has_target=True, needed=_FLUID, needed_because=_NO_FLUID,
    scheme="archive", refining="panmictic", search={"scent_extent": 6.0, "scent_mutation": 0.25, "point_mutation": 0.015, "point_scale": 0.7},
))
