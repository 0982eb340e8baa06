"""The ledger of a motion that was recorded: J by muscles, drag, damping and ground, from its frames (docs/reference/gaits.md).

`energy` keeps the same ledger while a motion is being computed; this one needs nothing but what was recorded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .form import chamber_areas
from .track import Track


@dataclass(frozen=True, eq=False)
class Work:
    """J done on the body; gain: J of stored energy; rest: J that these do not explain: on ground, its work."""

    muscle: float
    drag: float
    damping: float
    gain: float

    @property
    def rest(self) -> float:
        return self.gain - self.muscle - self.drag - self.damping


def work_of(track: Track) -> Work:
    """The ledger of a track; NaN where its world is not known."""
    w = track.world
    if not len(track.rest_length) or not np.isfinite(w.stiffness):
        return Work(np.nan, np.nan, np.nan, np.nan)
    a, b = track.springs.T
    along = track.position[:, b] - track.position[:, a]
    length = np.hypot(along[..., 0], along[..., 1])
    rest = (1.0 + w.muscle_range * (track.activation[:, a] + track.activation[:, b])) * track.rest_length
    velocity = track.speeds()
    rate = ((velocity[:, b] - velocity[:, a]) * along).sum(axis=-1) / length
    # Muscles that do their work at once do it at the start of a control step; others on the way, by the mean length of the cubic
    # through lengths and speeds.
    then = length[:-1]
    if not track.held:
        seconds = np.diff(track.time)[:, None]
        then = 0.5 * (length[:-1] + length[1:]) + seconds / 12.0 * (rate[:-1] - rate[1:])
    muscle = 0.5 * w.stiffness * ((then - rest[1:]) ** 2 - (then - rest[:-1]) ** 2).sum()
    damping = -np.trapezoid(w.damping * (rate**2).sum(axis=1), track.time)
    stored = _stored(track, length[[0, -1]], rest[[0, -1]], velocity[[0, -1]])
    drag = np.trapezoid(_drag_power(track, velocity), track.time)
    return Work(float(muscle), float(drag), float(damping), float(stored[1] - stored[0]))


def _drag_power(track: Track, velocity) -> np.ndarray:
    """(T,) W, never above 0."""
    a, b = track.outline.T
    along = track.position[:, b] - track.position[:, a]
    length = np.hypot(along[..., 0], along[..., 1])
    mean = 0.5 * (velocity[:, a] + velocity[:, b])
    tangential = np.abs((mean * along).sum(axis=-1)) / length
    normal = np.abs(mean[..., 0] * along[..., 1] - mean[..., 1] * along[..., 0]) / length
    drag = track.world.drag_tangential * tangential**3 + track.world.drag_normal * normal**3
    return -(length * drag).sum(axis=1)


def _stored(track: Track, length, rest, velocity) -> np.ndarray:
    """(2,) J at the first and the last frame."""
    w = track.world
    position = track.position[[0, -1]]
    kinetic = 0.5 * w.mass * (velocity**2).sum(axis=(1, 2))
    elastic = 0.5 * w.stiffness * ((length - rest) ** 2).sum(axis=1)
    lift = w.mass * w.gravity * position[..., 1].sum(axis=1)
    if not len(track.chamber_area):
        return kinetic + elastic + lift
    squeezed = (track.chamber_area - chamber_areas(position, track.chambers)) ** 2 / track.chamber_area
    return kinetic + elastic + lift + 0.5 * w.pressure * squeezed.sum(axis=1)
