#!/usr/bin/env python
"""What an archive holds after a run: how many of the kinds of bodies that can be filled, and which gaits, audited.

    python benchmarks/illumination.py --generations 485 --seed 1                # some 50,000 evaluations
    python benchmarks/illumination.py --task walk --generations 200 --csv rows.csv

Fillable are the kinds of bodies that the run fills or that growth alone does: bodies of random genomes and their mutants, spread over
all kinds.
"""

from __future__ import annotations

import argparse
import csv
import os
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from evodevo_ga.archive import Archive
from evodevo_ga.founding import bodies_of_founders
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.usual import usual_task
from evodevo_sim.analysis.gait import GaitError, analyse, track_of_performance
from evodevo_sim.parameters import ParameterError, with_settings
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.task_kinds import names
from evodevo_sim.tasks.audit import audit
from tqdm import tqdm

from evodevo_ga import Evolution, Individual, Settings, scheme
from evodevo_sim import Task, perform

COLUMNS = ("task", "seed", "kind", "fitness", "elongation", "chambers", "gait", "audit")
_LOOKED_AT = 20_000  # growths alone, for what can be filled
_OTHER_SEED = 2**40


def arguments(parser: argparse.ArgumentParser) -> argparse.Namespace:
    parser.add_argument("--task", default="swim", choices=names(), help="what to evolve for (default %(default)s)")
    parser.add_argument("--scheme", default="archive", choices=("archive", "gaits"), help="of the search (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the run (default %(default)s)")
    parser.add_argument("--generations", type=int, default=485, help="of the run (default %(default)s)")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="threads (default %(default)s)")
    parser.add_argument("--least", type=float, default=0.25, help="fitness of elites to look at, of the champion's (default %(default)s)")
    parser.add_argument("--csv", metavar="FILE", help="append a row for every elite looked at")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task")
    return parser.parse_args()


def evolve(task: Task, settings: Settings, name: str, seed: int, workers: int) -> Evolution:
    evolution = Evolution(settings, seed, scheme=name, task=task)
    with tqdm(total=settings.generations, desc=f"{task.name} {seed}", leave=False, mininterval=5.0) as bar:
        while not evolution.finished:
            evolution.tell(evaluate_all(evolution.ask(), task, seed, workers, evolution.bars))
            bar.update()
            bar.set_postfix_str(f"best {evolution.champion.evaluation.fitness:.2f}, {len(evolution.population)} kinds")
    return evolution


def kinds(search: Archive, evolution: Evolution) -> tuple[set, set]:
    """(kinds that the run fills, all that are known to be fillable)."""
    filled = {search.kind_of_body(search.nursery.grow(one.genome)) for one in evolution.population}
    found: set = set()

    def note(grown):
        kind = search.kind_of_body(grown)
        found.update(() if kind is None else (kind,))
        return kind

    more = Settings(**scheme("archive") | {"founders": _LOOKED_AT})
    bodies_of_founders(more, search.nursery, note, np.random.default_rng((evolution.seed, _OTHER_SEED)))
    return filled, filled | found


def row(one: Individual, search: Archive, task: Task, seed: int) -> dict:
    found = audit(one.genome, task, seed, quick=True)
    try:
        gait = analyse(track_of_performance(perform(one.genome, task, seed), task)).gait.name
    except GaitError:
        gait = "none"
    body = search.nursery.grow(one.genome)
    verdict = "stands" if found.stands else "; ".join(found.faults)
    values = (task.name, seed, search.kind(body), one.evaluation.fitness, body.elongation, body.share_of_chambers, gait, verdict)
    return dict(zip(COLUMNS, values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options = arguments(parser)
    try:
        task = with_settings(usual_task(options.task), dict(pairs(options.set)))
    except ParameterError as error:
        parser.exit(2, f"illumination.py: {error}\n")
    settings = Settings(**scheme(options.scheme, options.task) | {"generations": options.generations})
    evolution = evolve(task, settings, options.scheme, options.seed, options.workers)
    search = evolution.search
    filled, fillable = kinds(search, evolution)
    best = evolution.champion.evaluation.fitness
    worth = evolution.evaluations + evolution.growths / 8
    print(f"{worth:.0f} evaluations, growth alone at an eighth; best {best:.2f}; {len(filled)} of {len(fillable)} fillable kinds filled")
    looked_at = [one for one in evolution.population if one.evaluation.fitness >= options.least * best]
    with ThreadPoolExecutor(options.workers) as pool:
        rows = list(pool.map(lambda one: row(one, search, task, options.seed), looked_at))
    for gait, count in Counter(one["gait"] for one in rows if one["audit"] == "stands").most_common():
        farthest = max(one["fitness"] for one in rows if one["gait"] == gait and one["audit"] == "stands")
        print(f"{gait}: {count} elites whose audit stands, the best {farthest:.2f}")
    print(f"{sum(one['audit'] != 'stands' for one in rows)} of {len(rows)} elites failed their audit")
    if options.csv:
        new = not os.path.exists(options.csv)
        with open(options.csv, "a", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            if new:
                writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
