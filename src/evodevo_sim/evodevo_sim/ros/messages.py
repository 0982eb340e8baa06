"""Between the library's objects and `evodevo_msgs`, without losing a bit.

Dataclasses and messages of one name have fields of the same names, so Task, Metrics, Gait and what is nested in them are converted
by walking their fields: a new field needs a line in the dataclass and one in the `.msg`, and nothing here.  Only profiles of
a Scene are coordinates there and points in the message: rclpy pads empty arrays of doubles, which strict readers refuse.
"""

from __future__ import annotations

from array import array
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from evodevo_msgs import msg

from ..genetics.genome import Genome
from ..parameters import Scene, Task, default_task
from ..task_kinds import names
from ..tasks.outcome import Evaluation, Metrics, Status

_of_late: dict[str, tuple[msg.Task, Task]] = {}  # by name, of which there are few, the last one that was asked for


def task_message(task: Task) -> msg.Task:
    """The message of a task."""
    return _message(task)


def task_from_message(message: msg.Task) -> Task:
    """The task of a message.  Raises ParameterError that names the setting and what would work."""
    return _object(Task, message)


def task_of_request(message: msg.Task) -> Task:
    """The task that a request to a simulator asks for.

    Where every field but the name is 0 or empty, as in a message that nobody has filled, it is the default task of that name, and of
    no name the one to swim: a task of zeros could not run.  Any other message is taken as it is.  Raises ParameterError.

    The same again is the same object: requests of a run are for one task.
    """
    known = _of_late.get(message.name)
    if known is not None and known[0] == message:
        return known[1]
    task = default_task(message.name or names()[0]) if message == msg.Task(name=message.name) else task_from_message(message)
    _of_late[message.name] = message, task
    return task


def scene_message(scene: Scene) -> msg.Scene:
    """The message of a scene."""
    return _message(scene)


def scene_from_message(message: msg.Scene) -> Scene:
    """The scene of a message.  Raises ParameterError."""
    return _object(Scene, message)


def genome_message(genome: Genome) -> msg.Genome:
    """The message of a genome."""
    return msg.Genome(
        kind=_array("B", genome.kind), sign=_array("b", genome.sign), x=_array("d", genome.x), y=_array("d", genome.y)
    )


def genome_from_message(message: msg.Genome) -> Genome:
    """The genome of a message.  Raises GenomeError that names the element and how to mend it."""
    return Genome(*(np.asarray(values) for values in (message.kind, message.sign, message.x, message.y)))  # arrays without a copy


def evaluation_message(evaluation: Evaluation) -> msg.Evaluation:
    """The message of an evaluation."""
    return msg.Evaluation(
        fitness=evaluation.fitness, status=int(evaluation.status), cause=evaluation.cause, metrics=_message(evaluation.metrics)
    )


def evaluation_from_message(message: msg.Evaluation) -> Evaluation:
    """The evaluation of a message.  Raises ValueError where its status is unknown."""
    return Evaluation(message.fitness, Status(message.status), message.cause, _object(Metrics, message.metrics))


def gait_message(gait: Any) -> msg.Gait:
    """The message of a `gait.Gait`."""
    return _message(gait)


def gait_from_message(message: msg.Gait) -> Any:
    """The `gait.Gait` of a message."""
    from ..analysis.gait import Gait  # it takes SciPy, which nodes do without

    return _object(Gait, message)


def time_message(seconds: float) -> Time:
    """Seconds as a stamp, rounded to the nanosecond."""
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    return Time(sec=sec, nanosec=nanosec)


def cell_states_message(
    position: np.ndarray, velocity: np.ndarray, activation: np.ndarray, step: int, stamp: float, frame: str = "world"
) -> msg.CellStates:
    """All cells at one instant.

    Args: position (N, 2) m; velocity (N, 2) m/s; activation (N,) of e - c; step: control step; stamp: simulated s.
    """
    return msg.CellStates(
        header=Header(stamp=time_message(stamp), frame_id=frame),
        step=step,
        position_x=_array("d", position[:, 0]),
        position_y=_array("d", position[:, 1]),
        velocity_x=_array("d", velocity[:, 0]),
        velocity_y=_array("d", velocity[:, 1]),
        activation=_array("d", activation),
    )


def actuation_message(activation: Any, step: int, stamp: float, frame: str = "world") -> msg.Actuation:
    """What the muscles are told to do in a control step.

    Args: activation (N,) of e - c; step: control step that it drives; stamp: simulated s, at its end.
    """
    return msg.Actuation(header=Header(stamp=time_message(stamp), frame_id=frame), step=step, activation=_array("d", activation))


def target_message(target: Any, stamp: Time, frame: str = "world") -> PoseStamped:
    """A target.  Args: target: (x, y) m."""
    message = PoseStamped(header=Header(stamp=stamp, frame_id=frame))
    message.pose.position.x, message.pose.position.y = float(target[0]), float(target[1])
    message.pose.orientation.w = 1.0
    return message


def body_message(body: Any, frame: str = "world", stamp: float = 0.0) -> msg.Body:
    """The message of a `body.Body`: chambers are its triangles, then its polygons."""
    triangles = len(body.triangle)
    chamber_start = np.concatenate((3 * np.arange(triangles), 3 * triangles + body.polygon_start.astype(np.int64)))
    return msg.Body(
        header=Header(stamp=time_message(stamp), frame_id=frame),
        cells=len(body.position),
        spring_a=_array("I", body.spring_a),
        spring_b=_array("I", body.spring_b),
        rest_length=_array("d", body.rest_length),
        chamber_start=_array("I", chamber_start),
        chamber_cell=_array("I", np.concatenate((body.triangle.ravel(), body.polygon_cell))),
        chamber_area=_array("d", np.concatenate((body.triangle_area, body.polygon_area))),
        outline_a=_array("I", body.outline[:, 0]),
        outline_b=_array("I", body.outline[:, 1]),
    )


def graph_message(position: np.ndarray, edges: np.ndarray, frame: str = "world", stamp: float = 0.0) -> msg.Body:
    """The message of an embryo's graph: springs alone.  Args: position (N, 2) m; edges (E, 2)."""
    length = np.linalg.norm(position[edges[:, 0]] - position[edges[:, 1]], axis=1)
    return msg.Body(
        header=Header(stamp=time_message(stamp), frame_id=frame),
        cells=len(position),
        spring_a=_array("I", edges[:, 0]),
        spring_b=_array("I", edges[:, 1]),
        rest_length=_array("d", length),
    )


def _array(typecode, values):
    """What a message's array field takes without looking at every entry."""
    return array(typecode, np.asarray(values, typecode).tobytes())


@cache
def _layout(cls):
    """Of the fields of a dataclass: (name, the dataclass that it is or None, the message's name and axis of a profile or None)."""
    profiles = {f"{name}_{axis}": (name, axis) for name in ("ground", "ceiling") for axis in "xy"} if cls is Scene else {}
    return [
        (field.name, type(field.default) if is_dataclass(field.default) else None, profiles.get(field.name)) for field in fields(cls)
    ]


def _message(value):
    """The message of a dataclass of the same name, nested ones with it."""
    cls: Any = type(value)
    given: dict[str, Any] = {}
    for name, nested, profile in _layout(cls):
        if not profile:
            given[name] = _message(getattr(value, name)) if nested else getattr(value, name)
    if cls is Scene:  # points there, coordinates here
        for name in ("ground", "ceiling"):
            given[name] = [msg.Vertex(x=x, y=y) for x, y in zip(getattr(value, f"{name}_x"), getattr(value, f"{name}_y"))]
    return getattr(msg, cls.__name__)(**given)


def _object(cls, message):
    """The dataclass of a message of the same name; fields that are dataclasses themselves are told by their defaults."""
    given = {}
    for name, nested, profile in _layout(cls):
        if profile:
            given[name] = tuple(getattr(vertex, profile[1]) for vertex in getattr(message, profile[0]))
        else:
            given[name] = _object(nested, getattr(message, name)) if nested else getattr(message, name)
    return cls(**given)
