"""Brain and plant: the same life apart as together, and a brain that drives what is no simulation."""

import numpy as np
import pytest
from evodevo_sim.live import Animat
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.plant import Outcome, Plant
from evodevo_sim.task_kinds import kind_of, names
from evodevo_sim.tasks.swim.fitness import begin
from genomes import beating, pulsing

from evodevo_sim import perform

NOISE = {"noise.concentrations": 0.02, "noise.actuation": 0.1}
RIG = {"rig.lag": 0.1, "rig.dead_time": 0.05, "rig.rate": 3.0, "rig.failures": 2, "rig.fail_at": 0.5}


class Springs:
    """A plant of ten lines: every cell is a mass on a spring of its own, pulled up by its activation."""

    def __init__(self, cells):
        self.position, self.velocity, self.taken = np.zeros((cells, 2)), np.zeros((cells, 2)), []

    def move(self, activation, seconds):
        self.velocity[:, 1] += seconds * (activation - self.position[:, 1])
        self.position += seconds * self.velocity
        self.taken.append(activation.copy())
        return Outcome.SOUND

    def reset(self):
        self.position[:], self.velocity[:] = 0.0, 0.0

    def rests(self):
        return False


def test_a_brain_drives_a_plant_that_is_no_simulation():
    task = default_task("swim")
    plant: Plant = Springs(len(perform(pulsing(), with_settings(task, {"control_steps": 4})).body.position))
    _, brain, _ = begin(pulsing(), task, 0)
    for _ in range(300):
        assert plant.move(brain.step(plant.position), task.control_step) == Outcome.SOUND
    told = np.array(plant.taken)
    # The network knows nothing of the plant: what it asks for is what it asks of its own body.
    expected = perform(pulsing(), with_settings(task, {"control_steps": 300})).activation[1:]
    assert np.array_equal(told, expected)
    assert np.ptp(plant.position[:, 1]) > 0.0


@pytest.mark.parametrize("settings", [{}, NOISE, RIG], ids=["quiet", "noise", "rig"])
@pytest.mark.parametrize("name", [name for name in names() if not kind_of(name).has_target])
def test_brain_and_plant_apart_live_the_life_of_an_evaluation(name, settings):
    task = with_settings(default_task(name), {"control_steps": 120, "starts": 1, **settings})
    performance, animat = perform(beating(), task, 5), Animat(beating(), task, 5)
    for step in range(1, 121):
        animat.step()
        assert np.array_equal(animat.position, performance.position[step])
        assert np.array_equal(animat.activation, performance.activation[step])


@pytest.mark.parametrize("name", names())
def test_simulated_plants_meet_the_contract(name):
    task = with_settings(default_task(name), {"starts": 1})
    _, brain, plant = task.kind.function("begin")(pulsing(), task, 0)
    cells = len(brain.activation)
    assert plant.position.shape == plant.velocity.shape == (cells, 2)
    assert not plant.position.flags.writeable and not plant.velocity.flags.writeable and not brain.activation.flags.writeable
    assert plant.move(np.zeros(cells), task.control_step) is Outcome.SOUND
    assert plant.rests() in (True, False)
    assert np.isfinite(plant.position).all()


def test_a_plant_that_blows_up_says_so():
    _, _, plant = begin(pulsing(), default_task("swim"), 0)
    plant.state.velocity[:] = 1e12
    assert plant.move(np.zeros(len(plant.position)), 1 / 60) in (Outcome.UNSTABLE, Outcome.INVERTED)
