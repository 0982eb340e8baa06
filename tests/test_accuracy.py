"""Accuracy of what evolution sees: a ring under pressure as in closed form, swims the same in every frame, steps fine enough."""

from pathlib import Path

import numpy as np
import pytest
from bodies import STEP, body_of, go, rotation
from evodevo_sim.live.animat import Animat
from evodevo_sim.parameters import with_settings
from evodevo_sim.physics.control_step import relax
from evodevo_sim.physics.forces import Law, make_scratch
from evodevo_sim.physics.integrators import make_system
from evodevo_sim.physics.step_size import RK4
from evodevo_sim.tasks.outcome import Status
from genomes import pulsing
from scipy.optimize import brentq

from evodevo_sim import Task, load_genome, perform

CHAMPIONS = Path(__file__).parents[1] / "src/evodevo_sim/champions"
SWIM_ERROR = 5e-3  # cell diameters, after 1,000 control steps


class Ring:
    """n cells of mass m on a circle, springs between neighbours contracted to `share` of their length, one chamber.

    At `stretch` times its radius R at rest, with l = stretch L0 and S = stretch^2 S0, the force on a cell is, outward,
    c_p l (1 - S / S0) cos(pi / n) - 2 k (l - share L0) sin(pi / n).
    """

    def __init__(self, cells, share, pressure, mass=1.7, stiffness=400.0):
        angle = 2 * np.pi * np.arange(cells) / cells
        self.circle = np.array([np.cos(angle), np.sin(angle)])
        edges = [(i, i + 1) for i in range(cells - 1)] + [(0, cells - 1)]
        self.radius, self.mass, self.half = 2.0, mass, np.pi / cells
        self.body, self.share = body_of(self.radius * self.circle.T, edges, mass), share
        self.law = Law(stiffness, 0.0, pressure, 0.0, 0.0, 0.2)
        self.stretch = brentq(self.force, share, 1.0, xtol=1e-15)
        sin, cos = np.sin(self.half), np.cos(self.half)
        slope = 2 * stiffness * sin - pressure * cos * (1 - 3 * self.stretch**2)
        self.frequency = np.sqrt(2 * sin * slope / mass)

    def force(self, stretch):
        sin, cos, length = np.sin(self.half), np.cos(self.half), 2 * self.radius * np.sin(self.half)
        pull = 2 * self.law.stiffness * (stretch - self.share) * length * sin
        return self.law.pressure * stretch * length * (1 - stretch**2) * cos - pull

    @property
    def drive(self):
        """Muscles held at e - c: sines that stand still."""
        ones = np.ones(self.circle.shape[1])
        return (1 - self.share) / 0.4 * ones, 0.0 * ones, -np.pi / 2 * ones


RINGS = pytest.mark.parametrize("cells, share, pressure", [(3, 0.6, 400.0), (5, 0.8, 1000.0), (12, 0.6, 100.0), (40, 0.7, 5.0)])


@RINGS
def test_a_ring_under_pressure_rests_where_pressure_and_tension_balance(cells, share, pressure):
    ring = Ring(cells, share, pressure)
    position, velocity = ring.body.position.T.copy(), np.zeros((2, cells))
    relax(ring.body, ring.law, share * ring.body.rest_length, position, velocity, 1e-10, 200_000, make_scratch(ring.body))
    assert share < ring.stretch < 1
    assert position == pytest.approx(ring.stretch * ring.radius * ring.circle, abs=1e-8)


@RINGS
def test_a_ring_breathes_at_the_frequency_of_the_closed_form(cells, share, pressure):
    ring = Ring(cells, share, pressure)
    system = make_system(ring.body, ring.law, drive=ring.drive)
    radius, swing = ring.stretch * ring.radius, 1e-5
    period = 2 * np.pi / ring.frequency
    for turns in (0.25, 1.0, 2.125):
        p, _ = go(system, RK4, 40, 50, (radius + swing) * ring.circle, interval=turns * period / 50)
        found = np.hypot(*p) - radius
        assert found == pytest.approx(np.full(cells, swing * np.cos(2 * np.pi * turns)), abs=1e-3 * swing)


def test_a_whole_life_is_the_same_in_every_frame():
    turn, shift = rotation(2.1), np.array([[30.0], [-20.0]])
    here, there = Animat(pulsing()), Animat(pulsing())
    start = here.position.mean(axis=0)
    there.plant.state.position[:] = turn @ there.plant.state.position + shift
    for _ in range(Task().control_steps):
        here.step()
        there.step()
    assert here.status == there.status == Status.OK
    distance = np.hypot(*(here.position.mean(axis=0) - start))
    assert distance > 1.0
    assert there.position == pytest.approx((turn @ here.position.T + shift).T, abs=1e-9 * distance)
    assert there.velocity == pytest.approx((turn @ here.velocity.T).T, abs=1e-9)
    assert np.array_equal(here.activation, there.activation)


@pytest.mark.parametrize("name", ["undulator", "ribbon", "peristalsis", "jellyfish", "pulsing"])
def test_a_default_swim_is_accurate_after_1000_control_steps(name):
    task = with_settings(Task(), {"control_steps": 1000})
    champion = pulsing() if name == "pulsing" else load_genome(CHAMPIONS / f"{name}.yaml")
    swims = [perform(champion, task, finer=finer) for finer in (1, 8)]
    assert [swim.evaluation.status for swim in swims] == [Status.OK] * 2
    assert swims[1].evaluation.metrics.distance > 0.2
    off = np.hypot(*(swims[0].position[-1] - swims[1].position[-1]).T)
    assert np.sqrt((off**2).mean()) < SWIM_ERROR
    assert STEP == task.control_step
