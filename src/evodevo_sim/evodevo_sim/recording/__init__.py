"""Recordings: rosbag2 directories in MCAP, written by the process that makes the data.

    DIR/metadata.yaml, DIR/DIR_0.mcap
        evolution/settings, evolution/statistics, evolution/champion, evolution/audit      of a run
        growth/body, growth/cell_states                                   the embryo, where its graph changes and at each step
        body (latched), cell_states                                       the animat that lives
        scene (latched)                                                   the world of a walk by simulate
        gait (latched)                                                    what evolve found that motion to be
"""

from .definitions import RecordingError
from .performance import record_performance
from .reader import Recording, read_recording
from .writer import Recorder

__all__ = ["Recorder", "Recording", "RecordingError", "read_recording", "record_performance"]
