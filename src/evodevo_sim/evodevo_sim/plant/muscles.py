"""What actuators make of the activation asked for, in a simulated body: the law of docs/reference/plant.md, one control step at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..brain.chance import uniform
from ..kernels.jit import kernel, lean, seam

if TYPE_CHECKING:
    from ..parameters import Task

_FOLLOWED = 1e-9  # of e - c, from what a muscle goes to, that counts as there
_STRIKE = np.uint64(0x6A09E667F3BCC909)  # apart from the random numbers of noise


class Actuators(NamedTuple):
    """The actuators of a task, in control steps.  `present`: whether they do anything at all."""

    present: bool
    share: float  # of the way to what is asked, that a muscle goes in a step
    most: float  # change of e - c in a step
    resolution: float  # of e - c, 0 for none
    waits: int  # steps of dead time
    failing: np.ndarray  # (K, 2) int64: a cell, and the step from which on it does nothing, or -1
    failures: int  # so many more, by lot
    fails_at: int  # step from which on those do nothing


class Muscles(NamedTuple):
    """The muscles of a body, where actuators do not do at once what is asked; else `held` is empty."""

    held: np.ndarray  # (2 + D, N): activation; control step from which on a cell does nothing; what was asked in the last D steps
    share: float
    most: float
    resolution: float


def actuators_of(task: Task) -> Actuators:
    """The actuators of a task's rig."""
    rig, h = task.rig, task.control_step
    waits, fails_at = rig.steps(rig.dead_time, h), rig.steps(rig.fail_at, h)
    failing = [(cell, -1) for cell in rig.dead_cells] + [(cell, fails_at) for cell in rig.failing_cells]
    resolution = rig.fine(rig.resolution)
    present = bool(rig.lag or rig.rate or resolution or waits or failing or rig.failures)
    return Actuators(
        present, rig.share(h), rig.rate * h if rig.rate else np.inf, resolution, waits, np.array(failing, np.int64).reshape(-1, 2),
        rig.failures, fails_at,
    )


@kernel
def make_muscles(actuators, cells):
    """Muscles that hold nothing yet: `hold` and `strike` come next."""
    held = np.zeros((2 + actuators.waits, cells) if actuators.present else (0, 0))
    if actuators.present:
        held[1, :] = np.inf
        for k in range(actuators.failing.shape[0]):
            cell, step = actuators.failing[k]
            if cell < cells:
                held[1, cell] = min(held[1, cell], step)
    return Muscles(held, actuators.share, actuators.most, actuators.resolution)


@lean
def hold(muscles, activation):
    """Let muscles have held an activation (N,) for long."""
    held = muscles.held
    for i in range(activation.size):
        towards = settable(muscles, activation[i])
        held[0, i] = towards if held[1, i] >= 0.0 else 0.0
        for row in range(2, held.shape[0]):
            held[row, i] = towards


@kernel
def strike(muscles, actuators, seed):
    """Draw the cells that fail by lot, from those that do not fail anyway.  Args: seed: uint64."""
    held, random = muscles.held, np.array([seed ^ _STRIKE, seed ^ _STRIKE])
    for _ in range(actuators.failures):
        left = 0
        for i in range(held.shape[1]):
            left += held[1, i] == np.inf
        if left == 0:
            return
        drawn = int(uniform(random) * left)
        for i in range(held.shape[1]):
            if held[1, i] == np.inf:
                if drawn == 0:
                    held[1, i] = actuators.fails_at
                    break
                drawn -= 1


def drawn(cells: int, spared: tuple[int, ...], count: int, seed: int) -> tuple[int, ...]:
    """The cells that `strike` draws of a body of N cells, which `spared` are not among."""
    lot = Actuators(True, 1.0, np.inf, 0.0, 0, np.array([(cell, -1) for cell in spared], np.int64).reshape(-1, 2), count, 0)
    muscles = make_muscles(lot, cells)
    strike(muscles, lot, np.uint64(seed % 2**64))
    return tuple(np.flatnonzero(muscles.held[1] == 0.0).tolist())


@lean
def settable(muscles, asked):
    """What a valve can be set to, of what is asked of it."""
    if muscles.resolution > 0.0:
        asked = np.rint(asked / muscles.resolution) * muscles.resolution
    return min(max(asked, -1.0), 1.0)


@lean
def follow(muscles, asked, step):
    """One control step: `held[0]` goes to what was asked, (N,), the dead time ago."""
    held, waits = muscles.held, muscles.held.shape[0] - 2
    row = 2 + step % max(1, waits)
    for i in range(asked.size):
        towards = settable(muscles, asked[i])
        if waits:
            then = held[row, i]
            held[row, i] = towards
            towards = then
        if step >= held[1, i]:
            towards = 0.0
        change = muscles.share * (towards - held[0, i])
        if muscles.share == 1.0 and abs(change) <= muscles.most:
            held[0, i] = towards  # the same bits, where there is neither lag nor a rate that holds it back
        else:
            held[0, i] += min(max(change, -muscles.most), muscles.most)


@seam
def steady(muscles, asked, step):
    """Whether no muscle will ever change while the same (N,) is asked, from a control step on."""
    held = muscles.held
    if not held.size:
        return True
    for i in range(asked.size):
        towards = settable(muscles, asked[i])
        if held[1, i] != np.inf and held[1, i] >= step:
            return False
        for row in range(2, held.shape[0]):
            if abs(held[row, i] - towards) > _FOLLOWED:
                return False
        if abs(held[0, i] - (0.0 if step >= held[1, i] else towards)) > _FOLLOWED:
            return False
    return True


@kernel
def _follow_all(muscles, actuators, asked, seed, found):
    hold(muscles, asked[0])
    strike(muscles, actuators, seed)
    found[0] = muscles.held[0]
    for step in range(asked.shape[0] - 1):
        follow(muscles, asked[step + 1], step)
        found[step + 1] = muscles.held[0]


def muscles_had(activation: np.ndarray, task: Task, seed: int) -> np.ndarray:
    """The activation (T + 1, N) that muscles had in a life, of the one that was asked of them, both from birth on.

    Noise of actuation is not in it.  Args: seed: of the evaluation.
    """
    actuators = actuators_of(task)
    if not actuators.present:
        return activation
    found = np.empty(activation.shape)
    muscles = make_muscles(actuators, activation.shape[1])
    _follow_all(muscles, actuators, np.ascontiguousarray(activation), np.uint64(seed % 2**64), found)
    return found
