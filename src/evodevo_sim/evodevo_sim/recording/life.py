"""A recording's messages as arrays: what Rerun and the picture draw."""

from __future__ import annotations

from array import array
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..analysis.stretches import filled, speeds
from ..parameters import ParameterError, Scene
from ..physics.terrain import contacts
from ..ros.drawn import chambers_of, surfaces
from ..ros.messages import scene_from_message
from ..task_kinds import kind_of
from . import Recording, RecordingError

RINGS = 5  # drawn around a target, where its scent has fallen by another fifth


@dataclass(frozen=True, eq=False)
class Pose:
    """A body at one instant: position (N, 2) m; activation (N,) of e - c."""

    position: np.ndarray
    activation: np.ndarray


@dataclass(frozen=True, eq=False)
class Life:
    """Growth and locomotion of one animat.

    Attributes:
        growth_time (S,) s; growth: S poses; growth_springs: S arrays (E, 2) of the embryo's graph.
        time (T,) s, running on from growth; position (T, N, 2) m; activation (T, N) of e - c.
        target (T, 2) m, NaN while there is none, or (0, 2) where there never was one; reach: m to where its scent ends, 0 if
            not known.
        velocity (T, N, 2) m/s.
        springs (E, 2), outline (M, 2): cell indices; chambers: arrays of cell indices, counter-clockwise.
        scene: the solid world of a walker, or None.
    """

    growth_time: np.ndarray
    growth: list[Pose]
    growth_springs: list[np.ndarray]
    time: np.ndarray
    position: np.ndarray
    activation: np.ndarray
    springs: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))
    outline: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))
    chambers: list[np.ndarray] = field(default_factory=list)
    target: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    reach: float = 0.0
    velocity: np.ndarray | None = None
    scene: Scene | None = None

    @property
    def contact(self) -> np.ndarray:
        """(T, N): whether a cell touches the ground or the ceiling, itself or by an edge that lies on a tip."""
        if self.scene is None:
            return np.zeros(self.activation.shape, bool)
        return contacts(self.scene, self.outline, self.position)

    def surfaces(self, low: float, high: float) -> list[np.ndarray]:
        """The lines (K, 2) of ground and ceiling from x = low to high, m."""
        return [] if self.scene is None else surfaces(self.scene, low, high)

    @property
    def centre(self) -> np.ndarray:
        """(T, 2) m, the centre of mass: all cells weigh the same."""
        return self.position.mean(axis=1)

    @property
    def distance(self) -> np.ndarray:
        """(T,) m, of the centre of mass from where it was at birth; of a walker, along x alone."""
        way = self.centre - self.centre[:1]
        return np.hypot(*way.T) if self.scene is None else np.abs(way[:, 0])

    @property
    def target_distance(self) -> np.ndarray:
        """(T,) m, of the centre of mass from the target; NaN while there is none."""
        return np.hypot(*(self.centre - self.target).T)

    def pose(self, step: int) -> Pose:
        return Pose(self.position[step], self.activation[step])


def life_of(recording: Recording) -> Life:
    """The last life of a recording, e.g. after the last reset of a simulator; empty arrays where it holds none.

    Raises RecordingError where bodies and states do not fit each other, or are of other message types than ours.
    """
    for attribute in ("states", "body"):
        if attribute in recording.unread and not getattr(recording, attribute):
            raise RecordingError(f"{recording.path}: {recording.unread[attribute]}")
    growth = _finite(_last_run(recording.growth))
    lived = _filled(_last_run(recording.states))
    targets = _targets(recording, len(recording.states) - len(lived), len(lived))
    sound = [_is_finite(state) for state in lived]
    states = [state for state, fine in zip(lived, sound) if fine]
    targets = targets[np.array(sound, bool)] if len(targets) else targets
    body = recording.body
    cells = body.cells if body is not None else len(states[-1].activation) if states else 0
    fits = np.array([len(state.activation) == cells and cells > 0 for state in states], bool)
    states = [state for state, fit in zip(states, fits) if fit]
    targets = targets[fits] if len(targets) else targets
    settings = recording.settings
    try:
        return Life(
            growth_time=_seconds(growth),
            growth=[Pose(_positions(state), np.array(state.activation)) for state in growth],
            growth_springs=_graphs(growth, recording.growth_bodies),
            time=_seconds(states),
            position=np.array([_positions(state) for state in states]).reshape(len(states), cells, 2),
            activation=np.array([state.activation for state in states]).reshape(len(states), cells),
            target=targets,
            reach=settings.task.chemotaxis.scent_reach if settings is not None else 0.0,
            velocity=np.array([(s.velocity_x, s.velocity_y) for s in states]).reshape(len(states), 2, cells).swapaxes(1, 2),
            **({} if body is None else _parts(body)),
            scene=_scene(recording),
        )
    except (ValueError, IndexError):
        raise RecordingError(f"{recording.path}: cells, springs and chambers do not fit each other: record it again") from None


def last_states(recording: Recording, cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The last life as it was recorded: (time (T,) s, position (T, N, 2) m, NaN where not seen, activation (T, N), step (T,))."""
    states = [s for s in _last_run(recording.states) if len(s.position_x) == len(s.position_y) == len(s.activation) == cells]
    position = np.array([_positions(state) for state in states]).reshape(len(states), cells, 2)
    activation = np.array([state.activation for state in states]).reshape(len(states), cells)
    return _seconds(states), position, activation, np.array([state.step for state in states], int)


def _scene(recording: Recording) -> Scene | None:
    """The world, where there is ground in it: that of simulate, or of the task of a run."""
    settings, scene = recording.settings, recording.scene
    if scene is None and settings is not None and _has_ground(settings.task.name):
        scene = settings.task.scene
    try:
        return None if scene is None else scene_from_message(scene)
    except ParameterError:
        return None


def _has_ground(task: str) -> bool:
    kind = kind_of(task)
    return kind is not None and kind.has_ground


def _stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _seconds(messages) -> np.ndarray:
    return np.array([_stamp(message) for message in messages], float) * 1e-9


def _last_run(messages: list) -> list:
    """The messages since time last ran back: a recording holds each life in order."""
    stamps = np.array([_stamp(message) for message in messages])
    back = np.flatnonzero(np.diff(stamps) <= 0)
    return messages[back[-1] + 1 :] if len(back) else messages


def _finite(states: list) -> list:
    """Those without a number that is none, e.g. from a plant that blew up."""
    return [state for state in states if _is_finite(state)]


_COORDINATES = ("position_x", "position_y", "velocity_x", "velocity_y")


def _filled(states: list) -> list:
    """The states, with cells that hardware has not seen for a moment filled in; those whose cells do not fit each other as they are."""
    if all(np.isfinite(state.position_x).all() for state in states) or len({len(state.position_x) for state in states}) != 1:
        return states
    if any(len(getattr(state, name)) != len(state.position_x) for state in states for name in _COORDINATES):
        return states
    time, whole = _seconds(states), {}
    for axis in "xy":
        position, velocity = (filled(time, np.array([getattr(s, f"{what}_{axis}") for s in states])) for what in ("position", "velocity"))
        whole[f"position_{axis}"], whole[f"velocity_{axis}"] = position, speeds(time, position, velocity)
    found = [copy(state) for state in states]
    for name, series in whole.items():
        for state, values in zip(found, series):
            setattr(state, name, array("d", values.tobytes()))
    return found


def _is_finite(s) -> bool:
    return all(np.isfinite(values).all() for values in (s.position_x, s.position_y, s.activation))


def _targets(recording: Recording, first: int, count: int) -> np.ndarray:
    """(count, 2) m: the target at each state from `first` on, NaN while there is none; (0, 2) where there never was one."""
    points = [(message.pose.position.x, message.pose.position.y) for message in recording.targets]  # in the order of their times
    if not points or not count:
        return np.empty((0, 2))
    latest = np.searchsorted(recording.target_times, recording.state_times[first : first + count], side="right")
    return np.array([(np.nan, np.nan), *points])[latest]


def _positions(state) -> np.ndarray:
    position = np.column_stack((state.position_x, state.position_y))
    if len(position) != len(state.activation):
        raise ValueError
    return position


def _springs(body) -> np.ndarray:
    return _pairs(body.spring_a, body.spring_b, body.cells)


def _pairs(a, b, cells: int) -> np.ndarray:
    pairs = np.column_stack((a, b)).astype(int).reshape(-1, 2)
    if pairs.size and pairs.max() >= cells:
        raise IndexError
    return pairs


def _parts(body) -> dict:
    chambers = chambers_of(body.chamber_start, body.chamber_cell)
    if any(chamber.size and chamber.max() >= body.cells for chamber in chambers):
        raise IndexError
    return {"springs": _springs(body), "outline": _pairs(body.outline_a, body.outline_b, body.cells), "chambers": chambers}


def _graphs(states: list, bodies: list) -> list[np.ndarray]:
    """The embryo's springs at each state: those of the last body before it, if they are about the same cells."""
    bodies = _last_run(bodies)
    springs = [_springs(body) for body in bodies]
    latest = np.searchsorted([_stamp(body) for body in bodies], [_stamp(state) for state in states], side="right") - 1
    none = np.empty((0, 2), int)
    fits = [k >= 0 and bodies[k].cells == len(state.activation) for k, state in zip(latest, states)]
    return [springs[k] if fit else none for k, fit in zip(latest, fits)]


def contrasting_cells(activation: np.ndarray) -> list[int]:
    """Two cells whose activations (T, N) differ most over the second half, among those that are active; or fewer.

    They show the phase gradient of a gait, as in the paper's Fig. 5.
    """
    late = activation[len(activation) // 2 :]
    if not late.size:
        return []
    amplitude = np.ptp(late, axis=0)
    strongest = int(amplitude.argmax())
    active = np.flatnonzero(amplitude >= 0.5 * amplitude.max())
    apart = np.abs(late[:, active] - late[:, [strongest]]).mean(axis=0)
    return list(dict.fromkeys((strongest, int(active[apart.argmax()]))))


def period_of(life: Life, cells: Any) -> float:
    """The main period of some cells' muscles in the second half of a life, s; infinity where there is none."""
    if len(life.time) < 3:
        return np.inf
    late = life.activation[len(life.time) // 2 :, cells]
    power = np.abs(np.fft.rfft(late - late.mean(axis=0), axis=0)).sum(axis=1)
    k = int(power.argmax())
    return len(late) * float(life.time[1] - life.time[0]) / k if k else np.inf
