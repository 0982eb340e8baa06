"""Loops of the benchmarks that are compiled, so that no time is measured around single calls from Python."""

import numpy as np
from evodevo_sim.brain.brain import think
from evodevo_sim.brain.controller import Rules
from evodevo_sim.brain.eyes import Eyes
from evodevo_sim.brain.scent import Signals
from evodevo_sim.development.gabriel import follow
from evodevo_sim.genetics.regulation import exchange, regulate
from evodevo_sim.kernels.jit import kernel, lean
from evodevo_sim.physics.bounds import find_drag_rate
from evodevo_sim.physics.control_step import advance
from evodevo_sim.physics.forces import Ramp, accelerations
from evodevo_sim.physics.integrators import State, carry, carry_adaptively, set_muscles
from evodevo_sim.physics.soundness import judge
from evodevo_sim.physics.step_size import ADAPTIVE, substeps_at_rate
from evodevo_sim.plant.simulated import actuate
from evodevo_sim.tasks.life import Kept
from evodevo_sim.tasks.swim.kernel import locomote


@lean
def many_accelerations(body, law, rest, position, velocity, scratch, out, calls):
    for _ in range(calls):
        accelerations(body, law, rest, position, velocity, scratch, out)


@lean
def many_checks(body, position, velocity, h, scratch, calls):
    outcome = 0
    for _ in range(calls):
        outcome += judge(body, position, velocity, h, scratch)
    return outcome


@lean
def many_regulations(network, table, drive, start, neighbour, share, rate, cells, calls):
    for _ in range(calls):
        exchange(network, table, start, neighbour, cells, share)
        regulate(network, table, drive, cells, rate)


@lean
def many_graphs(position, moves, holds, witness, edges, spare, calls):
    """Keep a graph up to date while all cells move, to and fro along moves (M, N, 2) in turn.  Returns the number of edges."""
    cells, travelled, count = position.shape[0], 0.0, 0
    for i in range(cells):
        holds[i] = -1.0
    for call in range(calls):
        count, _ = follow(position, cells, travelled, holds, witness, edges, count, spare)
        sign, move = 1.0 if call // moves.shape[0] % 2 == 0 else -1.0, moves[call % moves.shape[0]]
        most = 0.0
        for i in range(cells):
            position[i, 0] += sign * move[i, 0]
            position[i, 1] += sign * move[i, 1]
            most = max(most, move[i, 0] ** 2 + move[i, 1] ** 2)
        travelled += np.sqrt(most)
    return count


@lean
def slope(system, t, position, velocity, scratch, out):
    """The right-hand side that every integrator sees: accelerations (2, N) with driven muscles and gravity."""
    set_muscles(system, t)
    accelerations(system.body, system.law, system.rest, position, velocity, scratch, out)
    for i in range(out.shape[1]):
        out[1, i] -= system.gravity


@kernel
def travel(system, method, effort, step, intervals, position, velocity, work):
    """Carry a state over intervals of `step` seconds, in place.  Args: effort: steps in each, or the tolerance.

    Returns: force evaluations where they are counted, in adaptive steps; else 0.
    """
    state, h, used = State(position, velocity, np.empty(0)), step / 8.0, 0
    for k in range(intervals):
        if method == ADAPTIVE:
            _, h, now = carry_adaptively(system, k * step, step, effort, h, state, work)
            used += now
        else:
            carry(system, method, k * step, step, int(effort), state, work)
    return used


@kernel
def grows(system, method, h, chunks, chunk, position, most, work):
    """Whether a small displacement from rest outgrows `most` (m) within that many chunks of steps of h seconds."""
    state = State(position, np.zeros_like(position), np.empty(0))
    rest = system.body.position
    for _ in range(chunks):
        carry(system, method, 0.0, h * chunk, chunk, state, work)
        for i in range(position.shape[1]):
            if not abs(position[0, i] - rest[i, 0]) + abs(position[1, i] - rest[i, 1]) < most:
                return True
    return False


@kernel
def live_on(life, steps, seconds, development, continual):
    """Live all control steps, whether or not all rests.  Returns: (status of the last stretch, step first seen at rest or -1)."""
    kept = Kept(np.empty((2, 0)), np.empty((0, 0, 0)), np.empty((0, 0)))
    signals = Signals(np.empty(0), np.empty(0), np.zeros(2, np.uint64), Eyes(np.empty((0, 0)), 0.0, 0.0, 0.0))
    rules = Rules(seconds, development, continual, signals)
    step, status, rested = 0, 0, -1
    while step < steps:
        before = step
        status, step = locomote(life, step, steps, rules, kept)
        if step == before:  # failed
            break
        if step < steps and rested < 0:
            rested = step
    return status, rested


@kernel
def mean_substeps(life, steps, seconds, development, continual):
    """Substeps of a control step in a swim from birth, the mean of so many control steps.  No early end, no ladder."""
    total, brain, state = 0, life.brain, life.state
    signals = Signals(np.empty(0), np.empty(0), np.zeros(2, np.uint64), Eyes(np.empty((0, 0)), 0.0, 0.0, 0.0))
    body, law, scratch = state.body, state.law, state.scratch
    find_drag_rate(body, law, state.position, state.velocity, scratch)
    for step in range(steps):
        think(brain, step, development, continual)
        actuate(state, brain.activation, signals, step)
        substeps = int(np.ceil(state.finer * substeps_at_rate(seconds, state.substeps, scratch)))
        total += substeps
        advance(body, law, Ramp(state.before, state.rest, 0.0), state.position, state.velocity, seconds, substeps, scratch)
    return total / steps
