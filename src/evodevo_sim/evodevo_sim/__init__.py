"""evodevo_sim: genome -> regulation -> development -> body -> locomotion, without ROS.

    from evodevo_sim import evaluate, load_genome
    evaluation = evaluate(load_genome("champion.yaml"))
"""

from .evaluation import Evaluation, Metrics, Performance, Status, evaluate, perform
from .genome import Genome, GenomeError, random_genome
from .genome_file import load_genome, parse_genome, save_genome
from .parameters import Development, Material, ParameterError, Scene, Task

__version__ = "0.1.0"

__all__ = [
    "Development", "Evaluation", "Genome", "GenomeError", "Material", "Metrics", "ParameterError", "Performance", "Scene",
    "Status", "Task", "evaluate", "load_genome", "parse_genome", "perform", "random_genome", "save_genome",
]
