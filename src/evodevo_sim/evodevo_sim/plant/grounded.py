"""The simulated body on the ground as a plant: symplectic Euler with exact contact (`physics.integrators.euler`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..brain.scent import Signals
from ..kernels.jit import kernel, lean
from ..physics.control_step import MOST_DOUBLINGS, SOUND, copy_state, finer_may_help, judge
from ..physics.integrators import System, Work, euler
from ..physics.rates import MOST_SUBSTEPS
from ..physics.stability import EULER, bounds, longest_step
from .contract import Outcome
from .simulated import BodyState, actuate, read_only, remembered, restore

ACCURATE_EULER = 1.6  # h * (bound of the highest frequency)
LEAST_STEPS = 4  # in a control step, for contact
_SAFETY = 0.8  # of the stability limit, where damping sets it
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
def choose_walk_steps(system, control_step):
    """Steps of physics in a control step: numbers of accuracy, and of stability where damping is strong."""
    frequency, damping = bounds(system)
    need = max(control_step * frequency / ACCURATE_EULER, control_step / (_SAFETY * longest_step(EULER, frequency, damping)))
    return max(LEAST_STEPS, int(np.ceil(need)))


@kernel
def make_grounded_state(state, scene, terrain, control_step, finer, moves, ledger):
    """A newborn body, to be laid on the ground.  Args: finer: times as many steps of physics, rounded up; moves: whether it can move at all."""
    cells, none = state.position.shape[1], np.empty(0)
    system = System(state.body, state.law, scene.gravity, scene.friction, True, terrain, none, none, none, none, state.rest)
    work = Work(state.scratch, np.empty((0, 2, cells)), np.empty((1, 2, cells)), np.zeros(4))
    steps = int(np.ceil(finer * choose_walk_steps(system, control_step))) if moves else 0
    return GroundedState(state, system, work, steps, state.position.copy(), ledger)


@lean
def move(grounded, seconds):
    """Carry the body over one control step; where that is not sound, again with twice the steps: see `control_step.finer_may_help`."""
    state, system, work, ledger = grounded.state, grounded.system, grounded.work, grounded.ledger
    position, velocity, scratch = state.position, state.velocity, state.scratch
    copy_state(position, velocity, scratch.start_position, scratch.start_velocity)
    for k in range(ledger.size):
        work.power[k] = ledger[k]
    doubling, steps = 0, grounded.steps
    while True:
        h = seconds / steps
        for _ in range(steps):
            euler(system, 0.0, h, position, velocity, work, ledger)
        outcome = judge(state.body, position, velocity, h, scratch)
        if outcome == SOUND or not finer_may_help(outcome, doubling, steps, MOST_DOUBLINGS, MOST_SUBSTEPS):
            return outcome
        doubling, steps = doubling + 1, 2 * steps
        copy_state(scratch.start_position, scratch.start_velocity, position, velocity)
        for k in range(ledger.size):
            ledger[k] = work.power[k]


@lean
def fastest(velocity):
    """The square of the largest speed of any cell."""
    most = 0.0
    for i in range(velocity.shape[1]):
        most = max(most, velocity[0, i] * velocity[0, i] + velocity[1, i] * velocity[1, i])
    return most


@lean
def lies_still(grounded):
    """Whether nothing moves any more."""
    return fastest(grounded.state.velocity) < _STILL * _STILL


@lean
def walk_step(grounded, activation, signals, seconds):
    """One control step of a body on the ground, in place.  Returns: SOUND, or what was wrong."""
    actuate(grounded.state, activation, signals)
    return move(grounded, seconds)


class WalkingBody:
    """A simulated body on the ground: a `Plant`.  Args: see `simulated.SwimmingBody`."""

    def __init__(self, grounded: GroundedState, signals: Signals):
        self.grounded, self.state, self._signals = grounded, grounded.state, signals
        self.body = self.state.body
        self.position, self.velocity = read_only(self.state.position.T), read_only(self.state.velocity.T)
        self._start = remembered(self.state)

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        return Outcome(walk_step(self.grounded, np.asarray(activation), self._signals, seconds))

    def reset(self) -> None:
        restore(self._start)

    def rests(self) -> bool:
        return bool(lies_still(self.grounded))
