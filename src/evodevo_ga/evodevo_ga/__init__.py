"""evodevo_ga: the genetic algorithm, ask/tell shaped, and the node that evolves on simulator nodes.

    from evodevo_ga import Evolution, Settings
"""

from .evolution import Evolution, Generation, Individual, Settings, diversity

__all__ = ["Evolution", "Generation", "Individual", "Settings", "diversity"]
