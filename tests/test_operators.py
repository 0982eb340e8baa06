"""Genetic operators: what they may change, and that the header always stays whole and in place."""

import numpy as np
import pytest
from evodevo_ga.operators import crossover, delete, duplicate, flip, mutate_points, tournament
from evodevo_sim.genetics.elements import HEADER, SPECIAL
from genomes import hand_made, random_genomes
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import random_genome

seeds = st.integers(0, 2**32)


def elements(genome):
    return list(zip(*(array.tolist() for array in genome.arrays())))


@given(random_genomes(), random_genomes(), seeds)
def test_operators_keep_the_header_and_their_parents(mother, father, seed):
    rng = np.random.default_rng(seed)
    before = mother.key(), father.key()
    for child in (
        mutate_points(mother, rng, 0.5, 3.0), flip(mother, rng, 0.5), duplicate(mother, rng, 2.6), delete(mother, rng, 2.6),
        crossover(mother, father, rng),
    ):
        assert (child.kind[:HEADER] == SPECIAL).all() and (child.kind[HEADER:] != SPECIAL).all()
    assert (mother.key(), father.key()) == before


@given(random_genomes(), seeds)
def test_duplication_inserts_a_copy_of_a_run(genome, seed):
    child = duplicate(genome, np.random.default_rng(seed), 2.6)
    before, after = elements(genome), elements(child)
    added = len(after) - len(before)
    assert added >= (len(before) > HEADER)
    places = [p for p in range(HEADER, len(before) + 1) if after[:p] == before[:p] and after[p + added :] == before[p:]]
    assert any(after[p : p + added] == before[f : f + added] for p in places for f in range(HEADER, len(before) - added + 1)) or not added


@given(random_genomes(), seeds)
def test_deletion_removes_one_run(genome, seed):
    before, after = elements(genome), elements(delete(genome, np.random.default_rng(seed), 2.6))
    removed = len(before) - len(after)
    assert removed >= (len(before) > HEADER)
    assert any(after == before[:p] + before[p + removed :] for p in range(HEADER, len(before) + 1))


@given(random_genomes(), seeds)
def test_points_move_and_nothing_else(genome, seed):
    child = mutate_points(genome, np.random.default_rng(seed), 0.3, 3.0)
    assert np.array_equal(child.kind, genome.kind) and np.array_equal(child.sign, genome.sign)


def test_point_mutation_has_its_rate_and_length():
    genome = random_genome(np.random.default_rng(0), 990)
    child = mutate_points(genome, np.random.default_rng(1), 0.1, 3.0)
    length = np.hypot(child.x - genome.x, child.y - genome.y)
    moved = length > 0
    assert moved.mean() == pytest.approx(0.1, abs=0.02)
    assert np.sqrt(np.mean(length[moved] ** 2)) == pytest.approx(3.0, rel=0.15)
    angle = np.arctan2(child.y - genome.y, child.x - genome.x)[moved]
    assert abs(np.exp(1j * angle).mean()) < 0.1


def test_runs_are_geometric_with_their_mean():
    genome = random_genome(np.random.default_rng(0), 1000)
    rng = np.random.default_rng(2)
    added = [len(duplicate(genome, rng, 2.6)) - len(genome) for _ in range(2000)]
    assert np.mean(added) == pytest.approx(2.6, rel=0.1) and min(added) == 1


@given(random_genomes(), random_genomes(), seeds)
def test_crossover_makes_nothing_up(mother, father, seed):
    child = crossover(mother, father, np.random.default_rng(seed))
    from_parents = set(elements(mother)) | set(elements(father))
    assert set(elements(child)) <= from_parents
    for place, element in enumerate(elements(child)[:HEADER]):
        assert element in (elements(mother)[place], elements(father)[place])


@given(random_genomes(), seeds)
def test_crossover_with_itself_changes_nothing(genome, seed):
    assert crossover(genome, genome, np.random.default_rng(seed)) == genome


def test_tournament_prefers_the_better_by_its_size():
    rng = np.random.default_rng(0)
    fitness = np.arange(10.0)
    won = np.array([tournament(fitness, rng, 2) for _ in range(20000)])
    assert np.mean(won == 9) == pytest.approx(1 - (9 / 10) ** 2, abs=0.01)
    assert {tournament(fitness, rng, 1) for _ in range(300)} == set(range(10))


@settings(max_examples=10)
@given(seeds)
def test_operators_of_rate_zero_do_nothing(seed):
    genome, rng = hand_made(), np.random.default_rng(seed)
    assert mutate_points(genome, rng, 0.0, 3.0) is genome and flip(genome, rng, 0.0) is genome
    assert duplicate(genome, rng, 2.6) is genome and delete(genome, rng, 2.6) is genome
