#!/usr/bin/env python
"""How far evolution scales, by each backend: the parts measured on this computer, then up to 64 hosts computed from them.

    python benchmarks/scaling.py [--population 100 1000 10000] [--cores 16] [--longer 10]

Measured: seconds of an evaluation on one core, over genomes of a run; the serial part of a generation (breeding, telling, checkpoint);
bytes of a batch and its answer on the wire; seconds that the process of `evolve`, and the scheduler of Dask, spend on a batch.
Computed: generations in which one process deals batches to so many cores, each batch after its serial share, by the pool's own sizes of
batches.  Networks add `--latency` to a batch.  The script takes the processors' time, so other work on the machine counts little.
"""

from __future__ import annotations

import argparse
import heapq
import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from evodevo_ga.backends.contract import Answer, Batch
from evodevo_ga.backends.dask import DaskBackend
from evodevo_ga.backends.plain import answer_of_plain, batch_of_plain, plain_answer, plain_batch
from evodevo_ga.pool.pace import Pace
from evodevo_ga.schemes import scheme
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import evaluation_from_message, evaluation_message, genome_from_message, genome_message, task_message
from evodevo_sim.tasks.evaluation import prepare
from rclpy.serialization import deserialize_message, serialize_message

from evodevo_ga import Evolution, Settings
from evodevo_msgs.msg import Evaluation as EvaluationMessage
from evodevo_msgs.msg import Genome as GenomeMessage
from evodevo_sim import Task, evaluate, random_genome

HOSTS = (1, 2, 4, 8, 16, 32, 64)
SEED = 1
# A genome that costs next to nothing: what a batch of it takes is the backend's own.
TRIFLE = with_settings(Task(), {"development.max_cells": 1, "development.steps": 1, "control_steps": 2, "windows": 2})


def cpu(function, repeats):
    """CPU seconds of a call in this thread, the least of five means."""
    best = np.inf
    for _ in range(5):
        began = time.thread_time()
        for _ in range(repeats):
            function()
        best = min(best, (time.thread_time() - began) / repeats)
    return best


def evolved(population, generations, task):
    """(CPU s of each evaluation of the last generation, CPU s of ask and tell in it, the batch that it was)."""
    settings = Settings(**scheme("panmictic", task.name) | {"population": population, "generations": generations})
    evolution, each, serial, batch = Evolution(settings, SEED), [], 0.0, None
    while not evolution.finished:
        began = time.thread_time()
        genomes = evolution.ask()
        serial, evaluations, each = time.thread_time() - began, [], []
        for genome in genomes:
            began = time.thread_time()
            evaluations.append(evaluate(genome, task, SEED))
            each.append(time.thread_time() - began)
        batch = Batch(tuple(genomes), task, SEED), Answer(evaluations, "")
        began = time.thread_time()
        evolution.tell(evaluations)
        serial += time.thread_time() - began
    began = time.thread_time()
    evolution.state()
    return np.array(each), serial + 2.0 * (time.thread_time() - began), batch


def wires(batch, answer):
    """By backend: (bytes of an evaluation's request, of its answer, CPU s of `evolve` for it), in a batch of 16."""
    part, told = Batch(batch.genomes[:16], batch.task, batch.seed), Answer(answer.evaluations[:16], "")
    count = len(part.genomes)

    def ros_out():
        return [serialize_message(task_message(part.task)), *(serialize_message(genome_message(genome)) for genome in part.genomes)]

    def ros_back():
        return [serialize_message(evaluation_message(one)) for one in told.evaluations]

    sent, came = ros_out(), ros_back()

    def ros():
        ros_out()
        for data in came:
            evaluation_from_message(deserialize_message(data, EvaluationMessage))

    packed, back = pickle.dumps(plain_batch(part)), pickle.dumps(plain_answer(told))

    def dask():
        pickle.dumps(plain_batch(part))
        answer_of_plain(pickle.loads(back), "")

    for data in sent[1:]:
        genome_from_message(deserialize_message(data, GenomeMessage))
    batch_of_plain(pickle.loads(packed))
    return {
        "ros": (sum(map(len, sent)) / count, sum(map(len, came)) / count, cpu(ros, 20) / count),
        "dask": (len(packed) / count, len(back) / count, cpu(dask, 20) / count),
        "local": (0.0, 0.0, 0.0),
    }


def dask_batches(batches):
    """Batches of a trifle through a real scheduler and worker: (CPU s of this process, of the scheduler, for a batch)."""
    code = (
        "import asyncio, distributed\n"
        "async def main():\n"
        "    async with distributed.Scheduler(host='127.0.0.1', port=0, dashboard_address='127.0.0.1:0') as s:\n"
        "        print(s.address, flush=True)\n"
        "        await s.finished()\n"
        "asyncio.run(main())\n"
    )
    worker = "from distributed.cli.dask_worker import main; main()"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as scheduler:
        address = scheduler.stdout.readline().strip()
        command = [
            sys.executable, "-c", worker, address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1",
        ]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            backend = DaskBackend(address, TRIFLE)
            while not (there := dict(backend.workers)):
                time.sleep(0.05)
            [name] = there
            batch = Batch((random_genome(np.random.default_rng(0)),), TRIFLE, SEED)
            backend.submit(batch, name).result()
            mine, theirs = time.process_time(), processor_time(scheduler.pid)
            futures = [backend.submit(batch, name) for _ in range(batches)]
            for future in futures:
                future.result()
            spent = (time.process_time() - mine) / batches, (processor_time(scheduler.pid) - theirs) / batches
            backend.close()
            process.terminate()
        scheduler.terminate()
    return spent


def processor_time(number):
    fields = Path(f"/proc/{number}/stat").read_text(encoding="ascii").rpartition(") ")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def generation(times, slots, per_batch, per_genome, latency, serial):
    """Wall seconds of a generation, dealt by one process to so many cores.

    Args: times: s of each evaluation; per_batch, per_genome: s of the process that deals; latency: s; serial: s before and after.
    """
    pace, free, now, at, last = Pace(), [0.0] * slots, 0.0, 0, 0.0
    pace.seconds = float(times.mean())
    heapq.heapify(free)
    while at < len(times):
        size = pace.size(len(times) - at, slots, per_batch if per_batch > 1e-3 else 0.0)
        now += per_batch + per_genome * size  # the dealer does one batch after the other
        core = heapq.heappop(free)
        ended = max(core, now + latency) + float(times[at : at + size].sum())
        heapq.heappush(free, ended)
        last, at = max(last, ended + latency), at + size
    return serial + last


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--population", type=int, nargs="+", default=[100, 1000, 10_000])
    parser.add_argument("--cores", type=int, default=16, help="of a host")
    parser.add_argument("--generations", type=int, default=12, help="of the run that is measured")
    parser.add_argument("--longer", type=float, default=1.0, help="times as long as measured an evaluation takes, e.g. 10 for a walk")
    parser.add_argument("--batches", type=int, default=300)
    parser.add_argument("--latency", type=float, default=1e-3, help="s, of a network")
    given = parser.parse_args()
    task = default_task("swim")
    prepare(task)
    each, serial, (batch, answer) = evolved(100, given.generations, task)
    wire, (mine, theirs) = wires(batch, answer), dask_batches(given.batches)
    # A batch of ROS costs its process what its messages cost; of Dask, also its client, or its scheduler where that takes longer.
    per_batch = {"local": 2e-5, "ros": wire["ros"][2], "dask": max(mine, theirs)}
    print(f"an evaluation: {each.mean() * 1e3:.2f} ms of one core in the mean, {np.median(each) * 1e3:.2f} in the middle, "
          f"{each.max() * 1e3:.1f} at the most; {1.0 / each.mean():.0f} a second and core")
    print(f"serial part of a generation of 100: {serial * 1e3:.1f} ms of breeding, telling, state")
    for name, (out, back, seconds) in wire.items():
        print(f"{name}: {out:.0f} bytes out and {back:.0f} back an evaluation, {seconds * 1e6:.0f} us of evolve's process")
    print(f"dask: {mine * 1e3:.2f} ms of evolve's process and {theirs * 1e3:.2f} ms of the scheduler for a batch\n")
    rng = np.random.default_rng(0)
    for population in given.population:
        times, part = given.longer * rng.choice(each, population), serial * population / 100
        print(f"| cores | {' | '.join(f'{name}, evaluations/s' for name in per_batch)} |")
        saturated = {}
        for hosts in (0, *HOSTS):
            slots, row = hosts * given.cores or 1, []
            for name, cost in per_batch.items():
                seconds = generation(times, slots, cost, wire[name][2], given.latency if name != "local" else 0.0, part)
                row.append(population / seconds)
                ideal = slots / times.mean()
                if population / seconds < 0.5 * ideal:
                    saturated.setdefault(name, slots)
            print(f"| {slots} | " + " | ".join(f"{rate:,.0f}" for rate in row) + " |")
        print(f"population {population}: half of the cores wait from {saturated} cores on\n", flush=True)


if __name__ == "__main__":
    main()
