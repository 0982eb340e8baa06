"""What `import evodevo_ga` offers."""

from __future__ import annotations

from .evolution import Evolution, Generation
from .individual import Child, Individual
from .likeness import diversity
from .schemes import SCHEMES, Scheme, default_scheme, register, scheme
from .search import Search
from .settings import Settings
from .variation import Parents, child_of, mutant, random_children

__all__ = [
    "SCHEMES", "Child", "Evolution", "Generation", "Individual", "Parents", "Scheme", "Search", "Settings", "child_of", "default_scheme",
    "diversity", "mutant", "random_children", "register", "scheme",
]
