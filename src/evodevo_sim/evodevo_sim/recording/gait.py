"""Tracks of recordings: the one module of gaits that reads messages."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analysis.gait.analysis import Gait, analyse
from ..analysis.gait.sources import ground_of_scene, world_of_scene, world_of_task
from ..analysis.gait.track import GaitError, Track
from ..analysis.stretches import longest_stretch, words_of_holes
from ..physics.terrain import Ground
from ..ros.messages import gait_from_message, task_from_message
from . import Recording
from .life import Life


def track_of_recording(recording: Recording, life: Life, walks: bool = False) -> Track:
    """The track of a recording's last life: of the longest stretch without a hole.

    Args: walks: it has ground, flat where the recording holds none.  Raises GaitError.
    """
    if not len(life.time):
        raise GaitError(f"{recording.path} holds no motion of a body: give the recording of a run that ended, or of simulate")
    body, task = recording.body, None if recording.settings is None else task_from_message(recording.settings.task)
    known: dict[str, Any] = {} if body is None else {"rest_length": np.array(body.rest_length), "chamber_area": np.array(body.chamber_area)}
    ground = ground_of_scene(life.scene) if life.scene is not None else Ground() if walks else None
    part = longest_stretch(life.time)
    return Track(
        (life.time - life.time[0])[part], life.position[part], life.activation[part], springs=life.springs, outline=life.outline,
        chambers=tuple(life.chambers), velocity=None if life.velocity is None else life.velocity[part],
        world=world_of_task(task) if task else world_of_scene(life.scene), ground=ground, held=ground is not None, **known,
    )


def words_of_stretch(life: Life) -> str:
    """What the track leaves out because of holes, or nothing."""
    said = words_of_holes(life.time)
    if not said:
        return ""
    part = longest_stretch(life.time)
    begin, end = life.time[part][[0, -1]] - life.time[0]
    return f"{said}: the gait is of the longest whole stretch, {begin:.3g} s to {end:.3g} s"


def gait_of_recording(recording: Recording, life: Life) -> Gait | None:
    """The gait that a run recorded, or else that of its motion; None where there is none, or nobody says in what scene it is."""
    if recording.gait is not None:
        return gait_from_message(recording.gait)
    if recording.settings is None and life.scene is None:
        return None
    try:
        return analyse(track_of_recording(recording, life)).gait
    except GaitError:
        return None
