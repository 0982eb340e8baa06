"""A Dask scheduler that ends in the middle of a run: one line, exit code 2, and the run goes on elsewhere to the same bits."""

import subprocess
import sys
import time

from clusters import SCHEDULER, WORKER, started
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.keeping.checkpoint import read_checkpoint
from evodevo_ga.keeping.errors import ResumeError
from evodevo_ga.usual import usual_task
from evodevo_sim.parameters import with_settings
from lab import DEADLINE

from evodevo_ga import Evolution, Settings

SETTINGS = Settings(population=16, generations=6)
TASK = with_settings(usual_task("swim"), {"development.max_cells": 12, "control_steps": 1500})
SMALL = ["--population", "16", "--generations", "6", "--cells", "12", "--set", "control_steps=1500", "--seed", "3"]


def evolve(*arguments):
    command = [sys.executable, "-m", "evodevo_ga.evolve", "--quiet", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def kept(directory):
    """What the newest checkpoint has of the search; of generation -1 while there is none."""
    try:
        return read_checkpoint(directory)[0]["evolution"]
    except ResumeError:
        return {"generation": -1}


def test_a_scheduler_that_ends_in_the_middle_is_a_line_and_the_run_goes_on_elsewhere_to_the_same_bits(tmp_path):
    directory = tmp_path / "run"
    with (
        started(SCHEDULER) as (scheduler, address),
        started(WORKER.format(scheduler=address)),
        evolve(*SMALL, "--backend", "dask", "--scheduler", address, "--out", directory) as process,
    ):
        deadline = time.monotonic() + DEADLINE
        while process.poll() is None and kept(directory)["generation"] < 1:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        scheduler.kill()
        _, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2 and 1 <= kept(directory)["generation"] < SETTINGS.generations - 1, stderr
    assert stderr == f"evolve: the Dask scheduler at {address} is gone: start it again, then go on by evolve --resume\n"
    with evolve("--resume", directory, "--backend", "local", "--threads", "1") as process:
        stdout, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode in (0, 1) and "1 thread of this process" in stdout, stderr
    evolution = Evolution(SETTINGS, 3)
    while not evolution.finished:
        evolution.tell(evaluate_all(evolution.ask(), TASK, 3))
    assert kept(directory)["population"] == evolution.state()["population"]
