"""The topics of a recording: which types they have, and where a reader keeps their messages."""

from __future__ import annotations

from dataclasses import dataclass

from geometry_msgs.msg import PoseStamped

from evodevo_msgs import msg


@dataclass(frozen=True)
class Topic:
    """name: below the namespace of an animat or a run; type: of its messages; attribute: of `Recording`; many: whether that is a list;
    latched: whether late subscribers get the last message; animat: whether it is of one animat, or else of a run."""

    name: str
    type: type
    attribute: str
    many: bool
    latched: bool
    animat: bool


TOPICS = (
    Topic("evolution/settings", msg.Evolution, "settings", many=False, latched=True, animat=False),
    Topic("evolution/statistics", msg.GenerationStatistics, "statistics", many=True, latched=False, animat=False),
    Topic("evolution/champion", msg.Champion, "champions", many=True, latched=False, animat=False),
    Topic("evolution/audit", msg.Audit, "audits", many=True, latched=False, animat=False),
    Topic("growth/body", msg.Body, "growth_bodies", many=True, latched=True, animat=True),
    Topic("growth/cell_states", msg.CellStates, "growth", many=True, latched=False, animat=True),
    Topic("body", msg.Body, "body", many=False, latched=True, animat=True),
    Topic("cell_states", msg.CellStates, "states", many=True, latched=False, animat=True),
    Topic("target_pose", PoseStamped, "targets", many=True, latched=True, animat=True),
    Topic("scene", msg.Scene, "scene", many=False, latched=True, animat=True),
    Topic("gait", msg.Gait, "gait", many=False, latched=True, animat=True),
)


def role_of(topic: str) -> Topic | None:
    """The entry that a topic's name ends with, in any namespace; of several the longest."""
    fitting = [entry for entry in TOPICS if ("/" + topic.lstrip("/")).endswith("/" + entry.name)]
    return max(fitting, key=lambda entry: len(entry.name), default=None)


def namespace_of(topic: str, entry: Topic) -> str:
    """What stands before the entry's name."""
    return ("/" + topic.lstrip("/"))[: -len(entry.name)].rstrip("/")
