#!/usr/bin/env python3
"""How often limbs pass through each other: the share of control steps in which edges of the outline cross.

    python benchmarks/crossings.py src/evodevo_sim/champions/*.yaml [--task walk] [--starts 4] [--set NAME=VALUE]

A life is that of evaluations; a walker's is repeated from evenly spread starts.  Edges that share a cell are not compared.
"""

from __future__ import annotations

import argparse

import numpy as np
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.task_kinds import names
from evodevo_sim.tasks.walk.audit import trial
from evodevo_sim.tasks.walk.fitness import headings

from evodevo_sim import perform, read_genome


def crossings(outline, position) -> np.ndarray:
    """(T,): pairs of outline edges (M, 2) that cross, of cells at position (T, N, 2)."""
    i, j = np.triu_indices(len(outline), 1)
    apart = ~(outline[i][:, :, None] == outline[j][:, None, :]).any((1, 2))
    i, j = outline[i[apart]].astype(int), outline[j[apart]].astype(int)
    count = np.empty(len(position), int)
    for t, p in enumerate(position):
        a, b, c, d = p[i[:, 0]], p[i[:, 1]], p[j[:, 0]], p[j[:, 1]]
        count[t] = ((_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)).sum()
    return count


def _side(a, b, c):
    return (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])


def lives(genome, task, starts):
    """(body, [positions (T, N, 2)]) of a genome."""
    first = perform(genome, task)
    if task.name != "walk" or first.body is None:
        return first.body, [first.position]
    return first.body, [trial(genome, task, heading[None])[3] for heading in headings(0, starts)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("genomes", nargs="+", metavar="GENOME")
    parser.add_argument("--task", default="walk", choices=names())
    parser.add_argument("--starts", type=int, default=4, help="of a walker (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    options = parser.parse_args()
    print("steps that cross    most pairs    cells    genome")
    for path in options.genomes:
        file = read_genome(path)
        body, positions = lives(file.genome, file.task(options.task, pairs(options.set)), options.starts)
        if body is None:
            continue
        count = np.concatenate([crossings(body.outline, p[np.isfinite(p).all((1, 2))]) for p in positions])
        print(f"{(count > 0).mean():16.2%}    {count.max():10d}    {len(body.position):5d}    {path}", flush=True)


if __name__ == "__main__":
    main()
