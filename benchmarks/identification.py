"""Numbers of an emulated body, fitted to recordings of some bodies and tried on others of the same stuff.

    python benchmarks/identification.py [--bodies N] [--others N] [--seconds S] [--noise M] [--seed N]

Bodies are grown from random genomes of several sizes and told smooth commands at random; actuators have a lag, and the stuff is not that
which the fit begins with.  Prints what was found beside the truth, and how far the simulation is from the other bodies.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
from evodevo_sim.development.shape import principal
from evodevo_sim.hardware.calibration import calibration_of
from evodevo_sim.hardware.emulator import EmulatedBody
from evodevo_sim.hardware.rig import Actuators, Rig, Sensors
from evodevo_sim.identification import Observation, fit, predicted, tracking
from evodevo_sim.identification.fitting import USUAL
from evodevo_sim.identification.prediction import Model
from evodevo_sim.live.animat import Animat, NotViable
from evodevo_sim.parameters import Task, default_task, with_settings

from evodevo_sim import Genome, random_genome

TRUTH = {"stiffness": 310.0, "damping": 14.0, "drag_normal": 55.0, "drag_tangential": 0.3, "lag": 0.12}
LEAST_CELLS = 6


@dataclass(frozen=True, eq=False)
class Body:
    """genome; task: in which it grows, with the stuff of the truth."""

    genome: Genome
    task: Task


def task_of(cells: int) -> Task:
    """The task of the truth, of bodies of up to so many cells."""
    stuff = {f"{'scene' if name.startswith('drag') else 'material'}.{name}": TRUTH[name] for name in TRUTH if name != "lag"}
    return with_settings(default_task("swim"), {"development.max_cells": cells, **stuff})


def bodies(count: int, seed: int) -> list[Body]:
    """Bodies of 6 to 32 cells that grow from random genomes."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        body = Body(random_genome(rng, 20), task_of(int(rng.integers(8, 33))))
        try:
            cells = len(Animat(body.genome, body.task).position)
        except NotViable:
            continue
        if cells >= LEAST_CELLS:
            found.append(body)
    return found


def commands(cells: int, steps: int, step: float, rng: np.random.Generator) -> np.ndarray:
    """(steps, cells): each cell a sum of three sines of 0.2 to 2 Hz, in all within [-1, 1]."""
    when = step * np.arange(steps)[:, None, None]
    frequency, phase = rng.uniform(0.2, 2.0, (1, cells, 3)), rng.uniform(0.0, 2.0 * np.pi, (1, cells, 3))
    return np.clip(0.5 * np.sin(2.0 * np.pi * frequency * when + phase).sum(axis=2), -1.0, 1.0)


def observed(body: Body, seconds: float, noise: float, seed: int, lost: float = 0.0) -> Observation:
    """What a camera sees of the emulated body, and what its muscles are told, from rest on."""
    rng, task = np.random.default_rng((seed, 7)), body.task
    animat = Animat(body.genome, task)
    calibration = calibration_of(animat.body.position)
    rig = Rig(Actuators(lag=TRUTH["lag"]), Sensors(noise=noise, lost=lost), seed=seed)
    emulated = EmulatedBody(animat.plant, calibration, rig, task.control_step)
    steps = round(seconds / task.control_step)
    told = commands(calibration.cells, steps, task.control_step, rng)
    for _ in range(120):  # to rest, with the first command
        emulated.move(calibration.by_channel(calibration.levels_of(told[0])))
    position, activation = [calibration.seen(emulated.markers())], [told[0]]
    for asked in told:
        emulated.move(calibration.by_channel(calibration.levels_of(asked)))
        position.append(calibration.seen(emulated.markers()))
        activation.append(asked)
    when = task.control_step * np.arange(steps + 1)
    return Observation(f"body {seed}", animat.body, when, np.array(position), np.array(activation))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=5, help="that are fitted to (default %(default)s)")
    parser.add_argument("--others", type=int, default=20, help="that are predicted (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="of each (default %(default)s)")
    parser.add_argument("--noise", type=float, default=0.01, help="m, of markers, in the second fit (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of bodies and commands (default %(default)s)")
    given = parser.parse_args()
    found = bodies(given.bodies + given.others, given.seed)
    clean = [observed(body, given.seconds, 0.0, k) for k, body in enumerate(found)]
    for noise in (0.0, given.noise):
        began = time.perf_counter()
        seen = [observed(body, given.seconds, noise, k) for k, body in enumerate(found[: given.bodies])]
        result = fit(seen, Model(), USUAL)
        took = time.perf_counter() - began
        print(f"fitted to {given.bodies} bodies of {min(one.cells for one in seen)} to {max(one.cells for one in seen)} cells, "
              f"{given.seconds:g} s each, noise {noise:g} m: {result.simulations} simulations, {took:.0f} s, rms {result.rms:.4f} m")
        for name, value in result.numbers.items():
            print(f"  {name:16} {value:9.4f}  truth {TRUTH[name]:9.4f}  off by {100 * (value / TRUTH[name] - 1):+.2f} %  "
                  f"(says +- {100 * result.spread[name] / (value if name in ('lag', 'delay') else 1):.2f} %)")
        off = []
        for one in clean[given.bodies :]:
            track = predicted(one, result.model)
            assert track is not None
            off.append(tracking(one.time, one.position, track, one.length).relative)
        print(f"  {len(off)} other bodies over {given.seconds:g} s: rms of all cells, share of a body's length: median "
              f"{100 * np.median(off):.3f} %, most {100 * max(off):.3f} %")
    first = [tracking(one.time, one.position, track, one.length).relative for one in clean[given.bodies :]
             if (track := predicted(one, Model())) is not None]
    longest = [np.ptp(principal(one.body.position)[1][:, 0]) for one in clean]
    print(f"before any fit: median {100 * np.median(first):.3f} %, most {100 * max(first):.3f} %; bodies of {min(longest):.1f} to "
          f"{max(longest):.1f} m")


if __name__ == "__main__":
    main()
