"""evodevo_sim: genome -> regulation -> development -> body -> locomotion, without ROS.

    from evodevo_sim import evaluate, read_genome
    file = read_genome("champion.yaml")
    evaluation = evaluate(file.genome, file.task())

All of it is imported when the first name is asked for.
"""

# ruff: noqa: F403, F405
from __future__ import annotations

from typing import TYPE_CHECKING

from .lazy import lazily

if TYPE_CHECKING:
    from .library import *

__version__ = "0.1.0"

__all__ = [
    "BodyError", "Development", "Evaluation", "Genome", "GenomeError", "GenomeFile", "Material", "Metrics", "Motion", "OwnBody",
    "ParameterError", "Performance", "Scene", "Status", "Task", "champions", "evaluate", "load_body", "load_champion", "load_genome",
    "make_own_body", "parse_genome", "perform", "random_genome", "read_genome", "save_genome", "simulate_body",
]


def _library():
    from . import library

    return library


__getattr__, __dir__ = lazily(globals(), _library)
