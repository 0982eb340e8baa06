"""What `import evodevo_ga` offers."""

from __future__ import annotations

from .evolution import Evolution, Generation, Individual, diversity
from .settings import SCHEMES, Settings, default_scheme, scheme

__all__ = ["SCHEMES", "Evolution", "Generation", "Individual", "Settings", "default_scheme", "diversity", "scheme"]
