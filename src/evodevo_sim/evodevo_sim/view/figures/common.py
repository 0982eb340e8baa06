"""What several figures ask of a source."""

from __future__ import annotations

from ...analysis.gait.analysis import Gait, analyse
from ...analysis.gait.track import GaitError
from ...recording.gait import gait_of_recording
from ..sources import Shown


def gait_of(one: Shown) -> Gait | None:
    """The gait of what is shown, where it has one: as recorded, or else of its motion."""
    try:
        if one.track is not None:
            return analyse(one.track).gait
    except GaitError:
        return None
    return None if one.recording is None else gait_of_recording(one.recording, one.life)
