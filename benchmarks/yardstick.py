#!/usr/bin/env python
"""How far a hand-made swimmer gets: the best of a sweep of travelling waves of muscle on a 10 x 3 lattice body.

The same world, time, material and start from rest as an evolved swimmer.  The muscle e - c of the cell at (x, y) is
amplitude * g * cos(2 pi (t / period - x / wavelength)), with g = 1 (along: waves of thickness) or g = y / y_max (bending:
antisymmetric about the long axis).

    python benchmarks/yardstick.py
    python benchmarks/yardstick.py --set scene.drag_normal=10 --set scene.drag_tangential=0.05
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
from evodevo_sim.parameters import with_settings
from evodevo_sim.physics.control_step import advance, relax
from evodevo_sim.physics.forces import Ramp, make_law, make_scratch, set_rest_lengths
from evodevo_sim.physics.mass import centre_of_mass
from evodevo_sim.physics.soundness import SOUND
from evodevo_sim.physics.step_size import choose_substeps, substeps_in_drag
from evodevo_sim.plant.simulated import RELAX_LIMIT, RELAX_TOLERANCE
from evodevo_sim.ros.command_line import pairs
from tqdm import tqdm

from evodevo_sim import Task

PERIODS = (10, 15, 20, 30, 40, 50, 60, 80, 100, 130, 170, 220, 300, 400)  # control steps
WAVELENGTHS = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, np.inf)  # m
KINDS = ("along", "bending")


def lattice(columns: int, rows: int, mass: float):
    """The body of a triangular lattice of spacing 1, its middle at the origin."""
    position = np.array([(c + 0.5 * (r % 2), r * np.sqrt(0.75)) for r in range(rows) for c in range(columns)])
    position -= position.mean(axis=0)
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


@numba.njit(nogil=True, error_model="numpy")
def ride(body, material, scene, steps, control_step, gain, phase, period):
    """Swim with muscle gain * cos(2 pi step / period - phase).  Returns: distance in all and in the second half, NaN if unsound."""
    law = make_law(material, scene)
    cells = gain.size
    position, velocity, scratch = body.position.T.copy(), np.zeros((2, cells)), make_scratch(body)
    muscle, rest = gain * np.cos(phase), np.empty(body.rest_length.size)
    set_rest_lengths(body, law, muscle, rest)
    relax(body, law, rest, position, velocity, RELAX_TOLERANCE, RELAX_LIMIT, scratch)
    substeps, before = choose_substeps(body, law, control_step), rest.copy()
    x0, y0 = centre_of_mass(position, body.inverse_mass)
    xh, yh = x0, y0
    for step in range(steps):
        if step == steps // 2:
            xh, yh = centre_of_mass(position, body.inverse_mass)
        for i in range(cells):
            muscle[i] = gain[i] * np.cos(2.0 * np.pi * (step + 1) / period - phase[i])
        before[:] = rest
        set_rest_lengths(body, law, muscle, rest)
        many = substeps_in_drag(body, law, position, velocity, control_step, substeps, scratch)
        if advance(body, law, Ramp(before, rest, 0.0), position, velocity, control_step, many, scratch) != SOUND:
            return np.nan, np.nan
    x, y = centre_of_mass(position, body.inverse_mass)
    return np.hypot(x - x0, y - y0), np.hypot(x - xh, y - yh)


def wave(body, kind: str, wavelength: float, amplitude: float):
    """Gain and phase of every cell."""
    x, y = body.position.T
    gain = amplitude * (np.ones(len(x)) if kind == "along" else y / y.max())
    return gain, 2.0 * np.pi * x / wavelength


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--columns", type=int, default=10)
    parser.add_argument("--rows", type=int, default=3)
    parser.add_argument("--amplitude", type=float, default=0.8, help="of e - c (default %(default)s)")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="threads (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="of the task, e.g. scene.drag_normal=10")
    options = parser.parse_args()
    task = with_settings(Task(), pairs(options.set))
    body = lattice(options.columns, options.rows, task.material.mass)

    def run(case):
        kind, wavelength, period = case
        gain, phase = wave(body, kind, wavelength, options.amplitude)
        return ride(body, task.material.arguments(), task.scene.arguments(), task.control_steps, task.control_step, gain, phase, period)

    cases = list(itertools.product(KINDS, WAVELENGTHS, PERIODS))
    with ThreadPoolExecutor(options.workers) as pool:
        found = dict(zip(cases, tqdm(pool.map(run, cases), total=len(cases), leave=False)))
    print("Metres in all, by period in control steps (across) and wavelength in m (down); - where the physics failed")
    for kind in KINDS:
        print(kind.rjust(8) + "".join(f"{period:7d}" for period in PERIODS))
        for wavelength in WAVELENGTHS:
            distances = [found[kind, wavelength, period][0] for period in PERIODS]
            print(f"{wavelength:8g}" + "".join("      -" if np.isnan(d) else f"{d:7.2f}" for d in distances))
    (kind, wavelength, period), (distance, half) = max(found.items(), key=lambda item: np.nan_to_num(item[1][0]))
    print(
        f"Best: {kind}, wavelength {wavelength:g} m, period {period} control steps ({period * task.control_step:.2f} s): "
        f"{distance:.2f} m in all, {half:.2f} m in the second half"
    )


if __name__ == "__main__":
    main()
