"""Niches of body shapes: each keeps its own best, so that shapes which start slowly have their time."""

import numpy as np
import pytest
from evodevo_ga.niches import niche_of
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from hypothesis import given
from hypothesis import strategies as st
from test_evolution import run

from evodevo_ga import Evolution, Settings
from evodevo_sim import Evaluation, Metrics, Status, random_genome

NICHED = Settings(population=30, niches=3, elite=2, tournament=2, generations=40, point_scale=0.5)
COMPACT, SLENDER = Metrics(cells=32, chambers=46), Metrics(cells=32, chambers=30)


def lattice(columns, rows):
    """Cells and chambers of a body on a triangular lattice."""
    position = np.array([(c + 0.5 * (r % 2), r * np.sqrt(0.75)) for r in range(rows) for c in range(columns)])
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    body = build_body(position, edges, start, neighbour, 1.0)
    return Metrics(cells=len(position), chambers=body.triangle_area.size + body.polygon_area.size)


def test_slender_bodies_are_in_low_niches_and_compact_ones_in_high_ones():
    shapes = [lattice(*shape) for shape in ((16, 2), (10, 3), (8, 4), (6, 6))]
    niches = [niche_of(metrics, 5) for metrics in shapes]
    assert niches == sorted(niches) and niches[0] == 1 and niches[-1] == 4 and len(set(niches)) >= 3
    assert niche_of(Metrics(), 5) == niche_of(Metrics(cells=3), 5) == 0
    assert niche_of(Metrics(cells=32, chambers=1), 5) == 0  # a ring
    assert {niche_of(metrics, 1) for metrics in shapes} == {0}


@given(st.integers(0, 100), st.integers(0, 200), st.integers(1, 20))
def test_niches_follow_the_number_of_chambers_and_there_is_one_for_every_body(cells, chambers, niches):
    here, more = (niche_of(Metrics(cells=cells, chambers=k), niches) for k in (chambers, chambers + 1))
    assert 0 <= here <= more < niches


def by_shape(genome):
    """Compact bodies are good at once and never better; slender ones begin badly and get better as points near the origin."""
    slender = genome.x[0] < 0.0
    return Evaluation(float(-np.hypot(genome.x, genome.y).mean()) if slender else 1.0, Status.OK, "", SLENDER if slender else COMPACT)


def best_slender(evolution):
    return max((one.evaluation.fitness for one in evolution.population if one.evaluation.metrics == SLENDER), default=-np.inf)


def test_a_shape_that_starts_slowly_lives_and_climbs_only_in_a_niche():
    niched, whole = Evolution(NICHED, 3), run(Settings(population=30, generations=40, point_scale=0.5), 3, by_shape)[0]
    best = []
    while not niched.finished:
        niched.tell([by_shape(genome) for genome in niched.ask()])
        best.append(best_slender(niched))
        fitness = [one.evaluation.fitness for one in niched.population]
        assert fitness == sorted(fitness, reverse=True)
        assert all(sum(one.evaluation.metrics == shape for one in niched.population) <= 10 for shape in (SLENDER, COMPACT))
    assert np.all(np.diff(best) >= 0) and best[-1] > best[0] + 0.15
    assert best_slender(whole) == -np.inf


def test_niches_give_the_same_run_in_any_order_of_evaluation():
    one, history = run(NICHED, 5, by_shape)
    two, again = run(NICHED, 5, by_shape, order=lambda n: np.random.default_rng(n).permutation(n))
    assert history == again and one.champion.genome == two.champion.genome


@pytest.mark.parametrize("settings", [Settings(population=30, founders=100), Settings(population=30, founders=100, layers=3), NICHED])
def test_the_best_of_many_founders_stay(settings):
    evolution = Evolution(settings, 1)
    founders = evolution.ask()
    assert len(founders) == max(30, settings.founders) == len({genome.key() for genome in founders})
    scores = [by_shape(genome) for genome in founders]
    generation = evolution.tell(scores)
    assert generation.evaluations == len(founders) and len(evolution.population) <= 30
    assert evolution.champion.evaluation.fitness == max(one.fitness for one in scores)
    assert len(evolution.ask()) <= 30  # later generations are as large as the population


def test_scales_of_mutation_spread_over_the_decades_below():
    """The moves of a child share a scale; over many children its logarithm is even."""

    first = random_genome(np.random.default_rng(4))

    def mean_moves(decades):
        settings = Settings(
            population=400, point_mutation=1.0, point_scale=1.0, point_decades=decades, crossover=0.0, flip=0.0, duplication=0.0,
            deletion=0.0, start_share=1.0, founders=400,
        )
        parent, *children = Evolution(settings, 2, [first]).ask()
        assert parent == first
        return np.array([np.hypot(child.x - parent.x, child.y - parent.y).mean() for child in children])

    one, spread = mean_moves(0.0), mean_moves(2.0)
    assert one.min() > 0.5 and one.max() < 1.1  # the mean of |N(0, 1)| is 0.8
    assert np.quantile(np.log10(spread / 0.8), [0.0, 0.25, 0.5, 0.75, 1.0]) == pytest.approx([-2.0, -1.5, -1.0, -0.5, 0.0], abs=0.2)
