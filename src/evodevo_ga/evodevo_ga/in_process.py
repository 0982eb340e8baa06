"""Evaluation in this process: the same bits as through simulator nodes, on as many threads as asked for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

from evodevo_sim import Evaluation, Genome, Task, evaluate


def evaluate_all(
    genomes: Sequence[Genome], task: Task = Task(), seed: int = 0, workers: int = 1, bars: Sequence[float] = ()
) -> list[Evaluation]:
    """Evaluate genomes in order.  Kernels release the GIL, so threads run side by side.

    Args: bars: none, or one for each genome: see `evaluate`.  Raises ValueError where there are more or fewer.
    """
    given = bars or [-math.inf] * len(genomes)
    if len(given) != len(genomes):
        raise ValueError(f"{len(given)} bars for {len(genomes)} genomes: give one for each, or none")
    if workers == 1:
        return [evaluate(genome, task, seed, bar) for genome, bar in zip(genomes, given)]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda genome, bar: evaluate(genome, task, seed, bar), genomes, given))
