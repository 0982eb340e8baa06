"""Living animats: the life of an evaluation, bit for bit, and a stage that lets one live in a thread."""

import dataclasses
import queue
import threading

import numpy as np
import pytest
from evodevo_sim.live.animat import Animat, NotViable, Stage
from evodevo_sim.parameters import default_task
from genomes import beating, hand_made, ring
from test_chemotaxis import pulsing_smeller
from test_turning import reflex

from evodevo_sim import Development, ParameterError, Task, perform

TASK = Task(development=Development(max_cells=12), control_steps=40)
CHEMOTAXIS = dataclasses.replace(default_task("chemotaxis"), development=Development(max_cells=12), control_steps=40)
WITHIN = 20.0  # s; what a thread is asked for comes at once, or the test fails


def swimmer():
    return Animat(beating(), TASK)


def state(animat):
    return np.hstack((animat.position, animat.velocity, animat.activation[:, None])).copy()


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_steps_are_those_of_a_performance_bit_for_bit(variant):
    task = Task(development=Development(max_cells=12, variant=variant), control_steps=40)
    performance, animat = perform(ring(), task), Animat(ring(), task)
    for step in range(task.control_steps + 1):
        assert np.array_equal(animat.position, performance.position[step])
        assert np.array_equal(animat.velocity, performance.velocity[step])
        assert np.array_equal(animat.activation, performance.activation[step])
        animat.step()
    assert animat.steps == 41 and animat.time == pytest.approx(41 / 60)


def test_a_reset_goes_back_to_birth_and_keeps_the_target():
    animat = swimmer()
    animat.target = (1.0, 2.0)
    lives = []
    for _ in range(2):
        lives.append([])
        for _ in range(10):
            lives[-1].append(state(animat))
            animat.step()
        animat.reset()
    assert np.array_equal(*lives) and animat.steps == 0 and animat.target == (1.0, 2.0)


def test_what_cannot_move_is_refused_with_the_reason():
    with pytest.raises(NotViable, match="never divided"):
        Animat(hand_made(), TASK)


def test_nobody_changes_an_animat_from_outside():
    with pytest.raises(ValueError, match="read-only"):
        swimmer().position[0, 0] = 1.0


class Audience:
    """Keeps what a stage shows and says."""

    def __init__(self, fails_at=None):
        self.shown, self.reasons, self.fails_at = queue.Queue(), queue.Queue(), fails_at

    def show(self, animat):
        if animat.steps == self.fails_at:
            raise RuntimeError("no light")
        self.shown.put((animat.steps, animat.target, state(animat)))

    def next(self):
        return self.shown.get(timeout=WITHIN)


@pytest.fixture
def stage_for():
    stages = []

    def make(audience, every=1):
        stages.append(Stage(audience.show, audience.reasons.put, every))
        return stages[-1]

    yield make
    for stage in stages:
        stage.close()


def test_a_stage_shows_every_so_many_steps_of_the_same_life(stage_for):
    audience = Audience()
    stage_for(audience, every=5).load(swimmer(), 0.0)
    other = swimmer()
    for step in (0, 5, 10):
        shown, _, seen = audience.next()
        assert shown == step and np.array_equal(seen, state(other))
        for _ in range(5):
            other.step()


def test_a_pause_holds_and_a_reset_shows_birth_again(stage_for):
    audience = Audience()
    stage = stage_for(audience)
    assert stage.pause(True) is False and stage.reset() is False and not stage.paused  # nobody there
    stage.load(swimmer(), 0.0)
    assert audience.next()[0] == 0
    assert stage.pause(True) is True
    while not audience.shown.empty():
        audience.shown.get()
    stage.aim((3.0, 4.0))
    assert stage.reset() is True and stage.paused
    step, target, _ = audience.next()
    assert (step, target) == (0, (3.0, 4.0)) and audience.shown.empty()  # every question to the thread found it holding
    assert stage.pause(False) is True
    assert [audience.next()[0] for _ in range(3)] == [1, 2, 3]


def test_a_target_stays_for_the_next_animat(stage_for):
    audience = Audience()
    stage = stage_for(audience)
    stage.aim((1.0, -1.0))
    stage.load(swimmer(), 1.0)
    assert audience.next()[1] == (1.0, -1.0)


def test_an_error_in_the_show_stops_the_animat_with_the_reason(stage_for):
    audience = Audience(fails_at=3)
    stage = stage_for(audience)
    stage.load(swimmer(), 0.0)
    assert "no light" in audience.reasons.get(timeout=WITHIN)
    assert stage.pause(False) is False  # nobody there any more, and the stage lives on
    stage.load(swimmer(), 1e6)
    assert [audience.next()[0] for _ in range(4)] == [0, 1, 2, 0]


def test_closing_ends_the_thread_once_and_for_all(stage_for):
    audience = Audience()
    before = threading.active_count()
    stage = stage_for(audience)
    stage.load(swimmer(), 0.0)
    stage.close()
    stage.close()
    assert threading.active_count() == before
    while not audience.shown.empty():
        audience.shown.get()
    with pytest.raises(RuntimeError, match="closed"):
        stage.load(swimmer(), 0.0)
    assert audience.shown.empty()


@pytest.mark.parametrize("factor", [-1.0, np.nan, np.inf])
def test_an_impossible_pace_is_named(stage_for, factor):
    with pytest.raises(ParameterError, match="real_time_factor"):
        stage_for(Audience()).load(swimmer(), factor)


def seeker():
    return Animat(pulsing_smeller(), CHEMOTAXIS)


def test_a_target_reaches_the_network_in_the_next_control_step(stage_for):
    """From the step after `aim` on, the life is that of an animat that had the target from there on, bit for bit."""
    audience = Audience()
    stage = stage_for(audience)
    stage.load(seeker(), 0.0)
    stage.pause(True)
    stage.reset()
    while audience.next()[0] or not audience.shown.empty():
        pass
    stage.aim((4.0, 2.0))
    stage.pause(False)
    other = seeker()
    other.target = (4.0, 2.0)
    blind = seeker()
    for step in range(1, 4):
        other.step()
        blind.step()
        shown, target, seen = audience.next()
        assert (shown, target) == (step, (4.0, 2.0)) and np.array_equal(seen, state(other))
        assert not np.array_equal(seen, state(blind))


def test_a_flood_of_targets_does_not_hold_the_animat_up(stage_for):
    audience = Audience()
    stage = stage_for(audience)
    stage.load(seeker(), 1.0)
    while audience.next()[0] < 20:
        for k in range(200):
            stage.aim((0.01 * k, 1.0))
    stage.aim((9.0, 9.0))
    while audience.next()[1] != (9.0, 9.0):
        pass
    assert audience.reasons.empty()


def test_a_second_animat_takes_the_place_of_the_first_and_says_so(stage_for):
    audience = Audience()
    stage = stage_for(audience)
    assert stage.load(swimmer(), 1.0) is False and stage.load(swimmer(), 1.0) is True


def test_an_animat_at_rest_wakes_up_when_a_target_comes():
    task = dataclasses.replace(CHEMOTAXIS, development=Development(max_cells=12))
    animat = Animat(reflex(), task)
    for _ in range(300):
        animat.step()
    still = animat.activation.copy()
    animat.target = (1.0, 1.0)
    for _ in range(10):
        animat.step()
    assert not still.any() and np.abs(animat.activation).min() > 0.02
