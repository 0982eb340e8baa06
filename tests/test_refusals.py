"""Refused or odd requests change no state: random sequences of them against a model of a few lines, on a stage and on a real node."""

import math
import os
import threading
from functools import partial

import numpy as np
import pytest
from evodevo_sim.live.animat import Animat, Stage
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import genome_message, task_message
from genomes import beating, hand_made, ring
from geometry_msgs.msg import PoseStamped
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lab import Operator, simulators
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger
from test_chemotaxis import pulsing_smeller

from evodevo_msgs.msg import CellStates
from evodevo_msgs.srv import Evaluate, Load
from evodevo_sim import Development, ParameterError, Task

NAMESPACE = f"/refusals_{os.getpid()}"
TASK = Task(development=Development(max_cells=12), control_steps=40)
WITHIN = 20.0  # s

requests = st.lists(
    st.one_of(
        st.tuples(st.just("load"), st.sampled_from([0.0, 1.0, 1e6, -1.0, math.nan, math.inf])),
        st.tuples(st.just("pause"), st.booleans()),
        st.tuples(st.just("reset"), st.none()),
        st.tuples(st.just("aim"), st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))),
        st.tuples(st.just("fail"), st.none()),  # the next time that the stage shows something
    ),
    max_size=12,
)


class Model:
    """What a stage should be: nobody, or an animat that lives or is held."""

    def __init__(self):
        self.lives = self.paused = False

    def ask(self, what, argument):
        """Whether this is accepted; then the state is another one."""
        if what == "load":
            if not 0.0 <= argument <= 1e6:
                return ParameterError
            self.lives, self.paused = True, False
            return True
        if what == "pause" and self.lives:
            self.paused = argument
        return self.lives


class Audience:
    def __init__(self):
        self.steps, self.ended, self.fails = 0, 0, False
        self.told = threading.Condition()

    def show(self, animat):
        if self.fails:
            self.fails = False
            raise RuntimeError("no light")
        with self.told:
            self.steps += 1
            self.told.notify_all()

    def stopped(self, cause):
        self.ended += 1

    def next(self):
        with self.told:
            count = self.steps
            return self.told.wait_for(lambda: self.steps > count, WITHIN)


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(requests)
def test_a_stage_is_as_its_model_whatever_it_is_asked(asked):
    audience, model = Audience(), Model()
    stage = Stage(audience.show, audience.stopped)
    animats = [Animat(beating(), TASK) for _ in range(2)]
    try:
        for k, (what, argument) in enumerate(asked):
            if what == "fail":
                if model.lives and not model.paused:
                    continue  # it would end the animat in a step, at any time
                audience.fails = True
                with pytest.raises(RuntimeError, match="no light"):
                    stage.load(Animat(beating(), TASK), 1.0)
            elif what == "aim":
                stage.aim(argument)
            else:
                expected = model.ask(what, argument)
                before = stage._animat, stage._paused
                call = {
                    "load": partial(stage.load, animats[k % 2], argument), "pause": partial(stage.pause, argument), "reset": stage.reset,
                }[what]
                if expected is ParameterError:
                    with pytest.raises(ParameterError):
                        call()
                else:
                    answer = call()
                    assert what == "load" or answer is expected
                if expected is not True:
                    assert (stage._animat, stage._paused) == before
            assert (stage._animat is not None, stage.paused) == (model.lives, model.paused)
        if model.lives and not model.paused and stage._interval < 1.0:
            assert audience.next()
        assert audience.ended == 0
    finally:
        stage.close()


@pytest.mark.parametrize("task", [TASK, with_settings(default_task("walk"), {"development.max_cells": 12})])
@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_a_reset_is_the_birth_bit_for_bit(task, variant):
    task = with_settings(task, {"development.variant": variant})
    genome = beating() if variant == "continual_graph" else ring()
    old, new = Animat(genome, task), Animat(genome, task)
    for _ in range(15):
        old.step()
    old.reset()
    for _ in range(20):
        for name in ("position", "velocity", "activation"):
            assert np.array_equal(getattr(old, name), getattr(new, name))
        old.step()
        new.step()


def test_an_action_that_comes_too_late_is_not_done(monkeypatch):
    """A stage that is deep in a step refuses, and forgets what it refused."""
    monkeypatch.setattr("evodevo_sim.live.animat._ANSWER_WITHIN", 0.05)
    entered, go_on = threading.Event(), threading.Event()

    def show(animat):
        if animat.steps == 2:
            entered.set()
            go_on.wait(WITHIN)

    stage = Stage(show, print)
    stage.load(Animat(beating(), TASK), 0.0)
    assert entered.wait(WITHIN)
    with pytest.raises(RuntimeError, match="ask again later"):
        stage.pause(True)
    monkeypatch.setattr("evodevo_sim.live.animat._ANSWER_WITHIN", WITHIN)
    go_on.set()
    assert stage.pause(False) is True and not stage.paused
    stage.close()


# --- over DDS ----------------------------------------------------------------------------------------------------------


def load_request(genome, task=TASK, factor=1.0, seed=1):
    return dict(task=task_message(task), seed=seed, genome=genome_message(genome), real_time_factor=factor)


def bad_loads():
    cut, far = load_request(beating()), load_request(beating())
    cut["genome"].kind = cut["genome"].kind[:5]
    far["task"].control_step = math.nan
    return [load_request(hand_made()), load_request(beating(), factor=-1.0), load_request(beating(), factor=math.nan), cut, far]


@pytest.fixture(scope="module")
def lab():
    with simulators(NAMESPACE) as [process], Operator() as operator:
        operator.process = process
        operator.states = operator.listen(CellStates, f"{NAMESPACE}/cell_states", qos_profile_sensor_data)
        operator.publisher = operator.node.create_publisher(PoseStamped, f"{NAMESPACE}/target_pose", 10)
        operator.until(lambda: operator.node.count_publishers(f"{NAMESPACE}/cell_states") and operator.publisher.get_subscription_count())
        yield operator
        assert process.poll() is None


def heard(lab):
    """Spin until three more states have come."""
    count = len(lab.states)
    lab.until(lambda: len(lab.states) > count + 2, WITHIN)


def silent(lab):
    """Whether no state comes, of an animat that would show dozens in the time that a dozen services take."""
    lab.call(Trigger, f"{NAMESPACE}/reset")
    lab.until(lambda: lab.states[-1].step == 0, WITHIN)
    for _ in range(12):
        assert not lab.call(Load, f"{NAMESPACE}/load", **bad_loads()[1]).success
    return lab.states[-1].step == 0


def test_a_node_is_as_the_model_through_odd_requests(lab):
    """Deliberately first in this file's node: nobody is loaded yet."""
    rng = np.random.default_rng(4)
    model = Model()
    assert not lab.call(SetBool, f"{NAMESPACE}/pause", data=True).success  # nobody there: and nobody is held by it later
    assert lab.call(Load, f"{NAMESPACE}/load", **load_request(beating())).success and model.ask("load", 1.0)
    heard(lab)
    for _ in range(25):
        what = rng.choice(["load", "pause", "go on", "reset", "bad load", "bad target", "bad batch"])
        if what == "load":
            assert lab.call(Load, f"{NAMESPACE}/load", **load_request(beating())).success and model.ask("load", 1.0)
        elif what in ("pause", "go on"):
            assert lab.call(SetBool, f"{NAMESPACE}/pause", data=bool(what == "pause")).success and model.ask("pause", what == "pause")
        elif what == "reset":
            answer = lab.call(Trigger, f"{NAMESPACE}/reset")
            assert answer.success and ("paused" in answer.message) == model.paused
        elif what == "bad load":
            answer = lab.call(Load, f"{NAMESPACE}/load", **bad_loads()[rng.integers(5)])
            assert not answer.success and 0 < len(answer.message) <= 300
        elif what == "bad batch":
            assert lab.call(Evaluate, f"{NAMESPACE}/evaluate", task=task_message(TASK), seed=1, genomes=[]).error
        else:
            message = PoseStamped()
            message.header.frame_id = rng.choice(["world", "moon", "x" * 100_000])
            message.header.stamp.sec = int(rng.integers(-(2**31), 2**31))
            message.pose.position.x = float(rng.choice([math.nan, 1e308, 1.0]))
            lab.publisher.publish(message)
    assert silent(lab) if model.paused else heard(lab) is None


def test_a_negative_stamp_is_said_and_the_node_lives(lab):
    message = PoseStamped()
    message.header.frame_id, message.header.stamp.sec = "world", -1
    for _ in range(200):
        lab.publisher.publish(message)
    assert lab.call(Load, f"{NAMESPACE}/load", **load_request(beating())).success
    heard(lab)


def test_live_control_does_not_wait_for_evaluations_or_births(lab):
    """While a long batch is computed, and a body that takes long to grow, an animat is paused, reset and let go."""
    assert lab.call(Load, f"{NAMESPACE}/load", **load_request(beating())).success
    long = task_message(with_settings(TASK, {"control_steps": 80_000}))
    evaluating = lab.node.create_client(Evaluate, f"{NAMESPACE}/evaluate")
    growing = lab.node.create_client(Load, f"{NAMESPACE}/load")
    lab.until(lambda: evaluating.service_is_ready() and growing.service_is_ready())
    batch = evaluating.call_async(Evaluate.Request(task=long, seed=1, genomes=[genome_message(beating())] * 4))
    large = with_settings(TASK, {"development.max_cells": 400, "development.steps": 3000})
    birth = growing.call_async(Load.Request(**load_request(beating(), large)))
    for data in (True, False, True):
        assert lab.call(SetBool, f"{NAMESPACE}/pause", data=data).success
        assert lab.call(Trigger, f"{NAMESPACE}/reset").success
    assert not batch.done()
    lab.until(lambda: batch.done() and birth.done())
    assert len(batch.result().evaluations) == 4 and birth.result().success
    answer = lab.call(Trigger, f"{NAMESPACE}/reset")  # at once, of a body of any size
    assert answer.success and "paused" not in answer.message


def test_without_a_clock_stamped_targets_say_so_and_others_count():
    namespace = f"{NAMESPACE}_clock"
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": 8})
    with simulators(namespace, arguments=["-p", "use_sim_time:=true", "-p", "target_age:=2"]) as [process], Operator() as operator:
        publisher = operator.node.create_publisher(PoseStamped, f"{namespace}/target_pose", 10)
        clock = operator.node.create_publisher(Clock, "/clock", 10)
        states = operator.listen(CellStates, f"{namespace}/cell_states", qos_profile_sensor_data)
        operator.until(lambda: publisher.get_subscription_count() and clock.get_subscription_count())
        message = PoseStamped()
        message.header.frame_id, message.header.stamp = "world", operator.node.get_clock().now().to_msg()
        publisher.publish(message)
        broken = Clock()
        broken.clock.sec = -1
        clock.publish(broken)  # rclpy's own callback makes no time of it
        assert operator.call(Load, f"{namespace}/load", **load_request(pulsing_smeller(), task)).success
        operator.until(lambda: len(states) > 5)
        process.terminate()
        _, stderr = process.communicate(timeout=WITHIN)
    assert "no /clock has come yet" in stderr and "in the future" not in stderr and "s ago" not in stderr and "Traceback" not in stderr
