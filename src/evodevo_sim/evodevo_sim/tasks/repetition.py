"""What audits are made of: lives and motions repeated in finer steps, or by another method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..parameters import Task
from ..physics.forces import make_law
from ..physics.integrators import State, make_system, make_work
from ..physics.replayed_motion import Method, repeat


class Way(NamedTuple):
    """A way to repeat a life.  method: see `physics.step_size`; finer: times as many substeps; tolerance: of the adaptive method,
    m and m/s;    ledger: whether to keep one; anew: whether the whole life, genes and all, or the motion by the same muscles."""

    name: str
    method: int
    finer: float
    tolerance: float
    ledger: bool
    anew: bool


@dataclass(frozen=True, eq=False)
class Run:
    """name; fitness, m; change of it, relative to the run as evolved; sustained, m: the part of fitness that is motion,
    windows x slowest window, or the plain distance where that is the fitness; ledger: J by muscles, drag, damping, ground, or
    empty; gap: energy that the ledger does not explain, relative to what drag and damping took; chamber: least S / S0; cause: why
    it failed; near: last distance of each target, m."""

    name: str
    fitness: float
    change: float
    sustained: float
    ledger: tuple[float, ...]
    gap: float
    chamber: float
    cause: str = ""
    near: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion repeated: path (points + 1, 2) m of the centre of mass; ledger, gap, chamber: see `Run`; outcome: SOUND or not."""

    path: np.ndarray
    ledger: tuple[float, ...]
    gap: float
    chamber: float
    outcome: int


def repeat_motion(body: Any, task: Task, substeps: int, start: np.ndarray, activation: np.ndarray, way: Way, points: int) -> Motion:
    """Repeat a motion from rest, by the same muscles.

    Args: substeps: at rest; start (N, 2) m; activation (T + 1, N); points: of the path, after the start.
    """
    system = make_system(body, make_law(task.material.arguments(), task.scene.arguments()))
    lengths = system.rest.copy(), system.rest.copy()
    system = system._replace(before=lengths[0], after=lengths[1], seconds=task.control_step)
    ledger, path = np.zeros(4 if way.ledger else 0), np.zeros((points + 1, 2))
    state = State(np.ascontiguousarray(start.T), np.zeros((2, len(start))), ledger)
    method = Method(way.method, substeps, way.finer, way.tolerance)
    outcome, gain, chamber = repeat(system, method, task.control_step, activation, state, make_work(body), path)
    gap = abs(gain - ledger.sum()) / max(abs(ledger[1:]).sum(), 1e-12) if way.ledger else 0.0
    return Motion(path, tuple(ledger.tolist()), float(gap), float(chamber), outcome)
