"""The frozen body: faces of a planar graph become chambers, what touches the outside becomes the outline."""

import numpy as np
import pytest
from bodies import body_of
from evodevo_sim.development.gabriel import gabriel_graph
from hypothesis import given, settings
from hypothesis import strategies as st


def test_a_square_with_a_tail_has_one_polygon_and_the_tail_once_on_its_outline():
    body = body_of([(0, 0), (1, 0), (1, 1), (0, 1), (2, 1)], [(0, 1), (0, 3), (1, 2), (2, 3), (2, 4)])
    assert body.triangle.shape == (0, 3) and body.polygon_area.tolist() == [1.0]
    assert sorted(map(sorted, body.outline.tolist())) == [[0, 1], [0, 3], [1, 2], [2, 3], [2, 4]]
    assert body_of([(0, 0), (1, 0)], mass=2.0).inverse_mass.tolist() == [0.5] * 2


def test_a_tail_inside_a_chamber_is_no_outline():
    body = body_of([(0, 0), (4, 0), (4, 4), (0, 4), (1, 1)], [(0, 1), (0, 3), (0, 4), (1, 2), (2, 3)])
    assert [0, 4] not in list(map(sorted, body.outline.tolist()))
    assert body.polygon_area.tolist() == [16.0]


def test_a_chain_has_no_chamber_and_is_all_outline():
    body = body_of([(0, 0), (1, 0), (2, 0)])
    assert len(body.triangle_area) == len(body.polygon_area) == 0
    assert len(body.outline) == len(body.rest_length) == 2


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 60), st.integers(0, 2**32))
def test_euler_and_area_hold_for_random_bodies(cells, seed):
    position = np.random.default_rng(seed).uniform(-4, 4, (cells, 2))
    body, edges = body_of(position), gabriel_graph(position)
    chambers = len(body.triangle_area) + len(body.polygon_area)
    assert cells - len(edges) + chambers + 1 == 2  # V - E + F of a connected planar graph
    assert (body.triangle_area > 0).all() and (body.polygon_area > 0).all()
    # The outline encloses just the chambers: Green's theorem over every edge of the outer walk.
    a, b = position[body.outline[:, 0]], position[body.outline[:, 1]]
    bridges = count_bridges(cells, edges)
    if not bridges:
        enclosed = -0.5 * np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        assert enclosed == pytest.approx(body.triangle_area.sum() + body.polygon_area.sum(), rel=1e-9)


def count_bridges(cells, edges):
    """Edges whose removal disconnects the graph, by the definition."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = 0
    for k in range(len(edges)):
        rest = np.delete(edges, k, axis=0)
        graph = coo_array((np.ones(len(rest)), rest.T), shape=(cells, cells))
        count += connected_components(graph)[0] > 1
    return count


@settings(max_examples=30, deadline=None)
@given(st.integers(2, 40), st.integers(0, 2**32))
def test_springs_are_the_edges_with_their_lengths_in_turn(cells, seed):
    position = np.random.default_rng(seed).uniform(-4, 4, (cells, 2))
    body, edges = body_of(position), gabriel_graph(position)
    springs = np.column_stack((body.spring_a, body.spring_b))
    assert np.array_equal(springs[np.lexsort(springs.T[::-1])], edges)
    assert body.rest_length == pytest.approx(np.linalg.norm(position[springs[:, 0]] - position[springs[:, 1]], axis=1))
    for cell in range(cells):  # sums over the springs of a cell have the bits of the ascending order
        own = springs[(springs == cell).any(1)]
        assert np.array_equal(own, own[np.lexsort(own.T[::-1])])


def test_springs_that_follow_each_other_seldom_share_a_cell():
    body = body_of(np.random.default_rng(1).uniform(-4, 4, (64, 2)))
    springs = np.column_stack((body.spring_a, body.spring_b))
    meet = (springs[1:, :, None] == springs[:-1, None, :]).any((1, 2))
    assert meet.mean() < 0.1


@settings(max_examples=30, deadline=None)
@given(st.integers(3, 40), st.integers(0, 2**32))
def test_springs_know_the_chambers_on_both_sides_and_the_outline_its_springs(cells, seed):
    body = body_of(np.random.default_rng(seed).uniform(-4, 4, (cells, 2)))
    corners = body.triangle.tolist() + [p.tolist() for p in np.split(body.polygon_cell, body.polygon_start[1:-1].astype(int)) if len(p)]
    walks = {(a, b): f for f, c in enumerate(corners) for a, b in zip(c, c[1:] + c[:1])}
    for a, b, left, right in zip(body.spring_a, body.spring_b, body.spring_left, body.spring_right):
        assert left == walks.get((a, b), len(corners)) and right == walks.get((b, a), len(corners))
    edges = np.column_stack((body.spring_a, body.spring_b))[body.outline_spring]
    assert np.array_equal(edges, np.sort(body.outline, axis=1))
