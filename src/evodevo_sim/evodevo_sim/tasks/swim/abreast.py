"""Swims of one animat abreast: towards several targets, from the same birth.  Each has the bits of `kernel.course` alone.

    copies = make_copies(life)                  # at birth
    begin(copies, life, signals, count)         # as many as are to swim, each with signals of its own
    courses(life, model, copies, paths)         # their paths; copies.status, copies.step and copies.active tell the rest
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...brain.brain import Brain
from ...brain.controller import Rules, brain_rests, brain_step
from ...brain.eyes import Eyes
from ...brain.scent import Signals
from ...kernels.jit import inlined, kernel, lean, seam
from ...kernels.lanes import aligned
from ...physics.abreast import COPIES, Abreast, make_abreast
from ...physics.bounds import find_drag_rate
from ...physics.mass import centre_of_mass
from ...physics.soundness import SOUND
from ...plant.abreast import copy_of, move_abreast
from ...plant.simulated import actuate, rests
from ..ends import OK, RESTING, end_of
from ..life import Life, activity, forget, widen
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
        activation=np.empty((COPIES, cells)), held=np.empty((COPIES, held.shape[0], held.shape[1])), target=np.empty((COPIES, 4)),
        random=np.empty((COPIES, 2), np.uint64), seen=np.full((COPIES, seen[0], seen[1]), np.nan),
        activation_range=np.empty((COPIES, 2, cells)), outcome=np.zeros(COPIES, np.int64), status=np.zeros(COPIES, np.int64),
        step=np.zeros(COPIES, np.int64), active=np.zeros(COPIES),
    )


@inlined
def _life_of(life, copies, k):
    brain = life.brain
    return Life(
        Brain(
            brain.network, brain.units, copies.table[k], copies.past[k], brain.delay, brain.start, brain.neighbour, brain.born,
            copies.drive[k], brain.spread, copies.activation[k],
        ),
        copy_of(life.state, copies.abreast, copies.held, k),
    )


@inlined
def _rules_of(rules, copies, k):
    signals, eyes = rules.signals, rules.signals.eyes
    own = Eyes(copies.seen[k], eyes.noise, eyes.resolution, eyes.lost)
    return Rules(rules.control_step, rules.development, rules.continual, Signals(copies.target[k], signals.noise, copies.random[k], own))


@kernel
def begin(copies, life, count):
    """Let the first few copies be as an animat is now, which has been put back to its birth; their targets and random numbers come next."""
    abreast, brain, state = copies.abreast, life.brain, life.state
    find_drag_rate(state.body, state.law, state.position, state.velocity, state.scratch)
    for k in range(COPIES):
        own = k < count
        abreast.of[k], copies.status[k] = k if own else 0, OK if own else RESTING
        copies.step[k], copies.active[k] = 0, 1.0
        if own:
            abreast.position[k][:], abreast.velocity[k][:], abreast.rest[k][:] = state.position, state.velocity, state.rest
            copies.table[k][:], copies.past[k][:], copies.activation[k][:] = brain.table, brain.past, brain.activation
            copies.held[k][:] = state.muscles.held
            abreast.rate[k] = state.scratch.rate[0]


@lean
def _end(copies, k, status, step):
    """A copy moves no more; its lane goes with one that does."""
    of = copies.abreast.of
    copies.status[k], copies.step[k], copies.active[k] = status, step, 0.0
    goes = COPIES
    for other in range(COPIES - 1, -1, -1):
        if copies.status[other] == OK:
            goes = other
    if goes < COPIES:
        for lane in range(COPIES):
            if copies.status[lane] != OK:
                of[lane] = goes


@seam
def locomote_abreast(life, step, until, rules, copies):
    """`kernel.locomote` of all copies that move.  Returns: whether any still does."""
    abreast, moving = copies.abreast, True
    while step < until and moving:
        if life.state.halt[0]:
            return True
        for k in range(COPIES):
            if copies.status[k] == OK:
                own, mine = _life_of(life, copies, k), _rules_of(rules, copies, k)
                brain_step(own.brain, own.state.position, mine, step)
                actuate(own.state, own.brain.activation, mine.signals, step)
        move_abreast(life.state, abreast, rules.control_step, copies.outcome)
        step += 1
        moving = False
        for k in range(COPIES):
            if copies.status[k] == OK:
                if copies.outcome[k] != SOUND:
                    _end(copies, k, end_of(copies.outcome[k]), step - 1)
                    continue
                own = _life_of(life, copies, k)
                widen(copies.activation_range[k], own.state.muscles.held[0] if own.state.muscles.held.size else own.brain.activation)
                if step % LOOK == 0 and brain_rests(own.brain, _rules_of(rules, copies, k)) and rests(own.state, own.brain.activation, step):
                    _end(copies, k, RESTING, step)
                    continue
                moving = True
    return moving


@seam
def courses(life, model, rules, copies, paths):
    """`kernel.course` of all copies, without stakes.

    Args: paths (count, S + 1, 2): as many as were begun with; rules: of all of them; their targets, random numbers and eyes are their own.
    """
    task, inverse_mass = model.task, life.state.body.inverse_mass
    count, samples = paths.shape[0], (paths.shape[1] - 1) // task.windows
    length, position, moving = task.control_steps // task.windows, copies.abreast.position, True
    for k in range(count):
        paths[k, 0, 0], paths[k, 0, 1] = centre_of_mass(position[k], inverse_mass)
    for window in range(task.windows):
        for k in range(count):
            forget(copies.activation_range[k])
        for sample in range(samples):
            row = window * samples + sample + 1
            first, until = window * length + length * sample // samples, window * length + length * (sample + 1) // samples
            if moving:
                moving = locomote_abreast(life, first, until, rules, copies)
            for k in range(count):
                x, y = centre_of_mass(position[k], inverse_mass)
                paths[k, row, 0], paths[k, row, 1] = x, y
        for k in range(count):
            if copies.status[k] == OK:
                working = activity(copies.activation_range[k], task.full_activity)[1]
                copies.active[k] = min(copies.active[k], working / model.development.max_cells)
