"""Batches and answers as plain data: dicts, lists, numbers, texts and bytes, without the loss of a bit.

Whoever reads them makes nothing but numbers and texts of what came, whatever a sender has put there.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from evodevo_sim.inputs import one_line
from evodevo_sim.parameters import ARGUMENTS
from evodevo_sim.tasks.outcome import Metrics, Status, Steering

from evodevo_sim import Evaluation, Genome, Task

from .contract import Answer, AnswerError, Batch

_TYPES = {"kind": np.uint8, "sign": np.int8, "x": np.float64, "y": np.float64}
_PARTS = {cls.__name__.lower(): cls for cls in ARGUMENTS if cls is not Task}  # of a task


def plain_batch(batch: Batch) -> dict[str, Any]:
    """A batch.  Genomes are bytes of their arrays, little-endian."""
    genomes = [
        {name: np.ascontiguousarray(getattr(genome, name), np.dtype(kind).newbyteorder("<")).tobytes() for name, kind in _TYPES.items()}
        for genome in batch.genomes
    ]
    return {"genomes": genomes, "task": dataclasses.asdict(batch.task), "seed": batch.seed, "bars": list(batch.bars)}


def batch_of_plain(plain: dict[str, Any]) -> Batch:
    """Raises GenomeError, ParameterError, KeyError, TypeError or ValueError where it is none."""
    genomes = tuple(
        Genome(*(np.frombuffer(one[name], np.dtype(kind).newbyteorder("<")) for name, kind in _TYPES.items())) for one in plain["genomes"]
    )
    given = dict(plain["task"])
    given |= {name: cls(**given[name]) for name, cls in _PARTS.items()}
    return Batch(genomes, Task(**given), int(plain["seed"]), tuple(float(bar) for bar in plain["bars"]))


def plain_answer(answer: Answer) -> dict[str, Any]:
    """An answer, without the name of its worker."""
    evaluations = [
        {**dataclasses.asdict(one), "status": int(one.status)} for one in answer.evaluations
    ]
    return {"evaluations": evaluations, "seconds": answer.seconds}


def answer_of_plain(plain: Any, worker: str) -> Answer:
    """Raises AnswerError where it is none."""
    try:
        return Answer([_evaluation(one) for one in plain["evaluations"]], worker, float(plain["seconds"]))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise AnswerError(f"its answer cannot be read: {one_line(f'{type(error).__name__}: {error}')}") from None


def _evaluation(plain: dict[str, Any]) -> Evaluation:
    given = {name: plain[name] for name in plain if name not in ("fitness", "status", "cause", "metrics")}
    metrics = dict(plain["metrics"])
    steering = Steering(**_numbers(Steering(), metrics.pop("steering")))
    return Evaluation(
        fitness=float(plain["fitness"]), status=Status(int(plain["status"])), cause=str(plain["cause"]),
        metrics=Metrics(steering=steering, **_numbers(Metrics(), metrics)), **_numbers(_EXAMPLE, given),
    )


_EXAMPLE = Evaluation(0.0, Status.OK, "", Metrics())


def _numbers(example: Any, given: dict[str, Any]) -> dict[str, Any]:
    """The fields given, as numbers of the kinds that they have in the example."""
    return {name: type(getattr(example, name))(value) for name, value in given.items()}
