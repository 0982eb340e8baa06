"""Who touches the ground and when: feet, flights, and how the mass moves over what it stands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .rhythm import beats
from .track import Track


@dataclass(frozen=True, eq=False)
class Contact:
    """Of a walker over some time.

    Attributes:
        touching (T, N): whether a cell is at the ground, itself or by an edge that lies on a tip.
        duty (N,): the share of the time for which it is.
        feet: arrays of cells, groups that touch the ground and lie apart along it, from the rear to the front in the direction
            of travel; foot_duty (F,): shares of the time for which any cell of a foot touches.
        flight: share of the time in which nothing touches; flights: 1/s, how often that begins.
        support: association of the ground contact of the rearmost and the foremost foot: -1 they alternate as far as their
            duty allows, 1 they go together, 0 also where there is one foot or where one never lifts.
        shift: m, amplitude at the common frequency of the centre of mass along the ground from the middle of what it stands on.
        direction: 1 or -1 along x, of travel.
    """

    touching: np.ndarray
    duty: np.ndarray
    feet: list
    foot_duty: np.ndarray
    flight: float
    flights: float
    support: float
    shift: float
    direction: float


def contact_of(track: Track, frequency: float, tolerance: float, least_duty: float, gap: float) -> Contact:
    """The contacts of a track with ground.

    Args: frequency: Hz, common, or NaN; tolerance: m above the ground that still touch; least_duty: share of the time for which a
        cell of a foot touches; gap: m along the ground between two feet.
    """
    if track.ground is None:
        raise ValueError("the track is of a swimmer: contacts take ground")
    x = track.position[..., 0]
    touching = track.ground.touching(track.outline, track.position, tolerance)
    centre = x.mean(axis=1)
    direction = 1.0 if centre[-1] >= centre[0] else -1.0
    duty = touching.mean(axis=0)
    feet = _feet(x - centre[:, None], touching, duty, least_duty, gap)[:: int(direction)]
    down = np.array([touching[:, foot].any(axis=1) for foot in feet]).reshape(len(feet), len(x))
    airborne = np.logical_not(touching.any(axis=1))
    starts = np.count_nonzero(airborne[1:] & ~airborne[:-1])
    return Contact(
        touching=touching, duty=duty, feet=feet, foot_duty=down.mean(axis=1), flight=float(airborne.mean()),
        flights=float(starts / (track.time[-1] - track.time[0])), support=_association(down[0], down[-1]) if len(feet) > 1 else 0.0,
        shift=_shift(track.time, x, centre, touching, frequency), direction=direction,
    )


def _feet(about, touching, duty, least_duty, gap) -> list:
    """Groups of cells by where they are about the centre when they touch, (T, N) m, from left to right."""
    cells = np.flatnonzero(duty >= max(least_duty, 1e-9))
    if not len(cells):
        return []
    at = np.array([about[touching[:, cell], cell].mean() for cell in cells])
    order = at.argsort()
    return np.split(cells[order], np.flatnonzero(np.diff(at[order]) > gap) + 1)


def _association(a, b) -> float:
    """Of two signals of 0 and 1: their covariance, relative to the most that their means allow (Cole's coefficient)."""
    p, q = a.mean(), b.mean()
    apart = np.mean(a & b) - p * q
    most = min(p, q) - p * q if apart > 0 else p * q - max(0.0, p + q - 1)
    return float(apart / most) if most > 1e-9 else 0.0


def _shift(time, x, centre, touching, frequency) -> float:
    stands = touching.any(axis=1)
    if not np.isfinite(frequency) or np.count_nonzero(stands) < 2:
        return 0.0
    under = (x * touching)[stands].sum(axis=1) / touching[stands].sum(axis=1)
    offset = np.interp(time, time[stands], centre[stands] - under)
    return float(abs(beats(time, offset[:, None], frequency)[0][0]))
