"""What `import evodevo_sim.analysis.gait` offers."""

from __future__ import annotations

from ...physics.terrain import Ground
from .analysis import Analysis, Gait, analyse
from .rules import SWIMMING, WALKING, Rules
from .sources import track_of_motion, track_of_performance
from .track import GaitError, Surroundings, Track

__all__ = [
    "SWIMMING",
    "WALKING",
    "Analysis",
    "Gait",
    "GaitError",
    "Ground",
    "Rules",
    "Surroundings",
    "Track",
    "analyse",
    "track_of_motion",
    "track_of_performance",
]
