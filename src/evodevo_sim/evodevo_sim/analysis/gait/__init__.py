"""Gaits: what a body does, in numbers and by name (docs/reference/gaits.md).  Arrays in, results out; no ROS but in the command.

    from evodevo_sim.analysis.gait import analyse, track_of_performance
    analysis = analyse(track_of_performance(perform(genome, task), task))
    print(analysis.gait.name, analysis.gait.frequency)

All of it is imported when the first name is asked for.
"""

# ruff: noqa: F403, F405
from __future__ import annotations

from typing import TYPE_CHECKING

from ...lazy import lazily

if TYPE_CHECKING:
    from .library import *

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


def _library():
    from . import library

    return library


__getattr__, __dir__ = lazily(globals(), _library)
