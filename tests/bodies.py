"""Bodies for tests of physics, and ways to run them."""

import numpy as np
from evodevo_sim.body import build_body
from evodevo_sim.gabriel import adjacency, gabriel_graph
from evodevo_sim.integrators import carry, carry_adaptively, make_system, make_work
from evodevo_sim.physics import Law
from evodevo_sim.stability import ADAPTIVE, RK4

STEP = 1 / 60  # s, of control
SWIM = Law(400.0, 10.0, 400.0, 100.0, 0.5)
ALONE = Law(400.0, 0.0, 400.0, 0.0, 0.0)
NO_LEDGER = np.zeros(0)


def body_of(position, mass=1.0):
    """The body of the Gabriel graph of these cells."""
    position = np.asarray(position, float)
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.int64)
    adjacency(edges, len(edges), len(position), start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


def slab(columns=8, rows=4, seed=0):
    """A body like those that grow: cells in a hexagonal slab, shaken a little."""
    shake = np.random.default_rng(seed).normal(0, 0.06, (columns * rows, 2))
    return body_of(np.array([(x + 0.5 * (y % 2), 0.87 * y) for y in range(rows) for x in range(columns)]) + shake)


def wave(body, amplitude=0.4, frequency=1.0, turn=1.0):
    """Muscles of a wave that travels along a body: (amplitude, frequency, phase), (N,) each."""
    ones = np.ones(len(body.position))
    return amplitude * ones, frequency * ones, -turn * body.position[:, 0]


def chain(length, velocity, law, drive=None, mass=1.0):
    """Two cells on a spring of rest length 1 along x, `length` apart.  Returns: (system, position, velocity)."""
    body = body_of([(0, 0), (1, 0)], mass)
    return make_system(body, law, drive=drive), np.array([[0.0, 0], [length, 0]]), np.array(velocity, float)


def go(system, method, steps, intervals, position=None, velocity=None, interval=STEP, ledger=NO_LEDGER):
    """Run from a state, or from rest.  Args: steps: in an interval, or the tolerance.  Returns: (position, velocity)."""
    p = (system.body.position if position is None else position).copy()
    v = np.zeros_like(p) if velocity is None else velocity.copy()
    work, h = make_work(len(p)), interval / 10
    for k in range(intervals):
        if method == ADAPTIVE:
            outcome, h, _ = carry_adaptively(system, k * interval, interval, steps, h, p, v, work, ledger)
            assert outcome == 0
        else:
            carry(system, method, k * interval, interval, steps, p, v, work, ledger)
    return p, v


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
