"""evodevo_ga: the genetic algorithm, ask/tell shaped, and the node that evolves on simulator nodes.

    from evodevo_ga import Evolution, Settings

All of it is imported when the first name is asked for.
"""

# ruff: noqa: F403, F405
from __future__ import annotations

from typing import TYPE_CHECKING

from evodevo_sim.lazy import lazily

if TYPE_CHECKING:
    from .library import *

__all__ = [
    "SCHEMES", "Child", "Evolution", "Generation", "Individual", "Parents", "Scheme", "Search", "Settings", "child_of", "default_scheme",
    "diversity", "mutant", "random_children", "register", "scheme",
]


def _library():
    from . import library

    return library


__getattr__, __dir__ = lazily(globals(), _library)
