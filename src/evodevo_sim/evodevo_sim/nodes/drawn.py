"""A live animat as public tools draw it, for whoever listens."""

from __future__ import annotations

from typing import Any

from ..ros.drawn import Drawing, drawing_of
from ..ros.messages import body_message
from ..ros.topics import DRAWN, DRAWN_CELLS, DRAWN_MARKERS, DRAWN_POSE


class DrawnTopics:
    """Publishers of a node.  Where nobody listens to one, its message is not made.  Args: frame: of positions."""

    def __init__(self, node: Any, frame: str):
        self._publishers = {topic: node.create_publisher(topic.type, topic.name, topic.quality) for topic in DRAWN}
        self._frame = frame
        self._drawing: Drawing | None = None
        self._animat: Any = None

    def show(self, animat: Any) -> None:
        """Publish what is seen of an `Animat` in this step."""
        heard = {topic for topic, publisher in self._publishers.items() if publisher.get_subscription_count()}
        if not heard:
            return
        if animat is not self._animat or self._drawing is None:
            scene = animat.task.scene if animat.task.kind.has_ground else None
            self._animat, self._drawing = animat, drawing_of(body_message(animat.body, self._frame), scene)
        drawing, position, seconds = self._drawing, animat.known(), animat.time
        if DRAWN_CELLS in heard:
            self._publishers[DRAWN_CELLS].publish(drawing.cloud(position, animat.activation, seconds))
        if DRAWN_POSE in heard:
            self._publishers[DRAWN_POSE].publish(drawing.pose(position, seconds))
        if DRAWN_MARKERS in heard and drawing.due(seconds):
            self._publishers[DRAWN_MARKERS].publish(drawing.markers(position, seconds, animat.target))
