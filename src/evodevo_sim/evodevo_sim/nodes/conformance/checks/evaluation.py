"""Checks of evaluations."""

from __future__ import annotations

import copy
import math
from typing import Any

from evodevo_msgs.msg import Genome
from evodevo_msgs.srv import Evaluate

from ..session import Session, check, must
from .asking import load


def short(s: Session) -> Any:
    """The task, of a second or so."""
    task = copy.deepcopy(s.task)
    task.control_steps = 80
    return task


@check("evaluate", "evaluate answers one evaluation for each genome, in order, with finite numbers")
def _evaluate(s: Session) -> None:
    odd = Genome(kind=[9], sign=[1], x=[0.0], y=[0.0])
    answer = s.call(Evaluate, "evaluate", task=short(s), genomes=[s.genome, odd])
    must(not answer.error, f"it was refused: {answer.error}")
    must(len(answer.evaluations) == 2, f"{len(answer.evaluations)} evaluations for 2 genomes")
    good, bad = answer.evaluations
    must(all(math.isfinite(one.fitness) for one in (good, bad)), f"a fitness is {good.fitness}, {bad.fitness}")
    must(bad.status == 6 and bad.cause, f"a malformed genome has status {bad.status} and cause {bad.cause!r}")
    must(good.status != 6 and good.metrics.cells > 0, f"a good genome has status {good.status}: {good.cause}")


@check("an empty batch", "evaluate refuses a request without genomes, in its error field")
def _empty(s: Session) -> None:
    answer = s.call(Evaluate, "evaluate", task=short(s), genomes=[])
    must(answer.error and not answer.evaluations, "an empty request was answered without an error")


@check("an odd task", "evaluate and load refuse a task whose numbers are out of range")
def _odd_task(s: Session) -> None:
    task = short(s)
    task.control_step = -1.0
    must(s.call(Evaluate, "evaluate", task=task, genomes=[s.genome]).error, "a control step of -1 s was evaluated")
    must(not load(s, task=task).success, "a control step of -1 s was loaded")
