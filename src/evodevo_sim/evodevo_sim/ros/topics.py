"""The one table of topics: what nodes publish and hear, what recordings hold, and where a reader keeps it.

Nodes, writer, reader and documentation take names, types and qualities of service from here:

    node.create_publisher(BODY.type, BODY.name, BODY.quality)
    recorder.write(BODY.name, message, stamp)

`python scripts/topics.py` writes the table of docs/reference/messages.md anew.
"""

from __future__ import annotations

from dataclasses import dataclass

from geometry_msgs.msg import PoseStamped
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from evodevo_msgs import msg


@dataclass(frozen=True)
class Quality:
    """A quality of service.  name: of it, in words; reliable: whether a lost message is sent again; latched: whether who comes late
    gets the last message; depth: messages that are kept."""

    name: str
    reliable: bool
    latched: bool
    depth: int

    def profile(self) -> QoSProfile:
        return QoSProfile(
            depth=self.depth,
            reliability=ReliabilityPolicy.RELIABLE if self.reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if self.latched else DurabilityPolicy.VOLATILE,
        )


LATCHED = Quality("latched", reliable=True, latched=True, depth=1)  # what holds until the next one comes
EVENTS = Quality("events", reliable=True, latched=False, depth=10)  # none of which may be missing
# Only the newest one counts: it is sent again where it was lost, and one that a newer one has overtaken is not.
COMMAND = Quality("command", reliable=True, latched=False, depth=1)
STREAM = Quality("stream", reliable=False, latched=False, depth=5)  # ROS's own for sensor data: the next one comes soon


@dataclass(frozen=True)
class Topic:
    """A topic of ours.

    Attributes:
        name: below the namespace of an animat or a run; type: of its messages; service: its quality.
        by: the node that publishes it live, or nothing where it is only recorded; what: its messages tell, in a few words.
        attribute: of `Recording`; many: whether that is a list; lives: whether its stamps begin anew in each life.
        animat: whether it is of one animat, or else of a run.
    """

    name: str
    type: type
    service: Quality
    by: str
    what: str
    attribute: str
    many: bool = False
    lives: bool = False
    animat: bool = True

    @property
    def quality(self) -> QoSProfile:
        """What its publishers offer and its subscribers ask for."""
        return self.service.profile()

    def at(self, namespace: str) -> str:
        """Its name in a namespace."""
        return f"{namespace.rstrip('/')}/{self.name}"


SETTINGS = Topic("evolution/settings", msg.Evolution, LATCHED, "", "settings of a run", "settings", animat=False)
STATISTICS = Topic(
    "evolution/statistics", msg.GenerationStatistics, EVENTS, "evolve", "each generation's", "statistics", many=True, animat=False,
)
CHAMPION = Topic(
    "evolution/champion", msg.Champion, EVENTS, "evolve", "each new champion, its genome and evaluation", "champions", many=True,
    animat=False,
)
AUDIT = Topic(
    "evolution/audit", msg.Audit, EVENTS, "evolve", "whether a champion's fitness stands", "audits", many=True, animat=False,
)
GROWTH_BODY = Topic(
    "growth/body", msg.Body, LATCHED, "", "the embryo's graph, where it changes", "growth_bodies", many=True, lives=True,
)
GROWTH_STATES = Topic(
    "growth/cell_states", msg.CellStates, EVENTS, "", "the embryo's cells, each regulation step", "growth", many=True, lives=True,
)
BODY = Topic("body", msg.Body, LATCHED, "simulator", "springs, chambers, outline", "body")
CELL_STATES = Topic(
    "cell_states", msg.CellStates, STREAM, "simulator", "positions, velocities, activation, each control step", "states", many=True,
    lives=True,
)
ACTUATION = Topic(
    "actuation", msg.Actuation, COMMAND, "simulator", "activation that the network asks of each cell, each control step", "actuation",
    many=True, lives=True,
)
TARGET_POSE = Topic(
    "target_pose", PoseStamped, COMMAND, "chase", "where to go, in frame `world`; stamped at sending, or with 0", "targets", many=True,
)
SCENE = Topic("scene", msg.Scene, LATCHED, "", "the world of a walk by `simulate`", "scene")
GAIT = Topic("gait", msg.Gait, LATCHED, "", "what `evolve` found the motion to be", "gait")
WORKER = Topic(
    "worker", msg.Worker, LATCHED, "simulator", "who evaluates, and how it does, each second where somebody listens", "worker",
    animat=False,
)
TOPICS = (SETTINGS, STATISTICS, CHAMPION, AUDIT, GROWTH_BODY, GROWTH_STATES, BODY, CELL_STATES, ACTUATION, TARGET_POSE, SCENE, GAIT, WORKER)


def role_of(topic: str) -> Topic | None:
    """The entry that a topic's name ends with, in any namespace; of several the longest."""
    fitting = [entry for entry in TOPICS if ("/" + topic.lstrip("/")).endswith("/" + entry.name)]
    return max(fitting, key=lambda entry: len(entry.name), default=None)


def namespace_of(topic: str, entry: Topic) -> str:
    """What stands before the entry's name."""
    return ("/" + topic.lstrip("/"))[: -len(entry.name)].rstrip("/")
