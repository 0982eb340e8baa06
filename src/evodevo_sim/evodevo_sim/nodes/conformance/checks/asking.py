"""What checks ask of a node, and how."""

from __future__ import annotations

from typing import Any

import numpy as np

from evodevo_msgs.srv import Load

from ....ros.topics import CELL_STATES
from ..session import Heard, Session, must

LOOK = 60  # states that a check looks at
CEASE = 0.3  # s after which what was asked to cease has ceased


def stamp(message: Any) -> float:
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def load(session: Session, **changes: Any) -> Any:
    request = {"task": session.task, "genome": session.genome, "real_time_factor": 1.0} | changes
    return session.call(Load, "load", **request)


def living(session: Session) -> None:
    answer = load(session)
    must(answer.success, f"load was refused: {answer.message}")


def states(session: Session, count: int = LOOK) -> Heard:
    """So many states of a living animat, from now on."""
    living(session)
    heard = session.listen(CELL_STATES)
    must(session.until(lambda: len(heard) >= count), f"{len(heard)} of {count} cell states came within {session.patience:g} s")
    return heard


def position(message: Any) -> np.ndarray:
    return np.stack([message.position_x, message.position_y], 1)
