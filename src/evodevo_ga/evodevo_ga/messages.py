"""Messages of an evolution: its settings, each generation's statistics, each new champion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict

from evodevo_sim.ros.messages import evaluation_message, genome_message, task_message, time_message

from evodevo_msgs import msg
from evodevo_sim import Genome, Task, __version__

from .auditor import Finding
from .evolution import Generation, Individual
from .settings import Settings


def evolution_message(settings: Settings, task: Task, seed: int, start: Sequence[Genome] = (), scheme: str = "") -> msg.Evolution:
    """The settings of a run.  Args: start: the genomes that it begins from; scheme: the name of its way to search."""
    genomes = [genome_message(genome) for genome in start]
    return msg.Evolution(version=__version__, task=task_message(task), seed=seed, start=genomes, scheme=scheme, **asdict(settings))


def statistics_message(generation: Generation, evaluations_per_second: float, seconds: float) -> msg.GenerationStatistics:
    fields = asdict(generation)
    del fields["improved"]
    return msg.GenerationStatistics(stamp=time_message(seconds), evaluations_per_second=evaluations_per_second, **fields)


def champion_message(generation: int, champion: Individual, seconds: float) -> msg.Champion:
    return msg.Champion(
        stamp=time_message(seconds),
        generation=generation,
        genome=genome_message(champion.genome),
        evaluation=evaluation_message(champion.evaluation),
    )


def audit_message(finding: Finding, seconds: float) -> msg.Audit:
    runs = [
        msg.AuditRun(
            name=run.name, fitness=run.fitness, change=run.change, sustained=run.sustained,
            unexplained=run.gap if run.ledger else math.nan, cause=run.cause,
        )
        for run in finding.audit.runs
    ]
    return msg.Audit(
        stamp=time_message(seconds),
        generation=finding.generation,
        stands=finding.audit.stands,
        faults=list(finding.audit.faults),
        fitness=finding.audit.evaluation.fitness,
        runs=runs,
    )
