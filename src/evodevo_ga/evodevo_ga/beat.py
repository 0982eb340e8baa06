"""How the muscles of a grown body will beat, told before it lives: its brain alone, on a body that does not move.

No sense tells a brain how its body moves, so where there is no scent what its muscles do follows from growth.  A beat is told by its
phases on the body, as gaits are (docs/reference/gaits.md), and is not the gait: what a body makes of it takes a life.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum
from functools import cached_property

import numpy as np
from evodevo_sim.brain.brain import make_brain
from evodevo_sim.brain.controller import Rules, brain_step
from evodevo_sim.brain.scent import make_signals, scent_row
from evodevo_sim.development.shape import principal
from evodevo_sim.kernels.jit import lean
from evodevo_sim.tasks.grown import Grown
from evodevo_sim.tasks.life import develop
from evodevo_sim.tasks.outcome import Status
from evodevo_sim.tasks.swim.fitness import kernel_arguments

from evodevo_sim import Genome, Task

from .nursery import Nursery

_BEFORE, _LOOKED_AT = 240, 480  # control steps: until the brain has found its rhythm, and of its rhythm
_LEAST_CYCLES = 2  # in what is looked at
_LEAST_AMPLITUDE = 0.02  # of e - c, mean of the cells
_PASSIVE_SHARE = 0.5  # of the cells that the amplitude is spread over at the most, where only a part beats
_TOGETHER = 0.7  # from which synchrony on all beat as one
_WAVES = np.linspace(-np.pi, np.pi, 65)  # rad/m along the body
_NONE = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)


class Beat(IntEnum):
    """STILL: muscles hardly move; PART: of some cells alone; PULSE: all as one; BEND: the sides against each other; WAVE: the sides alike,
    one place after the other."""

    STILL = 0
    PART = 1
    PULSE = 2
    BEND = 3
    WAVE = 4


@lean
def _think_on(brain, position, rules, activation):
    """The brain's steps, one after the other.  Args: position (2, N); activation (T, N): is filled with e - c of each step."""
    for k in range(activation.shape[0]):
        brain_step(brain, position, rules, k)
        for cell in range(activation.shape[1]):
            activation[k, cell] = brain.activation[cell]


def activation_of(genome: Genome, task: Task) -> np.ndarray:
    """(T, N): e - c of every cell in the control steps that a beat is told by, without scent and noise.  The genome must grow."""
    genes, model = kernel_arguments(genome, task)
    weights, units, embryo = develop(genes, model, *_NONE)
    brain = make_brain(weights, units, embryo, model.given_inputs, model.continual)
    if task.has_target:
        brain.table[scent_row(brain.units)] = 0.0
    found = np.empty((_BEFORE + _LOOKED_AT, len(embryo.position)))
    rules = Rules(task.control_step, model.development, model.continual, make_signals())
    _think_on(brain, np.ascontiguousarray(embryo.position.T), rules, found)
    return found[_BEFORE:]


def beat_of(activation: np.ndarray, position: np.ndarray) -> Beat:
    """The beat of muscles.  Args: activation (T, N) of e - c, evenly spaced; position (N, 2) m."""
    window = np.hanning(len(activation))[:, None]
    spectrum = np.fft.rfft((activation - activation.mean(axis=0)) * window, axis=0)[_LEAST_CYCLES:]
    beats = spectrum[np.argmax((np.abs(spectrum) ** 2).sum(axis=1))] * 2.0 / window.sum()  # (N,) complex amplitudes
    amplitude = np.abs(beats)
    whole = amplitude.sum()
    if not whole >= _LEAST_AMPLITUDE * len(beats):
        return Beat.STILL
    if whole**2 <= _PASSIVE_SHARE * len(beats) * (amplitude**2).sum():
        return Beat.PART
    if abs(beats.sum()) >= _TOGETHER * whole:
        return Beat.PULSE
    along, across = principal(position)[1].T
    waves = np.exp(-1j * np.outer(_WAVES, along))
    alike, against = (np.abs(waves @ (beats * side)).max() for side in (np.ones(len(beats)), np.sign(across)))
    return Beat.BEND if against > alike else Beat.WAVE


@dataclass(frozen=True, eq=False)
class Beating(Grown):
    """A body, and whose it is.  Attributes: as of `Grown`; genome; task."""

    genome: Genome
    task: Task

    @cached_property
    def beat(self) -> Beat:
        """How its muscles beat; STILL where nothing can live in it."""
        return beat_of(activation_of(self.genome, self.task), self.position) if self.status == Status.OK else Beat.STILL


class BeatingNursery(Nursery):
    """A nursery whose bodies tell their beat, when they are asked for it."""

    def new(self, genome: Genome) -> Beating:
        found = super().new(genome)
        return Beating(**{field.name: getattr(found, field.name) for field in fields(Grown)}, genome=genome, task=self.task)
