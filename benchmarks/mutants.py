#!/usr/bin/env python
"""What point mutation does to champions: the shares of their children that are better, near, worse, dead, by rate and scale.

    python benchmarks/mutants.py src/evodevo_sim/champions/{undulator,jellyfish}.yaml --children 300
    python benchmarks/mutants.py champion.yaml --rates 0.03 --scales 0.03 0.1 0.3 1
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from evodevo_ga.operators import delete, duplicate, flip, mutate_points
from evodevo_sim.ros.command_line import pairs
from rich.console import Console
from rich.table import Table
from tqdm import tqdm

from evodevo_ga import Settings
from evodevo_sim import Genome, evaluate, read_genome

SHARES = ("better", "better by 1 %", "as good", "within half", "below half", "none left")


def child(genome: Genome, rng: np.random.Generator, rate: float, scale: float) -> Genome:
    """A child as evolution makes it without a father, but for the rate and scale of its point mutation."""
    s = Settings()
    if rng.random() < s.duplication:
        genome = duplicate(genome, rng, s.run_length)
    if rng.random() < s.deletion:
        genome = delete(genome, rng, s.run_length)
    return flip(mutate_points(genome, rng, rate, scale), rng, s.flip)


def shares(fitness: np.ndarray, parent: float) -> list[float]:
    """Shares of SHARES, of which the second is a part of the first, and the others add up to 1."""
    change = fitness / parent - 1.0
    cuts = change > 0, change > 0.01, change == 0, (change < 0) & (change >= -0.5), (change < -0.5) & (change > -0.95), change <= -0.95
    return [float(cut.mean()) for cut in cuts]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("genomes", nargs="+", metavar="GENOME")
    parser.add_argument("--children", type=int, default=100, help="of each champion, rate and scale (default %(default)s)")
    parser.add_argument("--rates", type=float, nargs="+", default=[0.012, 0.03, 0.1], metavar="X", help="probability per element")
    parser.add_argument("--scales", type=float, nargs="+", default=[0.03, 0.1, 0.3, 1.0, 3.0], metavar="X", help="of the moves")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="threads (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, e.g. scene.drag_normal=10")
    options = parser.parse_args()
    files = [read_genome(name) for name in options.genomes]
    champions = [(file.genome, file.task(settings=pairs(options.set))) for file in files]
    parents = [evaluate(genome, task, options.seed).fitness for genome, task in champions]
    if min(parents) <= 0.0:
        parser.error(f"{options.genomes[int(np.argmin(parents))]} earns {min(parents):.3g} in this task: give champions that move")
    ways = [(rate, scale) for rate in options.rates for scale in options.scales]

    table = Table(
        "rate, scale", *SHARES, title=f"{len(champions)} champions, {options.children} children each; per cent, mean over champions"
    )
    with (
        ThreadPoolExecutor(options.workers) as pool,
        tqdm(total=len(ways) * len(champions) * options.children, unit="child", leave=False) as bar,
    ):
        for rate, scale in ways:
            found = []
            for (genome, task), parent in zip(champions, parents):
                rng = np.random.default_rng(options.seed)
                children = [child(genome, rng, rate, scale) for _ in range(options.children)]
                fitness = []
                for evaluation in pool.map(lambda one, task=task: evaluate(one, task, options.seed), children):
                    fitness.append(evaluation.fitness)
                    bar.update()
                found.append(shares(np.array(fitness), parent))
            table.add_row(f"{rate:g}, {scale:g}", *(f"{100 * share:.1f}" for share in np.mean(found, 0)))
    Console().print(table)


if __name__ == "__main__":
    main()
