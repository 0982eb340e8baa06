"""The frame of a body that bends and turns: its mean shape, the direction in which it travels, and how cells sway about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .rhythm import beats

_ROUNDS = 6  # of the mean shape and the turns that fit it


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """Of a body over some time, axes `along` (the direction of travel, or the long axis where it gets nowhere) and `across` (to
    the left of it).

    Attributes:
        shape (N, 2) m: mean position of each cell along and across, from the centre.
        sway (T, N, 2) m: position in that frame, turned and moved with the body.
        turn (T,) rad: of the body in the world.
        speed: m/s that it travels along; turning: rad/s.
        long_axis: rad from `along` to the body's long axis, -pi/2 .. pi/2; elongation: ratio of the root mean squares of the
            cells' distances along the long and the short axis.
        length, width: m, with the cells' own diameter, along and across.
    """

    shape: np.ndarray
    sway: np.ndarray
    turn: np.ndarray
    speed: float
    turning: float
    long_axis: float
    elongation: float

    @property
    def length(self) -> float:
        return float(np.ptp(self.shape[:, 0]) + 1.0)

    @property
    def width(self) -> float:
        return float(np.ptp(self.shape[:, 1]) + 1.0)

    @property
    def midline(self) -> np.ndarray:
        """(N,) m across: the middle of the body beside each cell."""
        weight = stations(self.shape[:, 0])
        return weight @ self.shape[:, 1] / weight.sum(axis=1)


def stations(along: np.ndarray, width: float = 0.6) -> Any:
    """(N, N) how far two cells are at the same station along the body: 1 beside each other, 0 far away.  Args: width, m."""
    return np.exp(-0.5 * ((along[:, None] - along) / width) ** 2)


def body_frame(time: np.ndarray, position: np.ndarray, frequency: float, least_travel: float) -> BodyFrame:
    """The frame of a motion.

    Args: time (T,) s; position (T, N, 2) m; frequency: Hz, whole periods of which count, or NaN; least_travel: m over the whole
        time from which on there is a direction of travel.
    """
    z = position[..., 0] + 1j * position[..., 1]
    centre = z.mean(axis=1)
    z = z - centre[:, None]
    shape = z[0]
    for _ in range(_ROUNDS):
        turn = np.angle((z * shape.conj()).sum(axis=1))
        shape = (z * np.exp(-1j * turn)[:, None]).mean(axis=0)
    turn = np.unwrap(turn)
    whole = _whole_periods(time, frequency)
    seconds = time[-1] - time[whole]
    # The way in the frame of the body: one that circles has a direction, too.
    steps = np.diff(centre) * np.exp(-0.5j * (turn[1:] + turn[:-1]))
    travel = steps[whole:].sum()
    spread = np.linalg.eigh(np.cov(np.stack((shape.real, shape.imag))))
    longest = complex(*spread[1][:, 1])
    moves = abs(travel) >= least_travel * seconds / (time[-1] - time[0])
    along = travel / abs(travel) if moves else longest / abs(longest)
    bent = np.angle(longest / along)
    least, most = np.sqrt(np.maximum(spread[0], 1e-12))
    sway = z * np.exp(-1j * turn)[:, None] / along
    return BodyFrame(
        shape=_plane(shape / along), sway=_plane(sway), turn=turn, speed=float(abs(travel) / seconds),
        turning=float((turn[-1] - turn[whole]) / seconds), long_axis=float((bent + np.pi / 2) % np.pi - np.pi / 2),
        elongation=float(most / least),
    )


def _whole_periods(time, frequency) -> int:
    """The frame from which on the time holds a whole number of periods."""
    if not np.isfinite(frequency):
        return 0
    periods = np.floor((time[-1] - time[0]) * frequency)
    return int(np.clip(np.searchsorted(time, time[-1] - periods / frequency - 1e-9), 0, len(time) // 2))


def _plane(z) -> np.ndarray:
    return np.stack((z.real, z.imag), axis=-1)


def swaying(time: np.ndarray, frame: BodyFrame, frequency: float) -> np.ndarray:
    """(N, 2) complex m: how each cell beats along and across, at a frequency, in the frame of the body."""
    frames, cells = frame.sway.shape[:2]
    return beats(time, frame.sway.reshape(frames, 2 * cells), frequency)[0].reshape(cells, 2)
