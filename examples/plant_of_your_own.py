"""A brain drives what is no simulated body: cells on springs of their own.  Hardware would stand in that place.  No ROS.

    python examples/plant_of_your_own.py
"""

import numpy as np
from evodevo_sim.plant import Outcome
from evodevo_sim.tasks.swim.fitness import begin

from evodevo_sim import Task, load_champion


class Springs:
    """Each cell is a mass on a spring, pulled up by its activation.  `evodevo_sim.plant.Plant` says what a plant must offer."""

    def __init__(self, cells):
        self.position, self.velocity = np.zeros((cells, 2)), np.zeros((cells, 2))

    def move(self, activation, seconds):
        self.velocity[:, 1] += seconds * (activation - self.position[:, 1])
        self.position += seconds * self.velocity
        return Outcome.SOUND

    def reset(self):
        self.position[:], self.velocity[:] = 0.0, 0.0

    def rests(self):
        return False


task = Task()
_, brain, _ = begin(load_champion("ribbon"), task, 0)
plant = Springs(len(brain.activation))
heights = []
for _ in range(300):
    plant.move(brain.step(plant.position), task.control_step)
    heights.append(plant.position[:, 1].copy())
print(f"{len(brain.activation)} cells, moved by up to {np.ptp(heights, axis=0).max():.2f} m")
