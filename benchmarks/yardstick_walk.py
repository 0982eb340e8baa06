#!/usr/bin/env python
"""How far a hand-made walker gets: the best of a sweep of travelling waves of muscle on lattice bodies, with and without legs.

The same world, time, material and rest on the ground before the start as an evolved walker.  The muscle e - c of the cell at
(x, y) is amplitude * g * cos(2 pi (t / period - x / wavelength)), with g = 1 (along: waves of thickness) or g = y / y_max
(bending: antisymmetric about the long axis).

    python benchmarks/yardstick_walk.py
    python benchmarks/yardstick_walk.py --set scene.gravity=5 --set scene.friction=0.5
"""

from __future__ import annotations

import argparse
import itertools
import os
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.physics.forces import make_law, set_rest_lengths
from evodevo_sim.physics.integrators import euler, make_system, make_work
from evodevo_sim.physics.mass import centre_of_mass
from evodevo_sim.physics.soundness import SOUND, check
from evodevo_sim.physics.step_size import choose_walk_steps
from evodevo_sim.physics.terrain import make_terrain
from evodevo_sim.ros.command_line import pairs
from tqdm import tqdm

PERIODS = (15, 20, 30, 40, 50, 60, 80, 100, 140, 200)  # control steps
WAVELENGTHS = (3.0, 4.0, 6.0, 8.0, 12.0, 20.0, np.inf)  # m
KINDS = ("along", "bending")
SETTLING = 600  # control steps


def shapes() -> dict[str, list[tuple[int, int]]]:
    """(column, row) of the cells of every body; 30 to 32 of them."""
    def block(columns, rows):
        return [(c, r) for r in rows for c in columns]

    return {
        "10 x 3": block(range(10), range(3)), "8 x 4": block(range(8), range(4)), "6 x 5": block(range(6), range(5)),
        "15 x 2": block(range(15), range(2)), "two legs": block(range(8), (2, 3)) + block((0, 1, 6, 7), range(2)) + block(range(8), (4,)),
        "three legs": block(range(10), (2, 3)) + block((0, 1, 4, 5, 8, 9), range(2)),
    }


def lattice(cells, mass: float):
    """The body of a triangular lattice of spacing 1, its lowest row at y = 0."""
    position = np.array([(c + 0.5 * (r % 2), r * np.sqrt(0.75)) for c, r in cells])
    position[:, 0] -= position[:, 0].mean()
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


@numba.njit(nogil=True, error_model="numpy")
def ride(system, work, steps, settling, control_step, gain, phase, period):
    """Walk with muscle gain * cos(2 pi step / period - phase), after some rest with the muscles of step 0.

    Returns: x of the centre of mass at the start, at the half and at the end; NaN if unsound.
    """
    body, cells = system.body, gain.size
    position, velocity, nothing = body.position.T.copy(), np.zeros((2, cells)), np.empty(0)
    muscle, rest = gain * np.cos(phase), system.rest
    set_rest_lengths(body, system.law, muscle, rest)
    substeps = choose_walk_steps(system, control_step)
    h = control_step / substeps
    x = np.full(3, np.nan)
    for step in range(-settling, steps):
        if step == 0 or step == steps // 2:
            x[0 if step == 0 else 1] = centre_of_mass(position, body.inverse_mass)[0]
        if step >= 0:
            for i in range(cells):
                muscle[i] = gain[i] * np.cos(2.0 * np.pi * (step + 1) / period - phase[i])
            set_rest_lengths(body, system.law, muscle, rest)
        else:
            velocity *= 1.0 - 2.0 * control_step
        for _ in range(substeps):
            euler(system, 0.0, h, position, velocity, work, nothing)
        if check(body, position, velocity, h) != SOUND:
            return np.full(3, np.nan)
    x[2] = centre_of_mass(position, body.inverse_mass)[0]
    return x


def wave(body, kind: str, wavelength: float, amplitude: float):
    """Gain and phase of every cell."""
    x, y = body.position.T
    y = y - y.mean()
    gain = amplitude * (np.ones(len(x)) if kind == "along" else y / np.abs(y).max())
    return gain, 2.0 * np.pi * x / wavelength


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--amplitude", type=float, default=0.8, help="of e - c (default %(default)s)")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="threads (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, e.g. scene.gravity=5")
    options = parser.parse_args()
    task = with_settings(default_task("walk"), pairs(options.set))
    scene, law = task.scene, make_law(task.material.arguments(), task.scene.arguments())

    def run(case):
        shape, kind, wavelength, period = case
        body = lattice(shapes()[shape], task.material.mass)
        system = make_system(body, law, scene.gravity, scene.friction, True, terrain=make_terrain(scene))
        gain, phase = wave(body, kind, wavelength, options.amplitude)
        return ride(system, make_work(body), task.control_steps, SETTLING, task.control_step, gain, phase, period)

    cases = list(itertools.product(shapes(), KINDS, WAVELENGTHS, PERIODS))
    with ThreadPoolExecutor(options.workers) as pool:
        found = dict(zip(cases, tqdm(pool.map(run, cases), total=len(cases), leave=False)))
    print(f"Gravity {scene.gravity:g} m/s^2, friction {scene.friction:g}. Best wave of every body:")
    for shape in shapes():
        of_shape = {case: x for case, x in found.items() if case[0] == shape}
        failed = sum(np.isnan(x[2]) for x in of_shape.values())
        (_, kind, wavelength, period), x = max(of_shape.items(), key=lambda item: np.nan_to_num(abs(item[1][2] - item[1][0])))
        second = (x[2] - x[1]) * np.sign(x[2] - x[0])
        print(
            f"{shape:>10} ({len(shapes()[shape])} cells): {abs(x[2] - x[0]):6.2f} m, {second:6.2f} m in the second half; {kind}, "
            f"wavelength {wavelength:g} m, period {period} control steps; {failed} of {len(of_shape)} waves unsound"
        )


if __name__ == "__main__":
    main()
