"""The walking task: rest first, then signed progress of working muscles; the same bits everywhere; bad worlds are named."""

import dataclasses

import numpy as np
import pytest
from evodevo_ga.arguments import parse
from evodevo_sim.brain.scent import disturb
from evodevo_sim.live.animat import Animat, NotViable
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.physics.terrain import make_terrain, touching
from evodevo_sim.plant.simulated import _actuate_late
from evodevo_sim.ros.messages import task_from_message, task_message
from evodevo_sim.tasks.walk.audit import trial
from evodevo_sim.tasks.walk.fitness import begin, headings, noise, score, start_fitness
from evodevo_sim.tasks.walk.kernel import Walk
from evodevo_sim.worlds import PRESETS, with_world
from genomes import beating, dividing, hand_made, ring
from rclpy.serialization import deserialize_message, serialize_message

from evodevo_sim import Development, ParameterError, Scene, Status, Task, evaluate, perform

TASK = with_settings(default_task("walk"), {"development.max_cells": 12, "control_steps": 400})


@pytest.mark.parametrize("genome", [beating(), ring()], ids=["beating", "ring"])
def test_a_walk_is_deterministic_and_depends_on_its_seed(genome):
    evaluation = evaluate(genome, TASK, 1)
    assert evaluation.status == Status.OK and evaluation.metrics.settling_steps > 15
    assert evaluate(genome, TASK, 1) == evaluation == perform(genome, TASK, 1).evaluation
    assert evaluate(genome, TASK, 2) != evaluation


def test_a_walker_starts_at_rest_on_the_ground_and_never_below():
    performance = perform(beating(), TASK, 3)
    start = performance.position[0]
    assert np.linalg.norm(performance.velocity[0], axis=1).max() <= TASK.settled_speed
    assert touching(TASK.scene, start).any()
    assert performance.position[..., 1].min() >= 0.0
    # At rest means that it stays: nothing moves while the network sleeps on.
    asleep = perform(dividing(), TASK, 3)
    assert np.abs(asleep.position - asleep.position[0]).max() < 0.02


def test_metrics_are_those_of_the_track():
    performance = perform(ring(), dataclasses.replace(TASK, starts=1), 5)
    metrics, x = performance.evaluation.metrics, performance.position[..., 0].mean(axis=1)
    along = np.sign(x[-1] - x[0])
    assert metrics.distance == pytest.approx(abs(x[-1] - x[0]), abs=1e-9)
    assert metrics.distance_second_half == pytest.approx(along * (x[-1] - x[200]), abs=1e-9)
    assert metrics.slowest_window == pytest.approx((along * np.diff(x[::100])).min(), abs=1e-9)
    windows = performance.activation[1:].reshape(TASK.windows, -1, metrics.cells)
    assert metrics.activation_amplitude == pytest.approx((np.ptp(windows, axis=1) / 2).mean(axis=1).min(), abs=1e-9)


def result(path, active=1.0, status=None):
    path = np.atleast_2d(np.array(path, float))
    starts = len(path)
    status = np.zeros(starts, int) if status is None else np.array(status)
    ones = np.ones(starts)
    return Walk(status, np.full(starts, -1), path, 0.5 * ones, active * ones, np.full(starts, 99), 0 * ones, 4, 12, 20, 9)


def test_only_progress_along_the_way_counts_and_only_as_far_as_muscles_work():
    bonus = TASK.activity_bonus
    assert score(result([0, 2, 3, 6, 8]), TASK).fitness == 4 * 1 + bonus
    assert score(result([0, -2, -3, -6, -8], active=0.5), TASK).fitness == 0.5 * (4 * 1 + bonus)
    shaking = score(result([0, 5, 0, 5, 1]), TASK)  # to and fro about a place
    assert shaking.fitness == bonus and shaking.metrics.slowest_window == -5 and shaking.metrics.distance == 1
    assert score(result([0, 9, 9, 9, 9]), TASK).fitness == bonus  # a single tumble
    assert score(result([0, 2, 3, 6, 8], active=0.0), TASK).fitness == 0.0


def test_the_worse_half_of_the_starts_counts_and_the_worst_is_told():
    bonus = TASK.activity_bonus
    paths = np.outer([5, -1, 2, 20], [0, 1, 2, 3, 4])
    four = score(result(paths), TASK)
    assert four.fitness == pytest.approx((4 + 8) / 2 + bonus) and four.metrics.worst_start == 4 + bonus
    assert four.metrics.distance == 28 and score(result(paths[:3]), TASK).fitness == four.fitness
    assert [score(result(paths[k : k + 1]), TASK).fitness for k in range(4)] == [20 + bonus, 4 + bonus, 8 + bonus, 80 + bonus]
    one = score(result(paths, status=[Status.OK, Status.OK, Status.UNSETTLED, Status.OK]), TASK)
    assert one.fitness == pytest.approx((4 + bonus) / 2) and one.status == Status.OK
    none = score(result([[0] * 5] * 2, status=[Status.UNSETTLED] * 2), TASK)
    assert none.status == Status.UNSETTLED and none.fitness < 0 and "come to rest" in none.cause
    assert score(result([[0] * 5] * 2, status=[Status.OK, Status.UNSTABLE]), TASK).status == Status.UNSTABLE


@pytest.mark.parametrize("share, stands", [(0.6, True), (0.4, False)])
def test_an_audit_says_how_far_it_walks_from_other_starts(monkeypatch, share, stands):
    """Nine of sixteen other starts go `share` as far as its own, the others farther: the median is what counts."""
    from evodevo_sim.tasks.audit import audit
    from evodevo_sim.tasks.walk import audit as walk_audit

    def trial(genome, task, directions, finer=1, seed=0):
        own = len(directions) == task.starts
        paths = np.outer([1.0] * 4 if own else [share] * 9 + [2.0] * 7, [0, 5, 10, 15, 20])
        walked = result(paths)
        return walked, start_fitness(walked, task), np.zeros((len(paths), 4)), perform(ring(), task, 1).position

    monkeypatch.setattr(walk_audit, "trial", trial)
    found = audit(ring(), TASK, 3)
    assert found.says == f"It walks {20 * share:.4g} m in the median of 16 other starts, {share:.2f} of the 20 m from its own."
    assert found.stands == stands and any("start's luck" in fault for fault in found.faults) != stands


def test_more_starts_begin_with_the_same_ones():
    assert np.array_equal(headings(7, 5)[:2], headings(7, 2))
    assert np.linalg.norm(headings(7, 5), axis=1) == pytest.approx(np.ones(5))
    for starts in (1, 2, 4, 16):
        turns = np.sort(np.arctan2(*headings((7, 1), starts).T))
        assert np.diff(turns) == pytest.approx(2 * np.pi / starts)  # evenly spread
    assert not np.array_equal(headings(7, 1), headings(8, 1))
    alone = [trial(ring(), TASK, headings(7, 3)[k : k + 1])[1][0] for k in range(3)]
    assert trial(ring(), TASK, headings(7, 3))[1].tolist() == alone


def test_noise_of_muscles_is_each_cells_own_where_no_morphogen_is_shared():
    # In plain Python, where every index is checked: this body's network exchanges nothing, so it has no scratch for that.
    status, controller, plant = begin(ring(), NOISY, 1)
    assert status == Status.OK and controller.brain.network.morphogens.size == 0
    still, before = np.zeros(len(plant.position)), plant.state.rest.copy()
    signals = noise(with_settings(TASK, {"noise.actuation": 0.1}), 1)
    disturb.py_func(controller.brain, signals, 0)
    _actuate_late.py_func(plant.state, still, signals, 0)
    assert not still.any() and len(set(plant.state.rest / before)) == before.size


def test_what_cannot_walk_says_so():
    lone, pair = evaluate(hand_made(), TASK), evaluate(dividing(), dataclasses.replace(TASK, development=Development(max_cells=2)))
    assert lone.status == Status.NO_GROWTH and pair.status == Status.NO_CHAMBER
    never = evaluate(ring(), dataclasses.replace(TASK, settling_limit=20))
    assert never.status == Status.UNSETTLED and -1 < never.fitness < 0
    with pytest.raises(NotViable, match="come to rest"):
        Animat(ring(), dataclasses.replace(TASK, settling_limit=20))
    low = dataclasses.replace(TASK, scene=dataclasses.replace(TASK.scene, ceiling_x=(-9.0, 9.0), ceiling_y=(1.5, 1.5)))
    assert evaluate(dividing(), low).status == Status.NO_ROOM


def test_a_network_at_rest_earns_nothing():
    evaluation = evaluate(dividing(), TASK, 2)
    assert evaluation.fitness == pytest.approx(0, abs=1e-9) and evaluation.metrics.activation_amplitude < 1e-9


NOISY = with_settings(TASK, {"noise.concentrations": 0.02, "noise.actuation": 0.1})


@pytest.mark.parametrize("task", [TASK, NOISY], ids=["quiet", "noisy"])
def test_live_steps_are_those_of_a_performance_bit_for_bit(task):
    performance, animat = perform(ring(), task, 4), Animat(ring(), task, 4)
    for step in range(60):
        assert np.array_equal(animat.position, performance.position[step])
        assert np.array_equal(animat.velocity, performance.velocity[step])
        assert np.array_equal(animat.activation, performance.activation[step])
        animat.step()


def test_noise_is_that_of_its_seed_and_without_it_no_bit_changes():
    evaluation, quiet = evaluate(ring(), NOISY, 1), evaluate(ring(), TASK, 1)
    assert evaluation == evaluate(ring(), NOISY, 1) and evaluation.status == Status.OK
    assert len({evaluate(ring(), with_settings(NOISY, {"noise.actuation": a}), 1).metrics.distance for a in (0.0, 0.05, 0.1)}) == 3
    assert evaluation != quiet
    assert quiet == evaluate(ring(), with_settings(NOISY, {"noise.concentrations": 0.0, "noise.actuation": 0.0}), 1)
    # Of one seed the body comes to rest in the same place, and every start has noise of its own.
    performance = perform(ring(), NOISY, 1)
    assert np.array_equal(performance.position[0], perform(ring(), TASK, 1).position[0])
    same = headings(1, 1).repeat(2, 0)
    assert len(set(trial(ring(), NOISY, same, seed=1)[0].path[:, -1])) == 2 and len(set(trial(ring(), TASK, same)[0].path[:, -1])) == 1
    # Noise alone moves what rests: as concentrations, which muscles show, or past them.
    one = {name: perform(dividing(), with_settings(TASK, {name: 0.1}), 2) for name in ("noise.concentrations", "noise.actuation")}
    assert [p.evaluation.metrics.activation_amplitude > 0.01 for p in one.values()] == [True, False]
    assert all(np.abs(p.velocity[100:]).max() > 0.1 for p in one.values())
    with pytest.raises(ParameterError, match=r"noise.sensing is 0.5: leave it at 0 where the task is walk"):
        with_settings(TASK, {"noise.sensing": 0.5})


@pytest.mark.parametrize("world", PRESETS)
def test_worlds_keep_their_bits_over_the_wire_and_cells_stay_outside(world):
    task = with_world(TASK, world)
    there = task_from_message(deserialize_message(serialize_message(task_message(task)), type(task_message(task))))
    assert there == task
    performance = perform(beating(), task, 1)
    assert performance.evaluation == evaluate(beating(), there, 1)
    p, scene = performance.position, task.scene
    if scene.ground_x:
        assert (p[..., 1] - np.interp(p[..., 0], scene.ground_x, scene.ground_y)).min() > -1e-9
    if scene.ceiling_x:
        assert (np.interp(p[..., 0], scene.ceiling_x, scene.ceiling_y) - p[..., 1]).min() > -1e-9
    assert touching(scene, p[0]).any()


BAD_WORLDS = {
    "ground: [[0, 0], [2, 1], [1, 0]]": "ground is not single-valued: point 2 at x = 1 follows x = 2",
    "ground: [[0, 0]]": "ground has 1 points",
    "ground: [[0, 0], [1, .inf]]": r"ground\[1\] is inf",
    "ground: [[0, 0], [1]]": r"ground\[1\] is \[1\]",
    "ground: flat": "ground is 'flat'",
    "ceiling: [[-5, 9], [5, 0.9]]": "the opening at x = 5 is 0.9 m high, less than a cell",
    "friction: -0.1": "friction is -0.1: give a number from 0",
    "gravity: heavy": "gravity is 'heavy'",
    "slope: 90": "slope is 90",
    "rough: {hight: 1}": "'hight' is unknown: did you mean 'height'",
    "grond: []": "'grond' is unknown: did you mean 'ground'",
    "slope: 3\nsteps: {}": "slope and steps are both given",
    "- 1": "give keys and values",
    "ground: [[0, 0": "neither YAML nor JSON from line",
}


@pytest.mark.parametrize("text", BAD_WORLDS)
def test_a_world_that_cannot_be_is_named_in_one_line(tmp_path, text):
    (tmp_path / "world.yaml").write_text(text)
    with pytest.raises(ParameterError, match=BAD_WORLDS[text]) as raised:
        with_world(TASK, tmp_path / "world.yaml")
    assert "\n" not in str(raised.value)


def test_the_command_line_takes_worlds_and_starts(tmp_path, capsys):
    (tmp_path / "mine.yaml").write_text("ground: [[-9, 1], [9, -1]]\nfriction: 0.3\n")
    task = parse(["--task", "walk", "--world", str(tmp_path / "mine.yaml"), "--starts", "3"]).task
    assert task.scene.friction == 0.3 and task.scene.ground_y == (1.0, -1.0) and task.starts == 3
    assert task.scene.gravity == default_task("walk").scene.gravity
    for arguments, says in (
        (["--task", "walk", "--world", "ruff"], "did you mean 'rough'"),
        (["--world", "rough"], "a world is for tasks that happen on the ground, such as walk: swim has no ground"),
        (["--task", "walk", "--set", "scene.friction=-1"], "scene.friction is -1"),
        (["--task", "walk", "--starts", "0"], "task.starts is 0"),
        (["--task", "walk", "--set", "scene.ground_x=3"], "give a world"),
    ):
        with pytest.raises(SystemExit) as raised:
            parse(arguments)
        assert raised.value.code == 2 and says in capsys.readouterr().err


def test_a_made_ground_depends_on_its_seed_alone():
    one, again = with_world(TASK, "rough").scene, with_world(TASK, "rough").scene
    assert one == again and len(one.ground_x) > 100 and np.ptp(one.ground_y) > 0.4
    assert make_terrain(Scene()).x.size == 0  # free where absent
    assert Task().scene.ground_x == () and default_task("swim") == Task()
