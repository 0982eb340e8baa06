"""Bodies for tests: random and hand-made ones, and their state as the physics holds it."""

import numpy as np
from evodevo_sim.body import build_body
from evodevo_sim.gabriel import adjacency, gabriel_graph
from evodevo_sim.physics import Law, make_scratch

LAW = Law(400.0, 10.0, 400.0, 100.0, 0.5)
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
    from evodevo_sim.physics import accelerations

    out = np.full(position.shape, np.nan)
    accelerations(body, law, rest, position, velocity, make_scratch(body), out)
    return out
