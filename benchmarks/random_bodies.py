"""Bodies, muscles and parameters at random, for stress: fair ones as growth leaves them, and all that could go wrong with a shape."""

from __future__ import annotations

import dataclasses

import numpy as np
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from evodevo_sim.own_body.planar import coincident
from evodevo_sim.parameters import Material, Scene

SHAPES = ("grown", "cloud", "clusters", "lattice", "needle", "ring", "sparse")
MUSCLES = ("held", "sine", "jumps")
STEP = (1e-9, 1.0)  # s, of a control step: the range of Task.control_step
_DRAWN = ("mass", "stiffness", "damping", "pressure", "drag_normal", "drag_tangential")
_FAIR = 30.0  # times and divided by which half of all parameters lie about their defaults


def positions(rng, shape, cells):
    """(N, 2) m."""
    side = np.sqrt(cells)
    if shape == "grown":  # at least 0.6 apart
        found = np.empty((0, 2))
        while len(found) < cells:
            p = rng.uniform(-0.7 * side, 0.7 * side, 2)
            if not len(found) or np.hypot(*(found - p).T).min() > 0.6:
                found = np.vstack((found, p))
        return found
    if shape == "clusters":
        centres = rng.uniform(-side, side, (rng.integers(1, 5), 2))
        return centres[rng.integers(len(centres), size=cells)] + 10 ** rng.uniform(-3, 0) * rng.standard_normal((cells, 2))
    if shape == "lattice":  # with ties, or almost
        columns = int(np.ceil(side))
        points = np.array([(k % columns, k // columns) for k in range(cells)], float)
        return points + rng.choice([0.0, 1e-9, 1e-4, 0.05]) * rng.standard_normal((cells, 2))
    if shape == "needle":
        return np.column_stack((np.arange(cells) + rng.uniform(-0.3, 0.3, cells), 10 ** rng.uniform(-6, -1) * rng.standard_normal(cells)))
    if shape == "ring":
        angle = 2 * np.pi * np.arange(cells) / cells
        return cells / (2 * np.pi) * np.column_stack((np.cos(angle), np.sin(angle))) + 1e-3 * rng.standard_normal((cells, 2))
    return rng.uniform(-0.5 * side, 0.5 * side, (cells, 2))


def _thinned(rng, edges, cells):
    """A connected part of a graph: polygons of many corners, dangling edges, tails inside of chambers."""
    order, root, kept = rng.permutation(len(edges)), list(range(cells)), []

    def find(i):
        while root[i] != i:
            i = root[i]
        return i

    share = rng.random()
    for e in order:
        a, b = (find(i) for i in edges[e])
        if a != b or rng.random() < share:
            root[max(a, b)] = min(a, b)
            kept.append(e)
    return edges[np.sort(kept)]


def random_body(rng, shape=None, cells=None, mass=1.0):
    """A body of 3 to 64 cells, 0.1 to 10 times as large as its shape says in a quarter of cases; None where cells coincide."""
    shape = shape or rng.choice(SHAPES)
    cells = cells or int(np.exp(rng.uniform(np.log(3), np.log(65))))  # most of them small
    position = positions(rng, shape, cells) * (10 ** rng.uniform(-1, 1) if rng.random() < 0.25 else 1.0)
    if coincident(position):
        return None
    edges = gabriel_graph(position)
    if shape == "sparse":
        edges = _thinned(rng, edges, cells)
    start, neighbour = np.zeros(cells + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), cells, start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


def random_muscles(rng, cells, steps):
    """e - c of every cell at every control step, (steps + 1, N) in -1 .. 1: held, sines of any speed, or jumps."""
    kind, full = rng.choice(MUSCLES), rng.random() < 0.3
    k, phase = np.arange(steps + 1)[:, None], rng.uniform(0, 2 * np.pi, cells)
    if kind == "held":
        return np.repeat(rng.uniform(-1, 1, (1, cells)), steps + 1, axis=0)
    gain = np.ones(cells) if full else rng.uniform(0, 1, cells)
    wave = np.sin(2 * np.pi * k / rng.integers(2, 60) + phase)
    return gain * (wave if kind == "sine" else np.where(wave >= 0.0, 1.0, -1.0))


def _draw(rng, default, low, high, beyond):
    if beyond:
        return float(rng.choice([0.0, -1.0, np.inf, np.nan])) if rng.random() < 0.05 else float(10 ** rng.uniform(-30, 30))
    if low == 0.0 and rng.random() < 0.2:
        return 0.0
    low, high = (default / _FAIR, default * _FAIR) if rng.random() < 0.7 else (low or 1e-3, high)
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_parameters(rng, beyond=False):
    """(Material, Scene, control step in s), each number near its default, or anywhere in its range; as plain dicts if `beyond`."""
    drawn = {
        cls: {f.name: _draw(rng, f.default, *f.metadata["range"], beyond) for f in dataclasses.fields(cls) if f.name in _DRAWN}
        for cls in (Material, Scene)
    }
    step = _draw(rng, 1 / 60, *STEP, beyond)
    return drawn[Material], drawn[Scene], step if beyond else min(step, STEP[1])
