"""What pays in selection: motion in every window, as far as muscles work to the end."""

import numpy as np
import pytest
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import task_from_message, task_message
from evodevo_sim.tasks.audit import audit
from evodevo_sim.tasks.swim.fitness import score, slowest_progress
from evodevo_sim.tasks.swim.kernel import Swim
from evodevo_sim.tasks.walk.fitness import score as walk_score
from evodevo_sim.tasks.walk.kernel import Walk
from genomes import dividing, ring

from evodevo_sim import Development, ParameterError, Status, Task, evaluate

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


def test_plain_distance_is_the_way_from_start_to_end_whatever_moves_it():
    path = np.array([[0.0, 0.0], [9.0, 0.0], [10.0, 0.0], [9.0, 0.0], [3.0, 4.0]])
    task = with_settings(Task(), {"task.fitness": "distance"})
    for active in (0.0, 1.0):
        assert score(Swim(0, -1, path, 0.3, active, 1, 12, 20, 9), task).fitness == 5.0
    assert score(Swim(Status.INVERTED, 7, path, 0.3, 1.0, 1, 12, 20, 9), task).fitness == -3.0
    life = evaluate(ring(), with_settings(TASK, {"fitness": "distance"}))
    assert life.fitness == life.metrics.distance and life.metrics == evaluate(ring(), TASK).metrics


def test_plain_distance_of_a_walker_is_that_of_the_worse_half_of_its_starts():
    task = with_settings(default_task("walk"), {"fitness": "distance"})
    ways = np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 9.0, 0.0, -9.0, -6.0], [0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0, 90.0]])
    zeros, ones = np.zeros(4, int), np.ones(4)
    found = Walk(zeros, zeros - 1, ways, ones, ones, zeros, ones, 4, 12, 20, 9)
    assert walk_score(found, task).fitness == 2.5  # of 4, 6, 1 and 90 m
    assert walk_score(found, default_task("walk")).fitness != 2.5
    unsettled = found._replace(status=np.array([0, 0, 0, Status.UNSETTLED]))
    assert walk_score(unsettled, task).fitness == 0.5


@pytest.mark.parametrize(
    "values, says",
    [
        ({"fitness": "speed"}, "task.fitness is 'speed': choose one of sustained, distance"),
        (
            {"task.fitness": "distance", "name": "chemotaxis"},
            "task.fitness is 'distance': leave it at 'sustained' where the task is chemotaxis",
        ),
    ],
)
def test_a_fitness_that_cannot_be_is_refused_by_name(values, says):
    with pytest.raises(ParameterError, match=says):
        with_settings(Task(), values)


def test_a_fitness_travels_in_messages_and_its_absence_is_the_default():
    task = with_settings(Task(), {"fitness": "distance"})
    assert task_from_message(task_message(task)) == task
    older = task_message(Task())
    older.fitness = ""
    assert task_from_message(older) == Task()


def test_an_audit_repeats_the_plain_distance():
    task = with_settings(TASK, {"fitness": "distance", "control_steps": 80})
    found = audit(ring(), task, quick=True)
    assert [run.fitness for run in found.runs] == [run.sustained for run in found.runs]
    assert found.evaluation.fitness == found.evaluation.metrics.distance == pytest.approx(found.runs[0].fitness, rel=1e-9)
