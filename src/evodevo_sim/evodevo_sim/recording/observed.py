"""Observations of bodies from recordings: what cells did, and what muscles were told, with what a camera has not seen left out."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..identification.observation import Observation, ObservationError, body_of_parts, first_pose
from ..parameters import Task
from ..ros.drawn import chambers_of
from ..ros.messages import task_from_message
from ..ros.topics import BODY, CELL_STATES
from . import Recording, RecordingError, read_recording
from .life import last_states


def observation_of(path: str | os.PathLike, say: Callable[[str], None] = lambda line: None) -> tuple[Observation, np.ndarray, Task | None]:
    """The last life of a recording.

    Returns: the observation; (T,) its control steps, as they were counted; the task of the run, if it is one.
    Raises RecordingError, or ObservationError where nothing can be told of the body.
    """
    recording = read_recording(path)
    for line in recording.notes:
        say(line)
    name = Path(os.path.realpath(path)).name
    body = recording.body
    if body is None or not recording.states:
        missing = BODY.name if body is None else CELL_STATES.name
        raise RecordingError(f"{path} lacks the topic {missing}: record {BODY.name} and {CELL_STATES.name} of one life")
    time, position, activation, step = last_states(recording, body.cells)
    keep = np.isfinite(position).any(axis=(1, 2)) if len(time) else np.empty(0, bool)
    time, position, activation, step = time[keep], position[keep], activation[keep], step[keep]
    springs = np.column_stack((body.spring_a, body.spring_b)).astype(int)
    chambers = chambers_of(body.chamber_start, body.chamber_cell)
    pose, lengths, areas = first_pose(name, time, position), np.array(body.rest_length), np.array(body.chamber_area)
    whole = body_of_parts(name, pose, springs, lengths, chambers, areas)
    return Observation(name, whole, time, position, activation), step, _task(recording)


def control_step_of(observation: Observation, step: np.ndarray) -> float:
    """s of a control step, by the stamps."""
    counted = np.diff(step.astype(float))
    if not (counted > 0).all():
        raise ObservationError(f"{observation.name}: its control steps do not count on: record one life at a time")
    return float(np.median(np.diff(observation.time) / counted))


def _task(recording: Recording) -> Task | None:
    return None if recording.settings is None else task_from_message(recording.settings.task)
