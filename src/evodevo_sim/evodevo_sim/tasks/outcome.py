"""How an evaluation ended: its status, what was measured, and what failures are worth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ..physics.step_size import MOST_SUBSTEPS
from . import ends


class Status(IntEnum):
    """How an evaluation ended; the same numbers as in `evodevo_msgs/Evaluation`."""

    OK = ends.OK
    NO_GROWTH = ends.NO_GROWTH
    NO_CHAMBER = ends.NO_CHAMBER
    RESTING = ends.RESTING
    UNSTABLE = ends.UNSTABLE
    INVERTED = ends.INVERTED
    INVALID_GENOME = ends.INVALID_GENOME
    UNSETTLED = ends.UNSETTLED
    NO_ROOM = ends.NO_ROOM
    STOPPED = ends.STOPPED


STIFF = f"the body needs more than {MOST_SUBSTEPS} physics steps in a control step: lower stiffness, damping or pressure, or raise mass"

# Fitness of what cannot be scored: all of it below a body that stands still, ordered so that growing comes before failing.
FAILURE = {
    Status.UNSETTLED: (-0.5, "the body did not come to rest on the ground within task.settling_limit"),
    Status.NO_ROOM: (-0.75, "the body does not fit below the ceiling where it starts"),
    Status.NO_CHAMBER: (-1.0, "the body has no closed chamber"),
    Status.NO_GROWTH: (-2.0, "the egg never divided"),
    Status.INVERTED: (-3.0, "a chamber turned inside out or a spring collapsed"),
    Status.UNSTABLE: (-4.0, "the physics blew up even with finer steps"),
    Status.INVALID_GENOME: (-5.0, ""),
}


@dataclass(frozen=True)
class Steering:
    """What the tests with targets measured; units as in `evodevo_msgs/Steering`.  All 0 where there was none."""

    distance: float = 0.0
    left_x: float = 0.0
    left_y: float = 0.0
    right_x: float = 0.0
    right_y: float = 0.0
    left_distance: float = 0.0
    right_distance: float = 0.0
    left_gain: float = 0.0
    right_gain: float = 0.0
    left_turn: float = 0.0
    right_turn: float = 0.0
    left_active: float = 0.0
    right_active: float = 0.0


@dataclass(frozen=True)
class Metrics:
    """What was measured; units as in `evodevo_msgs/Metrics`."""

    cells: int = 0
    springs: int = 0
    chambers: int = 0
    substeps: int = 0
    distance: float = 0.0
    distance_second_half: float = 0.0
    slowest_window: float = 0.0
    activation_amplitude: float = 0.0
    settling_steps: int = 0
    worst_start: float = 0.0
    steering: Steering = Steering()


@dataclass(frozen=True)
class Evaluation:
    """fitness in m; status; cause, empty unless it failed; metrics."""

    fitness: float
    status: Status
    cause: str
    metrics: Metrics


def failure(status: Status, metrics: Metrics, step: int = -1, cause: str = "") -> Evaluation:
    """The evaluation of what cannot be scored.  Args: step: control step at which it failed, -1 for none; cause: if not the usual."""
    fitness, usual = FAILURE[status]
    return Evaluation(fitness, status, (cause or usual) + (f", at control step {step}" if step >= 0 else ""), metrics)


def stopped(bound: float, metrics: Metrics) -> Evaluation:
    """The evaluation of a life that was stopped, since its fitness could not reach the bar any more: no failure, and nobody's fitness.

    Args: bound: what its fitness could have been at the most, below the bar; metrics: of the body; nothing is known of its motion.
    """
    return Evaluation(bound, Status.STOPPED, "", metrics)


def by_body(run: Callable[..., Any]) -> Callable[..., Any]:
    """Marks a `TaskKind.run` that sees nothing of a genome but what `life.birth` makes of it: genomes of one animal then have one
    evaluation, see `grown.Grown.key`."""
    vars(run)["by_body"] = True
    return run
