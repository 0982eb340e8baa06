"""The simulator node over real DDS: the library's bits, a live animat, and a node that outlives any request."""

import math
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import rclpy
import yaml
from evodevo_sim.commands.request import main as request_main
from evodevo_sim.live.animat import Animat
from evodevo_sim.nodes.simulator import _seconds
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import evaluation_from_message, genome_message, task_message
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.ros.topics import BODY
from genomes import beating, dividing, first_viable, hand_made
from geometry_msgs.msg import PoseStamped
from lab import DEADLINE, Operator, simulators
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import SetBool, Trigger
from test_chemotaxis import pulsing_smeller

from evodevo_msgs.msg import Body, CellStates, Genome
from evodevo_msgs.msg import Task as TaskMessage
from evodevo_msgs.srv import Evaluate, Load
from evodevo_sim import ParameterError, Status, Task, evaluate, perform, random_genome, save_genome

NAMESPACE = f"/test_{os.getpid()}"
TASK = with_settings(Task(), {"development.max_cells": 8, "control_steps": 40})


@pytest.fixture(scope="module")
def lab():
    with simulators(NAMESPACE) as [process], Operator() as operator:
        operator.process = process
        yield operator
        assert process.poll() is None  # it outlived every request of this file


def ask(lab, genomes, task=TASK, seed=1, bars=()):
    return lab.call(Evaluate, f"{NAMESPACE}/evaluate", task=task_message(task), seed=seed, genomes=genomes, bars=bars)


def load(lab, genome, task=TASK, factor=0.0):
    request = dict(task=task_message(task), seed=1, genome=genome_message(genome), real_time_factor=factor)
    return lab.call(Load, f"{NAMESPACE}/load", **request)


def test_a_batch_gives_the_librarys_bits_in_order(lab):
    genomes = [random_genome(np.random.default_rng(i)) for i in range(12)] + first_viable(2)
    response = ask(lab, [genome_message(genome) for genome in genomes])
    assert response.error == ""
    assert [evaluation_from_message(e) for e in response.evaluations] == [evaluate(genome, TASK, 1) for genome in genomes]


def changed(task_part, **values):
    message = task_message(TASK)
    target = getattr(message, task_part) if task_part else message
    for name, value in values.items():
        setattr(target, name, value)
    return message


@pytest.mark.parametrize(
    "task, says",
    [
        (changed("", name="fly"), "task 'fly' is unknown: choose one of swim"),
        (changed("", control_step=float("nan")), "task.control_step is nan"),
        (changed("", control_steps=0), "task.control_steps is 0"),
        (changed("", windows=7), "task.windows is 7"),
        (changed("material", stiffness=-1.0), "material.stiffness is -1.0"),
        (changed("scene", drag_normal=float("inf")), "scene.drag_normal is inf"),
        (changed("development", variant="C"), "development.variant is 'C'"),
    ],
)
def test_a_task_that_cannot_work_is_named(lab, task, says):
    response = lab.call(Evaluate, f"{NAMESPACE}/evaluate", task=task, seed=1, genomes=[genome_message(hand_made())])
    assert says in response.error and "\n" not in response.error and not response.evaluations


@pytest.mark.parametrize("name", ["", "swim"])
def test_a_task_of_zeros_in_a_request_is_the_default_one(lab, name):
    genome = first_viable(1)[0]
    response = lab.call(Evaluate, f"{NAMESPACE}/evaluate", task=TaskMessage(name=name), seed=1, genomes=[genome_message(genome)])
    assert response.error == "" and evaluation_from_message(response.evaluations[0]) == evaluate(genome, Task(), 1)
    assert lab.call(Load, f"{NAMESPACE}/load", task=TaskMessage(name=name), genome=genome_message(genome)).success


def test_a_task_filled_in_part_is_checked_and_never_completed(lab):
    for task, says in (
        (TaskMessage(name="fly"), "task 'fly' is unknown"), (TaskMessage(name="f" * 10_000), "is unknown"),
        (TaskMessage(control_steps=40), "development.max_cells is 0"),
        (TaskMessage(name="swim", control_steps=40), "development.max_cells is 0"),
        (TaskMessage(name="walk", control_step=float("nan")), "is"),
    ):
        answer = lab.call(Load, f"{NAMESPACE}/load", task=task, genome=genome_message(dividing()))
        assert not answer.success and says in answer.message and len(answer.message) <= 300


def filled(message, values):
    """A message with the fields that a request's YAML names, as `ros2 service call` fills it."""
    for name, value in values.items():
        kind = message.get_fields_and_field_types()[name]
        if isinstance(value, dict):
            filled(getattr(message, name), value)
        elif kind.startswith("sequence<evodevo"):
            setattr(message, name, [filled(Genome(), one) for one in value])
        else:
            setattr(message, name, value)
    return message


def test_what_the_request_command_prints_is_taken(lab, tmp_path, capsys):
    genome = first_viable(1)[0]
    save_genome(tmp_path / "genome.yaml", genome)
    for more, service, task in (
        ([], "load", Task()), (["--set", "development.max_cells=8"], "load", None), (["--service", "evaluate"], "evaluate", Task()),
    ):
        assert request_main([str(tmp_path / "genome.yaml"), *more]) == 0
        text = capsys.readouterr().out
        kind = {"load": Load, "evaluate": Evaluate}[service]
        request = filled(kind.Request(), yaml.safe_load(text))
        answer = lab.call(kind, f"{NAMESPACE}/{service}", **{name: getattr(request, name) for name in request.get_fields_and_field_types()})
        if service == "load":
            assert answer.success and (task is None or "name: swim}" in text)
        else:
            assert evaluation_from_message(answer.evaluations[0]) == evaluate(genome, task)
    for arguments in (["--service", "pause"], ["--real-time-factor", "nan"], ["--task", "x" * 1000]):
        with pytest.raises(SystemExit) as left:
            request_main([str(tmp_path / "genome.yaml"), *arguments])
        said = capsys.readouterr().err
        assert left.value.code == 2 and said.count("\n") == 1 and len(said) <= 301


@pytest.mark.parametrize("count", [0, 100_000])
def test_a_batch_of_an_impossible_size_is_refused(lab, count):
    response = ask(lab, [Genome()] * count)
    assert response.error == f"{count} genomes in a request: give 1 to 1000" and not response.evaluations


def test_bars_stop_lives_and_bad_ones_are_refused(lab):
    genomes, task = [genome_message(beating())] * 3, with_settings(Task(), {"control_steps": 200})
    whole = evaluate(beating(), task)
    answer = ask(lab, genomes, task, 0, [-math.inf, whole.fitness, 1e9])
    found = [evaluation_from_message(one) for one in answer.evaluations]
    assert found == [whole, whole, evaluate(beating(), task, 0, 1e9)] and found[2].status == Status.STOPPED
    for bars, fault in (([1.0], "1 bars for 3 genomes"), ([0.0, math.nan, 0.0], "bars[1] is not a number")):
        refused = ask(lab, genomes, bars=bars)
        assert refused.error.startswith(fault) and not refused.evaluations


def test_a_malformed_genome_fails_alone(lab):
    good, nan, cut = (genome_message(dividing()) for _ in range(3))
    nan.x[3] = float("nan")
    cut.kind = cut.kind[:5]
    response = ask(lab, [nan, good, cut, Genome()])
    assert [e.status for e in response.evaluations] == [Status.INVALID_GENOME, Status.OK, Status.INVALID_GENOME, Status.INVALID_GENOME] or (
        response.evaluations[1].status == Status.RESTING
    )
    assert "element 3: point is not finite" in response.evaluations[0].cause
    assert "equal numbers" in response.evaluations[2].cause
    assert all(e.fitness < -1 for e in response.evaluations if e.status == Status.INVALID_GENOME)


def since_birth(states):
    """Where the states of the newest animat begin: before them there may be some of who lived on the simulator before."""
    return max((i for i, message in enumerate(states) if message.step == 0), default=len(states))


def test_a_live_animat_is_the_performance_step_by_step(lab):
    genome = first_viable(1)[0]
    task = with_settings(TASK, {"control_steps": 400})
    performance = perform(genome, task, 1)
    states = lab.listen(CellStates, f"{NAMESPACE}/cell_states", qos_profile_sensor_data)
    lab.until(lambda: lab.node.count_publishers(f"{NAMESPACE}/cell_states"))
    assert load(lab, genome, task, factor=1.0).success
    lab.until(lambda: any(message.step > 60 for message in states[since_birth(states) :]))
    lab.call(SetBool, f"{NAMESPACE}/pause", data=True)
    del states[: since_birth(states)]
    for message in states:
        k = message.step
        assert message.header.frame_id == "world"
        assert message.header.stamp.sec + message.header.stamp.nanosec * 1e-9 == pytest.approx(k / 60, abs=1e-8)
        assert np.array_equal(np.column_stack((message.position_x, message.position_y)), performance.position[k])
        assert np.array_equal(np.column_stack((message.velocity_x, message.velocity_y)), performance.velocity[k])
        if k:
            assert np.array_equal(message.activation, performance.activation[k])
    assert [m.step for m in states] == sorted({m.step for m in states})


def test_the_body_is_latched_for_who_comes_late(lab):
    genome = first_viable(1)[0]
    assert load(lab, genome, factor=0.01).success
    bodies = lab.listen(Body, f"{NAMESPACE}/body", BODY.quality)
    lab.until(lambda: bodies)
    body = perform(genome, TASK, 1).body
    assert bodies[-1].cells == len(body.position) and np.array_equal(bodies[-1].rest_length, body.rest_length)
    assert len(bodies[-1].chamber_area) == len(body.triangle_area) + len(body.polygon_area)
    assert bodies[-1].chamber_start[-1] == len(bodies[-1].chamber_cell)


def test_pause_holds_and_reset_goes_back_to_birth(lab):
    states = lab.listen(CellStates, f"{NAMESPACE}/cell_states", qos_profile_sensor_data)
    assert load(lab, first_viable(1)[0], factor=2.0).success
    lab.call(SetBool, f"{NAMESPACE}/pause", data=False)
    lab.until(lambda: states and states[-1].step > 5)
    assert lab.call(SetBool, f"{NAMESPACE}/pause", data=True).success
    last = states[-1].step
    assert lab.call(Trigger, f"{NAMESPACE}/reset").success
    lab.until(lambda: states[-1].step == 0)
    assert max(message.step for message in states) - last < 30  # only what was under way
    assert lab.call(SetBool, f"{NAMESPACE}/pause", data=False).success
    lab.until(lambda: states[-1].step > 5)


@pytest.mark.parametrize(
    "genome, factor, says",
    [
        (hand_made(), 1.0, "the egg never divided"),
        (dividing(), -1.0, "real_time_factor is -1.0"),
        (dividing(), float("nan"), "real_time_factor is nan"),
    ],
)
def test_what_cannot_live_is_refused_and_the_live_one_goes_on(lab, genome, factor, says):
    states = lab.listen(CellStates, f"{NAMESPACE}/cell_states", qos_profile_sensor_data)
    assert load(lab, first_viable(1)[0], factor=1.0).success
    response = load(lab, genome, factor=factor)
    assert not response.success and says in response.message
    lab.call(SetBool, f"{NAMESPACE}/pause", data=False)
    count = len(states)
    lab.until(lambda: len(states) > count + 5)


def pose(x, y=0.0, frame="world", sec=0):
    message = PoseStamped()
    message.header.frame_id, message.header.stamp.sec = frame, sec
    message.pose.position.x, message.pose.position.y = x, y
    return message


def test_a_live_animat_follows_the_last_good_target_whatever_else_comes():
    """Its life is that of an animat that got the target at one step, through bad targets of every kind and a flood of them."""
    namespace = f"{NAMESPACE}_targets"
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": 8})
    with simulators(namespace) as [process], Operator() as operator:
        publisher = operator.node.create_publisher(PoseStamped, f"{namespace}/target_pose", 1)
        states = operator.listen(CellStates, f"{namespace}/cell_states", qos_profile_sensor_data)
        operator.until(lambda: publisher.get_subscription_count() and operator.node.count_publishers(f"{namespace}/cell_states"))
        request = dict(task=task_message(task), seed=1, genome=genome_message(pulsing_smeller()), real_time_factor=1.0)
        assert "instead" not in operator.call(Load, f"{namespace}/load", **request).message
        operator.until(lambda: states and states[-1].step > 5)
        for k in range(1000):
            publisher.publish(pose(0.01 * k, 5.0))
        good, now = pose(3.0, 1.0), operator.node.get_clock().now().to_msg()
        good.header.stamp = now  # to the nanosecond: a target of a second ago is too old
        publisher.publish(good)
        asked = states[-1].step
        operator.until(lambda: states[-1].step > asked + 60)
        for bad in (
            pose(float("nan")),
            pose(1.0, float("inf")),
            pose(1.0, frame="moon"),
            pose(1.0, frame=""),
            pose(1.0, sec=1),
            pose(1.0, sec=-1),
            pose(1.0, sec=now.sec + 1000),
        ):
            publisher.publish(bad)
            asked = states[-1].step
            operator.until(lambda asked=asked: states[-1].step > asked + 5)
        assert "instead" in operator.call(Load, f"{namespace}/load", **request).message  # and the target stays
        operator.until(lambda: 30 <= states[-1].step < asked)
        process.terminate()
        _, stderr = process.communicate(timeout=DEADLINE)
    second = next(k for k in range(1, len(states)) if states[k].step < states[k - 1].step)
    animat = Animat(pulsing_smeller(), task)
    animat.target = (3.0, 1.0)
    seen = {message.step: message for message in states[second:]}
    for step in range(31):
        if step in seen:
            assert np.array_equal(np.column_stack((seen[step].position_x, seen[step].position_y)), animat.position)
        animat.step()
    for says in ("(nan, 0.0) ignored", "frame 'moon' ignored", "s ago ignored", "in the future ignored", "stamp of -1 s ignored"):
        assert says in stderr


def test_nobody_to_pause_is_said():
    with simulators(f"{NAMESPACE}_empty"), Operator() as operator:
        for service, name in ((SetBool, "pause"), (Trigger, "reset")):
            response = operator.call(service, f"{NAMESPACE}_empty/{name}")
            assert not response.success and "load one first" in response.message


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_good_order_even_in_a_long_batch(number):
    namespace = f"{NAMESPACE}_{int(number)}"
    with simulators(namespace) as [process], Operator() as operator:
        client = operator.node.create_client(Evaluate, f"{namespace}/evaluate")
        operator.until(client.service_is_ready)
        long = task_message(with_settings(TASK, {"control_steps": 1_000_000}))
        future = client.call_async(Evaluate.Request(task=long, genomes=[genome_message(beating())] * 4))
        for _ in range(5):
            operator.executor.spin_once(timeout_sec=0.05)
        assert not future.done()
        process.send_signal(number)
        _, stderr = process.communicate(timeout=20)
        assert process.returncode == 0 and "Traceback" not in stderr


def test_nodes_stay_on_this_host_unless_told_otherwise(monkeypatch):
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE")
    monkeypatch.delenv("FASTRTPS_DEFAULT_PROFILES_FILE")
    monkeypatch.setattr(os, "environ", os.environ.copy())
    stay_on_this_host()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert os.path.exists(os.environ.pop("FASTRTPS_DEFAULT_PROFILES_FILE"))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"  # a network is not for our rhythm
    stay_on_this_host()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET" and "FASTRTPS_DEFAULT_PROFILES_FILE" not in os.environ
    os.environ |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "FASTRTPS_DEFAULT_PROFILES_FILE": "own.xml"}
    stay_on_this_host()
    assert os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] == "own.xml"


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--speed"], "--speed"),
        (["--ros-args", "-p", "max_batch:=0"], "max_batch"),
        (["--ros-args", "-p", "publish_every:=often"], "publish_every"),
        (["--ros-args", "-r", "__ns:=no good"], "no good"),
        (["--ros-args", "-p", "target_age:=nan"], "target_age is nan"),
        (["--ros-args", "-p", "frame_id:=''"], "frame_id is empty"),
    ],
)
def test_bad_arguments_get_one_line_and_exit_code_2(arguments, says):
    command = [sys.executable, "-m", "evodevo_sim.commands.simulator", *arguments]
    result = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
    assert result.returncode == 2 and says in result.stderr, result.stderr
    assert [line.partition(":")[0] for line in result.stderr.splitlines() if not line.startswith("[WARN]")] == ["simulator"]


@pytest.mark.parametrize(
    "value, says", [(-1, "is -1"), (math.inf, "is inf"), (True, "is True"), ("soon", "is 'soon'"), (1e10, "is 1"), (-0.1, "is -0.1")]
)
def test_a_time_that_cannot_be_is_refused_by_name(value, says):
    with Operator() as operator:
        node = rclpy.create_node("timed", context=operator.context, parameter_overrides=[rclpy.Parameter("target_age", value=value)])
        with pytest.raises(ParameterError, match=f"target_age {says}"):
            _seconds(node, "target_age", 1.0, "s")
        whole = rclpy.create_node("whole", context=operator.context, parameter_overrides=[rclpy.Parameter("target_age", value=2)])
        assert _seconds(whole, "target_age", 1.0, "s") == 2.0
        node.destroy_node()
        whole.destroy_node()
