#!/usr/bin/env python
"""Evaluations a second by 1 and 2 workers: threads of this process, as `evolve` in one process has, and processes.

    python benchmarks/workers.py [--quick] [--out DIR]

The population are mutants of the champion of bags/sample-swim.  The ways take turns; by the clock on the wall, since that is what
a second worker is for: other work on the machine shows.
"""

from __future__ import annotations

import multiprocessing
import os
import time

import numpy as np
from common import TINY, Figure, champion, main, write_csv
from evodevo_ga import Settings
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.operators import mutate_points
from evodevo_sim import Task, evaluate
from tqdm import tqdm

PART = "workers"


def population(size):
    rng, s = np.random.default_rng(0), Settings()
    return [champion()] + [mutate_points(champion(), rng, s.point_mutation, s.point_scale) for _ in range(size - 1)]


def run(effort, out):
    size, rounds = ((2, 1), (16, 2), (60, 7))[effort]
    genomes, task = population(size), Task(control_steps=2000 if effort > TINY else 20)
    seconds = {name: [] for name in ("1 thread", "2 threads", "1 process", "2 processes")}
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as one, context.Pool(2) as two:
        ways = dict(zip(seconds, (
            lambda: evaluate_all(genomes, task, 0, 1),
            lambda: evaluate_all(genomes, task, 0, 2),
            lambda: one.starmap(evaluate, [(genome, task) for genome in genomes], chunksize=1),
            lambda: two.starmap(evaluate, [(genome, task) for genome in genomes], chunksize=1),
        )))
        results = [way() for way in ways.values()]  # warm
        if any(result != results[0] for result in results):
            raise AssertionError("workers: other bits by other workers")
        for k in tqdm(range(rounds), desc="workers", leave=False):
            for name in list(ways)[:: 1 if k % 2 else -1]:
                began = time.perf_counter()
                ways[name]()
                seconds[name].append(time.perf_counter() - began)
    write_csv(out / "workers.csv", [
        {"way": name, "genomes": size, "per_second": size / min(values), "median_per_second": size / np.median(values)} for name, values in seconds.items()
    ])
    least = {name: min(values) for name, values in seconds.items()}
    cores = len(os.sched_getaffinity(0))
    figures = [Figure(PART, "1 thread: evaluations a second of 32 cells", f"{size / least['1 thread']:.1f}")]
    for kind in ("threads", "processes"):
        ratios = np.array(seconds["1 thread"]) / np.array(seconds[f"2 {kind}"])
        text = f"{least['1 thread'] / least[f'2 {kind}']:.2f} of the best rounds, {np.median(ratios):.2f} in the median"
        figures.append(Figure(PART, f"2 {kind} against 1 thread, {cores} cores, same bits", text))
    return figures


if __name__ == "__main__":
    main(run, __doc__)
