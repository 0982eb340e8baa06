"""The pool above a backend that does anything a backend may: every genome gets its own result, once, whoever is lost with it or comes."""

import math
import random
import threading
import time
from concurrent.futures import Future

import numpy as np
import pytest
from evodevo_ga.backends.contract import Answer, AnswerError, Backend, BackendError, NotEvaluated, WorkerLost
from evodevo_ga.pool.driver import CONDEMNED, Pool
from evodevo_ga.pool.pace import MOST, Pace
from evodevo_ga.pool.vigil import PoolError
from evodevo_sim.tasks.evaluation import invalid
from genomes import beating
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Evaluation, Genome, Metrics, Status, Task

TASK, SEED = Task(), 7
FATES = ("answer", "lost", "given back", "away", "away and back", "twice")


def genomes_of(count):
    first = beating()
    return [Genome(first.kind, first.sign, first.x + k, first.y) for k in range(count)]


def result_of(genome):
    return Evaluation(float(genome.x[0]), Status.OK, "", Metrics())


class Fates(Backend):
    """Workers of whom each batch meets a fate, drawn at random; after `most` of them all are well.  Time goes by in `wait` alone."""

    trusted = True

    def __init__(self, seed, workers=2, threads=2, most=30, killers=()):
        self.random, self.most, self.killers = random.Random(seed), most, killers
        self.threads, self.born = threads, workers
        self.there = {f"w{k}": threads for k in range(workers)}
        self.asked, self.absent = [], {}
        self.dropped = []

    @property
    def workers(self):
        return {name: threads for name, threads in self.there.items() if name not in self.absent}

    def submit(self, batch, worker):
        future = Future()
        self.asked.append((batch, worker, future))
        return future

    def drop(self, worker, reason):
        self.dropped.append(worker)
        self.there.pop(worker, None)

    def wait(self, futures, seconds):
        for name in list(self.absent):
            self.absent[name] -= 1
            if self.absent[name] <= 0:
                del self.absent[name]
        self.asked = [one for one in self.asked if not one[2].done()]
        live = [one for one in self.asked if one[1] not in self.absent]
        if not live:
            return
        batch, worker, future = self.random.choice([one for one in live if one[1] == live[0][1]][: self.threads])
        fate = self.random.choice(FATES) if self.most > 0 else "answer"
        self.most -= 1
        if any(one.key() in self.killers for one in batch.genomes):
            fate = "lost"
        if fate == "answer" or fate == "twice":
            future.set_result(Answer([result_of(genome) for genome in batch.genomes], worker, 0.01))
        elif fate == "lost":
            self.there.pop(worker, None)
            for _, name, other in self.asked:
                if name == worker and not other.done():
                    other.set_exception(WorkerLost(worker, "it has ended"))
            self.there[f"w{self.born}"] = self.threads
            self.born += 1
        elif fate == "given back":
            future.set_exception(NotEvaluated(worker, "it ends"))
        else:
            self.absent[worker] = 3 if fate == "away" else 1


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 40), st.integers(1, 3), st.integers(1, 3))
def test_whatever_happens_to_workers_every_genome_has_its_own_result(seed, count, workers, threads):
    genomes, lines = genomes_of(count), []
    pool = Pool(Fates(seed, workers, threads), lines.append, judge=lambda batch, patience: result_of(batch.genomes[0]))
    pool._rests = _Never()
    assert pool.evaluate(genomes, TASK, SEED) == [result_of(genome) for genome in genomes]
    assert pool.evaluate(genomes, TASK, SEED) == [result_of(genome) for genome in genomes]
    assert all(len(line) <= 300 and "\n" not in line for line in lines)


class _Never(dict):
    """Nobody rests."""

    def get(self, name, otherwise=None):
        return 0.0


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32), st.integers(2, 30), st.integers(1, 3), st.data())
def test_a_genome_that_ends_its_workers_is_condemned_and_nobody_beside_it(tmp_path_factory, seed, count, threads, data):
    genomes, run = genomes_of(count), tmp_path_factory.mktemp("run")
    bad = data.draw(st.integers(0, count - 1))
    backend = Fates(seed, 2, threads, most=0, killers={genomes[bad].key()})
    pool = Pool(backend, [].append, run, judge=lambda batch, patience: "it ended by signal 11")
    found = pool.evaluate(genomes, TASK, SEED)
    assert found == [invalid(CONDEMNED) if k == bad else result_of(genome) for k, genome in enumerate(genomes)]
    assert [f"{SEED}" in file.read_text() for file in (run / "quarantine").iterdir()] == [True]
    assert len(backend.dropped) == 2 if threads == 1 else len(backend.dropped) <= 3


class Silent(Fates):
    """Workers that hang with some genomes, and answer to the others at once."""

    def wait(self, futures, seconds):
        self.asked = [one for one in self.asked if not one[2].done()]
        for batch, worker, future in self.asked:
            if not any(genome.key() in self.killers for genome in batch.genomes):
                future.set_result(Answer([result_of(genome) for genome in batch.genomes], worker, 1e-3))
        time.sleep(0.002)

    def drop(self, worker, reason):
        super().drop(worker, reason)
        self.there[f"w{self.born}"] = self.threads
        self.born += 1


def test_a_genome_that_hangs_its_workers_is_judged_and_they_are_not_waited_for():
    genomes = genomes_of(12)
    backend = Silent(0, 2, 1, killers={genomes[5].key()})
    quick = Pace(least=0.05)
    quick.patience = lambda genomes, task: 0.05
    lines = []
    pool = Pool(backend, lines.append, judge=lambda batch, patience: "it did not end", pace=quick)
    found = pool.evaluate(genomes, TASK, SEED)
    assert found == [invalid(CONDEMNED) if k == 5 else result_of(genome) for k, genome in enumerate(genomes)]
    assert len(backend.dropped) == 2 and any("does not answer" in line for line in lines)


def test_a_pool_that_stood_still_itself_takes_nobody_for_hanging(monkeypatch):
    backend = Silent(0, 1, 1, killers={genomes_of(1)[0].key()})
    pace = Pace()
    pace.patience = lambda genomes, task: 5.0
    pool = Pool(backend, [].append, pace=pace)
    clock = [100.0]
    monkeypatch.setattr("evodevo_ga.pool.driver.time", _Clock(clock))
    monkeypatch.setattr(backend, "wait", lambda futures, seconds: clock.__setitem__(0, clock[0] + 1000.0))  # as a process that is stopped
    rounds = iter(range(20))
    assert pool.evaluate(genomes_of(1), TASK, SEED, stop=lambda: next(rounds, None) is None) is None
    assert not backend.dropped
    rounds = iter(range(20))
    monkeypatch.setattr(backend, "wait", lambda futures, seconds: clock.__setitem__(0, clock[0] + 1.0))
    assert pool.evaluate(genomes_of(1), TASK, SEED, stop=lambda: next(rounds, None) is None) is None
    assert backend.dropped


class _Clock:
    def __init__(self, now):
        self.monotonic = lambda: now[0]


class Coming(Fates):
    """Nobody is there until `come` is called."""

    def __init__(self, why=""):
        super().__init__(0, 0, most=0)
        self.why = why

    def come(self, name="late"):
        self.there[name] = 1

    def hopeless(self):
        return self.why

    def wait(self, futures, seconds):
        super().wait(futures, seconds)
        time.sleep(0.002)


def test_where_nobody_is_there_the_pool_waits_says_so_and_goes_on(monkeypatch):
    monkeypatch.setattr("evodevo_ga.pool.vigil._MOMENT", 0.05)
    backend, lines, genomes = Coming(), [], genomes_of(3)
    pool = Pool(backend, lambda line: (lines.append(line), backend.come()))
    assert pool.evaluate(genomes, TASK, SEED) == [result_of(genome) for genome in genomes]
    assert len(lines) == 2 and "no simulator is left: waiting for one" in lines[0] and "going on with simulator late" in lines[1]


@pytest.mark.parametrize(
    "backend, wait, says", [(Coming(), 0.05, "no simulator is left"), (Coming("they end again and again"), 9.0, "again")]
)
def test_it_gives_up_after_a_while_or_where_nobody_will_ever_come(backend, wait, says):
    with pytest.raises(PoolError, match=says):
        Pool(backend, [].append, give_up_after=wait).evaluate(genomes_of(2), TASK, SEED)


def test_a_backend_that_cannot_go_on_ends_the_run_in_one_line():
    class Broken(Fates):
        def wait(self, futures, seconds):
            self.asked[0][2].set_exception(BackendError("the scheduler is gone: start it, and resume the run"))

    with pytest.raises(PoolError, match="the scheduler is gone"):
        Pool(Broken(0), [].append).evaluate(genomes_of(2), TASK, SEED)


def test_a_worker_that_breaks_the_contract_is_sent_away_and_others_do_its_work():
    class Odd(Fates):
        trusted = False

        def wait(self, futures, seconds):
            self.asked = [one for one in self.asked if not one[2].done()]
            for _, worker, future in self.asked:
                if worker == "w0":
                    future.set_exception(AnswerError("its answer cannot be read"))
                elif worker == "w1":
                    future.set_result(Answer(["no evaluation"], worker))
                else:
                    future.set_result(Answer(None, worker))

    backend, lines = Odd(0, 3), []
    with pytest.raises(PoolError, match="no simulator is left"):
        Pool(backend, lines.append, give_up_after=0.0).evaluate(genomes_of(4), TASK, SEED)
    assert sorted(backend.dropped) == ["w0", "w1", "w2"] and all(len(line) <= 300 for line in lines)


@given(st.floats(1e-5, 100.0), st.integers(1, 10_000), st.integers(1, 64))
def test_batches_are_short_by_the_clock_and_get_smaller_towards_the_end(seconds, left, slots):
    pace, genome = Pace(), beating()
    assert 1 <= pace.size(left, slots) <= MOST
    pace.learn([genome] * 4, TASK, 4 * seconds)
    size = pace.size(left, slots)
    assert 1 <= size <= MOST and (size == 1 or size * seconds <= 0.25 * (1 + 1e-9)) and (size == 1 or size * 2 * slots <= left)
    assert pace.size(1, slots) == 1


@given(st.floats(1e-4, 1.0), st.integers(1, 50))
def test_patience_is_long_against_what_was_measured_and_grows_with_the_batch(seconds, count):
    pace, genome = Pace(), beating()
    bound = pace.patience([genome] * count, TASK)
    pace.learn([genome], TASK, seconds)
    measured = pace.patience([genome] * count, TASK)
    assert bound >= measured >= 60.0 and measured >= min(bound, 20.0 * seconds * count) * (1 - 1e-9)
    assert math.isfinite(bound) and pace.patience([genome] * (count + 1), TASK) >= measured


def test_results_come_from_threads_too():
    """A backend whose futures end in threads of its own, as Dask's do."""

    class Threads(Fates):
        def submit(self, batch, worker):
            future = Future()
            threading.Timer(0.001, lambda: future.set_result(Answer([result_of(g) for g in batch.genomes], worker, 1e-3))).start()
            return future

        wait = Backend.wait

    genomes = genomes_of(50)
    assert Pool(Threads(0, 3), [].append).evaluate(genomes, TASK, SEED) == [result_of(genome) for genome in genomes]
    assert np.isfinite([result_of(genome).fitness for genome in genomes]).all()
