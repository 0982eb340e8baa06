"""What a simulation makes of the commands that a body was told."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..brain.scent import make_signals
from ..hardware.chain import ActuatorChain
from ..hardware.rig import Actuators
from ..parameters import Material, Noise, Scene, Task
from ..plant.contract import Outcome
from ..plant.muscles import actuators_of
from ..plant.simulated import SwimmingBody, make_body_state
from .observation import Observation

LISTEN = 1.0  # s, but no more than a quarter of a motion
_DRAWN = 0.1  # share of the way to where a cell is seen, in a control step
_NO_HALT = np.zeros(1, np.int64)
_IDEAL = actuators_of(Task())  # the chain before it has all that actuators do


@dataclass(frozen=True)
class Model:
    """A body as it is simulated.  delay: s, from where a body is to where it is seen to be; control_step: s."""

    material: Material = field(default_factory=Material)
    scene: Scene = field(default_factory=Scene)
    actuators: Actuators = field(default_factory=Actuators)
    delay: float = 0.0
    control_step: float = 1.0 / 60.0

    def with_numbers(self, numbers: dict[str, float]) -> Model:
        """The same with others of the numbers of material, scene and actuators, by their names."""
        given: dict[str, Any] = dict(numbers)
        for name in ("material", "scene", "actuators"):
            part: Any = getattr(self, name)
            given[name] = replace(part, **{key: given.pop(key) for key in list(given) if hasattr(part, key)})
        return replace(self, **given)

    def number(self, name: str) -> float:
        """One of them."""
        return next(getattr(part, name) for part in (self.material, self.scene, self.actuators, self) if hasattr(part, name))


PLAIN = Model()


def predicted(observation: Observation, model: Model) -> np.ndarray | None:
    """Where the cells (T, N, 2) m are at the times of an observation, by simulation with the commands that it was told; NaN in the first
    `LISTEN` s, in which the simulation is drawn to what was seen, so that it knows how fast everything moves; None where the physics
    cannot be carried on."""
    h, time = model.control_step, observation.time - observation.time[0]
    step = np.rint(time / h).astype(int)
    count = int(step[-1])
    told = observation.activation[np.minimum(np.searchsorted(step, np.arange(1, count + 1)), len(step) - 1)]
    body = observation.body._replace(inverse_mass=np.full(observation.cells, 1.0 / model.material.mass))
    state = make_body_state(body, model.material.arguments(), model.scene.arguments(), h, 1.0, True, _NO_HALT, _IDEAL)
    if state.substeps == 0:
        return None
    state.position[...] = observation.begin().T
    plant = SwimmingBody(state, make_signals(noise=Noise().arguments(), seed=0))
    chain = ActuatorChain(model.actuators, observation.cells, h)
    chain.hold(observation.activation[0])
    track = np.empty((count + 1, observation.cells, 2))
    track[0] = plant.position
    listened = min(LISTEN, 0.25 * time[-1])
    row_of = dict(zip((step - round(model.delay / h)).tolist(), range(len(step))))
    for k in range(count):
        if plant.move(chain.step(told[k]), h) != Outcome.SOUND:
            return None
        if (k + 1) * h <= listened and k + 1 in row_of:
            seen = observation.position[row_of[k + 1]].T
            state.position[...] += np.where(np.isfinite(seen), _DRAWN * (seen - state.position), 0.0)
        track[k + 1] = plant.position
    found = _at(track, np.maximum(time - model.delay, 0.0) / h)
    found[time <= listened + model.delay] = np.nan
    return found


def _at(track: np.ndarray, step: np.ndarray) -> np.ndarray:
    """A track (K, N, 2) of control steps at steps (T,) that need not be whole."""
    first = np.minimum(np.floor(step).astype(int), len(track) - 1)
    after = np.minimum(first + 1, len(track) - 1)
    part = (step - first)[:, None, None]
    return (1.0 - part) * track[first] + part * track[after]
