"""Growth alone, shapes and keys of animals: one key, one evaluation."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from evodevo_sim.development.shape import asymmetry, elongation, same_shape, shape_distance, share_of_chambers, sprawl
from evodevo_sim.genetics.elements import HEADER, MORPHOGEN, REGULATORY, SPECIAL
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.tasks.grown import animal_key, grow
from genomes import FAR, dividing, pulsing, random_genomes, ring
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Genome, Status, Task, evaluate, load_champion, perform, random_genome

SHORT = {"control_steps": 200}
SWIM = with_settings(Task(), {**SHORT, "windows": 2})
TASKS = (
    SWIM,
    with_settings(SWIM, {"development.variant": "graph_at_end", "development.max_cells": 12}),
    with_settings(SWIM, {"noise.concentrations": 0.05, "noise.actuation": 0.1}),
    with_settings(default_task("walk"), {**SHORT, "starts": 1, "windows": 2}),
    with_settings(default_task("chemotaxis"), {**SHORT, "chemotaxis.least_distance": 0.0, "chemotaxis.pairs": 1}),
)
GRID = np.array([(x, y) for x in range(8) for y in range(2)], float)


def inserted(genome, rng):
    """The genome with a unit in it that nothing reads and that reads nothing, so that the units behind it have other numbers."""
    begins = np.flatnonzero((genome.kind == REGULATORY) & (np.append(SPECIAL, genome.kind[:-1]) != REGULATORY))
    at = int(rng.choice([*begins, len(genome)])) if len(begins) else len(genome)
    place = rng.uniform(2, 3, 2) * FAR * 100
    new = ((REGULATORY, MORPHOGEN), rng.choice((-1, 1), 2), place[:1].repeat(2) + (0, FAR), place[1:].repeat(2))
    return Genome(*(np.concatenate((old[:at], added, old[at:])) for old, added in zip(genome.arrays(), new)))


def scaled(genome, rng):
    """The genome with points moved that no affinity reaches, if there are any; else one element moved by 0.1."""
    x, y = genome.x.copy(), genome.y.copy()
    alone = [i for i in range(HEADER, len(genome)) if np.sort(np.hypot(x - x[i], y - y[i]))[1] > 12.0]
    i = int(rng.choice(alone or range(len(genome))))
    x[i] += 0.1
    return Genome(genome.kind, genome.sign, x, y)


@given(random_genomes(12), st.sampled_from(TASKS), st.integers(0, 2**16))
@settings(max_examples=40, deadline=None)
def test_genomes_of_one_key_have_the_same_bits(genome, task, seed):
    rng = np.random.default_rng(seed)
    first = evaluate(genome, task, seed)
    assert animal_key(inserted(genome, rng), task) == animal_key(genome, task)
    for other in (inserted(genome, rng), scaled(genome, rng), scaled(inserted(genome, rng), rng)):
        if animal_key(other, task) == animal_key(genome, task):
            assert evaluate(other, task, seed) == first


@pytest.mark.parametrize("task", TASKS, ids=lambda task: f"{task.name} {task.development.variant}")
def test_mutants_of_a_champion_with_its_key_have_its_bits_and_those_with_other_bits_another_key(task):
    name = {"walk": "walker", "chemotaxis": "seeker"}.get(task.name, "peristalsis")
    parent, rng = load_champion(name), np.random.default_rng(5)
    key, first = animal_key(parent, task), evaluate(parent, task)
    equal = 0
    for _ in range(12):
        other = scaled(parent, rng)
        equal += animal_key(other, task) == key
        assert animal_key(other, task) != key or evaluate(other, task) == first
    silent = inserted(parent, rng)
    assert animal_key(silent, task) == key and evaluate(silent, task) == first
    assert equal < 12


def test_what_never_lives_is_one_animal_by_its_size():
    pair = with_settings(Task(), {"development.max_cells": 2})
    still = Genome(*(values[:HEADER] for values in random_genome(np.random.default_rng(0)).arrays()))
    found = grow(dividing(), pair)
    assert (found.status, found.cells, found.springs, found.chambers) == (Status.NO_CHAMBER, 2, 1, 0)
    assert found.key != grow(dividing(), SWIM).key
    lone = [grow(Genome(still.kind, still.sign, still.x + k * np.arange(HEADER) * FAR, still.y)) for k in (1, 2)]
    assert [one.status for one in lone] == [Status.NO_GROWTH] * 2 and lone[0].key == lone[1].key


def test_a_task_that_may_look_at_the_genome_keeps_genomes_apart(monkeypatch):
    from evodevo_sim import task_kinds

    kind = task_kinds.TaskKind("long", "long genomes", run=lambda genome, *_: len(genome), begin="", kernel="kernel.swim")
    monkeypatch.setitem(task_kinds._kinds, "long", kind)
    task, one = with_settings(SWIM, {"name": "long"}), ring()
    assert animal_key(one, task) == animal_key(ring(), task) != animal_key(inserted(one, np.random.default_rng(1)), task)


@pytest.mark.parametrize("genome", [ring(), pulsing(), dividing()], ids=("ring", "pulsing", "dividing"))
def test_growth_alone_is_that_of_an_evaluation(genome):
    grown, life = grow(genome, SWIM), perform(genome, SWIM)
    assert np.array_equal(grown.position, life.growth[-1][: grown.cells])
    metrics = life.evaluation.metrics
    assert (grown.cells, grown.springs, grown.chambers) == (metrics.cells, metrics.springs, metrics.chambers)
    with ThreadPoolExecutor(2) as pool:
        assert [one.key for one in pool.map(lambda _: grow(genome, SWIM), range(4))] == [grown.key] * 4


@given(st.integers(0, 2**32), st.floats(-10, 10), st.booleans(), st.integers(2, 40))
@settings(max_examples=60, deadline=None)
def test_a_shape_is_the_same_wherever_it_is_and_however_it_is_turned(seed, turn, mirrored, cells):
    rng = np.random.default_rng(seed)
    body = rng.uniform(-1, 1, (cells, 2)) * (5.0, 2.0)
    c, s = np.cos(turn), np.sin(turn)
    other = rng.permutation(body * (1, -1 if mirrored else 1)) @ np.array([(c, s), (-s, c)]) + rng.uniform(-100, 100, 2)
    assert shape_distance(body, other) < 1e-6 and same_shape(body, other)
    assert shape_distance(body, other) == pytest.approx(shape_distance(other, body), abs=1e-9)
    for measure in (elongation, sprawl, asymmetry):
        assert measure(other) == pytest.approx(measure(body), rel=1e-6, abs=1e-6)


def test_measures_of_known_shapes():
    chain = np.column_stack((np.arange(32.0), np.zeros(32)))
    assert elongation(GRID) > 2.0 and elongation(chain) > 30.0 > 25.0 > elongation(chain[:20])
    assert asymmetry(GRID) < 1e-9 and asymmetry(np.vstack((GRID, [(7, 2), (7, 3), (7, 4)]))) > 0.1
    assert sprawl(chain) > 2 * sprawl(GRID) and 0.8 < sprawl(np.zeros((1, 2))) < 1.2
    assert share_of_chambers(32, 59) == 1.0
    assert shape_distance(GRID, GRID + 0.05 * np.random.default_rng(0).normal(size=GRID.shape)) < 0.1
    assert not same_shape(GRID, chain) and not same_shape(GRID, GRID[:4]) and not same_shape(GRID, GRID[:0])
