"""What `import evodevo_sim` offers."""

from __future__ import annotations

from .genetics.champions import champions, load_champion
from .genetics.genome import Genome, GenomeError, random_genome
from .genetics.genome_file import GenomeFile, load_genome, parse_genome, read_genome, save_genome
from .own_body.body_file import BodyError, OwnBody, load_body, make_own_body
from .own_body.motion import Motion, simulate_body
from .parameters import Development, Material, ParameterError, Scene, Task
from .tasks.evaluation import Performance, evaluate, perform
from .tasks.outcome import Evaluation, Metrics, Status

__all__ = [
    "BodyError", "Development", "Evaluation", "Genome", "GenomeError", "GenomeFile", "Material", "Metrics", "Motion", "OwnBody",
    "ParameterError", "Performance", "Scene", "Status", "Task", "champions", "evaluate", "load_body", "load_champion", "load_genome",
    "make_own_body", "parse_genome", "perform", "random_genome", "read_genome", "save_genome", "simulate_body",
]
