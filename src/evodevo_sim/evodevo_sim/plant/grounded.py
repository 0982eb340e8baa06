"""The simulated body on the ground as a plant: symplectic Euler with exact contact (`physics.integrators.euler`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..brain.scent import Signals
from ..kernels.jit import inlined, kernel, lean, seam
from ..physics.grounded_steps import alike_in, are_alike, go_alike, go_soundly_alike
from ..physics.integrators import System, Work, euler
from ..physics.ladder import MOST_DOUBLINGS, Ladder, again, remember
from ..physics.soundness import SOUND, judge
from ..physics.step_size import MOST_SUBSTEPS, choose_walk_steps
from .contract import Outcome
from .muscles import steady
from .simulated import BodyState, actuate, read_only, remembered, restore

_STILL = 1e-7  # m/s below which nothing moves any more


class GroundedState(NamedTuple):
    """A body that moves on the ground of its scene."""

    state: BodyState
    system: System
    work: Work
    steps: int  # of physics in a control step
    born: np.ndarray  # (2, N) m: place of the cells before they are turned and laid down
    ledger: np.ndarray  # see `physics.energy`, or empty


@kernel
def make_grounded_state(state, scene, terrain, control_step, finer, moves, ledger):
    """A newborn body, to be laid on the ground.  Args: finer: times as many steps of physics, rounded up; moves: whether it can."""
    cells, none = state.position.shape[1], np.empty(0)
    system = System(
        body=state.body, law=state.law, gravity=scene.gravity, friction=scene.friction, ground=True, terrain=terrain, amplitude=none,
        frequency=none, phase=none, muscle=none, rest=state.rest,
        before=none, after=none, seconds=control_step,
    )
    work = Work(state.scratch, np.empty((0, 2, cells)), np.empty((1, 2, cells)), np.zeros(4))
    steps = int(np.ceil(finer * choose_walk_steps(system, control_step))) if moves else 0
    return GroundedState(state, system, work, steps, state.position.copy(), ledger)


@inlined
def move(grounded, seconds):
    """Carry the body over one control step.  Returns: SOUND, or what was wrong."""
    state, system, steps = grounded.state, grounded.system, grounded.steps
    if are_alike(system, grounded.ledger) and go_soundly_alike(
        alike_in(system, state.scratch), seconds / steps, steps, state.position, state.velocity
    ):
        return SOUND
    return _move_carefully(grounded, seconds)


@seam
def _move_carefully(grounded, seconds):
    """The same; where a try is not sound, again with twice the steps: see `physics.ladder`."""
    state, system, work, ledger = grounded.state, grounded.system, grounded.work, grounded.ledger
    position, velocity, scratch = state.position, state.velocity, state.scratch
    ladder = Ladder(MOST_DOUBLINGS, MOST_SUBSTEPS)
    remember(position, velocity, ledger, scratch)
    doubling, steps = 0, grounded.steps
    while True:
        h = seconds / steps
        if are_alike(system, ledger):
            go_alike(alike_in(system, scratch), h, steps, position, velocity)
        else:
            for _ in range(steps):
                euler(system, 0.0, h, position, velocity, work, ledger)
        outcome = judge(state.body, position, velocity, h, scratch)
        if not again(outcome, doubling, steps, ladder, position, velocity, ledger, scratch):
            return outcome
        doubling, steps = doubling + 1, 2 * steps


@lean
def fastest(velocity):
    """The square of the largest speed of any cell."""
    most = 0.0
    for i in range(velocity.shape[1]):
        most = max(most, velocity[0, i] * velocity[0, i] + velocity[1, i] * velocity[1, i])
    return most


@lean
def lies_still(grounded, activation, step):
    """Whether nothing moves any more while the same activation (N,) is asked, from a control step on."""
    return fastest(grounded.state.velocity) < _STILL * _STILL and steady(grounded.state.muscles, activation, step)


@lean
def walk_step(grounded, activation, signals, seconds, step):
    """One control step of a body on the ground, in place.  Returns: SOUND, or what was wrong."""
    actuate(grounded.state, activation, signals, step)
    return move(grounded, seconds)


class WalkingBody:
    """A simulated body on the ground: a `Plant`.  Args: see `simulated.SwimmingBody`."""

    def __init__(self, grounded: GroundedState, signals: Signals):
        self.grounded, self.state, self._signals = grounded, grounded.state, signals
        self.body = self.state.body
        self.position, self.velocity = read_only(self.state.position.T), read_only(self.state.velocity.T)
        self._start, self._steps, self._asked = remembered(self.state), 0, np.zeros(len(self.position))

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        self._asked[...] = activation
        self._steps += 1
        return Outcome(walk_step(self.grounded, self._asked, self._signals, seconds, self._steps - 1))

    def reset(self) -> None:
        restore(self._start)
        self._steps = 0

    def rests(self) -> bool:
        return bool(lies_still(self.grounded, self._asked, self._steps))
