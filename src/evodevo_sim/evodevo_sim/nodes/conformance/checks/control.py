"""Checks of what controls a life: pause, reset, load anew, targets."""

from __future__ import annotations

import math
import time

import numpy as np
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool, Trigger

from ....ros.topics import CELL_STATES, TARGET_POSE
from ..session import Heard, Session, check, must
from .asking import CEASE, living, states


def quiet(heard: Heard) -> bool:
    """Whether nothing comes any more."""
    time.sleep(CEASE)
    seen = len(heard)
    time.sleep(CEASE)
    return len(heard) == seen


@check("pause", "pause holds the animat, and lets it go on where it was")
def _pause(s: Session) -> None:
    heard = states(s, 10)
    answer = s.call(SetBool, "pause", data=True)
    must(answer.success, f"pause was refused: {answer.message}")
    must(quiet(heard), "states come on while it is paused")
    held = heard.messages[-1].step
    seen = len(heard)
    must(s.call(SetBool, "pause", data=False).success, "going on was refused")
    must(s.until(lambda: len(heard) > seen + 5), "it does not go on")
    must(0 < heard.messages[seen].step - held <= 10, f"it was held at step {held} and goes on at {heard.messages[seen].step}")


@check("reset", "reset begins the life anew, from its first step")
def _reset(s: Session) -> None:
    heard = states(s, 30)
    before = heard.messages[-1].step
    must(s.call(Trigger, "reset").success, "reset was refused")
    must(s.until(lambda: any(message.step < before for message in heard.messages[30:])), "the steps go on as if nothing had been")
    first = min(message.step for message in heard.messages[30:])
    must(first <= 10, f"the first step that came is {first}")


@check("reset while paused", "an animat that is held stays so through a reset")
def _reset_held(s: Session) -> None:
    heard = states(s, 5)
    s.call(SetBool, "pause", data=True)
    must(s.call(Trigger, "reset").success, "reset was refused")
    must(quiet(heard), "states come on while it is paused")
    s.call(SetBool, "pause", data=False)


@check("load anew", "load takes the place of the animat that lives, at its first step, held or not")
def _anew(s: Session) -> None:
    states(s, 30)
    s.call(SetBool, "pause", data=True)
    heard = s.listen(CELL_STATES)
    living(s)
    must(s.until(lambda: len(heard) > 5), "after a pause a loaded animat does not live")
    must(heard.messages[min(3, len(heard) - 1)].step < 30, f"it begins at step {heard.messages[0].step}")


@check("odd targets", "targets in another frame, not finite or long past are ignored, and the node lives on")
def _targets(s: Session) -> None:
    heard = states(s, 5)
    publisher = s.node.create_publisher(TARGET_POSE.type, s.at(TARGET_POSE.name), TARGET_POSE.quality)
    must(s.until(publisher.get_subscription_count, 5.0), "nobody hears targets")
    for change in ("frame", "nan", "stamp"):
        pose = PoseStamped()
        pose.header.frame_id = "nowhere" if change == "frame" else heard.messages[-1].header.frame_id
        pose.pose.position.x = math.nan if change == "nan" else 1.0
        pose.header.stamp.sec = 1 if change == "stamp" else 0
        publisher.publish(pose)
    seen = len(heard)
    must(s.until(lambda: len(heard) > seen + 30), "after odd targets no state comes")
    must(np.isfinite([message.activation for message in heard.messages]).all(), "after odd targets the activation is not finite")
