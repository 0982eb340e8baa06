#!/usr/bin/env python
"""Evaluations a second by 1 and 2 workers: threads of this process, as `evolve` in one process has, and processes.

    python benchmarks/workers.py [--quick] [--out DIR]

The population are mutants of benchmarks/swimmer.yaml.  The ways take turns.  The clock on the wall says what a second
worker brought while other work on the machine took its share; the processors' time says what it would bring on two free cores,
since all that workers cost each other there is time of processors.
"""

from __future__ import annotations

import multiprocessing
import os
import time

import numpy as np
import psutil
from common import TINY, Figure, champion, champion_task, main, write_csv
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.operators import mutate_points
from tqdm import tqdm

from evodevo_ga import Settings
from evodevo_sim import evaluate

PART = "workers"
WAYS = ("1 thread", "2 threads", "2 processes")


def population(size):
    rng, s = np.random.default_rng(0), Settings()
    return [champion()] + [mutate_points(champion(), rng, s.point_mutation, s.point_scale) for _ in range(size - 1)]


def processors():
    """CPU seconds of this process and its children so far."""
    me = psutil.Process()
    return sum(sum(process.cpu_times()[:2]) for process in (me, *me.children()))


def run(effort, out):
    size, rounds = ((2, 1), (12, 2), (24, 5))[effort]
    genomes, task = population(size), champion_task(control_steps=2000 if effort > TINY else 20)
    pairs = [(genome, task) for genome in genomes]
    wall, cpu = {name: [] for name in WAYS}, {name: [] for name in WAYS}
    context = multiprocessing.get_context("spawn")
    with context.Pool(2) as pool:
        ways = dict(zip(WAYS, (
            lambda: evaluate_all(genomes, task, 0, 1),
            lambda: evaluate_all(genomes, task, 0, 2),
            lambda: pool.starmap(evaluate, pairs, chunksize=1),
        )))
        results = [way() for way in ways.values()]  # warm
        if any(result != results[0] for result in results):
            raise AssertionError("workers: other bits by other workers")
        for k in tqdm(range(rounds), desc="workers", leave=False):
            for name in WAYS[:: 1 if k % 2 else -1]:
                began, spent = time.perf_counter(), processors()
                ways[name]()
                wall[name].append(time.perf_counter() - began)
                cpu[name].append(processors() - spent)
    table = [(name, k, size, wall[name][k], cpu[name][k]) for name in WAYS for k in range(rounds)]
    write_csv(out / "workers.csv", [dict(zip(("way", "round", "genomes", "wall_s", "cpu_s"), row)) for row in table])
    least = ({name: min(values) for name, values in clock.items()} for clock in (wall, cpu))
    return conclusions(size, *least)


def conclusions(size, wall, cpu):
    figures = [Figure(PART, "1 thread: evaluations a second of 32 cells", f"{size / wall['1 thread']:.1f}")]
    for kind in ("threads", "processes"):
        text = f"{wall['1 thread'] / wall[f'2 {kind}']:.2f} times as fast by the wall's clock"
        if cpu[f"2 {kind}"] > 0.0:
            text += f", {2 * cpu['1 thread'] / cpu[f'2 {kind}']:.2f} by the processors' time"
        figures.append(Figure(PART, f"2 {kind} against 1 thread, {len(os.sched_getaffinity(0))} cores, same bits", text))
    return figures


if __name__ == "__main__":
    main(run, __doc__)
