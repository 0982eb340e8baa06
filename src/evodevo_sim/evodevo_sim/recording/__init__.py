"""Recordings: rosbag2 directories in MCAP, written by the process that makes the data; read also in the forms that others give them.

    DIR/metadata.yaml, DIR/DIR_0.mcap
        evolution/settings, evolution/statistics, evolution/champion, evolution/audit      of a run
        growth/body, growth/cell_states                                   the embryo, where its graph changes and at each step
        body (latched), cell_states                                       the animat that lives
        actuation                                                         what its muscles were told, where chase recorded it
        scene (latched)                                                   the world of a walk by simulate
        gait (latched)                                                    what evolve found that motion to be

`ros.topics` is the table of them.  Reading: `storage` finds the files, `mcap_file` and `sqlite_file` their messages; `decoding` tells by
`schema` whether a type is ours, and `older` what another version of it lacks; `ordering` puts messages in the order of time.
"""

from ..extras import lacking

try:
    from .definitions import RecordingError
    from .performance import record_performance
    from .reader import Recording, read_recording
    from .storage import is_recording
    from .writer import Recorder
except ModuleNotFoundError as error:
    raise lacking(error) from None

__all__ = ["Recorder", "Recording", "RecordingError", "is_recording", "read_recording", "record_performance"]
