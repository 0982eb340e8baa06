#!/usr/bin/env python
"""Random bodies dropped, kicked and driven at random, on flat and rough ground and below ceilings: what breaks?

Every body is run by the very steps of a walker.  Told are: bodies whose physics stopped with a named cause after the finest
steps (that is allowed), and, among the others, any number that is none, any cell below ground or above the ceiling, any
energy from the ground, and any gain of energy that the ledger does not explain (none of these is allowed).

    python benchmarks/stress_walk.py [--count 20000]
"""

from __future__ import annotations

import argparse
import sys

import numba
import numpy as np
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from evodevo_sim.parameters import default_task
from evodevo_sim.physics.energy import stored_energy
from evodevo_sim.physics.forces import make_law, set_rest_lengths
from evodevo_sim.physics.integrators import euler, make_system, make_work
from evodevo_sim.physics.soundness import SOUND, check
from evodevo_sim.physics.step_size import choose_walk_steps
from evodevo_sim.physics.terrain import clearance, make_terrain
from evodevo_sim.worlds import PRESETS, scene_of
from tqdm import tqdm

from evodevo_sim import Scene

CONTROL_STEPS = 240
CAVE = {"ground": [[-30.0, 0.0], [-4.0, 0.0], [-3.9, 2.0], [-3.0, 0.2], [4.0, 1.0], [4.1, 0.0], [30.0, 0.0]],
        "ceiling": [[-30.0, 3.0], [-6.0, 3.2], [-5.9, 60.0], [6.0, 60.0], [6.1, 2.6], [30.0, 2.4]]}


@numba.njit(nogil=True, error_model="numpy")
def run(system, work, control_steps, control_step, position, velocity, driven, gain, pace, seed):
    """Returns: (outcome, control steps done, least room below and above, ledger, gain of stored energy, energy that came in)."""
    np.random.seed(seed)  # noqa: NPY002  (a Generator cannot be seeded in compiled code)
    body, p, v, ledger = system.body, position.copy(), velocity.copy(), np.zeros(4)
    steps = choose_walk_steps(system, control_step)
    h = control_step / steps
    muscle, target = np.zeros(p.shape[1]), np.zeros(p.shape[1])
    set_rest_lengths(body, system.law, muscle, system.rest)
    begin = np.array(stored_energy(body, system.law, system.rest, system.gravity, p, v)).sum()
    low, high, outcome, k = np.inf, np.inf, SOUND, 0
    scratch = work.scratch
    while k < control_steps and outcome == SOUND:
        then = p - 0.5 * h * v  # see `walk.live`
        before = stored_energy(body, system.law, system.rest, system.gravity, then, v)[1]
        for i in range(muscle.size):
            if np.random.random() < pace:  # noqa: NPY002  (see above)
                target[i] = gain * (2.0 * np.random.random() - 1.0)  # noqa: NPY002  (likewise)
            muscle[i] += 0.3 * (target[i] - muscle[i])
        if driven:
            set_rest_lengths(body, system.law, muscle, system.rest)
        ledger[0] += stored_energy(body, system.law, system.rest, system.gravity, then, v)[1] - before
        scratch.start_position[:], scratch.start_velocity[:] = p, v
        kept = ledger.copy()
        for doubling in range(4):
            if doubling:
                p[:], v[:], ledger[:] = scratch.start_position, scratch.start_velocity, kept
            count = steps << doubling
            for _ in range(count):
                euler(system, 0.0, control_step / count, p, v, work, ledger)
            outcome = check(body, p, v, control_step / count)
            if outcome == SOUND:
                break
        below, above = clearance(system.terrain, system.body.outline, p[0], p[1])
        low, high, k = min(low, below), min(high, above), k + 1
    end = np.array(stored_energy(body, system.law, system.rest, system.gravity, p, v)).sum()
    return outcome, k, low, high, ledger, end - begin, begin + max(ledger[0], 0.0)


def random_body(rng):
    """Cells at least 0.6 m apart, as growth leaves them; of each step of growth a body of 2 to 40."""
    cells = int(rng.integers(2, 41))
    side, position = 1.0 + np.sqrt(cells), np.empty((0, 2))
    while len(position) < cells:
        point = rng.uniform(-side / 2, side / 2, 2)
        if not len(position) or np.linalg.norm(position - point, axis=1).min() > 0.6:
            position = np.vstack((position, point))
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(cells + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), cells, start, neighbour)
    return build_body(position, edges, start, neighbour, 1.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000, help="bodies (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    task = default_task("walk")
    law = make_law(task.material.arguments(), task.scene.arguments())
    worlds = [make_terrain(Scene(**scene_of(document))) for document in ({}, CAVE, *(PRESETS[n] for n in ("rough", "steps", "slope")))]
    stopped, broken, worst_gap, deepest, worst_ground = {}, [], 0.0, np.inf, -np.inf
    for k in tqdm(range(options.count), mininterval=5.0):
        rng = np.random.default_rng((options.seed, k))
        body, terrain = random_body(rng), worlds[k % len(worlds)]
        gravity, friction = rng.choice([2.0, 5.0, 10.0]), rng.choice([0.0, 0.3, 0.8, 2.0])
        system = make_system(body, law, gravity, friction, True, terrain=terrain)
        position = np.ascontiguousarray(body.position.T)
        position[1] += rng.uniform(0.0, 4.0) - clearance(terrain, body.outline, position[0], position[1])[0]
        velocity = rng.normal(0.0, 1.5, position.shape) + rng.normal(0.0, 5.0, (2, 1))
        outcome, _done, low, high, ledger, gain, came = run(
            system, make_work(body), CONTROL_STEPS, task.control_step, position, velocity, k % 3 > 0, rng.uniform(0.2, 1.0), 0.1, k
        )
        if outcome != SOUND:
            stopped[int(outcome)] = stopped.get(int(outcome), 0) + 1
            continue
        gap = (gain - ledger.sum()) / came  # energy from nothing is positive
        worst_gap, deepest, worst_ground = max(worst_gap, gap), min(deepest, low, high), max(worst_ground, ledger[3] / came)
        if not (np.isfinite(gain) and low > -1e-7 and high > -1e-7 and ledger[3] <= 1e-3 * came and gap < 0.05):
            broken.append((k, low, high, ledger[3], gap))
    print(
        f"{options.count} bodies: {sum(stopped.values())} stopped with a cause "
        f"(unstable {stopped.get(1, 0)}, inverted {stopped.get(2, 0)}); "
        f"{len(broken)} broke a law"
    )
    print(
        f"deepest {deepest:.2e} m, most work by the ground {worst_ground:.2e} of what came in, "
        f"most unexplained gain {worst_gap:.2%} of what came in"
    )
    for row in broken[:20]:
        print("body {}: room below {:.2e}, above {:.2e}, ground {:.2e} J, unexplained {:.2%}".format(*row))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
