"""The genetic algorithm as ask/tell: selection climbs, the elite lives on, equal seeds give equal runs, the run ends."""

import numpy as np
import pytest
from evodevo_ga.layers import Layers
from evodevo_sim.genetics.elements import HEADER
from genomes import random_genomes
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_ga import Evolution, Settings, diversity
from evodevo_sim import Evaluation, Genome, Metrics, ParameterError, Status, random_genome


def evaluation(fitness):
    return Evaluation(float(fitness), Status.OK, "", Metrics())


def near_origin(genome):
    """A cheap fitness with a known best: all points at the origin."""
    return evaluation(-np.hypot(genome.x, genome.y).mean())


def run(settings, seed, score=near_origin, order=None):
    evolution, history = Evolution(settings, seed), []
    while not evolution.finished:
        asked = evolution.ask()
        indices = range(len(asked)) if order is None else order(len(asked))
        results = {i: score(asked[i]) for i in indices}
        history.append(evolution.tell([results[i] for i in range(len(asked))]))
    return evolution, history


def test_selection_climbs_and_never_loses_its_best():
    _, history = run(Settings(population=40, generations=40, point_scale=0.5), 3)
    best = [generation.best for generation in history]
    assert np.all(np.diff(best) >= 0)
    assert best[-1] > best[0] + 0.15
    assert [generation.generation for generation in history] == list(range(40))


def _shuffled(n: int) -> np.ndarray:
    return np.random.default_rng(n).permutation(n)


def test_equal_seeds_give_equal_runs_in_any_order_of_evaluation():
    settings = Settings(population=20, generations=10)
    one, history = run(settings, 5)
    two, again = run(settings, 5, order=_shuffled)
    assert history == again and one.champion.genome == two.champion.genome
    assert run(settings, 6)[1] != history


def test_nothing_known_is_evaluated_again():
    seen = []

    def score(genome):
        seen.append(genome.key())
        return near_origin(genome)

    evolution, _ = run(Settings(population=30, generations=8, point_mutation=0.01, flip=0.0), 1, score)
    assert evolution.evaluations == len(seen) < 30 * 8
    assert evolution.ask() is not None and not {g.key() for g in evolution.ask()} & {p.genome.key() for p in evolution.population}


def test_the_elite_lives_on_unchanged():
    evolution = Evolution(Settings(population=10, elite=3, generations=5), 0)
    evolution.tell([evaluation(i) for i in range(len(evolution.ask()))])
    elite = [one.genome for one in evolution.population[:3]]
    evolution.tell([evaluation(-1) for _ in evolution.ask()])
    assert [one.genome for one in evolution.population[:3]] == elite


def test_patience_ends_a_run():
    evolution, history = run(Settings(population=5, generations=1000, patience=7), 0, lambda genome: evaluation(1))
    assert len(history) == 8 and evolution.stagnation == 7


def test_equals_drift():
    evolution = Evolution(Settings(population=10, generations=5), 0)
    evolution.tell([evaluation(0) for _ in evolution.ask()])
    first = evolution.champion.genome
    evolution.tell([evaluation(0) for _ in evolution.ask()])
    assert evolution.champion.genome != first


def test_diversity_is_nought_for_clones_and_one_for_strangers():
    genomes = [random_genome(np.random.default_rng(i)) for i in range(4)]
    assert diversity([genomes[0]] * 5) == 0.0
    assert diversity(genomes) == 1.0
    assert diversity([genomes[0], genomes[0], genomes[1], genomes[1]]) == pytest.approx(2 / 3, abs=0.02)


@given(st.lists(random_genomes(3), min_size=2, max_size=6), st.data())
@settings(max_examples=40, deadline=None)
def test_diversity_counts_the_pairs_that_share_an_element_whatever_its_mark(genomes, data):
    index = st.integers(0, len(genomes) - 1)
    for _ in range(data.draw(st.integers(0, 4))):  # some have elements of others, some twice, some with a zero of the other sign
        one, other = genomes[data.draw(index)], genomes[data.draw(index)]
        x = np.where(np.arange(len(other)) % 3 == 0, -0.0, other.x) if data.draw(st.booleans()) else other.x
        columns = zip(one.arrays(), (other.kind, other.sign, x, other.y))
        genomes.append(Genome(*(np.concatenate((a, b[HEADER:], b[HEADER:])) for a, b in columns)))
        genomes.append(Genome(one.kind, one.sign, one.x * 0.0, -one.y * 0.0))
    sets = [set(zip(*(values.tolist() for values in genome.arrays()))) for genome in genomes]
    shared = sum(len(a & b) for k, a in enumerate(sets) for j, b in enumerate(sets) if k != j)
    right = 1.0 - shared / ((len(sets) - 1) * sum(map(len, sets)))
    assert diversity(genomes) == right
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("evodevo_ga.likeness._marks", lambda kind, *_: np.zeros(len(kind), np.uint64))  # all collide
        assert diversity(genomes) == right


@pytest.mark.parametrize(
    "bad, says",
    [
        (dict(population=1), "settings.population"),
        (dict(elite=100), "settings.elite is 100"),
        (dict(crossover=1.5), "settings.crossover"),
        (dict(point_scale=float("nan")), "settings.point_scale"),
        (dict(generations=2.5), "settings.generations is 2.5: give a whole number"),
    ],
)
def test_settings_that_cannot_work_are_named(bad, says):
    with pytest.raises(ParameterError, match=says):
        Settings(**bad)


def test_a_wrong_number_of_evaluations_is_refused():
    evolution = Evolution(Settings(population=5))
    evolution.ask()
    with pytest.raises(ValueError, match="3 evaluations for 5 genomes"):
        evolution.tell([evaluation(0)] * 3)


def test_a_run_begins_from_given_genomes_their_mutants_and_random_ones():
    given = [random_genome(np.random.default_rng(k), 3) for k in (1, 2)]
    moved = Settings(population=20, start_share=0.5, point_mutation=1.0)  # so that no mutant is its parent
    asked, again = (Evolution(moved, 7, given).ask() for _ in range(2))
    assert asked == again and len(asked) == 20 and asked[:2] == given
    # Mutants differ from their parents by a run of a few elements at the most, and are as far from random ones of 20 units.
    assert all(abs(len(genome) - len(given[k % 2])) < 20 for k, genome in enumerate(asked[:10]))
    assert min(len(genome) for genome in asked[10:]) > 20 + max(map(len, given))
    for share, kept in ((0.0, 2), (1.0, 20)):
        asked = Evolution(Settings(population=20, start_share=share, point_mutation=1.0), 7, given).ask()
        assert sum(len(genome) < 20 + max(map(len, given)) for genome in asked) == kept
    assert Evolution(Settings(population=20), 7).ask() == Evolution(Settings(population=20), 7, ()).ask()


def test_scent_points_scatter_farther_in_the_first_population_alone():
    given = [random_genome(np.random.default_rng(1), 3)]
    first = Evolution(Settings(population=40, scent_extent=6.0), 7, given).ask()
    assert first[0] == given[0]
    points = np.array([(genome.x[3], genome.y[3]) for genome in first[1:]])
    assert np.abs(points).max() <= 6.0 and np.abs(points).mean() > 2.0


def test_the_scents_point_moves_in_its_share_of_children():
    settings = Settings(population=100, scent_mutation=0.3, point_mutation=0.0, flip=0.0, crossover=0.0, start_share=1.0)
    given = [random_genome(np.random.default_rng(1), 3)]
    others = Evolution(settings, 7, given).ask()[1:]
    moved = [genome for genome in others if genome.x[3] != given[0].x[3]]
    assert 15 < len(moved) < 45 and all(np.array_equal(genome.x[:3], given[0].x[:3]) for genome in others)
    assert 0 < sum(genome.sign[3] != given[0].sign[3] for genome in moved) < 12


LAYERED = Settings(population=30, layers=3, elite=2, age_gap=4, generations=41)
LIMITS = (4, 8, np.inf)  # ages below which the three layers are open


def generations_of(settings, seed, score=near_origin):
    """Yields the evolution after each generation."""
    evolution = Evolution(settings, seed)
    while not evolution.finished:
        evolution.tell([score(genome) for genome in evolution.ask()])
        yield evolution


def test_layers_hold_their_share_and_nobody_who_is_too_old():
    for evolution in generations_of(LAYERED, 1):
        fitness = [one.evaluation.fitness for one in evolution.population]
        assert fitness == sorted(fitness, reverse=True)
        for layer, limit in enumerate(LIMITS):
            ages = [evolution.generation - one.born for one in evolution.population if one.layer == layer]
            assert len(ages) <= 10 and all(0 <= age < limit for age in ages)


def test_the_layers_open_at_1_2_4_9_and_16_gaps():
    layers = Layers(Settings(layers=5, age_gap=10))
    first = [next(age for age in range(1000) if layers.layer_of(age) == layer) for layer in range(5)]
    assert first == [0, 10, 20, 40, 90] and layers.layer_of(10**9) == 4
    assert Layers(Settings(layers=1)).layer_of(10**9) == 0


def test_random_genomes_fill_the_youngest_layer_at_every_gap():
    for evolution in generations_of(LAYERED, 2):
        youngest = [one for one in evolution.population if one.layer == 0]
        assert {one.born for one in youngest} == {evolution.generation - evolution.generation % 4}
        if evolution.generation % 4 == 0:
            assert len(youngest) == 10 and diversity([one.genome for one in youngest]) == 1.0


def test_layers_never_lose_the_best_and_climb():
    best = [evolution.champion.evaluation.fitness for evolution in generations_of(LAYERED, 3)]
    assert np.all(np.diff(best) >= 0) and best[-1] > best[0] + 0.1


def test_an_old_line_cannot_reach_the_young_ones():
    """A genome that is far better than all others, at the top, has no children below it."""
    hero = random_genome(np.random.default_rng(9))
    settings = Settings(population=20, layers=2, age_gap=6, generations=30, start_share=0.0, crossover=0.5)
    evolution = Evolution(settings, 4, [hero])
    elements = set(zip(hero.x.tolist(), hero.y.tolist()))

    def kin(genome):
        return len(elements & set(zip(genome.x.tolist(), genome.y.tolist())))

    while not evolution.finished:
        evolution.tell([evaluation(kin(genome)) for genome in evolution.ask()])
        assert not any(kin(one.genome) for one in evolution.population if one.layer == 0)
    assert sum(kin(one.genome) > 40 for one in evolution.population if one.layer == 1) >= 5


def test_layers_keep_diversity_where_one_population_loses_it():
    layered = run(Settings(population=60, layers=3, age_gap=10, generations=60), 5)[1][-1].diversity
    whole = run(Settings(population=60, generations=60), 5)[1][-1].diversity
    assert layered > whole + 0.2


def test_layers_give_the_same_run_in_any_order_of_evaluation():
    one, history = run(LAYERED, 5)
    two, again = run(LAYERED, 5, order=_shuffled)
    assert history == again and one.champion.genome == two.champion.genome


def test_a_layered_population_refills_when_all_have_moved_up():
    """Gap 1: all move up every generation, and every layer is bred again from those below."""
    for evolution in generations_of(Settings(population=20, layers=4, age_gap=1, elite=1, tournament=2, generations=30), 1):
        assert 5 <= len(evolution.population) <= 20
