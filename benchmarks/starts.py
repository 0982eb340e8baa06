#!/usr/bin/env python
"""What averaging over N starts costs and brings: how well two rankings of the same walkers from other starts agree.

Walkers are a champion's or a random population's children: the genomes of GENOMES files, each with mutants around it.  Every
one is evaluated from MANY orientations; rankings by means over N of them are then compared with rankings by means over N
others (Kendall's tau), and a tournament's choice of the better of two with the truth of all.

    python benchmarks/starts.py bags/walk/champion.yaml ... [--mutants 40] [--many 32]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from evodevo_ga.evolution import Settings
from evodevo_ga.operators import flip, mutate_points
from evodevo_sim.parameters import with_settings
from evodevo_sim.tasks.walk.fitness import fitness_by_start, headings
from scipy.stats import kendalltau
from tqdm import tqdm

from evodevo_sim import evaluate, read_genome

COUNTS = (1, 2, 3, 4, 8, 16)
REPEATS = 200


def mutants(genome, count, rng):
    s = Settings()
    return [flip(mutate_points(genome, rng, s.point_mutation, s.point_scale), rng, s.flip) for _ in range(count)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("genomes", nargs="+", metavar="GENOME")
    parser.add_argument("--mutants", type=int, default=40, help="of each genome (default %(default)s)")
    parser.add_argument("--many", type=int, default=32, help="orientations (default %(default)s)")
    options = parser.parse_args()
    rng, files = np.random.default_rng(0), [read_genome(path) for path in options.genomes]
    population = [(g, file.task("walk")) for file in files for g in [file.genome, *mutants(file.genome, options.mutants, rng)]]
    directions, table = headings(12345, options.many), []
    for genome, task in tqdm(population, mininterval=5.0, leave=False):
        fitness = fitness_by_start(genome, task, directions)
        if fitness.max() > 2 * task.activity_bonus:
            table.append(fitness)
    table = np.array(table)
    cost = [_seconds(*population[0], n) for n in COUNTS]
    print(f"{len(table)} of {len(population)} walkers move; spread of one by starts: median standard deviation / mean = "
          f"{np.median(table.std(1) / table.mean(1)):.2f}; of means between walkers {table.mean(1).std() / table.mean(1).mean():.2f}")
    print("starts  ms    tau    right choice of two")
    for n, seconds in zip(COUNTS, cost):
        taus, right = [], []
        for _ in range(REPEATS):
            order = rng.permutation(options.many)
            one = table[:, order[:n]].mean(1)
            other = table[:, order[n : 2 * n]].mean(1)
            taus.append(kendalltau(one, other).statistic)
            a, b = rng.integers(len(table), size=(2, 200))
            truth = table[:, order[n:]].mean(1)
            apart = a != b
            right.append(((one[a] > one[b]) == (truth[a] > truth[b]))[apart].mean())
        print(f"{n:6d}  {1e3 * seconds:4.0f}  {np.mean(taus):5.2f}  {np.mean(right):5.2f}")


def _seconds(genome, task, starts):
    """CPU seconds of an evaluation, the median of five."""
    task, times = with_settings(task, {"starts": starts}), []
    for _ in range(5):
        begin = time.thread_time()
        evaluate(genome, task, 1)
        times.append(time.thread_time() - begin)
    return float(np.median(times))


if __name__ == "__main__":
    main()
