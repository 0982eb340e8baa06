"""What `import evodevo_sim` offers."""

from __future__ import annotations

from .body_file import BodyError, OwnBody, load_body, make_own_body
from .evaluation import Performance, evaluate, perform
from .genome import Genome, GenomeError, random_genome
from .genome_file import load_genome, parse_genome, save_genome
from .motion import Motion, simulate_body
from .outcome import Evaluation, Metrics, Status
from .parameters import Development, Material, ParameterError, Scene, Task

__all__ = [
    "BodyError", "Development", "Evaluation", "Genome", "GenomeError", "Material", "Metrics", "Motion", "OwnBody",
    "ParameterError", "Performance", "Scene", "Status", "Task", "evaluate", "load_body", "load_genome", "make_own_body",
    "parse_genome", "perform", "random_genome", "save_genome", "simulate_body",
]
