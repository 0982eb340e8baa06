"""An archive of unlike bodies: who is kept, where children come from, and the same bits whoever evaluates, and when it goes on."""

import json

import numpy as np
import pytest
from evodevo_ga.archive import Archive
from evodevo_ga.arguments import parse
from evodevo_ga.beat import Beat, activation_of, beat_of
from evodevo_ga.emitters import EMITTERS
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.individual import Child, Individual
from evodevo_ga.nursery import Nursery
from evodevo_ga.parts import entangled, graft, parts_of, random_parted, varied
from evodevo_sim.development.shape import same_shape
from evodevo_sim.genetics.elements import INPUTS, REGULATORY
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.tasks.grown import grow
from genomes import pulsing
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_ga import Evolution, Settings, scheme
from evodevo_sim import Evaluation, ParameterError, Status, load_champion, perform, random_genome

SMALL = {"development.max_cells": 9, "control_steps": 80, "windows": 2, "starts": 1}
NUMBERS = {"population": 12, "founders": 60, "generations": 3}


def task_of(name="swim"):
    return with_settings(default_task(name), SMALL)


def evolution_of(name="swim", seed=3, start=(), way="archive", **numbers):
    chosen = scheme(way, name) | NUMBERS | numbers
    return Evolution(Settings(**chosen), seed, start, way, task_of(name))


def run_on(evolution, task, generations=None, stopped=True, workers=1):
    while not evolution.finished and generations != 0:
        asked = evolution.ask()
        evolution.tell(evaluate_all(asked, task, evolution.seed, workers, evolution.bars if stopped else ()))
        generations = None if generations is None else generations - 1
    return evolution.state()


@pytest.mark.parametrize("name", ["swim", "walk", "chemotaxis"])
def test_an_archive_keeps_unlike_bodies_for_every_task_and_goes_on_to_the_same_bits(name):
    task, start = task_of(name), [random_genome(np.random.default_rng(k)) for k in (1, 2)]
    one, two = evolution_of(name, start=start), evolution_of(name, start=start)
    run_on(two, task, 1)
    resumed = Evolution.resumed(json.loads(json.dumps(two.state(), allow_nan=False)), task)
    assert resumed.state() == two.state()
    state = run_on(one, task)
    assert run_on(resumed, task) == state
    search = one.search
    kinds = [search.kind(grow(elite.genome, task)) for elite in one.population]
    assert len(set(kinds)) == len(kinds) > 3 and None not in kinds
    assert one.growths >= 60 and one.evaluations + one.growths / 8 > 12 * 2


def test_an_archive_of_gaits_keeps_each_beat_of_a_body_apart_with_the_same_bits_when_it_goes_on():
    task = task_of()
    one, two = evolution_of(way="gaits"), evolution_of(way="gaits")
    run_on(two, task, 1)
    resumed = Evolution.resumed(json.loads(json.dumps(two.state(), allow_nan=False)), task)
    assert run_on(one, task) == run_on(resumed, task, workers=2) == run_on(evolution_of(way="gaits"), task, stopped=False)
    search = one.search
    bodies = [search.nursery.grow(elite.genome) for elite in one.population]
    assert len({search.kind(body) for body in bodies}) == len(bodies) > len({search.kind_of_body(body) for body in bodies}) > 3
    assert len({body.beat for body in bodies}) > 1


def body_of(rows, columns):
    return np.array([(0.9 * x, 0.8 * y) for y in range(rows) for x in range(columns)], float)


@pytest.mark.parametrize("beat, activation", [
    (Beat.STILL, lambda t, x, y: 0.005 * np.sin(t) + 0 * x),
    (Beat.STILL, lambda t, x, y: 0.002 * t + 0 * x),
    (Beat.PART, lambda t, x, y: np.sin(t - x) * (x < 1.5)),
    (Beat.PULSE, lambda t, x, y: np.sin(t + 0.2 * x)),
    (Beat.BEND, lambda t, x, y: np.sin(t - x) * np.sign(y)),
    (Beat.WAVE, lambda t, x, y: np.sin(t - x)),
])
@pytest.mark.parametrize("turned", [0.0, 1.0])
def test_a_beat_is_told_by_its_phases_on_the_body(beat, activation, turned):
    position = body_of(4, 8)
    x, y = (position - position.mean(axis=0)).T
    found = activation(np.arange(480)[:, None] * 0.2, x - x.min(), y)
    turn = np.array([(np.cos(turned), -np.sin(turned)), (np.sin(turned), np.cos(turned))])
    assert beat_of(found, position @ turn.T) == beat


@pytest.mark.parametrize("name", ["swim", "walk"])
def test_what_muscles_do_is_known_before_a_life_to_the_last_bit(name):
    task = with_settings(task_of(name), {"control_steps": 800})
    lived, told = perform(pulsing(), task).activation[1:], activation_of(pulsing(), task)
    assert np.ptp(told) > 0.1 and (lived[240:720] == told).all()


def test_lives_that_stop_below_the_bar_and_threads_change_nothing():
    task = task_of()
    asked = evolution_of()
    run_on(asked, task, 1)
    assert len(asked.ask()) == len(asked.bars) and max(asked.bars) > -1.0
    assert run_on(evolution_of(), task) == run_on(evolution_of(), task, workers=3) == run_on(evolution_of(), task, stopped=False)


def test_breeding_changes_nothing_and_a_batch_is_worth_the_population():
    evolution = evolution_of()
    run_on(evolution, task_of(), 2)
    before = evolution.state()
    bred = [evolution.search.breed(evolution.population, 2, np.random.default_rng(1)) for _ in "12"]
    assert bred[0] == bred[1] and evolution.state() == before
    worth = len(bred[0]) + sum(child.growths for child in bred[0]) / 8
    assert 6 <= len(bred[0]) < 12 and 11 - 9 / 8 < worth <= 13
    assert len({grow(child.genome, task_of()).key for child in bred[0]}) == len(bred[0])


def individual(genome, fitness, number):
    return Individual(genome, Evaluation(fitness, Status.OK, "", perform(genome, task_of()).evaluation.metrics), number=number)


def test_of_a_kind_the_fittest_stays_and_of_equals_the_first_in_the_order_of_asking():
    search, task, rng = Archive(evolution_of().settings), task_of(), np.random.default_rng(4)
    search.task = task
    genomes = alive(rng, 60)
    ones = [individual(genome, float(rng.integers(4)), k) for k, genome in enumerate(genomes)]
    kept: dict[int, Individual] = {}
    for one in ones:
        kind = search.kind(grow(one.genome, task))
        if kind not in kept or one.evaluation.fitness > kept[kind].evaluation.fitness:
            kept[kind] = one
    half = len(ones) // 2
    survivors = search.survive(search.survive([], ones[:half], 0), ones[half:], 1)
    assert {one.number for one in survivors} == {one.number for one in kept.values()} and len(survivors) > 4


@given(st.integers(0, 2**32))
@settings(max_examples=8, deadline=None)
def test_genomes_in_two_parts_vary_one_of_them_and_keep_the_other(seed):
    rng, task = np.random.default_rng(seed), task_of()
    genome, other = (random_parted(rng, 44, 1.0, 9.0) for _ in "12")
    part, gait = parts_of(genome)
    assert not (part & gait).any() and part[:INPUTS].sum() == INPUTS - 1 and not entangled(genome, part)
    body = grow(genome, task)
    child, made = varied(genome, gait, rng, (-2.5, -1.0))
    assert made and child != genome and same_shape(grow(child, task).position, body.position)
    assert (parts_of(graft(genome, other))[0].sum(), parts_of(graft(genome, other))[1].sum()) == (part.sum(), parts_of(other)[1].sum())
    grafted = graft(genome, other)
    assert grow(grafted, task).position.shape == body.position.shape
    assert same_shape(grow(grafted, task).position, body.position)
    assert (graft(genome, genome).kind == REGULATORY).sum() <= (genome.kind == REGULATORY).sum()


def alive(rng, count):
    """Random genomes in two parts whose bodies have chambers."""
    drawn = (random_parted(rng, 44, 1.0, 9.0) for _ in range(100 * count))
    return [genome for genome in drawn if grow(genome, task_of()).status == Status.OK][:count]


@pytest.mark.parametrize("name", EMITTERS)
@pytest.mark.parametrize("whole", [True, False], ids=["one network", "two parts"])
def test_what_an_emitter_promises(name, whole):
    """From genomes in two parts, and from champions whose muscles share units with growth."""
    task, rng = task_of(), np.random.default_rng(2)
    nursery = Nursery(task)
    genomes = [load_champion(name) for name in ("undulator", "peristalsis")] if whole else alive(rng, 4)
    elites = [individual(genome, float(k), k) for k, genome in enumerate(genomes)]
    drafts = [EMITTERS[name](elites, evolution_of().settings, nursery, np.random.default_rng(k)) for k in range(8)]
    assert all(1 <= draft.growths <= 9 for draft in drafts)
    children = [draft.child for draft in drafts if draft.child is not None]
    assert len(children) > 1 and all(isinstance(child, Child) and child.parents for child in children)
    if name == "keep":
        assert all(same_shape(grow(one.genome, task).position, grow(genomes[one.parents[0]], task).position) for one in children)
    if name == "graft":
        assert all(len(one.parents) == 2 for one in children)


@pytest.mark.parametrize("arguments, says", [
    ("--scheme archive --cells 3 --fillings 3", "settings.fillings is 3: give 1 or less, bodies have no more shares of chambers"),
    ("--scheme archive --cells 5 --fillings 1 --elongations 26", "settings.elongations is 26: give 25 or less"),
    ("--scheme archive --evaluations 99", "--evaluations is 99: give 100 or more, a batch of evaluations"),
    ("--scheme archive --layers 5", "settings.layers is 5: give 1, the search of scheme 'archive' has no layers"),
])
def test_archives_that_cannot_be_filled_are_refused_in_one_line(capsys, arguments, says):
    with pytest.raises(SystemExit) as left:
        parse(arguments.split())
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.count("\n") == 1


def test_what_an_archive_lacks_is_said_before_the_first_evaluation():
    with pytest.raises(ParameterError, match="give it a task"):
        Evolution(Settings(**scheme("archive")), scheme="archive").ask()
    with pytest.raises(ParameterError, match="measure 'colour' is unknown: choose one of elongation"):
        Archive(Settings(), measures=("colour",))
    with pytest.raises(ParameterError, match="emitter 'cma' is unknown: choose one of keep"):
        Archive(Settings(), emitters=("cma",))
    with pytest.raises(ParameterError, match=r"settings.founders is 12: give more, no body of those"):
        evolution_of(extent=1e3, founders=12).ask()  # where no product is near a receptor
    state = evolution_of().state()
    state["search"]["brought"]["keep"] = [float("nan"), 0.0]
    with pytest.raises(ParameterError, match="state that is not whole"):
        Evolution.resumed(state, task_of())
