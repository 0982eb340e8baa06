"""Threads of this process and workers of a Dask cluster give the bits of the library, whatever ends, comes, goes or differs."""

import signal
import socket
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
from clusters import SCHEDULER, WORKER, started
from evodevo_ga.arguments import parse
from evodevo_ga.backends.contract import Answer, AnswerError, BackendError, Batch, NotEvaluated, WorkerLost
from evodevo_ga.backends.dask import DaskBackend, _unlike
from evodevo_ga.backends.dask_scheduler import _other_versions
from evodevo_ga.backends.local import NAME, LocalBackend
from evodevo_ga.backends.plain import answer_of_plain, batch_of_plain, plain_answer, plain_batch
from evodevo_ga.backends.remote import IDENTITY
from evodevo_ga.pool.driver import Pool
from evodevo_ga.pool.pace import MOST, Pace
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.task_kinds import names
from genomes import beating, random_genomes
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Task, evaluate, load_champion, random_genome

TASK = with_settings(Task(), {"development.max_cells": 12, "control_steps": 40})
LONG = with_settings(Task(), {"control_steps": 10_000_000})
SEED, DEADLINE = 3, 60.0
ENDLESS = (load_champion("undulator"),)  # for LONG
GENOMES = (*(random_genome(np.random.default_rng(i), 4) for i in range(7)), beating())
LACKING = """
class Without:
    def find_spec(name, path=None, target=None):
        if name == "evodevo_ga":
            raise ModuleNotFoundError("No module named 'evodevo_ga'", name=name)
sys.meta_path.insert(0, Without)
"""


def until(done):
    """What `done()` says once that is true."""
    deadline = time.monotonic() + DEADLINE
    while not (said := done()):
        assert time.monotonic() < deadline, "nothing happened in time"
        time.sleep(0.02)
    return said


def alone(backend, address):
    """The name of the worker at an address, once it can be given work, and those of tests before are gone."""
    until(lambda: [name.partition(" ")[0] for name in backend.workers] == [address])
    return next(iter(backend.workers))


@pytest.fixture(scope="module")
def right():
    return [evaluate(genome, TASK, SEED) for genome in GENOMES]


@pytest.fixture(scope="module")
def cluster():
    """(backend, what it said); its workers come from the tests."""
    said = []
    with started(SCHEDULER) as (_, address), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Dask's own
        backend = DaskBackend(address, TASK, say=said.append)
        yield backend, said
        backend.close()


def test_threads_of_this_process_give_the_bits_of_the_library(right):
    backend = LocalBackend(2)
    futures = [backend.submit(Batch(GENOMES, TASK, SEED), worker) for worker in [*backend.workers] * 3]
    assert [future.result(DEADLINE).evaluations for future in futures] == [right] * 3 and backend.workers == {NAME: 2}
    backend.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("evaluations ")]


def test_a_batch_of_this_process_is_cancelled_while_it_waits_and_while_it_is_in_work(right):
    backend = LocalBackend(1)
    endless = Batch(ENDLESS, LONG, SEED)
    first, second, third = backend.submit(endless), backend.submit(endless), backend.submit(Batch(GENOMES, TASK, SEED))
    assert second.cancel() and first.cancel() and first.done() and second.done()
    assert third.result(DEADLINE).evaluations == right
    backend.close()


def test_what_goes_wrong_with_a_genome_fails_alone(right, monkeypatch):
    def faulty(genome, *given):
        return evaluate(genome, *given) if genome != GENOMES[1] else 1 / 0

    monkeypatch.setattr("evodevo_ga.backends.evaluating.evaluate", faulty)
    backend = LocalBackend(1)
    found = backend.submit(Batch(GENOMES[:3], TASK, SEED)).result(DEADLINE).evaluations
    backend.close()
    assert found[0] == right[0] and found[2] == right[2] and "ZeroDivisionError" in found[1].cause


@given(
    st.lists(random_genomes(), min_size=1, max_size=3), st.sampled_from(names()[:3]), st.integers(0, 2**63 - 1),
    st.lists(st.floats(allow_nan=False), max_size=3), st.floats(1e-9, 1.0, exclude_min=True),
)
@settings(deadline=None)
def test_batches_become_plain_data_and_back_without_the_loss_of_a_bit(genomes, name, seed, bars, control_step):
    batch = Batch(tuple(genomes), with_settings(default_task(name), {"control_step": control_step}), seed, tuple(bars))
    assert batch_of_plain(plain_batch(batch)) == batch


def test_answers_become_plain_data_and_back_and_what_is_none_is_an_error(right):
    plain = plain_answer(Answer(right, "here", 0.25))
    assert answer_of_plain(plain, "here") == Answer(right, "here", 0.25)
    first = plain["evaluations"][0]
    for wrong in (
        None, {}, {"evaluations": [first]}, {"evaluations": [None], "seconds": 1.0}, {"evaluations": [first], "seconds": "x"},
        {"evaluations": [{**first, "status": 99}], "seconds": 0.0}, {"evaluations": [{**first, "extra": 1}], "seconds": 0.0},
        {"evaluations": [{**first, "metrics": {}}], "seconds": 0.0},
    ):
        with pytest.raises(AnswerError, match="cannot be read"):
            answer_of_plain(wrong, "there")


def test_workers_of_a_cluster_give_the_bits_of_the_library_and_a_killed_one_is_lost(cluster, right):
    backend, _ = cluster
    with started(WORKER.format(scheduler=backend.scheduler)) as (first, address):
        name = alone(backend, address)
        futures = [backend.submit(Batch(GENOMES, TASK, SEED), name) for _ in range(3)]
        assert [future.result(DEADLINE).evaluations for future in futures] == [right] * 3
        assert backend.submit(Batch(GENOMES, TASK, SEED), name).result(DEADLINE).worker == name
        futures = [backend.submit(Batch(ENDLESS, LONG, SEED), name) for _ in range(2)]
        first.send_signal(signal.SIGKILL)
        until(lambda: (backend.workers, all(future.done() for future in futures))[1])
        assert {type(future.exception()) for future in futures} == {WorkerLost} and not backend.workers
        assert type(backend.submit(Batch(GENOMES, TASK, SEED), name).exception()) is NotEvaluated
        with started(WORKER.format(scheduler=backend.scheduler)) as (_, address):
            other = alone(backend, address)
            assert backend.submit(Batch(GENOMES, TASK, SEED), other).result(DEADLINE).evaluations == right
            assert address in other and other != name


def test_a_cancelled_batch_leaves_its_worker_and_a_dropped_worker_gets_nothing(cluster, right):
    backend, _ = cluster
    with started(WORKER.format(scheduler=backend.scheduler)) as (_, address):
        name = alone(backend, address)
        endless = [backend.submit(Batch(ENDLESS, LONG, SEED), name) for _ in range(2)]
        behind = backend.submit(Batch(GENOMES, TASK, SEED), name)
        assert all(one.cancel() and one.cancelled() for one in endless)
        assert behind.result(DEADLINE).evaluations == right
        backend.drop(name, "it answers wrongly")
        looked = time.monotonic()
        until(lambda: backend.workers or backend._looked > looked + 1.0)  # it is listed, and no worker any more
        assert not backend.workers and type(backend.submit(Batch(GENOMES, TASK, SEED), name).exception()) is NotEvaluated


@pytest.mark.parametrize(
    "before, environment, says",
    [
        ("import evodevo_sim.tasks.code as code; code.code_hash = lambda: 'f' * 16", {}, "it runs other code"),
        (LACKING, {}, "it lacks evodevo_ga"),
    ],
)
def test_a_worker_with_other_code_or_none_is_named_in_a_line_and_not_used(cluster, before, environment, says):
    backend, said = cluster
    said.clear()
    with started(WORKER.format(scheduler=backend.scheduler), before, **environment) as (_, address):
        until(lambda: not backend.workers and said)
        assert len(said) == 1
        assert says in said[0] and address in said[0] and len(said[0]) <= 300 and "\n" not in said[0]


def test_no_scheduler_none_of_this_version_and_no_address_are_a_line_each(monkeypatch):
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
    monkeypatch.setattr("evodevo_ga.backends.dask_scheduler.CONNECT", 0.5)
    with pytest.raises(BackendError, match="no Dask scheduler of this version answers at"):
        DaskBackend(nobody, TASK)
    with socket.socket() as other:  # it takes the connection, and says what no scheduler says
        other.bind(("127.0.0.1", 0))
        other.listen()
        threading.Thread(target=lambda: other.accept()[0].sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 9), daemon=True).start()
        with pytest.raises(BackendError, match="Dask scheduler"):
            DaskBackend(f"tcp://127.0.0.1:{other.getsockname()[1]}", TASK)
    for text in ("", "nonsense", "http://x:1", "tcp://127.0.0.1", "tcp://127.0.0.1:port", "x" * 1000)[1:]:
        with pytest.raises(BackendError, match="is no address of a Dask scheduler") as error:
            DaskBackend(text, TASK)
        assert len(str(error.value)) <= 300


def test_a_scheduler_of_another_version_is_refused_in_a_line():
    old = "import distributed.versions as versions; versions._version_cached = lambda name: '2020.1.0'"
    with started(SCHEDULER, old) as (_, address), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(BackendError, match=r"distributed 2020.1.0 there, [0-9.]+ here: install the same on both"):
            DaskBackend(address, TASK)


def test_versions_and_code_that_differ_are_named():
    packages = {"python": "3.11.4.final.0", "distributed": "1", "dask": "1", "msgpack": "1"}
    told = {"scheduler": {"packages": packages}, "client": {"packages": packages | {"python": "3.11.9.final.0"}}}
    assert _other_versions(told) == ""
    told["scheduler"] = {"packages": packages | {"python": "3.12.1.final.0"}}
    assert "Python 3.12 there, 3.11 here" in _other_versions(told)
    assert _unlike(IDENTITY) == "" and "other code" in _unlike(IDENTITY | {"code": "0" * 16}) and _unlike(None) and _unlike({})


def test_a_generation_goes_on_where_a_worker_is_killed_in_the_middle_with_the_bits_of_threads(cluster):
    backend, _ = cluster
    genomes = [random_genome(np.random.default_rng(i)) for i in range(16)]
    task = with_settings(TASK, {"control_steps": 1000})
    right = [evaluate(genome, task, SEED) for genome in genomes]
    local = Pool(LocalBackend(2))
    assert local.evaluate(genomes, task, SEED) == right
    local.backend.close()
    said = []
    worker = WORKER.format(scheduler=backend.scheduler)
    with started(worker) as (first, one), started(worker) as (_, second):
        until(lambda: sorted(backend.workers) == sorted([one, second]))
        killed = threading.Event()

        def kill_once():
            """Asked in each round of the pool: as soon as both have something in work, one is killed."""
            if not killed.is_set() and all(one.asked for one in backend._workers.values()):
                first.kill()
                killed.set()
            return False

        assert Pool(backend, say=said.append).evaluate(genomes, task, SEED, kill_once) == right
        assert killed.is_set()
        until(lambda: [second] == [*backend.workers])


@given(st.integers(1, 10**6), st.integers(1, 2000), st.floats(1e-4, 10.0), st.floats(0.0, 0.1))
def test_batches_that_cost_to_give_are_larger_and_never_more_than_wait_or_the_most(left, slots, seconds, cost):
    pace = Pace()
    pace.seconds = seconds
    assert 1 <= pace.size(left, slots) <= pace.size(left, slots, cost) <= MOST
    pace.seconds = 6.5e-3
    assert pace.size(10_000, 1024) < 10 < pace.size(10_000, 1024, 3e-3) <= MOST


def evolve(directory, *arguments):
    command = [sys.executable, "-m", "evodevo_ga.evolve", "--out", str(directory), "--generations", "2", "--population", "8", "--quiet"]
    command += ["--cells", "12", "--set", "control_steps=80", "--scheme", "panmictic", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=4 * DEADLINE, check=False)


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--backend", "cloud"], "--backend is 'cloud': choose one of ros, local, dask"),
        (["--scheduler", "tcp://127.0.0.1:1"], "--scheduler is given where the backend is ros"),
        (["--backend", "local", "--simulators", "2"], "--simulators is given where the backend is local"),
        (["--backend", "dask", "--scheduler", "tcp://127.0.0.1:1", "--threads", "2"], "--threads is given beside --scheduler"),
    ],
)
def test_a_backend_that_cannot_be_meant_is_a_line(capsys, arguments, says):
    with pytest.raises(SystemExit) as left:
        parse(arguments)
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.count("\n") == 1


def test_a_scheduler_that_cannot_be_used_is_a_line_and_nothing_is_written(tmp_path):
    ended = evolve(tmp_path / "run", "--backend", "dask", "--scheduler", "here")
    assert ended.returncode == 2 and ended.stderr.count("\n") == 1
    assert ended.stderr.startswith("evolve: 'here' is no address of a Dask scheduler")
    assert not (tmp_path / "run").exists()
