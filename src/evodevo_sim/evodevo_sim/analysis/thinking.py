"""What the networks of cells did in a recorded life: the same brain, led along the recorded places, thinks the same once more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..genetics.elements import INPUT_NAMES, MORPHOGEN, OUTPUT_NAMES, OUTPUTS, TRANSCRIPTION_FACTOR
from ..genetics.genome import Genome
from ..genetics.regulation import assign_units, express
from ..parameters import ParameterError, Task
from ..tasks.swim.fitness import given_inputs

INPUT, OUTPUT, OWN, SENT = "input", "output", "transcription factor", "morphogen"  # what a node is, or makes


@dataclass(frozen=True)
class Node:
    """name; role: INPUT, OUTPUT, or what a unit makes; row: of concentrations."""

    name: str
    role: str
    row: int


@dataclass(frozen=True)
class Edge:
    """From node to node, by their numbers; weight: above 0 it drives, below it holds back."""

    source: int
    target: int
    weight: float


@dataclass(frozen=True, eq=False)
class Thoughts:
    """nodes and edges of the network that locomotion needs; concentration (T, nodes, K): of K cells at each state; error: the most by
    which the activation that was recorded differs from what the network did here."""

    nodes: list[Node]
    edges: list[Edge]
    concentration: np.ndarray
    error: float


def network_of(genome: Genome, needed: Sequence[int], given_inputs: np.ndarray) -> tuple[list[Node], list[Edge]]:
    """The nodes and edges of a network.

    Args: needed: rows of the units and outputs that are integrated; given_inputs (INPUTS,) bool: input signals that the scene has.
    """
    weights, units = express(*genome.arrays())
    unit, _ = assign_units(genome.kind)
    sent = {int(unit[k]) for k in np.flatnonzero(genome.kind == MORPHOGEN) if unit[k] >= 0}
    own = {int(unit[k]) for k in np.flatnonzero(genome.kind == TRANSCRIPTION_FACTOR) if unit[k] >= 0}
    joined: dict[tuple[int, int], float] = {}
    for row in map(int, needed):
        for source in np.flatnonzero(weights[row]):
            if source >= 2 * units and not given_inputs[source - 2 * units]:
                continue
            origin = int(source % units) if source < 2 * units else units + OUTPUTS + int(source) - 2 * units
            joined[origin, row] = joined.get((origin, row), 0.0) + float(weights[row, source])
    rows = sorted({*map(int, needed), *(origin for origin, _ in joined)})
    nodes = []
    for row in rows:
        if row < units:
            nodes.append(Node(f"u{row}", SENT if row in sent and row not in own else OWN, row))
        elif row < units + OUTPUTS:
            nodes.append(Node(OUTPUT_NAMES[row - units], OUTPUT, row))
        else:
            nodes.append(Node(INPUT_NAMES[row - units - OUTPUTS], INPUT, units + OUTPUTS + units + row - units - OUTPUTS))
    number = {row: k for k, row in enumerate(rows)}
    edges = [Edge(number[origin], number[row], weight) for (origin, row), weight in joined.items()]
    return nodes, sorted(edges, key=lambda edge: -abs(edge.weight))


def thoughts_of_life(
    genome: Genome, task: Task, seed: int, position: np.ndarray, activation: np.ndarray, target: np.ndarray, cells: Sequence[int]
) -> Thoughts:
    """Let the brain of a genome live a recorded life again.

    Args: position (T, N, 2) m, activation (T, N): as recorded, from birth on; target (T, 2) m, NaN while there is none, or (0, 2);
        cells: of which concentrations are kept.  Raises ParameterError where the genome grows another number of cells.
    """
    _, brain, _ = task.kind.function("begin")(genome, task, seed)
    if len(brain.activation) != position.shape[1]:
        raise ParameterError(f"the genome grows {len(brain.activation)} cells here, and {position.shape[1]} are recorded")
    nodes, edges = network_of(genome, brain.brain.network.nodes, given_inputs(task))
    rows, picked = np.array([node.row for node in nodes]), np.asarray(cells)
    kept = np.empty((len(position), len(nodes), len(picked)), np.float32)
    error = float(np.abs(brain.activation - activation[0]).max())
    kept[0] = brain.brain.table[rows[:, None], picked]
    for step in range(1, len(position)):
        aim = target[step - 1] if len(target) else None
        known = aim is not None and bool(np.isfinite(aim).all())
        told = brain.step(position[step - 1], (float(aim[0]), float(aim[1])) if known and aim is not None else None)
        error = max(error, float(np.abs(told - activation[step]).max()))
        kept[step] = brain.brain.table[rows[:, None], picked]
    return Thoughts(nodes, edges, kept, error)
