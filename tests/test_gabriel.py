"""The Gabriel graph three ways: of all triples, by a tree, and kept up to date while cells move."""

import numpy as np
import pytest
from evodevo_sim.development.gabriel import adjacency, follow, gabriel_edges, gabriel_graph
from evodevo_sim.development.gabriel_tree import TIE, tree_edges
from hypothesis import given, settings
from hypothesis import strategies as st


def of_all_triples(p):
    """Edges (E, 2) by the definition with a closed circle, in the order of arithmetic of the kernels."""
    p, at = np.asarray(p, float), np.arange(len(p))
    d = p[:, None] - p[None]  # d[i, k]
    dot = d[:, None, :, 0] * d[None, :, :, 0] + d[:, None, :, 1] * d[None, :, :, 1]
    dot[at, :, at], dot[:, at, at] = np.inf, np.inf
    free = np.all(dot > TIE * (d[..., 0] ** 2 + d[..., 1] ** 2)[..., None], axis=2)
    return np.argwhere(np.triu(free, 1))


def by_tree(p):
    edges = np.empty((3 * len(p) + 1, 2), np.int64)
    return edges[: tree_edges(p, edges)]


def lattice(rng, n):
    columns = int(rng.integers(1, n + 1))
    at = np.arange(n)
    square = np.column_stack((at % columns, at // columns)).astype(float)
    skew, turn = rng.choice((0.0, 0.5)), rng.choice((0.0, 0.3, np.pi / 4))
    square = square @ np.array([[1.0, 0.0], [skew, 1.0]]) @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return rng.permutation(square) * rng.choice((1.0, 0.1)) + rng.choice((0.0, 1e4))


def on_a_circle(rng, n):
    angle = rng.choice((2 * np.pi / n, 0.7)) * np.arange(n)
    return np.column_stack((np.cos(angle), np.sin(angle)))


SETS = {
    "random": lambda rng, n: rng.uniform(-3, 3, (n, 2)),
    "lattice": lattice,
    "lattice but for rounding": lambda rng, n: lattice(rng, n) + rng.normal(0, 1e-13, (n, 2)),
    "collinear": lambda rng, n: rng.uniform(-3, 3, (n, 1)) * rng.choice((0.0, 0.3, 1.0), (1, 2)),
    "on a circle": on_a_circle,
    "with coincident cells": lambda rng, n: rng.integers(0, 6, (n, 2)).astype(float),
    "of many scales": lambda rng, n: np.exp(rng.normal(0, 4, (n, 2))),
}


@pytest.mark.parametrize("name", SETS)
@settings(max_examples=30, deadline=None)
@given(cells=st.integers(1, 70), seed=st.integers(0, 2**32))
def test_a_tree_finds_the_graph_of_all_triples(name, cells, seed):
    p = np.ascontiguousarray(SETS[name](np.random.default_rng(seed), cells))
    expected = of_all_triples(p).tolist()
    assert by_tree(p).tolist() == expected
    assert gabriel_graph(p).tolist() == expected


@pytest.mark.parametrize("name", SETS)
def test_many_cells_have_the_same_graph_by_a_tree(name):
    p = np.ascontiguousarray(SETS[name](np.random.default_rng(1), 300))
    edges = np.empty((3 * len(p) + 1, 2), np.int64)
    count = gabriel_edges(p, len(p), np.zeros((len(p), len(p)), np.int32), edges)
    assert gabriel_graph(p).tolist() == edges[:count].tolist()


@pytest.mark.parametrize("name", SETS)
@settings(max_examples=20, deadline=None)
@given(cells=st.integers(1, 40), seed=st.integers(0, 2**32), scale=st.sampled_from([1e-12, 1e-6, 1e-3, 0.1]))
def test_following_moving_cells_gives_the_graph_from_nothing(name, cells, seed, scale):
    """Moves that shrink to nothing, as in growth, so that most rows are not looked at; now and then there is a new cell."""
    rng = np.random.default_rng(seed)
    p = np.ascontiguousarray(SETS[name](rng, cells))
    holds, witness = np.full(cells, -1.0), np.zeros((cells, cells), np.int32)
    edges, spare = np.empty((3 * cells + 1, 2), np.int64), np.empty((3 * cells + 1, 2), np.int64)
    present, count, travelled, before = max(1, cells // 2), 0, 0.0, []
    for step in range(30):
        if present < cells and rng.random() < 0.3:
            present += 1
            holds[:present] = -1.0
        count, changed = follow(p, present, travelled, holds, witness, edges, count, spare)
        now = edges[:count].tolist()
        assert now == gabriel_graph(p[:present]).tolist() and changed == (now != before)
        before = now
        move = scale * 0.8**step * rng.normal(0, 1, p.shape)
        p += move
        travelled += 1.001 * np.linalg.norm(move, axis=1).max() + 1e-11


def test_rows_are_not_looked_at_again_before_cells_have_moved_far():
    p = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.9], [1.5, 0.9]])
    holds, witness, edges = np.full(4, -1.0), np.zeros((4, 4), np.int32), np.empty((13, 2), np.int64)
    count, _ = follow(p, 4, 0.0, holds, witness, edges, 0, edges.copy())
    assert holds.min() > 0.05
    p[:] = 0.0  # a lie: the cells did move
    assert follow(p, 4, 0.05, holds, witness, edges, count, edges.copy()) == (count, False)


def test_adjacency_lists_hold_every_edge_from_both_ends():
    edges = gabriel_graph(np.random.default_rng(3).uniform(-3, 3, (50, 2)))
    start, neighbour = np.zeros(51, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), 50, start, neighbour)
    pairs = [(i, int(j)) for i in range(50) for j in neighbour[start[i] : start[i + 1]]]
    assert sorted(pairs) == sorted([tuple(e) for e in edges.tolist()] + [tuple(e[::-1]) for e in edges.tolist()])
