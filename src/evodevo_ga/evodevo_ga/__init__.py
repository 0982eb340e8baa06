"""evodevo_ga: the genetic algorithm, ask/tell shaped, and the node that evolves on simulator nodes.

    from evodevo_ga import Evolution, Settings
"""

from .evolution import Evolution, Generation, Individual, diversity
from .settings import SCHEMES, Settings, default_scheme, scheme

__all__ = ["SCHEMES", "Evolution", "Generation", "Individual", "Settings", "default_scheme", "diversity", "scheme"]
