"""What public tools draw, made of our own messages while these are recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..parameters import ParameterError, Scene
from ..ros.drawn import Drawing, drawing_of
from ..ros.messages import scene_from_message
from ..ros.topics import (
    BODY,
    CELL_STATES,
    DRAWN_CELLS,
    DRAWN_MARKERS,
    DRAWN_POSE,
    GROWTH_BODY,
    GROWTH_STATES,
    SCENE,
    SETTINGS,
    TARGET_POSE,
    namespace_of,
    role_of,
)
from ..task_kinds import kind_of


@dataclass
class _Animat:
    """What is known of the animat of one namespace."""

    drawing: Drawing | None = None
    target: tuple[float, float] | None = None
    scene: Scene | None = None


class Drawn:
    """Messages that public tools draw, of those that a recording holds.  Its topics are those of `ros.topics.DRAWN`."""

    def __init__(self) -> None:
        self._animats: dict[str, _Animat] = {}
        self._scene: Scene | None = None  # of the run

    def of(self, topic: str, message: Any) -> list[tuple[str, Any]]:
        """(topic, message) of what is drawn when a message has been recorded; nothing for most."""
        entry = role_of(topic)
        kind: Any = None if entry is None else entry.type
        if entry is None or not isinstance(message, kind):
            return []
        namespace = namespace_of(topic, entry)
        animat = self._animats.setdefault(namespace, _Animat())
        if entry in (BODY, GROWTH_BODY):
            animat.drawing = drawing_of(message, (animat.scene or self._scene) if entry is BODY else None)
        elif entry is SCENE:
            animat.scene = _scene(message)
            if animat.drawing is not None:
                animat.drawing.scene = animat.scene
        elif entry is SETTINGS:
            task = kind_of(message.task.name)
            self._scene = _scene(message.task.scene) if task is not None and task.has_ground else None
        elif entry is TARGET_POSE:
            animat.target = message.pose.position.x, message.pose.position.y
        elif entry in (CELL_STATES, GROWTH_STATES):
            return [(drawn.at(namespace) if namespace else drawn.name, one) for drawn, one in _states(animat, message)]
        return []


def _scene(message) -> Scene | None:
    try:
        return scene_from_message(message)
    except ParameterError:
        return None


def _states(animat: _Animat, state):
    """Cells, pose and markers of a state; nothing where it is not of numbers."""
    cells = {len(values) for values in (state.position_x, state.position_y, state.activation)}
    position = np.column_stack((state.position_x, state.position_y)) if len(cells) == 1 else np.empty((0, 2))
    activation = np.asarray(state.activation)
    if not len(position) or not (np.isfinite(position).all() and np.isfinite(activation).all()):
        return
    if animat.drawing is None:
        animat.drawing = Drawing(np.empty((0, 2), int), np.empty((0, 2), int), frame=state.header.frame_id)
    drawing, seconds = animat.drawing, state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
    yield DRAWN_CELLS, drawing.cloud(position, activation, seconds)
    yield DRAWN_POSE, drawing.pose(position, seconds)
    if drawing.cells <= len(position) and drawing.due(seconds):
        yield DRAWN_MARKERS, drawing.markers(position, seconds, animat.target)
