"""Evaluation in this process: the same bits as through simulator nodes, on as many threads as asked for."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

from evodevo_sim import Evaluation, Genome, Task, evaluate


def evaluate_all(genomes: Sequence[Genome], task: Task = Task(), seed: int = 0, workers: int = 1) -> list[Evaluation]:
    """Evaluate genomes in order.  Kernels release the GIL, so threads run side by side."""
    if workers == 1:
        return [evaluate(genome, task, seed) for genome in genomes]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda genome: evaluate(genome, task, seed), genomes))
