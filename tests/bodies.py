"""Bodies for tests: random and hand-made ones, their state as the physics holds it, and ways to run them."""

import numpy as np
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from evodevo_sim.physics.forces import Law, accelerations, make_scratch
from evodevo_sim.physics.integrators import State, carry, carry_adaptively, make_system, make_work
from evodevo_sim.physics.step_size import ADAPTIVE

STEP = 1 / 60  # s, of control
NO_LEDGER = np.zeros(0)
LAW = Law(400.0, 10.0, 400.0, 100.0, 0.5, 0.2)
ALONE = Law(400.0, 0.0, 400.0, 0.0, 0.0, 0.2)
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
# Of four and five corners, with a tail outside and one inside.
POLYGONS = [(0, 0), (2, 0), (2, 2), (0, 2), (3, 3), (0.7, 0.8), (4, 1)]
POLYGON_EDGES = [(0, 1), (0, 3), (0, 5), (1, 2), (1, 6), (2, 3), (2, 4), (4, 6)]


def body_of(position, edges=None, mass=1.0):
    """The body of cells at position (N, 2) on a planar graph, by default their Gabriel graph."""
    position = np.asarray(position, float)
    edges = gabriel_graph(position) if edges is None else np.array(sorted(edges), np.int64)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


def random_body(rng, cells, mass=1.0):
    """Cells at least 0.6 apart, as growth leaves them."""
    side = 1.0 + np.sqrt(cells)
    position = np.empty((0, 2))
    while len(position) < cells:
        p = rng.uniform(-side / 2, side / 2, 2)
        if not len(position) or np.linalg.norm(position - p, axis=1).min() > 0.6:
            position = np.vstack((position, p))
    return body_of(position, mass=mass)


def state_of(body, rng=None, shift=0.0, speed=0.0):
    """(position, velocity) as (2, N) arrays and rest lengths (E,): at rest, or shifted, moving and actuated at random."""
    position, velocity, rest = body.position.T.copy(), np.zeros(body.position.T.shape), body.rest_length.copy()
    if rng is not None:
        position += shift * rng.standard_normal(position.shape)
        velocity += speed * rng.standard_normal(position.shape)
        rest *= rng.uniform(0.6, 1.4, rest.shape)
    return position, velocity, rest


def accelerations_of(body, law, position, velocity, rest):
    out = np.full(position.shape, np.nan)
    accelerations(body, law, rest, position, velocity, make_scratch(body), out)
    return out


def slab(columns=8, rows=4, seed=0):
    """A body like those that grow: cells in a hexagonal slab, shaken a little."""
    shake = np.random.default_rng(seed).normal(0, 0.06, (columns * rows, 2))
    return body_of(np.array([(x + 0.5 * (y % 2), 0.87 * y) for y in range(rows) for x in range(columns)]) + shake)


def wave(body, amplitude=0.4, frequency=1.0, turn=1.0):
    """Muscles of a wave that travels along a body: (amplitude, frequency, phase), (N,) each."""
    ones = np.ones(len(body.position))
    return amplitude * ones, frequency * ones, -turn * body.position[:, 0]


def chain(length, velocity, law, drive=None, mass=1.0):
    """Two cells on a spring of rest length 1 along x, `length` apart.  Returns: (system, position, velocity), (2, 2) each."""
    body = body_of([(0, 0), (1, 0)], mass=mass)
    return make_system(body, law, drive=drive), np.array([[0.0, length], [0.0, 0.0]]), np.array(velocity, float)


def go(system, method, steps, intervals, position=None, velocity=None, interval=STEP, ledger=NO_LEDGER):
    """Run from a state (2, N), or from rest.  Args: steps: in an interval, or the tolerance.  Returns: (position, velocity)."""
    p = (system.body.position.T if position is None else position).copy()
    v = np.zeros_like(p) if velocity is None else velocity.copy()
    state, work, h = State(p, v, ledger), make_work(system.body), interval / 10
    for k in range(intervals):
        if method == ADAPTIVE:
            outcome, h, _ = carry_adaptively(system, k * interval, interval, steps, h, state, work)
            assert outcome == 0
        else:
            carry(system, method, k * interval, interval, steps, state, work)
    return p, v


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
