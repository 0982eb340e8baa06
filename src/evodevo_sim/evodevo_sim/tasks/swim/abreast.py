"""Swims of one animat abreast: towards several targets, from the same birth.  Each has the bits of `kernel.course` alone.

    copies = make_copies(life, eyes)
    begin(copies, life, count)                  # at birth; their targets and random numbers come next
    courses(life, model, rules, copies, paths)  # their paths; copies.status, copies.step and copies.active tell the rest
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...brain.abreast import sense_abreast
from ...brain.brain import Brain
from ...brain.controller import Rules, brain_rests, brain_step
from ...brain.eyes import Eyes
from ...brain.scent import Signals, scent_row
from ...kernels.jit import inlined, kernel, seam
from ...kernels.lanes import aligned
from ...physics.abreast import COPIES, Abreast, go_along, make_abreast, put_copy, put_rest, set_out, set_rest_abreast, take_copy, take_rest
from ...physics.bounds import find_drag_rate
from ...physics.mass import centre_of_mass
from ...physics.soundness import SOUND
from ...plant.abreast import move_abreast
from ...plant.muscles import Muscles
from ...plant.simulated import BodyState, actuate, rests
from ..ends import OK, RESTING, end_of
from ..life import activity, forget, widen
from .kernel import LOOK


class Copies(NamedTuple):
    """Four copies of an animat.  The first dimension of all is 4, the others are those of `Brain`, `BodyState`, `Signals` and `Eyes`."""

    abreast: Abreast
    table: np.ndarray
    past: np.ndarray
    drive: np.ndarray
    activation: np.ndarray
    held: np.ndarray
    target: np.ndarray
    random: np.ndarray
    seen: np.ndarray
    activation_range: np.ndarray  # see `life.Kept`
    outcome: np.ndarray  # int64: of a control step
    status: np.ndarray  # int64: how each swim ended
    step: np.ndarray  # int64: control step that it reached
    active: np.ndarray  # see `swim.Swim`
    end: np.ndarray  # m: the centre of mass where a swim ended early


@kernel
def make_copies(life, eyes):
    """Room for four copies of an animat.  Args: eyes: with which it sees."""
    brain, held = life.brain, life.state.muscles.held
    rows, cells, past, seen = brain.table.shape[0], brain.activation.size, brain.past.shape, eyes.seen.shape
    width, nodes = brain.table.shape[1], brain.drive.shape[0]
    return Copies(
        abreast=make_abreast(life.state.body), table=aligned(COPIES * rows, width).reshape(COPIES, rows, width),
        past=np.empty((COPIES, past[0], past[1], past[2])),
        drive=aligned(COPIES * nodes, brain.drive.shape[1]).reshape(COPIES, nodes, brain.drive.shape[1]),
        activation=np.empty((COPIES, cells)), held=np.empty((COPIES, held.shape[0], held.shape[1])), target=np.zeros((COPIES, 4)),
        random=np.zeros((COPIES, 2), np.uint64), seen=np.full((COPIES, seen[0], seen[1]), np.nan),
        activation_range=np.empty((COPIES, 2, cells)), outcome=np.zeros(COPIES, np.int64), status=np.zeros(COPIES, np.int64),
        step=np.zeros(COPIES, np.int64), active=np.zeros(COPIES), end=np.zeros((COPIES, 2)),
    )


@kernel
def begin(copies, life, count):
    """Let the first few copies be as an animat is now, which has been put back to its birth."""
    abreast, brain, state = copies.abreast, life.brain, life.state
    find_drag_rate(state.body, state.law, state.position, state.velocity, state.scratch)
    copies.seen[:] = np.nan
    for k in range(COPIES):
        own = k < count
        abreast.of[k], copies.status[k] = k if own else 0, OK if own else RESTING
        copies.step[k], copies.active[k], abreast.rate[k] = 0, 1.0, state.scratch.rate[0]
        put_copy(abreast, k, state.position, state.velocity)
        put_rest(abreast, k, state.rest)
        if own:
            copies.table[k][:], copies.past[k][:], copies.activation[k][:] = brain.table, brain.past, brain.activation
            copies.held[k][:] = state.muscles.held


@inlined
def _brain_of(brain, copies, k):
    return Brain(
        brain.network, brain.units, copies.table[k], copies.past[k], brain.delay, brain.start, brain.neighbour, brain.born,
        copies.drive[k], brain.spread, copies.activation[k],
    )


@inlined
def _state_of(state, copies, k):
    """The muscles of a copy in the one body that all take turns to have."""
    muscles = Muscles(copies.held[k], state.muscles.share, state.muscles.most, state.muscles.resolution)
    return BodyState(
        state.body, state.law, state.rest, state.before, state.position, state.velocity, state.scratch, state.substeps, state.finer,
        state.halt, muscles,
    )


@inlined
def _rules_of(rules, copies, k):
    signals, eyes = rules.signals, rules.signals.eyes
    own = Eyes(copies.seen[k], eyes.noise, eyes.resolution, eyes.lost)
    return Rules(rules.control_step, rules.development, rules.continual, Signals(copies.target[k], signals.noise, copies.random[k], own))


@inlined
def _act(life, step, rules, copies):
    """The brains of all copies that move, and what their muscles make of it."""
    brain, state, abreast, signals = life.brain, life.state, copies.abreast, rules.signals
    clear = not signals.noise.size and not signals.eyes.seen.size
    if clear:
        sense_abreast(copies.table, scent_row(brain.units), abreast, copies.target, brain.activation.size)
    late = copies.held.size or signals.noise.size
    set_out(abreast)
    for k in range(COPIES):
        if copies.status[k] == OK:
            own, mine = _brain_of(brain, copies, k), _rules_of(rules, copies, k)
            if clear:
                brain_step(own, state.position, rules, step)  # it has smelt
            else:
                take_copy(abreast.state, k, state.position, state.velocity)
                brain_step(own, state.position, mine, step)
            if late:
                actuate(_state_of(state, copies, k), own.activation, mine.signals, step)
                put_rest(abreast, k, state.rest)
    if late:
        for lane in range(COPIES):
            if abreast.of[lane] != lane:
                take_rest(abreast.rest, abreast.of[lane], state.rest)
                put_rest(abreast, lane, state.rest)
    else:
        set_rest_abreast(state.body, state.law, copies.activation, abreast)


@seam
def _rests(life, step, rules, copies, k):
    """Whether nothing of a copy will ever change again: see `kernel.locomote`."""
    state, brain = _state_of(life.state, copies, k), _brain_of(life.brain, copies, k)
    if not brain_rests(brain, _rules_of(rules, copies, k)):
        return False
    take_rest(copies.abreast.rest, k, state.rest)
    take_copy(copies.abreast.state, k, state.position, state.velocity)
    return rests(state, brain.activation, step)


@seam
def _end(life, status, step, copies, k):
    """A copy moves no more: how it ended is noted, and lanes like its own go along with one that still moves."""
    state, goes = life.state, COPIES
    take_copy(copies.abreast.state, k, state.position, state.velocity)
    copies.end[k, 0], copies.end[k, 1] = centre_of_mass(state.position, state.body.inverse_mass)
    copies.status[k], copies.step[k], copies.active[k] = status, step, 0.0
    for lane in range(COPIES - 1, -1, -1):
        if copies.status[lane] == OK:
            goes = lane
    if goes < COPIES:
        for lane in range(COPIES):
            if copies.status[lane] != OK:
                go_along(copies.abreast, lane, goes)


@seam
def locomote_abreast(life, step, until, rules, copies):
    """`kernel.locomote` of all copies that move, which are left in `copies`; what `life` holds is scratch."""
    status, outcome, late, moving = copies.status, copies.outcome, copies.held.size > 0, 0
    for k in range(COPIES):
        moving += status[k] == OK
    while step < until and moving and not life.state.halt[0]:
        _act(life, step, rules, copies)
        move_abreast(life.state, copies.abreast, rules.control_step, outcome)
        step += 1
        for k in range(COPIES):
            if status[k] != OK:
                continue
            if outcome[k] != SOUND:
                _end(life, end_of(outcome[k]), step - 1, copies, k)
                moving -= 1
                continue
            widen(copies.activation_range[k], copies.held[k, 0] if late else copies.activation[k])
            if step % LOOK == 0 and _rests(life, step, rules, copies, k):
                _end(life, RESTING, step, copies, k)
                moving -= 1


@seam
def courses(life, model, rules, copies, paths):
    """`kernel.course` of all copies, without stakes.

    Args: paths (count, S + 1, 2): as many as were begun with; rules: of all of them; their targets, random numbers and eyes are their own.
    """
    task, state = model.task, life.state
    count, samples, length = paths.shape[0], (paths.shape[1] - 1) // task.windows, task.control_steps // task.windows
    for row in range(paths.shape[1]):
        if row > 0:
            window, sample = (row - 1) // samples, (row - 1) % samples
            if sample == 0:
                for k in range(count):
                    forget(copies.activation_range[k])
            first = window * length + length * sample // samples
            locomote_abreast(life, first, window * length + length * (sample + 1) // samples, rules, copies)
        for k in range(count):
            if copies.status[k] == OK:
                take_copy(copies.abreast.state, k, state.position, state.velocity)
                copies.end[k, 0], copies.end[k, 1] = centre_of_mass(state.position, state.body.inverse_mass)
                if row > 0 and row % samples == 0:
                    working = activity(copies.activation_range[k], task.full_activity)[1]
                    copies.active[k] = min(copies.active[k], working / model.development.max_cells)
            paths[k, row, 0], paths[k, row, 1] = copies.end[k, 0], copies.end[k, 1]
