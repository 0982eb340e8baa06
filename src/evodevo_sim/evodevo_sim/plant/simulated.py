"""The simulated body as a plant: activation in, positions and velocities out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..brain.chance import normal
from ..brain.scent import Signals
from ..development.body import Body
from ..kernels.jit import kernel, lean, seam
from ..physics.bounds import find_drag_rate
from ..physics.control_step import advance, relax
from ..physics.forces import Law, Ramp, Scratch, accelerations, make_law, make_scratch, set_rest_lengths
from ..physics.step_size import MOST_SUBSTEPS, choose_substeps, substeps_at_rate
from .contract import Outcome
from .muscles import Muscles, follow, hold, make_muscles, steady

RELAX_TOLERANCE = 1e-3  # m/s^2
RELAX_LIMIT = 2000
_STILL = 1e-7  # m/s and m/s^2 below which a body rests


class BodyState(NamedTuple):
    """A body that moves.  Control steps change rest, position, velocity and what muscles hold; the rest is scratch or stays."""

    body: Body
    law: Law
    rest: np.ndarray  # (E,) m, rest lengths that the muscles go to, and hold when they are there
    before: np.ndarray  # (E,) m, those that they come from in this control step
    position: np.ndarray  # (2, N) m
    velocity: np.ndarray  # (2, N) m/s
    scratch: Scratch
    substeps: int  # of Lawson's method in a control step at rest; 0 where there is no body to move, or it needs more than MOST_SUBSTEPS
    finer: float  # times as many, rounded up, for an audit
    halt: np.ndarray  # (1,) int64: where not 0, nobody waits for its life any more, which then ends at once, wherever it is
    muscles: Muscles


@kernel
def make_body_state(body, material, scene, control_step, finer, moves, halt, actuators):
    """A body where it grew, at rest.

    Args: finer, halt: see `BodyState`; moves: whether it has chambers to move with; actuators: see `muscles.Actuators`."""
    law, springs, position = make_law(material, scene), body.rest_length.size, body.position.T.copy()
    substeps = choose_substeps(body, law, control_step) if moves else 0
    return BodyState(
        body, law, np.empty(springs), np.empty(springs), position, np.zeros(position.shape), make_scratch(body),
        substeps if substeps <= MOST_SUBSTEPS else 0, finer, halt, make_muscles(actuators, body.position.shape[0]),
    )


@lean
def come_to_shape(state, activation):
    """Let a newborn body come to rest in the shape that its muscles hold."""
    muscles = state.muscles
    if muscles.held.size:
        hold(muscles, activation)
    set_rest_lengths(state.body, state.law, muscles.held[0] if muscles.held.size else activation, state.rest)
    relax(state.body, state.law, state.rest, state.position, state.velocity, RELAX_TOLERANCE, RELAX_LIMIT, state.scratch)


@lean
def actuate(state, activation, signals, step):
    """Set the rest lengths that a control step goes to by the activation (N,) asked for, equation (1); see `_actuate_late` where a muscle
    has another."""
    for e in range(state.rest.size):
        state.before[e] = state.rest[e]
    if state.muscles.held.size or signals.noise.size:
        _actuate_late(state, activation, signals, step)
    else:
        set_rest_lengths(state.body, state.law, activation, state.rest)


@seam
def _actuate_late(state, activation, signals, step):
    """The same by what actuators make of it, and where there is noise of actuation by a disturbed one, which stays in [-1, 1]."""
    muscles, had = state.muscles, state.scratch.k1[0]
    if muscles.held.size:
        follow(muscles, activation, step)
    for i in range(activation.size):
        had[i] = muscles.held[0, i] if muscles.held.size else activation[i]
        if signals.noise.size and signals.noise[2] > 0.0:
            had[i] = min(max(had[i] + signals.noise[2] * normal(signals.random), -1.0), 1.0)
    set_rest_lengths(state.body, state.law, had, state.rest)


@lean
def move(state, seconds):
    """Carry a swimming body over a control step.  Returns: SOUND, or what was wrong.  `physics.bounds.find_drag_rate` comes first."""
    substeps = int(np.ceil(state.finer * substeps_at_rate(seconds, state.substeps, state.scratch)))
    ramp = Ramp(state.before, state.rest, 0.0)
    return advance(state.body, state.law, ramp, state.position, state.velocity, seconds, substeps, state.scratch)


@lean
def rests(state, activation, step):
    """Whether nothing moves, nor is about to while the same activation (N,) is asked, from a control step on."""
    most, scratch = 0.0, state.scratch
    if not steady(state.muscles, activation, step):
        return False
    accelerations(state.body, state.law, state.rest, state.position, state.velocity, scratch, scratch.k1)
    for a in range(2):
        for i in range(state.position.shape[1]):
            most = max(most, abs(state.velocity[a, i]), abs(scratch.k1[a, i]))
    return most < _STILL


@lean
def swim_step(state, activation, signals, seconds, step):
    """One control step of a swimming body, in place.  Returns: SOUND, or what was wrong."""
    find_drag_rate(state.body, state.law, state.position, state.velocity, state.scratch)
    actuate(state, activation, signals, step)
    return move(state, seconds)


def read_only(array: np.ndarray) -> np.ndarray:
    """A view of an array that cannot be written to."""
    view = array.view()
    view.flags.writeable = False
    return view


def remembered(state: BodyState) -> list[tuple[np.ndarray, np.ndarray]]:
    """What control steps change of a body, each with a copy of what it is now."""
    return [(array, array.copy()) for array in (state.rest, state.position, state.velocity, state.muscles.held)]


def restore(arrays: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """Set arrays to their copies."""
    for array, copy in arrays:
        array[...] = copy


class SwimmingBody:
    """A simulated body in a fluid: a `Plant`.  Args: state: changed in place; signals: noise of actuation goes on with the brain's."""

    def __init__(self, state: BodyState, signals: Signals):
        self.state, self._signals = state, signals
        self.body = state.body
        self.position, self.velocity = read_only(self.state.position.T), read_only(self.state.velocity.T)
        self._start, self._steps, self._asked = remembered(self.state), 0, np.zeros(len(self.position))

    def move(self, activation: np.ndarray, seconds: float) -> Outcome:
        self._asked[...] = activation
        self._steps += 1
        return Outcome(swim_step(self.state, self._asked, self._signals, seconds, self._steps - 1))

    def reset(self) -> None:
        restore(self._start)
        self._steps = 0

    def rests(self) -> bool:
        return bool(rests(self.state, self._asked, self._steps))
