#!/usr/bin/env python
"""What champions are worth with some of their muscles dead: fitness and distance by the number of cells that fail.

    python benchmarks/damage.py src/evodevo_sim/champions/undulator.yaml src/evodevo_sim/champions/peristalsis.yaml
    python benchmarks/damage.py --task walk src/evodevo_sim/champions/walker.yaml --at 5 --lots 20 --out out

Cells are drawn by lot, LOTS times for each number, and fail when AT seconds have passed.  Writes damage.csv and damage.png.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from common import options, plt, save, write_csv
from evodevo_sim.inputs import InputError
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording.champion import Champion, champion_of
from evodevo_sim.ros.command_line import pairs
from rich.console import Console
from rich.table import Table
from tqdm import tqdm

from evodevo_sim import evaluate

PARTS = 8  # of the cells, between whole and dead


def numbers(cells: int) -> list[int]:
    """How many cells fail: one, and parts of them all."""
    return sorted({0, 1, *(round(cells * k / PARTS) for k in range(1, PARTS + 1))})


def curve(champion: Champion, at: float, lots: int) -> list[dict[str, object]]:
    """A row for each number of failed cells: means over the lots, and of fitness the standard deviation."""
    cells = evaluate(champion.genome, champion.task, champion.seed).metrics.cells
    rows: list[dict[str, object]] = []
    for count in tqdm(numbers(cells), desc=champion.name, leave=False):
        task = with_settings(champion.task, {"rig.failures": count, "rig.fail_at": at})
        seeds = range(champion.seed, champion.seed + (lots if 0 < count < cells or task.has_ground else 1))
        found = [evaluate(champion.genome, task, seed) for seed in seeds]
        fitness, distance = (np.array(values) for values in zip(*((one.fitness, one.metrics.distance) for one in found)))
        rows.append({
            "champion": champion.name, "task": task.name, "at": at, "cells": cells, "failed": count, "lots": len(found),
            "fitness": fitness.mean(), "spread": fitness.std(), "distance": distance.mean(),
            "failures": sum(bool(one.cause) for one in found),
        })
    return rows


def draw(curves: list[list[dict[str, object]]], path: Path) -> None:
    """Fitness as a share of that without damage, by the share of cells that failed."""
    figure, axes = plt.subplots(figsize=(5, 3.4), layout="constrained")
    for rows in curves:
        failed, fitness, spread = (np.array([row[name] for row in rows], float) for name in ("failed", "fitness", "spread"))
        x, y, dy = 100 * failed / rows[0]["cells"], 100 * fitness / fitness[0], 100 * spread / fitness[0]
        line = axes.plot(x, y, "o-", markersize=3, label=rows[0]["champion"])[0]
        axes.fill_between(x, y - dy, y + dy, color=line.get_color(), alpha=0.2, linewidth=0)
    axes.set(xlabel="cells that failed, %", ylabel="fitness, % of that without damage", ylim=(0, None), xlim=(0, 100))
    axes.legend(frameon=False)
    save(figure, path)


def show(curves: list[list[dict[str, object]]]) -> None:
    table = Table("champion", "failed", "of cells", "fitness m", "spread", "of the whole", "distance m")
    for rows in curves:
        for row in rows:
            share = row["fitness"] / rows[0]["fitness"]
            values = [row["fitness"], row["spread"], share, row["distance"]]
            table.add_row(str(row["champion"]), str(row["failed"]), str(row["cells"]), *(f"{value:.2f}" for value in values))
    Console().print(table)


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("sources", nargs="+", metavar="GENOME|BAG")
    parser.add_argument("--task", default="swim", help="of genome files (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a number of that task")
    parser.add_argument("--at", type=float, default=0.0, metavar="S", help="when they fail (default %(default)s)")
    parser.add_argument("--lots", type=int, default=10, metavar="N", help="draws for each number of cells (default %(default)s)")
    given = parser.parse_args()
    try:
        champions = [champion_of(source, pairs(given.set), given.task) for source in given.sources]
        curves = [curve(one, given.at, given.lots) for one in champions]
    except InputError as error:
        parser.error(str(error))
    write_csv(given.out / "damage.csv", [row for rows in curves for row in rows])
    draw(curves, given.out / "damage.png")
    show(curves)


if __name__ == "__main__":
    main()
