"""What simulators answer, or others in their place, is looked at: whoever breaks the contract is dropped, and no fitness depends on it."""

import dataclasses
import itertools
import math
import os
import subprocess
import sys
from contextlib import ExitStack

import numpy as np
import pytest
from evodevo_ga.auditor import Auditor
from evodevo_ga.backends.contract import Batch
from evodevo_ga.backends.ros import RosBackend
from evodevo_ga.evolution import Individual
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.operators import crossover, duplicate
from evodevo_ga.pool.driver import CONDEMNED, Pool
from evodevo_ga.pool.quarantine import DIRECTORY
from evodevo_ga.pool.trial import judged
from evodevo_ga.pool.vigil import PoolError
from evodevo_sim.genetics.elements import REGULATORY, TRANSCRIPTION_FACTOR
from evodevo_sim.genetics.limits import MAX_ELEMENTS
from evodevo_sim.live.animat import Animat, NotViable
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.tasks.memory import MOST_MEMORY, needed
from genomes import beating
from hypothesis import given, settings
from hypothesis import strategies as st
from lab import DEADLINE, Operator
from rogues import FAULTS, Death, changed, service

from evodevo_ga import Evolution, Settings
from evodevo_sim import Genome, GenomeError, Status, Task, evaluate, load_genome, random_genome

TASK = with_settings(Task(), {"development.max_cells": 12, "control_steps": 40})
SEED = 1
_numbers = itertools.count()


@pytest.fixture(scope="module")
def genomes():
    return [random_genome(np.random.default_rng(i), 4) for i in range(23)] + [beating()]


@pytest.fixture(scope="module")
def right(genomes):
    return evaluate_all(genomes, TASK, SEED)


@pytest.fixture
def pool_of(tmp_path):
    """pool_of(faults...) -> (pool, its lines); a fault of None is honest."""
    with ExitStack() as stack:
        operator = stack.enter_context(Operator())

        def make(*faults, judge=None):
            names, lines = [], []
            for fault in faults:
                names.append(f"/trust_{os.getpid()}_{next(_numbers)}/evaluate")
                stack.enter_context(service(names[-1], *([fault] if fault else [])))
            backend = RosBackend(operator.node, operator.executor, names, say=lines.append, away=0.5)
            stack.callback(backend.close)
            operator.until(lambda: len(backend.workers) == len(names))
            return Pool(backend, lines.append, tmp_path, give_up_after=0.0, judge=judge), lines

        yield make


@pytest.mark.parametrize("name", FAULTS)
def test_a_node_that_breaks_the_contract_is_dropped_in_one_line_and_changes_no_fitness(pool_of, genomes, right, name):
    pool, lines = pool_of(FAULTS[name], None)
    assert pool.evaluate(genomes, TASK, SEED) == right
    assert len(pool) == 1 and len(lines) == 1 and "going on without simulator" in lines[0]
    assert len(lines[0]) <= 300 and "\n" not in lines[0]


@pytest.mark.parametrize("name", FAULTS)
def test_alone_it_ends_the_run_in_one_line(pool_of, genomes, name):
    pool, _ = pool_of(FAULTS[name])
    if name == "all are invalid later":  # nobody can contradict it: these genomes count as failed, and beat nobody
        found = pool.evaluate(genomes, TASK, SEED)
        assert {e.status for e in found[3:]} <= {Status.INVALID_GENOME, *Status} and all(math.isfinite(e.fitness) for e in found)
        return
    with pytest.raises(PoolError, match="no simulator is left") as error:
        pool.evaluate(genomes, TASK, SEED)
    assert len(str(error.value)) <= 300 and "\n" not in str(error.value)


def test_bars_go_to_the_nodes_and_their_answers_are_proved_with_the_same_bars(pool_of, genomes, right):
    bars = [one.fitness + (0.5 if k % 2 else -0.5) for k, one in enumerate(right)]
    wanted = evaluate_all(genomes, TASK, SEED, 2, bars)
    stopped = [one.status == Status.STOPPED for one in wanted]
    assert 0 < sum(stopped) < len(right)
    pool, lines = pool_of(None, changed(status=9, cause="", fitness=1e6))  # not below any bar
    assert pool.evaluate(genomes, TASK, SEED, bars=bars) == wanted
    assert len(pool) == 1 and "stopped a life" in lines[0]
    bars = [1e5] * len(genomes)
    assert pool.evaluate(genomes, TASK, SEED, best=-10.0, bars=bars) == evaluate_all(genomes, TASK, SEED, 1, bars)
    assert len(pool) == 1


@pytest.mark.parametrize("bars", [[1.0], [1.0] * 25])
def test_bars_in_this_process_are_none_or_one_for_each_genome(genomes, bars):
    with pytest.raises(ValueError, match="bars for 24 genomes"):
        evaluate_all(genomes, TASK, SEED, 1, bars)


def mortal(length):
    """A fault: the node dies of a genome of that length."""

    def fault(request, response, _):
        if any(len(genome.kind) == length for genome in request.genomes):
            raise Death
        return response

    return fault


def marked():
    """A genome that is told from others by its length, and lives."""
    return beating().take(np.append(np.arange(len(beating())), [len(beating()) - 1] * 200))


def test_a_genome_that_ends_two_nodes_counts_as_failed_and_no_other_does(pool_of, genomes, right, tmp_path):
    killer = marked()
    pool, lines = pool_of(*[mortal(len(killer))] * 3)
    before, after = genomes[:5], genomes[5:]
    found = pool.evaluate([*before, killer, *after], TASK, SEED)
    assert [*found[:5], *found[6:]] == right
    assert found[5].status == Status.INVALID_GENOME and found[5].cause == CONDEMNED
    assert len(pool) == 1 and sum("counts as failed" in line for line in lines) == 1
    [file] = (tmp_path / DIRECTORY).iterdir()
    assert load_genome(file) == killer and CONDEMNED in file.read_text() and any(str(file) in line for line in lines)


def test_a_genome_that_two_nodes_were_lost_with_is_judged_by_a_process_of_its_own(pool_of, genomes, right, tmp_path):
    innocent = marked()
    pool, lines = pool_of(*[mortal(len(innocent))] * 3, judge=judged)
    assert pool.evaluate([*genomes, innocent], TASK, SEED) == [*right, evaluate(innocent, TASK, SEED)]
    assert len(pool) == 1 and any("was evaluated here" in line for line in lines) and not (tmp_path / DIRECTORY).exists()


def test_a_judge_tells_how_its_process_ended(monkeypatch):
    batch = Batch((beating(),), TASK, SEED)
    assert judged(batch, 1.0) == evaluate(beating(), TASK, SEED)
    for program, says in (("import os; os.abort()", "by signal 6"), ("raise SystemExit(3)", "exit code 3")):
        monkeypatch.setattr("evodevo_ga.pool.trial.COMMAND", [sys.executable, "-c", program])
        assert says in judged(batch, 1.0)
    monkeypatch.setattr("evodevo_ga.pool.trial.COMMAND", [sys.executable, "-c", "import time; time.sleep(1000)"])
    monkeypatch.setattr("evodevo_ga.pool.trial.START", 0.2)
    assert "did not end" in judged(batch, 0.1)


def test_nodes_that_die_of_something_else_change_no_fitness(pool_of, genomes, right):
    def after(count):
        def fault(request, response, answered):
            if answered == count:
                raise Death
            return response

        return fault

    pool, lines = pool_of(after(0), after(2), None)
    assert pool.evaluate(genomes, TASK, SEED) == right and len(pool) == 1 and not any("failed" in line for line in lines)


@given(st.integers(0, 4), st.sampled_from([math.nan, math.inf, -math.inf]))
def test_an_evolution_refuses_what_is_no_number_and_stays_as_it_was(place, fitness):
    evolution = Evolution(Settings(population=5, elite=1, units=2), 1)
    asked = evolution.ask()
    evaluation = evaluate(beating(), TASK)
    good = [evaluation] * len(asked)
    bad = [*good[:place], dataclasses.replace(evaluation, fitness=fitness), *good[place + 1 :]]
    with pytest.raises(ValueError, match=f"evaluation {place} has a fitness of"):
        evolution.tell(bad)
    assert evolution.generation == -1 and evolution.ask() is asked
    assert evolution.tell(good).best == evaluation.fitness


@pytest.mark.parametrize("fitness", [1e6, -5.0])
def test_the_audit_finds_a_recorded_fitness_that_is_not_its_own(fitness):
    evaluation = evaluate(beating(), TASK, SEED)
    with Auditor(TASK, SEED) as auditor:
        auditor.submit(0, Individual(beating(), dataclasses.replace(evaluation, fitness=fitness)))
        found = auditor.next_finding().audit
    assert not found.stands and "recorded fitness of" in found.faults[0] and "differs" in found.faults[0]


def units(count, genes=1):
    """A genome of that many regulatory units."""
    kind = np.concatenate((beating().kind[:8], np.tile([REGULATORY] + [TRANSCRIPTION_FACTOR] * genes, count)))
    rng = np.random.default_rng(1)
    return Genome(kind, rng.choice((-1, 1), kind.size), *rng.uniform(0.0, 9.0, (2, kind.size)))


def test_a_genome_beyond_the_limit_is_refused_by_name():
    with pytest.raises(GenomeError, match=f"{MAX_ELEMENTS + 2} elements"):
        units((MAX_ELEMENTS - 6) // 2)
    longest = units((MAX_ELEMENTS - 8) // 2)
    assert len(longest) == MAX_ELEMENTS and needed(longest, TASK) < 0.5e9


def test_a_genome_that_takes_too_much_memory_in_a_task_is_refused_before_any_of_it_is_taken():
    genome, task = units(1900), with_settings(TASK, {"development.max_cells": 4096, "development.variant": "graph_at_end"})
    genome = Genome(np.where(genome.kind == TRANSCRIPTION_FACTOR, 3, genome.kind), genome.sign, genome.x, genome.y)
    assert needed(genome, task) > MOST_MEMORY
    evaluation = evaluate(genome, task)
    assert evaluation.status == Status.INVALID_GENOME and "lower development.max_cells" in evaluation.cause and len(evaluation.cause) <= 300
    with pytest.raises(NotViable, match=r"lower development.max_cells"):
        Animat(genome, task)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_children_of_the_longest_genomes_are_no_longer(seed, less):
    rng = np.random.default_rng(seed)
    longest = units((MAX_ELEMENTS - 8) // 2)
    other = longest.take(np.arange(len(longest) - less))
    child = crossover(longest, other, rng)
    assert len(duplicate(child, rng, 100.0)) <= MAX_ELEMENTS and len(duplicate(longest, rng, 2.6)) == MAX_ELEMENTS


def test_a_run_beside_a_rogue_is_the_run_without_one(tmp_path):
    """The whole command: a node that flatters from its second answer on, one good one; then the flatterer alone."""
    small = [
        "--generations", "3", "--population", "10", "--cells", "8", "--seed", "3", "--set", "control_steps=40", "--scheme", "panmictic",
    ]
    task = with_settings(Task(), {"development.max_cells": 8, "control_steps": 40})
    evolution = Evolution(Settings(generations=3, population=10), 3)
    while not evolution.finished:
        evolution.tell(evaluate_all(evolution.ask(), task, 3))

    def run(out):
        command = [sys.executable, "-m", "evodevo_ga.evolve", *small, "--look", "1", "--give-up-after", "0", "--quiet", "--out", str(out)]
        return subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)

    with service(f"/rogue_{os.getpid()}/evaluate", FAULTS["flatters later"]):
        with service(f"/good_{os.getpid()}/evaluate"):
            done = run(tmp_path / "both")
        assert done.returncode == 0 and "2 simulators of the graph" in done.stdout, done.stderr
        assert done.stderr.count("\n") == 1 and "by our own evaluation" in done.stderr
        assert load_genome(tmp_path / "both/champion.yaml") == evolution.champion.genome
        done = run(tmp_path / "alone")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "no simulator is left" in done.stderr, done.stderr
    assert read_recording(tmp_path / "alone").settings.seed == 3
