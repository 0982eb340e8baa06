"""What pays in selection: motion in every window, as far as muscles work to the end."""

import numpy as np
import pytest
from evodevo_sim.tasks.swim.fitness import score, slowest_progress
from evodevo_sim.tasks.swim.kernel import Swim
from genomes import dividing, ring

from evodevo_sim import Development, Status, Task, evaluate

TASK = Task(control_steps=400, development=Development(max_cells=12))


def test_a_network_that_oscillates_earns_the_bonus_of_all_its_cells():
    found = evaluate(ring(), TASK)
    assert found.status == Status.OK and found.metrics.activation_amplitude > 0.1
    assert found.fitness == pytest.approx(TASK.windows * found.metrics.slowest_window + TASK.activity_bonus)


def test_a_network_at_rest_earns_nothing():
    found = evaluate(dividing(), TASK)
    assert found.metrics.cells == 12 and found.metrics.activation_amplitude == 0.0
    assert found.fitness == 0.0


def test_a_curved_way_counts_as_far_as_it_is_straight():
    turn = np.linspace(0.0, 2 * np.pi, 5)
    circle = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    for path, slowest in (
        (circle, 0.0), (circle[[0, 1, 0, 1, 2]], np.sqrt(2) * 2 / (4 * np.sqrt(2))), (np.zeros((5, 2)), 0.0),
        (np.array([[0.0, 0.0], [3.0, 4.0], [6.0, 8.0], [9.0, 12.0], [10.5, 14.0]]), 2.5),
    ):
        assert slowest_progress(path) == pytest.approx(slowest, abs=1e-12)


def test_the_slowest_window_counts_and_only_as_far_as_muscles_work():
    path = np.array([[0.0, 0.0], [9.0, 0.0], [10.0, 0.0], [13.0, 0.0], [15.0, 0.0]])
    for active in (0.0, 0.25, 1.0):
        found = score(Swim(0, -1, path, 0.3, active, 1, 12, 20, 9), Task())
        assert found.fitness == pytest.approx(active * (4 * 1.0 + Task().activity_bonus))
        assert (found.metrics.distance, found.metrics.distance_second_half, found.metrics.slowest_window) == (15.0, 5.0, 1.0)
