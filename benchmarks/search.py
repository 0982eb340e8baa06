#!/usr/bin/env python
"""Evolution against random search: champions over several seeds, and the best of as many random genomes.

    python benchmarks/search.py --seeds 3 --generations 50
    python benchmarks/search.py --seeds 10 --generations 200 --no-random --set scene.drag_normal=10 --set settings.tournament=3
    python benchmarks/search.py --task walk --seeds 5 --generations 200 --no-random
    python benchmarks/search.py --scheme alps --generations 1000 --no-random --curves alps.csv    # then benchmarks/curves.py draws
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import math
import os
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from evodevo_ga.feasible import check
from evodevo_ga.operators import scatter_scent
from evodevo_ga.usual import law_of, usual_task
from evodevo_sim.analysis.gait import GaitError, analyse, track_of_performance
from evodevo_sim.parameters import with_settings
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.task_kinds import names
from evodevo_sim.tasks.audit import audit
from tqdm import tqdm

from evodevo_ga import SCHEMES, Evolution, Settings, default_scheme, scheme
from evodevo_sim import Evaluation, Genome, GenomeError, ParameterError, Task, evaluate, perform, random_genome, read_genome, save_genome

CHUNK = 500  # random genomes drawn at a time
COLUMNS = (
    "search", "seed", "evaluations", "fitness", "distance", "second_half", "slowest", "amplitude", "cells", "chambers", "status",
    "last_gain", "diversity", "chambered", "oscillating", "seconds", "audit", "gait",
)
CURVE = ("search", "seed", "generation", "evaluations", "fitness", "distance", "second_half", "amplitude", "diversity", "seconds", "born")


def arguments(parser: argparse.ArgumentParser) -> argparse.Namespace:
    parser.add_argument("--seeds", type=int, default=3, help="runs, of seeds FIRST, FIRST + 1, ... (default %(default)s)")
    parser.add_argument("--first", type=int, default=1, help="first seed (default %(default)s)")
    parser.add_argument("--generations", type=int, default=Settings().generations, help="of each run (default %(default)s)")
    parser.add_argument("--task", default="swim", choices=names(), help="what to evolve for (default %(default)s)")
    parser.add_argument("--scheme", choices=SCHEMES, help="of the search (default that of the task); --set goes over it")
    parser.add_argument("--start", nargs="+", default=[], metavar="FILE", help="genomes to begin from")
    parser.add_argument("--random-only", type=int, metavar="N", help="random search alone, with N evaluations of each seed")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="threads (default %(default)s)")
    parser.add_argument("--no-random", action="store_true", help="evolution only")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, or of evolution as settings.NAME")
    parser.add_argument("--csv", metavar="FILE", help="append the rows to a file as well")
    parser.add_argument("--curves", metavar="FILE", help="append a row for every generation there")
    parser.add_argument("--genomes", metavar="DIR", help="keep champions there, as YAML")
    return parser.parse_args()


def evolve(task: Task, settings: Settings, name: str, seed: int, pool: ThreadPoolExecutor, start=()):
    """Run evolution.  Returns: (champion, row of the table, rows of its curve)."""
    evolution, last_gain, began = Evolution(settings, seed, start, name, task), 0, time.monotonic()
    curve = []
    chambered = oscillating = 0
    with tqdm(total=settings.generations, desc=f"{name} {seed}", leave=False, mininterval=5.0) as bar:
        while not evolution.finished:
            asked = evolution.ask()
            bars = evolution.bars or [-math.inf] * len(asked)
            found = list(pool.map(lambda genome, bar: evaluate(genome, task, seed, bar), asked, bars))
            generation = evolution.tell(found)
            last_gain = generation.generation if generation.improved else last_gain
            chambered += sum(one.metrics.chambers > 0 for one in found)
            oscillating += sum(one.metrics.activation_amplitude >= 0.1 for one in found)
            bar.update()
            m = evolution.champion.evaluation.metrics
            about = (generation.diversity, time.monotonic() - began, evolution.champion.born)
            curve.append(point(name, seed, generation.generation, worth(evolution), evolution.champion.evaluation, *about))
            bar.set_postfix_str(f"{m.distance_second_half:.2f} m in the second half, amplitude {m.activation_amplitude:.2f}")
    n = evolution.evaluations
    champion = evolution.champion
    about = (last_gain, generation.diversity, chambered / n, oscillating / n, time.monotonic() - began)
    found = audit(champion.genome, task, seed, quick=True)
    gait = gait_name(champion.genome, task, seed) if found.runs else "none"
    about += ("stands" if found.stands else "; ".join(found.faults), gait)
    return champion, row(name, seed, worth(evolution), champion.evaluation, *about), curve


def worth(evolution: Evolution) -> int:
    """Evaluations, growth alone counted as an eighth of one."""
    return round(evolution.evaluations + evolution.growths / 8)


def gait_name(genome: Genome, task: Task, seed: int) -> str:
    try:
        return analyse(track_of_performance(perform(genome, task, seed), task)).gait.name
    except GaitError:
        return "none"


def search_at_random(task: Task, settings: Settings, seed: int, budget: int, pool: ThreadPoolExecutor):
    """Evaluate `budget` random genomes.

    Returns: (rows: of the highest fitness, and of the longest second half; the curve of the fittest so far, a row where it changes).
    """
    rng, began = np.random.default_rng((seed, 2**32)), time.monotonic()
    best = longest = None
    chambered = oscillating = done = 0
    curve = []
    with tqdm(total=budget, desc=f"random {seed}", leave=False, mininterval=5.0) as bar:
        for first in range(0, budget, CHUNK):
            genomes = [random_genome(rng, settings.units, settings.extent) for _ in range(min(CHUNK, budget - first))]
            if settings.scent_extent:
                genomes = [scatter_scent(genome, rng, settings.scent_extent) for genome in genomes]
            for one in pool.map(lambda genome: evaluate(genome, task, seed), genomes):
                done += 1
                if best is None or one.fitness > best.fitness:
                    best = one
                    curve.append(point("random", seed, 0, done, best, 1.0, time.monotonic() - began))
                if longest is None or one.metrics.distance_second_half > longest.metrics.distance_second_half:
                    longest = one
                chambered += one.metrics.chambers > 0
                oscillating += one.metrics.activation_amplitude >= 0.1
                bar.update()
    curve.append(point("random", seed, 0, budget, best, 1.0, time.monotonic() - began))
    about = (0, 1.0, chambered / budget, oscillating / budget, time.monotonic() - began)
    return [row("random: fittest", seed, budget, best, *about), row("random: farthest", seed, budget, longest, *about)], curve


def point(
    search: str, seed: int, generation: int, evaluations: int, e: Evaluation, diversity: float, seconds: float, born: int = 0
) -> dict:
    """A row of a curve: the best so far after so many evaluations.  Args: born: generation in which its oldest line began."""
    m = e.metrics
    values = (
        search, seed, generation, evaluations, e.fitness, m.distance, m.distance_second_half, m.activation_amplitude, diversity, seconds,
        born,
    )
    return dict(zip(CURVE, values))


def row(
    search: str, seed: int, evaluations: int, e: Evaluation, last_gain, diversity, chambered, oscillating, seconds, verdict="", gait=""
) -> dict:
    m = e.metrics
    values = (
        search, seed, evaluations, e.fitness, m.distance, m.distance_second_half, m.slowest_window, m.activation_amplitude, m.cells,
        m.chambers, e.status.name, last_gain, diversity, chambered, oscillating, seconds, verdict, gait,
    )
    return dict(zip(COLUMNS, values))


def split(items: list[str]) -> tuple[dict, dict]:
    """`name=value` texts into numbers of the task and, without their prefix, those of evolution."""
    numbers = pairs(items)
    whole = {field.name: type(field.default) for field in dataclasses.fields(Settings)}
    of_task, of_settings = {}, {}
    for name, value in numbers.items():
        own = name.removeprefix("settings.")
        if own == name:
            of_task[name] = value
        elif own not in whole:
            raise ParameterError(f"setting {name!r} is unknown: choose one of {', '.join(whole)}")
        else:
            try:
                of_settings[own] = whole[own](value)
            except ValueError:
                raise ParameterError(f"{name} is {value!r}: give a number") from None
    return of_task, of_settings


def text(value) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def print_table(rows: list[dict]) -> None:
    lines = [COLUMNS] + [tuple(text(one[name]) for name in COLUMNS) for one in rows]
    widths = [max(len(line[k]) for line in lines) for k in range(len(COLUMNS))]
    for line in lines:
        print("  ".join(value.rjust(width) for value, width in zip(line, widths)))
    for search in dict.fromkeys(one["search"] for one in rows):
        halves, whole, amplitude = (
            np.array([one[name] for one in rows if one["search"] == search]) for name in ("second_half", "distance", "amplitude")
        )
        print(
            f"{search}: median {np.median(halves):.3f} m in the second half ({halves.min():.3f} to {halves.max():.3f}), "
            f"{np.median(whole):.3f} m in all ({whole.min():.3f} to {whole.max():.3f}), amplitude {np.median(amplitude):.2f}"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options = arguments(parser)
    try:
        of_task, of_settings = split(options.set)
        files = [read_genome(name) for name in options.start]
        task = with_settings(usual_task(options.task, options.scheme or ""), law_of(files) | of_task)
        name = options.scheme or default_scheme(options.task, of_settings, task.development.max_cells, bool(options.start))
        settings = Settings(**scheme(name, options.task) | {"generations": options.generations} | of_settings)
        start = tuple(file.genome for file in files)
        check(task, settings, start)
    except (ParameterError, GenomeError) as error:
        parser.exit(2, f"search.py: {error}\n")
    rows = []
    with ThreadPoolExecutor(options.workers) as pool:
        for seed in range(options.first, options.first + options.seeds):
            budget = options.random_only
            if budget is None:
                champion, one, curve = evolve(task, settings, name, seed, pool, start)
                rows.append(one)
                budget = one["evaluations"]
                append(options.curves, options.set, CURVE, curve)
                keep(options.genomes, name, seed, champion, task)
            if not options.no_random:
                found, curve = search_at_random(task, settings, seed, budget, pool)
                rows += found
                append(options.curves, options.set, CURVE, curve)
    print(" ".join(options.set) or "defaults")
    print_table(rows)
    append(options.csv, options.set, COLUMNS, rows)


def keep(directory: str | None, name: str, seed: int, champion, task: Task) -> None:
    """Write the genome of a champion, if that was asked for."""
    if directory:
        os.makedirs(directory, exist_ok=True)
        save_genome(os.path.join(directory, f"{name}-{seed}.yaml"), champion.genome, {"scheme": name, "seed": seed}, task.development)


def append(path: str | None, settings: list[str], columns: tuple[str, ...], rows: list[dict]) -> None:
    """Add rows to a CSV file, if one was asked for."""
    if not path:
        return
    new = not os.path.exists(path)
    with open(path, "a", newline="") as file:
        writer = csv.DictWriter(file, ("settings", *columns))
        if new:
            writer.writeheader()
        writer.writerows({"settings": " ".join(settings), **one} for one in rows)


if __name__ == "__main__":
    main()
