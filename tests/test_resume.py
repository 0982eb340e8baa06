"""Runs of `evolve` that are ended in whatever way and resumed: real processes over DDS, and the same bits as without an end."""

import json
import os
import resource
import subprocess
import sys
import time

import pandas as pd
import pytest
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.keeping.checkpoint import BEFORE, NAME, Checkpoints, read_checkpoint
from evodevo_ga.keeping.errors import ResumeError
from evodevo_ga.keeping.history import TABLES, History
from evodevo_ga.keeping.limits import Limits
from evodevo_ga.keeping.resume import resumed
from evodevo_ga.usual import usual_task
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import life_of
from lab import DEADLINE
from rosbags.rosbag2 import Reader

from evodevo_ga import Evolution, Settings
from evodevo_sim import load_genome

GENERATIONS = 24
SMALL = ["--population", "14", "--cells", "8", "--seed", "3", "--set", "control_steps=80", "--quiet"]
TASK = with_settings(usual_task("swim"), {"development.max_cells": 8, "control_steps": 80})
HERE = ("--backend", "local", "--threads", "1")  # where it is not about nodes


class Undisturbed:
    """The run in process, and what it keeps."""

    def __init__(self, directory):
        self.directory, self.evolution = directory, Evolution(Settings(generations=GENERATIONS, population=14), 3)
        checkpoints, history = Checkpoints(directory, self.evolution, TASK, Limits(), ()), History(directory)
        self.statistics, self.champions = [], []
        while not self.evolution.finished:
            generation = self.evolution.tell(evaluate_all(self.evolution.ask(), TASK, 3))
            self.statistics.append(generation)
            if generation.improved:
                self.champions.append((generation.generation, self.evolution.champion))
            history.take(generation, self.evolution)
            history.write_if_due(generation.generation)
            of, champion = self.champions[-1]
            checkpoints.write(champion, of, history.kept())
        history.write()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    return Undisturbed(tmp_path_factory.mktemp("undisturbed"))


def start(*arguments, **popen):
    who = () if "--backend" in arguments else ("--simulators", "1")
    command = [sys.executable, "-m", "evodevo_ga.evolve", *who, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **popen)


def run(*arguments, **popen):
    with start(*arguments, **popen) as process:
        stdout, stderr = process.communicate(timeout=DEADLINE)
    assert "Traceback" not in stderr, stderr
    return process.returncode, stdout, stderr


def until(process, directory, generation):
    """Until a generation is kept, or the process has ended."""
    deadline = time.monotonic() + DEADLINE
    while process.poll() is None and (not (directory / NAME).exists() or kept(directory) < generation):
        assert time.monotonic() < deadline
        time.sleep(0.005)


def kept(directory):
    """The generation of the newest checkpoint; -1 while there is none."""
    try:
        return read_checkpoint(directory)[0]["evolution"]["generation"]
    except ResumeError:
        return -1


def same(directory, undisturbed):
    """Checkpoints, history, recording and champion are those of the undisturbed run; each generation is recorded once."""
    for name in (NAME, BEFORE):
        assert (directory / name).read_bytes() == (undisturbed.directory / name).read_bytes()
    for table in TABLES:
        assert pd.read_parquet(directory / table).equals(pd.read_parquet(undisturbed.directory / table)), table
    recording = read_recording(directory)
    assert not recording.truncated and recording.notes == []
    for name in ("generation", "best", "median", "worst", "diversity", "evaluations"):
        assert [getattr(s, name) for s in recording.statistics] == [getattr(s, name) for s in undisturbed.statistics]
    champions = [(generation, one.evaluation.fitness) for generation, one in undisturbed.champions]
    assert [(c.generation, c.evaluation.fitness) for c in recording.champions] == champions
    audited = sorted(a.generation for a in recording.audits)
    assert audited == [generation for generation, one in undisturbed.champions if not one.evaluation.cause]
    assert recording.settings.generations == GENERATIONS and recording.gait and len(life_of(recording).time) == 81
    assert load_genome(directory / "champion.yaml") == undisturbed.evolution.champion.genome
    with Reader(directory) as bag:  # of another hand, by metadata.yaml
        counts = {connection.topic: connection.msgcount for connection in bag.connections}
        numbers = [message for connection, _, message in bag.messages() if connection.topic == "/evolution/statistics"]
    assert counts["/evolution/statistics"] == len(numbers) == GENERATIONS


def test_a_run_that_is_killed_twice_and_resumed_is_the_run_that_was_not(tmp_path, undisturbed):
    directory = tmp_path / "run"
    with start(*SMALL, "--generations", GENERATIONS, "--out", directory) as process:
        until(process, directory, 2)
        with pytest.raises(ResumeError, match=f"in use by process {process.pid} on"):
            resumed(directory)
        process.kill()
    with start("--resume", directory, "--quiet") as process:
        until(process, directory, 13)
        process.kill()
    (directory / NAME).write_bytes((directory / NAME).read_bytes()[:-100])
    for name, rest in (("run_0.mcap", 100), ("run_1.mcap", (directory / "run_1.mcap").stat().st_size // 2)):  # as a power cut leaves them
        os.truncate(directory / name, rest)
    code, stdout, stderr = run("--resume", directory, "--quiet")
    assert code == 0 and stderr.count("\n") == 1 and "checkpoint.json is damaged: going on after generation" in stderr, stderr
    assert "24 generations" in stdout and "Go on:" not in stdout
    same(directory, undisturbed)
    assert len(json.loads((directory / "sessions.json").read_text())) == 3
    times = {path: path.stat().st_mtime_ns for path in directory.rglob("*") if path.name != "lock"}
    code, _, stderr = run("--resume", directory)
    assert code == 2 and stderr.count("\n") == 1 and "is finished, after 24 generations: raise --generations" in stderr
    assert {path: path.stat().st_mtime_ns for path in directory.rglob("*") if path.name != "lock"} == times


def test_a_run_goes_on_after_ctrl_c_after_budgets_and_beyond_its_generations(tmp_path, undisturbed):
    directory = tmp_path / "run"
    code, stdout, stderr = run(*SMALL, *HERE, "--generations", "12", "--evaluations", "40", "--out", directory)
    done = next(s.generation for s in undisturbed.statistics if s.evaluations >= 40)
    assert code == 0 and kept(directory) == done and f"{done + 1} generations" in stdout, stderr
    assert "(ended by --evaluations 40: give more)" in stdout
    with start("--resume", directory, *HERE, "--evaluations", "100000") as process:
        until(process, directory, done + 2)
        process.terminate()
        stdout, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode in (0, 130), stderr  # it may have been at its end
    code, stdout, stderr = run("--resume", directory, *HERE, "--generations", GENERATIONS, "--quiet")
    assert code == 0, stderr
    content = json.loads(b"{" + (directory / NAME).read_bytes().partition(b"\n")[2])
    assert content["run"]["limits"] == {"evaluations": 100000, "hours": None}
    other = json.loads(b"{" + (undisturbed.directory / NAME).read_bytes().partition(b"\n")[2])
    assert content["run"] | {"limits": 0} == other["run"] | {"limits": 0}
    recording = read_recording(directory)
    assert [s.generation for s in recording.statistics] == list(range(GENERATIONS)) and recording.notes == []


def test_a_full_disk_ends_a_run_with_one_line_and_it_goes_on_once_there_is_room(tmp_path, undisturbed):
    directory = tmp_path / "run"
    with start(*SMALL, *HERE, "--generations", GENERATIONS, "--out", directory) as process:
        until(process, directory, 3)
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (1000, resource.RLIM_INFINITY))  # bytes of a file: the kernel refuses more
        _, stderr = process.communicate(timeout=DEADLINE)
    last = stderr.splitlines()[-1]
    assert process.returncode == 2 and "File too large" in last and f"evolve --resume {directory}" in last and len(last) <= 300, stderr
    assert [name for name in os.listdir(directory) if name.endswith(".new")] == [] and 0 <= kept(directory) < GENERATIONS - 1
    code, _, stderr = run("--resume", directory, *HERE, "--quiet")
    assert code == 0, stderr
    same(directory, undisturbed)
