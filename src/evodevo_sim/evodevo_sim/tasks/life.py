"""What every task's animats share: growth, birth, and what is kept of a life.

An animat is born at rest in the shape that its own network holds, so that neither the first jump of the rest lengths nor one
fold of a tail carries it (docs/reference/model.md).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..brain.brain import Brain, make_brain
from ..development.body import build_body
from ..development.growth import grow
from ..genetics.regulation import express, prune
from ..kernels.jit import kernel, lean
from ..plant.muscles import Actuators
from ..plant.simulated import BodyState, come_to_shape, make_body_state
from .ends import NO_CHAMBER, NO_GROWTH, OK, UNSTABLE

if TYPE_CHECKING:
    from ..parameters import DevelopmentArguments, MaterialArguments, SceneArguments, TaskArguments


class Model(NamedTuple):
    """The numbers of a task, as kernels take them."""

    task: TaskArguments
    development: DevelopmentArguments
    continual: bool  # variant B, whose graph is kept up to date while the embryo grows
    material: MaterialArguments
    scene: SceneArguments
    given_inputs: np.ndarray  # (inputs,) bool: which input signals the scene has
    bar: float  # fitness below which a life is worth nothing: it stops where it cannot reach that any more; -inf: it never does
    halt: np.ndarray  # see `plant.simulated.BodyState`
    actuators: Actuators


class Life(NamedTuple):
    """A living animat."""

    brain: Brain
    state: BodyState


class Kept(NamedTuple):
    """What is kept of a life, each empty where nobody looks."""

    activation_range: np.ndarray  # (2, N): least and most activation so far
    track: np.ndarray  # (control_steps + 1, most cells, 4): x, y, vx, vy of every cell
    activations: np.ndarray  # (control_steps + 1, most cells): activation


@kernel
def develop(genome, model, history, activations, graphs):
    """Grow a genome's embryo.  Returns: (weights, units, Embryo); see `regulation.express` and `growth.grow`."""
    weights, units = express(*genome)
    network = prune(weights, units, (True, True, True, True), model.given_inputs, model.development.max_cells)
    return weights, units, grow(network, model.development, model.continual, history, activations, graphs, model.halt)


@kernel
def birth(genome, model, finer):
    """Grow a genome and bring its body to rest with the muscles where its network holds them, as far as actuators can.

    Args: genome: (kind, sign, x, y); finer: times as many substeps as are chosen, rounded up; 1 but for an audit.

    Returns: (OK, NO_GROWTH, NO_CHAMBER, or UNSTABLE where it needs more than MOST_SUBSTEPS; Life, which moves only if OK).
    """
    weights, units, embryo = develop(genome, model, np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64))
    cells = embryo.position.shape[0]
    body = build_body(embryo.position, embryo.edges, embryo.start, embryo.neighbour, model.material.mass)
    status = OK
    if cells < 2:
        status = NO_GROWTH
    elif body.triangle_area.size + body.polygon_area.size == 0:
        status = NO_CHAMBER
    brain = make_brain(weights, units, embryo, model.given_inputs, model.continual)
    state = make_body_state(
        body, model.material, model.scene, model.task.control_step, finer, status == OK, model.halt, model.actuators
    )
    if status == OK and state.substeps == 0:
        status = UNSTABLE
    if status == OK:
        come_to_shape(state, brain.activation)
    return status, Life(brain, state)


@lean
def keep(life, track, activations):
    """Keep a moment of a life.  Args: track (most cells, 4), activations (most cells,)."""
    position, velocity, activation = life.state.position, life.state.velocity, life.brain.activation
    for i in range(activation.size):
        track[i, 0], track[i, 1] = position[0, i], position[1, i]
        track[i, 2], track[i, 3] = velocity[0, i], velocity[1, i]
        activations[i] = activation[i]


@lean
def forget(range_of_muscle):
    """Make a range (2, N) of least and most e - c empty."""
    for i in range(range_of_muscle.shape[1]):
        range_of_muscle[0, i], range_of_muscle[1, i] = np.inf, -np.inf


@lean
def widen(range_of_muscle, muscle):
    """Let a range of least and most e - c hold what muscles (N,) do now."""
    least, most = range_of_muscle[0], range_of_muscle[1]
    for i in range(muscle.size):
        least[i] = muscle[i] if muscle[i] < least[i] else least[i]
        most[i] = muscle[i] if muscle[i] > most[i] else most[i]


@lean
def activity(range_of_muscle, full_activity):
    """(mean amplitude over the cells, number of cells that work, those of less than full activity in part) of a range."""
    total, working, cells = 0.0, 0.0, range_of_muscle.shape[1]
    for i in range(cells):
        a = 0.5 * (range_of_muscle[1, i] - range_of_muscle[0, i])
        total += a
        working += min(1.0, a / full_activity)
    return total / cells, working
