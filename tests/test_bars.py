"""Lives that a bar stops: whoever is not stopped has the bits of a whole life, and whoever is could not have reached the bar."""

import itertools
import math

import numpy as np
import pytest
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.settings import Settings
from evodevo_ga.variation import mutant
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.tasks.chemotaxis.fitness import attempt, placements
from evodevo_sim.tasks.chemotaxis.kernel import SAMPLES
from evodevo_sim.tasks.outcome import stopped
from evodevo_sim.tasks.walk.kernel import _most, _most_of_start
from genomes import dividing, pulsing, random_genomes, ring
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_ga import Evolution
from evodevo_sim import Metrics, Status, Task, evaluate, load_champion, random_genome, task_kinds

SHORT = {"control_steps": 240}
NOISE = {"noise.concentrations": 0.05, "noise.actuation": 0.1}
SWIM = with_settings(default_task("swim"), SHORT)
WALK = with_settings(default_task("walk"), {**SHORT, "starts": 3, "development.max_cells": 16})
SEEK = with_settings(default_task("chemotaxis"), {**SHORT, "chemotaxis.least_distance": 0.0, "development.max_cells": 16})
TASKS = {
    "swim": SWIM,
    "swim with noise": with_settings(SWIM, {**NOISE, "windows": 12}),
    "swim, variant A": with_settings(SWIM, {"development.variant": "graph_at_end", "development.max_cells": 12, "windows": 2}),
    "swim without a bonus": with_settings(SWIM, {"activity_bonus": 0.0, "full_activity": 0.9}),
    "walk": WALK,
    "walk from one start": with_settings(WALK, {"starts": 1}),
    "walk with noise": with_settings(WALK, {**NOISE, "starts": 4, "windows": 2}),
    "walk, variant A": with_settings(WALK, {"development.variant": "graph_at_end", "development.max_cells": 12}),
    "walk that seldom settles": with_settings(WALK, {"settling_limit": 455}),
    "chemotaxis": SEEK,
    "chemotaxis in turns": with_settings(SEEK, {"chemotaxis.pairs": 1, "chemotaxis.angle": 2.8, "chemotaxis.distance": 2.0, **NOISE}),
}
CHAMPIONS = {"swim": "undulator", "walk": "walker", "chemotaxis": "seeker"}


def mutants(task, seed, count, start=()):
    """Random genomes, champions of the task, given ones, and mutants of them."""
    rng = np.random.default_rng(seed)
    genomes = [random_genome(rng), load_champion(CHAMPIONS[task.name]), ring(), pulsing(), *start]
    while len(genomes) < count:
        genomes.append(mutant(genomes[rng.integers(len(genomes))], Settings(), rng)[0])
    return genomes


def holds(genome, task, seed, bar, whole):
    found = evaluate(genome, task, seed, bar)
    if found.status != Status.STOPPED:
        assert found == whole
        return False
    m = whole.metrics
    assert whole.fitness <= found.fitness < bar and not found.cause
    assert found.metrics == Metrics(cells=m.cells, springs=m.springs, chambers=m.chambers, substeps=m.substeps)
    return True


@pytest.mark.parametrize("name", TASKS)
def test_a_bar_stops_only_those_that_cannot_reach_it(name):
    task, count = TASKS[name], 0
    for k, genome in enumerate(mutants(task, 7, 8)):
        whole = evaluate(genome, task, k)
        for bar in (whole.fitness, np.nextafter(whole.fitness, math.inf), whole.fitness + 0.01, 1.3 * abs(whole.fitness), 1e9, math.inf):
            count += holds(genome, task, k, bar, whole)
        for bar in (-math.inf, math.nan, whole.fitness, whole.fitness - 0.01):
            assert evaluate(genome, task, k, bar) == whole
    assert count >= 6


@given(random_genomes(12), st.sampled_from(list(TASKS.values())), st.integers(0, 2**16), st.floats(-1.0, 3.0), st.floats(0.0, 3.0))
@settings(max_examples=50, deadline=None)
def test_whatever_the_bar_the_bits_of_a_life_that_is_not_stopped_are_the_same(genome, task, seed, share, more):
    whole = evaluate(genome, task, seed)
    holds(genome, task, seed, share * whole.fitness + more, whole)


class Archive:
    """The best of each kind of body, and the champion: what a search keeps of a stream of genomes."""

    def __init__(self):
        self.elites = {}

    def bar(self, metrics):
        return self.elites[self.cell(metrics)][0] if self.cell(metrics) in self.elites else -math.inf

    @staticmethod
    def cell(metrics):
        return metrics.chambers * 3 // max(1, 2 * metrics.cells - 5)

    def take(self, genome, evaluation):
        if evaluation.status != Status.STOPPED and evaluation.fitness > self.bar(evaluation.metrics):
            self.elites[self.cell(evaluation.metrics)] = evaluation.fitness, genome.key(), evaluation


@pytest.mark.parametrize("name", ["swim", "walk", "chemotaxis", "walk that seldom settles", "swim with noise"])
@pytest.mark.parametrize("seed", range(2))
def test_an_archive_and_its_champion_are_the_same_to_the_last_bit(name, seed):
    from evodevo_sim.tasks.grown import grow

    task, with_bars, without, stops = TASKS[name], Archive(), Archive(), 0
    rng = np.random.default_rng(seed)
    genomes = mutants(task, seed, 8)
    for k in range(40):
        genome = genomes[k] if k < len(genomes) else mutant(genomes[rng.integers(8)], Settings(), rng)[0]
        found = evaluate(genome, task, seed, with_bars.bar(grow(genome, task)))
        stops += found.status == Status.STOPPED
        with_bars.take(genome, found)
        without.take(genome, evaluate(genome, task, seed))
    assert with_bars.elites == without.elites and stops >= 5


def test_a_plain_distance_has_no_bound():
    for task in (with_settings(SWIM, {"fitness": "distance"}), with_settings(WALK, {"fitness": "distance"})):
        assert evaluate(ring(), task, 1, 1e9) == evaluate(ring(), task, 1)


def test_what_cannot_live_fails_as_without_a_bar():
    for task in (SWIM, WALK, SEEK):
        two = with_settings(task, {"development.max_cells": 2})
        assert evaluate(dividing(), two, 0, 1e9).status == Status.NO_CHAMBER


def test_a_task_whose_run_takes_no_bar_lives_on(monkeypatch):
    whole = evaluate(ring(), SWIM)
    kind = task_kinds.TaskKind("plain", "live", run=lambda genome, task, *_: whole, begin="", kernel="kernel.swim")
    monkeypatch.setitem(task_kinds._kinds, "plain", kind)
    assert evaluate(ring(), with_settings(SWIM, {"name": "plain"}), 0, 1e9) == whole


@given(st.lists(st.lists(st.floats(-10, 10), min_size=4, max_size=4), min_size=1, max_size=7), st.floats(0, 1))
@settings(max_examples=60, deadline=None)
def test_bounds_of_walks_fall_as_windows_pass_and_end_at_what_is_earned(ways, active):
    arguments = with_settings(WALK, {"starts": len(ways)}).arguments()
    ends = np.array([np.cumsum([0.0, *one]) for one in ways])
    bounds = [[_most_of_start(path, done, active, arguments) for done in range(1, 5)] for path in ends]
    for path, one in zip(ends, bounds):
        assert all(b <= a for a, b in itertools.pairwise(one))
        along = -1.0 if path[-1] < path[0] else 1.0
        assert one[-1] >= active * (4 * max(0.0, (along * np.diff(path)).min()) + arguments.activity_bonus)
    half = (len(ways) + 1) // 2
    last = np.array([one[-1] for one in bounds])
    assert _most(last) == pytest.approx(np.sort(last)[:half].mean()) and _most(np.full(len(ways), np.inf)) == math.inf


@given(
    st.integers(0, 2**32), st.floats(0.1, math.pi), st.floats(0.5, 20.0), st.floats(0.01, 50.0), st.floats(0.0, 0.9),
)
@settings(max_examples=100, deadline=None)
def test_no_path_gains_more_on_a_target_than_the_bound(seed, angle, distance, size, spread):
    from evodevo_sim.tasks.chemotaxis.kernel import _most_gain, nearing

    rng = np.random.default_rng(seed)
    angle *= 1 + spread
    target = distance * np.array([math.cos(angle), math.sin(angle)])
    path = np.vstack((np.zeros((1, 2)), size * rng.normal(size=(4 * SAMPLES, 2))))
    path[-SAMPLES // 2 :] = target * rng.uniform(0.9, 1.1) + 1e-3 * rng.normal(size=(SAMPLES // 2, 2))
    _, gain = nearing(path, target, angle)
    assert gain <= _most_gain(np.array([angle, distance])) * (1 + 1e-9)


def test_swims_towards_targets_are_spared_too():
    task = default_task("chemotaxis")
    whole, result = evaluate(load_champion("seeker"), task), attempt(load_champion("seeker"), task, 0, placements(task), every=False)
    assert result.swims == 4
    late = [
        attempt(load_champion("seeker"), task, 0, placements(task), every=False, bar=share * whole.fitness).swims
        for share in (1.0, 1.02, 1.05, 1.1, 1.15, 2.0)
    ]
    assert late == sorted(late, reverse=True) and late[0] == 4 and late[-1] == 0 and len(set(late)) > 2


def test_an_evolution_settles_nobody_who_was_stopped():
    evolution = Evolution(Settings(population=4, elite=1, tournament=2, units=2), 1)
    asked = evolution.ask()
    with pytest.raises(ValueError, match="stopped"):
        evolution.tell([stopped(3.0, Metrics())] * len(asked))
    evolution.tell(evaluate_all(asked, with_settings(Task(), {"control_steps": 40})))
