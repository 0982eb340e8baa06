"""evodevo_ga: the genetic algorithm, ask/tell shaped, and the node that evolves on simulator nodes.

    from evodevo_ga import Evolution, Settings
"""

from .evolution import Evolution, Generation, diversity
from .individual import Child, Individual
from .schemes import SCHEMES, Scheme, default_scheme, register, scheme
from .search import Search
from .settings import Settings
from .variation import Parents, child_of, mutant, random_children

__all__ = [
    "SCHEMES", "Child", "Evolution", "Generation", "Individual", "Parents", "Scheme", "Search", "Settings", "child_of", "default_scheme",
    "diversity", "mutant", "random_children", "register", "scheme",
]
