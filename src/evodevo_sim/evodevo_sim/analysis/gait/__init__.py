"""Gaits: what a body does, in numbers and by name (docs/reference/gaits.md).  Arrays in, results out; no ROS but in the command.

    from evodevo_sim.analysis.gait import analyse, track_of_performance
    analysis = analyse(track_of_performance(perform(genome, task), task))
    print(analysis.gait.name, analysis.gait.frequency)
"""

from ...physics.terrain import Ground
from .analysis import Analysis, Gait, analyse
from .rules import SWIMMING, WALKING, Rules
from .sources import track_of_motion, track_of_performance
from .track import GaitError, Track, World

__all__ = [
    "SWIMMING", "WALKING", "Analysis", "Gait", "GaitError", "Ground", "Rules", "Track", "World", "analyse", "track_of_motion",
    "track_of_performance",
]
