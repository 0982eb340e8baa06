#!/usr/bin/env python
"""Other engines on the same work: 64 point masses, some 160 springs, gravity and ground, substeps a second on one core.

    python benchmarks/peers.py [--quick] [--out DIR]

Substeps are not equal work: `what` says what each does.  All must sink onto the ground alike: the mean height after 1 s is
given.  Engines that are not installed are skipped; none belongs to the project, and `make peers` installs them.
"""

from __future__ import annotations

import importlib.util
import time

import numpy as np
from common import Figure, body_of, main, scattered, write_csv
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.integrators import make_system, make_work
from evodevo_sim.physics.step_size import EULER
from kernels import travel
from tqdm import tqdm

PART = "peers"
STIFFNESS, DAMPING, GRAVITY, FRICTION, STEP, RADIUS = 400.0, 10.0, 9.81, 0.8, 1e-3, 0.05
INSTALL = "`make peers` installs it"


def make_body():
    """A slab just above the ground."""
    position = scattered(16, 4)
    return body_of(position - [0.0, position[:, 1].min() - 0.1])


class Ours:
    what = "symplectic Euler; springs, damping; exact contact and Coulomb friction by projection; one call for many substeps"
    pressure = 0.0

    def __init__(self, body):
        self.system = make_system(body, Law(STIFFNESS, DAMPING, self.pressure, 0.0, 0.0, 0.2), GRAVITY, FRICTION, True)
        self.position, self.work = body.position.T.copy(), make_work(body)
        self.velocity = np.zeros_like(self.position)

    def run(self, substeps):
        travel(self.system, EULER, float(substeps), STEP * substeps, 1, self.position, self.velocity, self.work)

    def height(self):
        return self.position[1].mean()


class OursWithChambers(Ours):
    what = "the same with pressure chambers in every face, which none of the others has"
    pressure = STIFFNESS


class MuJoCo:
    what = "Euler, damping implicit; springs as spatial tendons; spheres on a plane, by its solver; one call for many substeps"

    def __init__(self, body):
        import mujoco

        cells = "".join(
            f'<body name="b{i}" pos="{x!r} 0 {y + RADIUS!r}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
            f'<geom type="sphere" size="{RADIUS}" mass="1" contype="0" conaffinity="1"/><site name="s{i}"/></body>'
            for i, (x, y) in enumerate(body.position.tolist())
        )
        springs = "".join(
            f'<spatial stiffness="{STIFFNESS}" damping="{DAMPING}" springlength="{rest!r}">'
            f'<site site="s{a}"/><site site="s{b}"/></spatial>'
            for a, b, rest in zip(body.spring_a, body.spring_b, body.rest_length.tolist())
        )
        self.engine = mujoco
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{STEP}" gravity="0 0 -{GRAVITY}" integrator="Euler"/><worldbody>'
            f'<geom type="plane" size="100 100 1" friction="{FRICTION}" contype="1" conaffinity="0"/>{cells}</worldbody>'
            f"<tendon>{springs}</tendon></mujoco>"
        )
        self.data = mujoco.MjData(self.model)

    def run(self, substeps):
        self.engine.mj_step(self.model, self.data, substeps)

    def height(self):
        return self.data.xpos[1:, 2].mean() - RADIUS


class Pymunk:
    what = "symplectic Euler with impulses; DampedSpring constraints, 10 iterations; circles on a segment; one call a substep"

    def __init__(self, body):
        import pymunk

        self.space = pymunk.Space()
        self.space.gravity = 0, -GRAVITY
        ground = pymunk.Segment(self.space.static_body, (-1000, -RADIUS), (1000, -RADIUS), RADIUS)
        ground.friction = 1.0
        self.space.add(ground)
        self.bodies = []
        for x, y in body.position.tolist():
            cell = pymunk.Body(1.0, float("inf"))  # a point: it does not turn
            cell.position = x, y + RADIUS
            circle = pymunk.Circle(cell, RADIUS)
            circle.friction, circle.filter = FRICTION, pymunk.ShapeFilter(group=1)
            self.space.add(cell, circle)
            self.bodies.append(cell)
        for a, b, rest in zip(body.spring_a, body.spring_b, body.rest_length.tolist()):
            self.space.add(pymunk.DampedSpring(self.bodies[a], self.bodies[b], (0, 0), (0, 0), rest, STIFFNESS, DAMPING))

    def run(self, substeps):
        for _ in range(substeps):
            self.space.step(STEP)

    def height(self):
        return np.mean([cell.position.y for cell in self.bodies]) - RADIUS


class Taichi:
    what = "symplectic Euler by hand in one kernel, springs, damping, float64, one thread, ground as ours; one call for many"

    def __init__(self, body):
        import peers_taichi

        self.run, self.height = peers_taichi.make(body, STIFFNESS, DAMPING, GRAVITY, FRICTION, STEP)


ENGINES = {"evodevo": (Ours, None), "evodevo, chambers": (OursWithChambers, None), "MuJoCo": (MuJoCo, "mujoco"),
           "pymunk": (Pymunk, "pymunk"), "Taichi": (Taichi, "taichi")}


def run(effort, out):
    rounds, seconds = ((1, 0.02), (3, 0.1), (9, 0.3))[effort]
    body, table, figures = make_body(), [], []
    engines, missing = {}, {}
    for name, (kind, module) in ENGINES.items():
        if module and not importlib.util.find_spec(module):
            missing[name] = f"skipped, not installed: {INSTALL}"
            continue
        try:
            engines[name] = kind(body)
        except ImportError as error:
            missing[name] = f"skipped, cannot be imported ({str(error).partition(chr(10))[0]}): {INSTALL}"
    heights, batch = {}, {}
    for name, engine in tqdm(engines.items(), desc="peers: a second of simulated time", leave=False):
        engine.run(round(1.0 / STEP))  # compiled; and fallen onto the ground
        heights[name] = engine.height()
        began = time.process_time()
        engine.run(100)
        batch[name] = max(100, int(100 * seconds / max(time.process_time() - began, 1e-6)))
    rates = {name: [] for name in engines}
    for k in tqdm(range(rounds), desc="peers", leave=False):
        for name in list(engines)[:: 1 if k % 2 else -1]:
            began = time.process_time()
            engines[name].run(batch[name])
            rates[name].append(batch[name] / (time.process_time() - began))
    for name in engines:
        if not np.isfinite(engines[name].height()):
            raise AssertionError(f"{name}: not finite")
        rate, ratio = max(rates[name]), max(rates["evodevo"]) / max(rates[name])
        table.append({"engine": name, "substeps_per_second": rate, "time_over_ours": ratio, "height_after_1_s": heights[name],
                      "what": engines[name].what})
        text = f"{rate:,.0f} substeps a second" + ("" if name == "evodevo" else f", {ratio:.3g} times the time of ours")
        figures.append(Figure(PART, f"{name}: {engines[name].what}", f"{text}; mean height after 1 s {heights[name]:.3f} m"))
    figures += [Figure(PART, name, why) for name, why in missing.items()]
    write_csv(out / "peers.csv", table)
    return figures


if __name__ == "__main__":
    main(run, __doc__)
