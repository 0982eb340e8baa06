"""`analyse(track)`: the gait of a motion, from its second half."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .contact import Contact, contact_of
from .form import chamber_areas, limbs, share_of_cells, synchrony
from .frame import BodyFrame, body_frame, swaying
from .phase import bending, plane_wave, sides
from .rhythm import Rhythm, beats, common_rhythm
from .rules import Rules, classify_swimmer, classify_walker
from .track import Track
from .work import Work, work_of


@dataclass(frozen=True, eq=False)
class Gait:
    """A gait in numbers, of the second half of a motion; NaN: not known, or not there.

    name, why: of the classifier.  frequency, Hz.  amplitude: mean over cells, of e - c at that frequency.  coherence: share of the
    muscles' variance at that frequency and its first harmonics.  gradient_along, gradient_across: of the phase, rad/m, forward
    and to the left; gradient_fit: 0 .. 1, of such a plane wave.  lateral_shift: rad, 0 .. pi, between left and right cells;
    lateral_agreement: 0 .. 1.  synchrony, area_synchrony: 0 .. 1, of cells' muscles and of chambers' areas.  pulsation: amplitude
    of the body's area, relative.  bending: 1 the body bends, -1 it swells.  moving_share: of cells over which the amplitude of
    muscles is spread.  limb_lead: power of sway of a limb's cell relative to one of the body; limb_power: share of all limbs.
    length, width: m, along and across.  long_axis: rad, from the way to the body's long axis.
    speed: m/s along its own heading; travel: m between begin and end; turning: rad/s; stroke: m per period.
    muscle_work, drag_work, damping_work, ground_work: J done on the body.  cost_of_transport: J/(kg m), muscle work per mass
    and travel.
    flight: share of the time; flights: 1/s; feet; duty: mean share of the time for which a foot stands; support: association of
    the end feet's contact; mass_shift: m.
    """

    name: str
    why: str
    frequency: float = np.nan
    amplitude: float = np.nan
    coherence: float = np.nan
    gradient_along: float = np.nan
    gradient_across: float = np.nan
    gradient_fit: float = np.nan
    lateral_shift: float = np.nan
    lateral_agreement: float = np.nan
    synchrony: float = np.nan
    area_synchrony: float = np.nan
    pulsation: float = np.nan
    bending: float = np.nan
    moving_share: float = np.nan
    limb_lead: float = np.nan
    limb_power: float = np.nan
    length: float = np.nan
    width: float = np.nan
    long_axis: float = np.nan
    speed: float = np.nan
    travel: float = np.nan
    turning: float = np.nan
    stroke: float = np.nan
    muscle_work: float = np.nan
    drag_work: float = np.nan
    damping_work: float = np.nan
    ground_work: float = np.nan
    cost_of_transport: float = np.nan
    flight: float = np.nan
    flights: float = np.nan
    feet: int = 0
    duty: float = np.nan
    support: float = np.nan
    mass_shift: float = np.nan


@dataclass(frozen=True, eq=False)
class Analysis:
    """A gait and what it was read from: the second half of the track, its muscles' rhythm, its body's frame, its contacts."""

    gait: Gait
    half: Track
    rhythm: Rhythm
    frame: BodyFrame
    contact: Contact | None
    limb: np.ndarray


def analyse(track: Track, rules: Rules = Rules()) -> Analysis:
    """The gait of a motion: of a walker where the track has ground, or else of a swimmer."""
    half = track.second_half()
    rhythm = common_rhythm(half.time, half.activation)
    frame = body_frame(half.time, half.position, rhythm.frequency, rules.least_travel)
    limb = limbs(frame.shape, rules.limb_thickness)
    contact = None
    found = {**_rhythm(rhythm), **_motion(half, rhythm, frame), **_work(half)}
    if np.isfinite(rhythm.frequency):
        found |= _phases(frame, rhythm)
        found |= _form(half, rhythm, frame, limb, found["gradient_along"])
    if half.ground is not None:
        contact = contact_of(half, rhythm.frequency, rules.contact_height, rules.least_duty, rules.foot_gap)
        found |= {
            "flight": contact.flight, "flights": contact.flights, "feet": len(contact.feet), "support": contact.support,
            "duty": float(contact.foot_duty.mean()) if len(contact.feet) else 0.0, "mass_shift": contact.shift,
        }
    classify = classify_swimmer if contact is None else classify_walker
    name, why = classify(Gait("", "", **found), rules)
    return Analysis(Gait(name, why, **found), half, rhythm, frame, contact, limb)


def _rhythm(rhythm: Rhythm) -> dict:
    size = np.abs(rhythm.wave)
    return {
        "frequency": rhythm.frequency, "amplitude": float(size.mean()), "coherence": rhythm.coherence,
        "synchrony": synchrony(rhythm.wave), "moving_share": share_of_cells(size),
    }


def _motion(half: Track, rhythm: Rhythm, frame: BodyFrame) -> dict:
    way = half.position[-1].mean(axis=0) - half.position[0].mean(axis=0)
    return {
        "speed": frame.speed, "travel": float(np.hypot(*way)), "turning": frame.turning, "stroke": frame.speed / rhythm.frequency,
        "length": frame.length, "width": frame.width, "long_axis": frame.long_axis,
    }


def _work(half: Track) -> dict:
    work: Work = work_of(half)
    way = np.hypot(*(half.position[-1] - half.position[0]).mean(axis=0))
    mass = half.world.mass * half.position.shape[1]
    return {
        "muscle_work": work.muscle, "drag_work": work.drag, "damping_work": work.damping,
        "ground_work": work.rest if half.ground is not None else np.nan,
        "cost_of_transport": float(work.muscle / (mass * way)) if way > 0 else np.nan,
    }


def _phases(frame: BodyFrame, rhythm: Rhythm) -> dict:
    plane = plane_wave(frame.shape, rhythm.wave)
    lateral = sides(frame, rhythm.wave, plane.along)
    return {
        "gradient_along": plane.along, "gradient_across": plane.across, "gradient_fit": plane.fit,
        "lateral_shift": lateral.shift, "lateral_agreement": lateral.agreement,
    }


def _form(half: Track, rhythm: Rhythm, frame: BodyFrame, limb, along: float) -> dict:
    areas = chamber_areas(half.position, half.chambers)
    pulse = beats(half.time, areas, rhythm.frequency)[0] if areas.size else np.zeros(1)
    sway = swaying(half.time, frame, rhythm.frequency)
    power = (np.abs(sway) ** 2).sum(axis=1)
    apart = limb.any() and not limb.all()
    return {
        "area_synchrony": synchrony(pulse), "pulsation": float(abs(pulse.sum()) / areas.sum(axis=1).mean()) if areas.size else 0.0,
        "bending": bending(frame, sway, along), "limb_lead": float(power[limb].mean() / power[~limb].mean()) if apart else 0.0,
        "limb_power": float(power[limb].sum() / power.sum()) if apart else 0.0,
    }
