"""Checks of services and topics: names, types, qualities."""

from __future__ import annotations

from ....ros.topics import ACTUATION, BODY, CELL_STATES, TARGET_POSE
from ..session import Session, check, must

_SERVICES = {
    "load": "evodevo_msgs/srv/Load", "pause": "std_srvs/srv/SetBool", "reset": "std_srvs/srv/Trigger",
    "evaluate": "evodevo_msgs/srv/Evaluate",
}


@check("services", "load, pause, reset and evaluate are there, with their types")
def _services(s: Session) -> None:
    s.until(lambda: all(map(s.has, _SERVICES)), 10.0)
    offered = dict(s.node.get_service_names_and_types())
    for name, kind in _SERVICES.items():
        must(kind in offered.get(s.at(name), []), f"{s.at(name)} is {offered.get(s.at(name)) or 'not there'}, not {kind}")


@check("topics", "body, cell_states and actuation are published and target_pose is heard, with their types")
def _topics(s: Session) -> None:
    for topic in (BODY, CELL_STATES, ACTUATION):
        kind = f"{topic.type.__module__.split('.')[0]}/msg/{topic.type.__name__}"
        kinds = {info.topic_type for info in s.publishers(topic.name)}
        must(kinds == {kind}, f"{s.at(topic.name)} is published as {sorted(kinds) or 'nothing'}, not {kind}")
    must(s.until(lambda: s.node.count_subscribers(s.at(TARGET_POSE.name)), 5.0), f"nobody hears {s.at(TARGET_POSE.name)}")


@check("quality of body", "body is reliable and latched, so that who comes late has it")
def _quality_of_body(s: Session) -> None:
    for info in s.publishers(BODY.name):
        quality = info.qos_profile
        must(quality.reliability == BODY.quality.reliability, "body is published best effort")
        must(quality.durability == BODY.quality.durability, "body is published volatile: who comes late never has it")


@check("quality of actuation", "actuation is reliable, so that a driver has the newest command even where a packet was lost")
def _quality_of_actuation(s: Session) -> None:
    for info in s.publishers(ACTUATION.name):
        must(info.qos_profile.reliability == ACTUATION.quality.reliability, "actuation is published best effort")
