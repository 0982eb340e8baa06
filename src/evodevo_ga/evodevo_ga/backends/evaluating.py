"""A batch evaluated by this process: what workers of all backends do, in the end."""

from __future__ import annotations

import math
import time
from itertools import repeat

from evodevo_sim.inputs import one_line
from evodevo_sim.tasks.evaluation import invalid
from evodevo_sim.tasks.halt import Halt, Halted, halting

from evodevo_sim import evaluate

from .contract import Answer, Batch


def evaluated(batch: Batch, worker: str, halt: Halt) -> Answer | None:
    """The answer to a batch; None where `halt` says that nobody waits any more, at once wherever it is.

    What goes wrong with a genome harms no other of its batch.
    """
    began, evaluations = time.perf_counter(), []
    try:
        with halting(halt):
            for genome, bar in zip(batch.genomes, batch.bars or repeat(-math.inf)):
                try:
                    evaluations.append(evaluate(genome, batch.task, batch.seed, bar))
                except Halted:
                    raise
                except Exception as error:
                    evaluations.append(invalid(one_line(f"its evaluation failed: {type(error).__name__}: {error}")))
    except Halted:
        return None
    return Answer(evaluations, worker, time.perf_counter() - began)
