#!/usr/bin/env python
"""How well bodies are inherited under a law of growth: bodies are evolved towards a shape, and the mutants of each champion grown.

    python benchmarks/inheritance.py --seeds 10
    python benchmarks/inheritance.py --seeds 10 --preset contact_inhibition
    python benchmarks/inheritance.py --seeds 10 --shape ell --set development.division_room=0.6

Two bodies are of one shape where the mean distance from a cell of one to the nearest of the other is below KEPT, both turned to their
principal axes.  Fitness is how near the body comes to the shape, at a spacing of 1.  Laws are compared by bodies that evolved under
each, since a champion of one law was not selected under another.
"""

from __future__ import annotations

import argparse

import numpy as np
from evodevo_sim.parameters import ParameterError, preset, with_settings
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.tasks.life import develop
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from rich.console import Console
from rich.table import Table
from tqdm import trange

from evodevo_ga import Evolution, Settings
from evodevo_sim import Evaluation, Genome, Metrics, Status, Task, random_genome

KEPT = 0.1  # m
SCALES = (0.0003, 0.003, 0.01)  # of moves of all points
_FEWEST = 4, 12  # cells of a body that is compared with the shape, and of a random one that counts
_FAR = 5.0  # m, that smaller bodies are taken to be from any shape
_NOBODY = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)


def lattice(columns: int, rows: int) -> np.ndarray:
    """(N, 2) m of cells packed as close as they get."""
    return np.array([(c + 0.5 * (r % 2), r * np.sqrt(0.75)) for r in range(rows) for c in range(columns)])


SHAPES = {
    "ribbon": lattice(10, 3),
    "ell": np.array([p for p in lattice(9, 9) if p[1] < 1.8 or p[0] < 2.1])[:32],
    "disc": lattice(6, 5),
}


def grown(genome: Genome, task: Task) -> np.ndarray:
    """(N, 2) m of the cells of a genome's body."""
    return develop(*kernel_arguments(genome, task), *_NOBODY)[2].position


def turned(p: np.ndarray) -> np.ndarray:
    """Cells about their centre, along their principal axes."""
    q = p - p.mean(0)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
    return q @ (axes * np.array([1.0, np.sign(np.linalg.det(axes))]))


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Mean distance in m from a cell of one body to the nearest of the other, both ways, the better of two turns."""
    if min(len(a), len(b)) < _FEWEST[0]:
        return 0.0 if len(a) == len(b) else _FAR
    a, b = turned(a), turned(b)
    distances = [np.linalg.norm(a[:, None] - sign * b, axis=-1) for sign in (1.0, -1.0)]
    return float(min(0.5 * (d.min(0).mean() + d.min(1).mean()) for d in distances))


def spaced(p: np.ndarray) -> np.ndarray:
    """A body with a mean distance of 1 between a cell and its nearest neighbour."""
    distances = np.linalg.norm(p[:, None] - p, axis=-1) + np.diag(np.full(len(p), np.inf))
    return p / max(1e-6, float(distances.min(1).mean()))


def moved(genome: Genome, rng: np.random.Generator, length: np.ndarray) -> Genome:
    """A genome whose points are moved by `length` (elements,) in random directions."""
    direction = rng.uniform(0.0, 2.0 * np.pi, len(genome))
    return Genome(genome.kind, genome.sign, genome.x + length * np.cos(direction), genome.y + length * np.sin(direction))


def inherited(genome: Genome, task: Task, mutants: int) -> list[float]:
    """Shares of mutants: kept (one element moved by 0.1), with the same bits, kept of those with others; kept (all moved) by SCALES."""
    rng, body = np.random.default_rng(3), grown(genome, task)
    bodies = [grown(moved(genome, rng, 0.1 * (np.arange(len(genome)) == rng.integers(len(genome)))), task) for _ in range(mutants)]
    same = np.array([np.array_equal(one, body) for one in bodies])
    kept = np.array([apart(body, one) < KEPT for one in bodies])
    every = []
    for scale in SCALES:
        lengths = [np.abs(rng.normal(0.0, scale, len(genome))) for _ in range(max(1, mutants // 4))]
        every.append(float(np.mean([apart(body, grown(moved(genome, rng, length), task)) < KEPT for length in lengths])))
    return [float(kept.mean()), float(same.mean()), float(kept[~same].mean()) if not same.all() else np.nan, *every]


def evolved(task: Task, shape: np.ndarray, seed: int, generations: int) -> tuple[Genome, float]:
    """The champion of a short run towards a shape, and its distance from it in m."""
    settings = Settings(population=60, generations=generations, point_decades=1.0, tournament=2, founders=400)
    evolution = Evolution(settings, seed)
    while not evolution.finished:
        bodies = [grown(genome, task) for genome in evolution.ask()]
        distances = [apart(shape, spaced(body)) if len(body) >= _FEWEST[0] else _FAR for body in bodies]
        evolution.tell([Evaluation(-d, Status.OK, "", Metrics(cells=len(body))) for d, body in zip(distances, bodies)])
    return evolution.champion.genome, -evolution.champion.evaluation.fitness


def unlike(task: Task, genomes: int) -> tuple[int, int]:
    """Of random genomes: bodies none of which is of the shape of another, and bodies, of twelve cells or more."""
    bodies = [grown(random_genome(np.random.default_rng(10**6 + k)), task) for k in range(genomes)]
    large, leaders = [body for body in bodies if len(body) >= _FEWEST[1]], []
    for body in large:
        if all(apart(body, other) >= KEPT for other in leaders):
            leaders.append(body)
    return len(leaders), len(large)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10, help="runs (default %(default)s)")
    parser.add_argument("--first", type=int, default=1, help="seed of the first run (default %(default)s)")
    parser.add_argument("--generations", type=int, default=45, help="of 60, of each run (default %(default)s)")
    parser.add_argument("--mutants", type=int, default=100, help="of each champion (default %(default)s)")
    parser.add_argument("--genomes", type=int, default=400, help="at random, to count unlike bodies (default %(default)s)")
    parser.add_argument("--shape", choices=SHAPES, default="ribbon", help="to evolve towards (default %(default)s)")
    parser.add_argument("--preset", metavar="NAME", help="of the model, e.g. contact_inhibition")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, e.g. development.division_room=0.6")
    options = parser.parse_args()
    if min(options.seeds, options.generations, options.mutants, options.genomes) < 1 or options.first < 0:
        parser.error("give 1 or more of seeds, generations, mutants and genomes, and 0 or more as the first seed")
    try:
        task = with_settings(Task(), (preset(options.preset) if options.preset else {}) | dict(pairs(options.set)))
    except ParameterError as error:
        parser.error(str(error))
    rows = []
    for seed in trange(options.first, options.first + options.seeds, unit="run", leave=False):
        champion, distance = evolved(task, SHAPES[options.shape], seed, options.generations)
        rows.append([distance, *inherited(champion, task, options.mutants)])
    names = ("distance, m", "kept, one element by 0.1", "same bits", "kept of the others", *(f"kept, all points by {s:g}" for s in SCALES))
    table = Table("of champions", "mean", "standard error", "least", "most", title=f"{options.shape}, {options.seeds} seeds")
    for name, column in zip(names, np.array(rows).T):
        column = column[np.isfinite(column)]
        error = column.std(ddof=1) / np.sqrt(len(column)) if len(column) > 1 else np.nan
        table.add_row(name, *(f"{value:.2f}" for value in (column.mean(), error, column.min(), column.max())) if len(column) else ())
    found = "{} unlike bodies among {} of {} random genomes".format(*unlike(task, options.genomes), options.genomes)
    Console().print(table, found)


if __name__ == "__main__":
    main()
