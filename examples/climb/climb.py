"""A task of your own: climb steps.  Fitness is the height that the centre of mass gains.  docs/guide/task.md tells what each part is for.

    PYTHONPATH=examples/climb EVODEVO_TASKS=climb ros2 run evodevo_ga evolve --task climb --generations 20
    python examples/climb/climb.py          # the same question to two walkers, without ROS
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from evodevo_sim.task_kinds import kind_of, register
from evodevo_sim.tasks.walk.fitness import headings, kernel_arguments, noise, score
from evodevo_sim.tasks.walk.kernel import walk

from evodevo_sim import Evaluation, Genome, Task

RISE, RUN, LEVEL, STEPS = 0.4, 3.0, 4.0, 12  # m of each step; m of level ground to either side of the start; steps to either side


def run(genome: Genome, task: Task, seed: int, finer: float, track: np.ndarray, activations: np.ndarray) -> Evaluation:
    """Evaluate a climber.  Args: as for every task; track and activations are filled where they are given, and may be empty."""
    cells = task.development.max_cells
    if not track.size:  # the walking kernel keeps only x of the centre: the height comes from the cells
        track, activations = np.empty((task.control_steps + 1, cells, 4)), np.empty((task.control_steps + 1, cells))
    unkept = np.zeros((task.starts, 0))
    result = walk(*kernel_arguments(genome, task), headings(seed, task.starts), finer, noise(task, seed), (track, activations), unkept)
    evaluation = score(result, task)
    if evaluation.cause:
        return evaluation
    height = track[:, : result.cells, 1].mean(axis=1)
    earned = float(result.active[0]) * (max(0.0, float(height[-1] - height[0])) + task.activity_bonus)
    return dataclasses.replace(evaluation, fitness=earned)


def steps() -> dict[str, object]:
    """The scene: steps that rise to both sides."""
    edges = LEVEL + RUN * np.arange(STEPS)
    x = np.column_stack((edges, edges + 0.05)).ravel()
    y = np.column_stack((np.arange(STEPS), np.arange(1, STEPS + 1))).ravel() * RISE
    return {"scene.ground_x": (*-x[::-1], *x), "scene.ground_y": (*y[::-1], *y)}


WALK = kind_of("walk")
register(dataclasses.replace(
    WALK, name="climb", what="gain height on steps", run=run, audit=None, defaults={**WALK.defaults, "starts": 1, **steps()},
))

if __name__ == "__main__":
    from evodevo_sim.parameters import default_task

    from evodevo_sim import evaluate, load_genome

    champions = Path(__file__).resolve().parents[2] / "src" / "evodevo_sim" / "champions"
    for name in ("walker", "jumper"):
        evaluation = evaluate(load_genome(champions / f"{name}.yaml"), default_task("climb"))
        print(f"{name}: {evaluation.status.name}, fitness {evaluation.fitness:.2f} m")
