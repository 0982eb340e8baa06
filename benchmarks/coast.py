#!/usr/bin/env python
"""Does a champion swim or glide?  Its second half, against how far it coasts when its muscles freeze at the half.

Also the period of its muscles and how much of the swim each eighth of the run holds.

    python benchmarks/coast.py bags/long/champion.yaml
"""

from __future__ import annotations

import argparse

import numpy as np
from evodevo_sim.parameters import Task
from evodevo_sim.physics.control_step import advance
from evodevo_sim.physics.forces import Ramp, make_law, make_scratch, set_rest_lengths
from evodevo_sim.physics.soundness import SOUND
from evodevo_sim.physics.step_size import choose_substeps, substeps_in_drag
from evodevo_sim.ros.command_line import pairs

from evodevo_sim import perform, read_genome


def coast(performance, task: Task, step: int) -> float:
    """Distance in m from control step `step` to the end with the muscles held as they are at that step."""
    body, law = performance.body, make_law(task.material.arguments(), task.scene.arguments())
    position, velocity = performance.position[step].T.copy(), performance.velocity[step].T.copy()
    rest, scratch = np.empty(body.rest_length.size), make_scratch(body)
    set_rest_lengths(body, law, performance.activation[step].copy(), rest)
    start, substeps = position.mean(axis=1), choose_substeps(body, law, task.control_step)
    for _ in range(step, task.control_steps):
        many = substeps_in_drag(body, law, position, velocity, task.control_step, substeps, scratch)
        if advance(body, law, Ramp(rest, rest, 0.0), position, velocity, task.control_step, many, scratch) != SOUND:
            return np.nan
    return float(np.hypot(*(position.mean(axis=1) - start)))


def period(activation: np.ndarray) -> float:
    """Period in control steps that holds most of the power of e - c, all cells together."""
    power = (np.abs(np.fft.rfft(activation - activation.mean(axis=0), axis=0)) ** 2).sum(axis=1)
    return len(activation) / (1 + int(np.argmax(power[1:])))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("genomes", nargs="+", metavar="GENOME")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, e.g. scene.drag_normal=10")
    options = parser.parse_args()
    for name in options.genomes:
        file = read_genome(name)
        task = file.task(settings=pairs(options.set))
        half = task.control_steps // 2
        performance = perform(file.genome, task)
        m = performance.evaluation.metrics
        if not m.chambers:
            print(f"{name}: {performance.evaluation.cause}")
            continue
        centre = performance.position.mean(axis=1)
        eighths = np.hypot(*np.diff(centre[:: task.control_steps // 8], axis=0).T)
        long, short = np.linalg.svd(performance.body.position - performance.body.position.mean(axis=0), compute_uv=False)
        print(
            f"{name}: {m.distance:.2f} m, second half {m.distance_second_half:.2f} m, coasting from the half "
            f"{coast(performance, task, half):.2f} m; {m.cells} cells, {m.chambers} chambers, long to wide {long / short:.1f}; "
            f"amplitude {m.activation_amplitude:.2f}, period {period(performance.activation[half:]):.0f} control steps; "
            f"eighths {' '.join(f'{e:.2f}' for e in eighths)}"
        )


if __name__ == "__main__":
    main()
