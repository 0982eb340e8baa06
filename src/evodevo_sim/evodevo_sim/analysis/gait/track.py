"""What a gait is read from: the motion of one body as arrays, from a recording, a performance or a formula."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...physics.terrain import Ground

LEAST_FRAMES = 16  # in the half that is analysed
_UNEVEN = 0.01  # relative to a frame, above which frames count as unevenly spaced


class GaitError(ValueError):
    """A motion that no gait can be read from; the message says why, and the mend."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Constants that forces and work follow from; NaN: unknown.  mass: kg of a cell; the others as in `parameters`."""

    mass: float = 1.0
    stiffness: float = np.nan
    damping: float = np.nan
    pressure: float = np.nan
    drag_normal: float = 0.0
    drag_tangential: float = 0.0
    gravity: float = 0.0
    muscle_range: float = np.nan


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of one body.

    Attributes:
        time (T,) s; position (T, N, 2) m; activation (T, N) of e - c.
        springs (E, 2): cells; rest_length (E,) m at zero activation, or empty; outline (M, 2): cells; chambers: arrays of
            cells, counter-clockwise; chamber_area: m^2 at rest, of each, or empty.
        velocity (T, N, 2) m/s, or None: then it follows from positions.
        held: whether muscles hold over a frame and change at its end, as a walker's do, or go on their way between frames.
        world: see `Surroundings`; ground: of a walker, or None: a swimmer.
    """

    time: np.ndarray
    position: np.ndarray
    activation: np.ndarray
    springs: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))
    rest_length: np.ndarray = field(default_factory=lambda: np.empty(0))
    outline: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))
    chambers: tuple = ()
    chamber_area: np.ndarray = field(default_factory=lambda: np.empty(0))
    velocity: np.ndarray | None = None
    world: Surroundings = Surroundings()
    ground: Ground | None = None
    held: bool = True

    def __post_init__(self):
        frames, cells = self.position.shape[:2]
        if cells < 2:
            raise GaitError(f"the body has {cells} cell{'' if cells == 1 else 's'}: a gait takes two or more")
        for name in ("time", "position", "activation", "velocity"):
            values = getattr(self, name)
            if values is None:
                continue
            bad = np.flatnonzero(~np.isfinite(values).reshape(frames, -1).all(axis=1))
            if len(bad):
                raise GaitError(f"{name} holds no number in frame {bad[0]} of {frames}: give a motion that did not fail")
        if not (np.diff(self.time) > 0).all():
            frame = int(np.flatnonzero(np.diff(self.time) <= 0)[0])
            raise GaitError(f"time does not run on after frame {frame}: give one run at a time")

    def second_half(self) -> Track:
        """The later half, in frames evenly spaced.  Raises GaitError where they are too few."""
        if len(self.time) < 2 * LEAST_FRAMES:
            raise GaitError(f"the motion has {len(self.time)} frames: a gait takes {2 * LEAST_FRAMES} or more")
        late = slice(len(self.time) // 2, None)
        time = self.time[late]
        even = np.linspace(time[0], time[-1], len(time))
        uneven = np.abs(time - even).max() > _UNEVEN * (even[1] - even[0])

        def later(values: np.ndarray) -> np.ndarray:
            return _at(even, time, values[late]) if uneven else values[late]

        return replace(
            self, time=later(self.time), position=later(self.position), activation=later(self.activation),
            velocity=None if self.velocity is None else later(self.velocity),
        )

    def speeds(self) -> np.ndarray:
        """(T, N, 2) m/s."""
        return np.gradient(self.position, self.time, axis=0) if self.velocity is None else self.velocity


def _at(now: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (T, ...) at other times, by linear interpolation."""
    flat = values.reshape(len(time), -1)
    return np.stack([np.interp(now, time, column) for column in flat.T], axis=1).reshape(len(now), *values.shape[1:])
