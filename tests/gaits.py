"""Motions of known gait, by formula: positions and muscles of bodies as functions of time."""

import numpy as np
from bodies import body_of
from evodevo_sim.analysis.gait import Ground, Track
from evodevo_sim.analysis.gait.sources import parts_of_body

SECONDS, FREQUENCY = 12.0, 1.3
TIME = np.arange(int(60 * SECONDS) + 1) / 60
TURN = 2 * np.pi * FREQUENCY * TIME[:, None]


def lattice(columns=10, rows=3):
    """Cells of a triangular lattice, its middle at the origin: (N, 2)."""
    position = np.array([(c + 0.5 * (r % 2), r * np.sqrt(0.75)) for r in range(rows) for c in range(columns)])
    return position - position.mean(axis=0)


def track(rest, x, y, activation, ground=None):
    """A track of cells with coordinates (T, N) about a body at rest (N, 2)."""
    return Track(TIME, np.stack((x, y), axis=-1), activation, ground=ground, **parts_of_body(body_of(rest)))


def undulating(wavelength=6.0, speed=0.4):
    """Muscles of both sides in antiphase; the midline bends in a wave that runs to the rear."""
    rest = lattice()
    x, y = rest.T
    phase = TURN + 2 * np.pi / wavelength * x
    muscle = 0.8 * y / y.max() * np.cos(phase)
    bend = 0.35 * np.sin(phase)
    slope = 0.35 * 2 * np.pi / wavelength * np.cos(phase)
    return track(rest, x + speed * TIME[:, None] - y * slope, y + bend, muscle)


def pulsing_bell(speed=0.3):
    """The whole body swells and narrows, nearly in time."""
    rest = lattice(6, 5)
    x, y = rest.T
    beat = 0.7 * np.cos(TURN + 0.1 * x)
    return track(rest, x * (1 - 0.03 * beat) + speed * TIME[:, None], y * (1 + 0.12 * beat), beat)


def tailed(speed=0.3, columns=7):
    """A stout body of still cells, whose tail, two cells wide, beats across."""
    body = lattice(5, 5)
    tail = np.array([(body[:, 0].min() - 1 - k, 0.87 * r - 0.43) for k in range(columns) for r in range(2)])
    rest = np.vstack((body, tail))
    x, y = rest.T
    behind = np.maximum(0.0, body[:, 0].min() - x)
    beat = np.sin(TURN + 0.6 * x)
    muscle = 0.8 * (behind > 0) * np.sign(y) * beat
    return track(rest, x + speed * TIME[:, None], y + 0.12 * behind * beat, muscle)


def rowing(speed=0.3):
    """A stout body with an arm on either side; all cells work, in a wave to the front, and the arms swing."""
    body = lattice(7, 5)
    arms = np.array([(0.87 * r - 0.4, side * (body[:, 1].max() + 1 + k)) for side in (-1, 1) for k in range(4) for r in range(2)])
    rest = np.vstack((body, arms))
    x, y = rest.T
    out = np.maximum(0.0, np.abs(y) - body[:, 1].max())
    phase = TURN - 0.6 * x
    return track(rest, x + speed * TIME[:, None] + 0.25 * out * np.sin(TURN), y + 0.05 * np.sin(phase), 0.6 * np.cos(phase))


def peristaltic(speed=0.3):
    """A ribbon in waves of thickness, both sides alike."""
    rest = lattice()
    x, y = rest.T
    phase = TURN + 2 * np.pi / 3 * x
    return track(rest, x + 0.1 * np.sin(phase) + speed * TIME[:, None], y * (1 + 0.15 * np.cos(phase)), 0.8 * np.cos(phase))


def standing(shape):
    """Rest (N, 2) on y = 0."""
    return shape - (0.0, shape[:, 1].min())


def hopping(speed=0.8, height=0.5):
    """A block that leaps in parabolas and squats in between, a third of the time in the air."""
    rest = standing(lattice(5, 4))
    x, y = rest.T
    phase = (FREQUENCY * TIME) % 1.0
    air = np.clip(phase / 0.35, 0.0, 1.0)
    lift = 4 * height * air * (1 - air)
    squat = np.where(phase > 0.35, np.sin(np.pi * (phase - 0.35) / 0.65), 0.0)
    muscle = -0.7 * squat[:, None] + 0.0 * x
    way = speed * TIME
    return track(rest, x + way[:, None], y * (1 - 0.15 * squat[:, None]) + lift[:, None], muscle, Ground())


def running(speed=0.8):
    """A body on two legs, rear and front, of which one stands while the other is lifted."""
    rest, legs = two_legged()
    x, y = rest.T
    swing = np.sin(TURN)
    lift = sum(0.3 * np.maximum(0.0, sign * swing) * leg for sign, leg in zip((1, -1), legs))
    return track(rest, x + speed * TIME[:, None], y + lift, 0.6 * np.cos(TURN - 0.5 * x), Ground())


def shifting(speed=0.2):
    """A body on two legs that never lift, whose upper cells swing to and fro."""
    rest, _ = two_legged()
    x, y = rest.T
    swing = 0.15 * y / y.max() * np.sin(TURN)
    return track(rest, x + speed * TIME[:, None] + swing * 3, y + 0.0 * swing, 0.5 * (y > 1) * np.cos(TURN + 0.2 * x), Ground())


def two_legged():
    """(rest (N, 2), its rear and its front leg (N,) each)."""
    back = standing(lattice(8, 2)) + (0.0, 2.0)
    legs = np.array([(side * 3.3 + 0.8 * k, 0.9 * h) for side in (-1, 1) for k in (-0.5, 0.5) for h in range(2)])
    rest = np.vstack((back, legs))
    leg = np.arange(len(rest)) >= len(back)
    return rest, (leg & (rest[:, 0] < 0), leg & (rest[:, 0] > 0))
