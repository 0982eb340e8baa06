"""What the muscles are told, on its topic: every control step for whoever listens, nothing for nobody, and in the recording of a chase."""

import os
import threading

import numpy as np
import pytest
from evodevo_sim.live.animat import Animat, Stage
from evodevo_sim.nodes import living as node
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.topics import ACTUATION, CELL_STATES, COMMAND, STREAM, Quality
from genomes import first_viable
from lab import Operator, simulators
from test_chase import SMALL, run
from test_chemotaxis import pulsing_smeller

from evodevo_msgs.srv import Load
from evodevo_sim import Task, perform, save_genome

NAMESPACE = f"/actuation_{os.getpid()}"
TASK = with_settings(Task(), {"development.max_cells": 12})
STEPS = 60
EVERY = Quality("every", reliable=True, latched=False, depth=1000).profile()  # for who keeps what it has no time for yet


@pytest.fixture(scope="module")
def lab():
    """A simulator that shows cells every seventh step, and an operator."""
    with simulators(NAMESPACE, arguments=["-p", "publish_every:=7"]), Operator() as operator:
        yield operator


@pytest.fixture(scope="module")
def smeller(tmp_path_factory):
    path = tmp_path_factory.mktemp("genomes") / "smeller.yaml"
    save_genome(path, pulsing_smeller())
    return path


def load(lab, genome, task, factor=1.0, seed=1):
    request = {"task": task_message(task), "seed": seed, "genome": genome_message(genome), "real_time_factor": factor}
    assert lab.call(Load, f"{NAMESPACE}/load", **request).success


def listen(lab, topic, quality=None):
    heard = lab.listen(topic.type, topic.at(NAMESPACE), quality or topic.quality)
    lab.until(lambda: lab.node.count_publishers(topic.at(NAMESPACE)))
    return heard


def test_each_control_step_tells_what_the_network_asks_and_cells_come_of_it(lab):
    """Noise of actuation comes after: the activation is that of the network, to the last bit.  Cells are shown more rarely."""
    genome = first_viable(1)[0]
    task = with_settings(TASK, {"noise.actuation": 0.1, "control_steps": 400})
    performance = perform(genome, task, 1)
    told, states = listen(lab, ACTUATION, EVERY), listen(lab, CELL_STATES)
    load(lab, genome, task)
    lab.until(lambda: len(told) > STEPS and len(states) > 3)
    steps = [message.step for message in told]
    assert steps == sorted(set(steps)) and steps[0] >= 1
    # Loopback loses nothing: at the most some steps before the listener was known are missing.
    assert len(steps) >= 0.9 * (steps[-1] - steps[0] + 1)
    for message in told:
        assert np.array_equal(message.activation, performance.activation[message.step])
        seconds = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        assert seconds == pytest.approx(message.step * task.control_step, abs=1e-8) and message.header.frame_id == "world"
    seen = {message.step: message for message in told}
    common = [state for state in states if state.step in seen]
    assert common and all(state.header == seen[state.step].header for state in common)
    assert all(np.array_equal(state.activation, seen[state.step].activation) for state in common)
    assert {state.step % 7 for state in states} == {0}


def test_who_asks_for_best_effort_hears_it_too(lab):
    told = listen(lab, ACTUATION, STREAM.profile())
    assert not COMMAND.latched and COMMAND.reliable
    load(lab, first_viable(1)[0], TASK)
    lab.until(lambda: len(told) > 5)


def test_where_nobody_listens_no_message_is_made(monkeypatch):
    """The node's own callback, driven by a stage, with a publisher that is heard from one step on."""
    made, heard, asked = [], threading.Event(), threading.Event()

    class Publisher:
        def get_subscription_count(self):
            asked.set()
            return int(heard.is_set())

        def publish(self, message):
            made.append(message)

    class Node:
        _actuation, _frame = Publisher(), "leg"

    def counted(*arguments):
        assert heard.is_set(), "a message is made for nobody"
        return right(*arguments)

    right = node.actuation_message
    monkeypatch.setattr(node, "actuation_message", counted)
    animat, stopped = Animat(first_viable(1)[0], TASK), []
    for step in range(1, 9):
        if step == 5:
            heard.set()
        animat.step()
        node.Living.act(Node, animat)
    assert [message.step for message in made] == [5, 6, 7, 8] and made[0].header.frame_id == "leg"
    heard.clear()
    asked.clear()
    stage = Stage(lambda animat: None, stopped.append, 1, lambda animat: node.Living.act(Node, animat))
    try:
        stage.load(animat, 0.0)
        assert asked.wait(20.0)
    finally:
        stage.close()
    assert not stopped and len(made) == 4


def test_a_chase_records_what_the_muscles_were_told(smeller, tmp_path):
    (tmp_path / "path.csv").write_text("x,y\n40,0\n")
    arguments = [*SMALL[:-1], "1"]  # at the pace of life, which nobody misses a step of
    code, _, stderr = run(smeller, "--targets", tmp_path / "path.csv", "--capture", 1, "--each", 1.5, "--out", tmp_path / "bag", *arguments)
    assert code == 0, stderr
    recording = read_recording(tmp_path / "bag")
    assert not recording.notes and len(recording.actuation) > 60
    steps = [message.step for message in recording.actuation]
    assert steps == sorted(set(steps))
    states = {state.step: state for state in recording.states}
    both = [message for message in recording.actuation if message.step in states]
    assert len(both) > 60
    assert all(message.activation == states[message.step].activation for message in both)


def test_a_chase_on_a_simulator_where_another_animat_lives_is_of_its_own_alone(smeller, tmp_path):
    namespace = f"{NAMESPACE}_lived"
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": 12})
    with simulators(namespace), Operator() as operator:
        told = operator.listen(ACTUATION.type, ACTUATION.at(namespace), ACTUATION.quality)
        request = {"task": task_message(task), "seed": 1, "genome": genome_message(pulsing_smeller()), "real_time_factor": 4.0}
        answer = operator.call(Load, f"{namespace}/load", **request)
        assert answer.success and "12 cells" in answer.message
        operator.until(lambda: told and told[-1].step > 100)
        code, out, stderr = run(smeller, "--simulator", namespace, "--count", 1, "--each", 0.5, "--out", tmp_path / "bag", *SMALL[:-1], "1")
    assert code == 0 and "of 1 targets" in out, stderr
    recording = read_recording(tmp_path / "bag")
    for messages in (recording.actuation, recording.states):
        assert messages[0].step < 10 and messages[-1].step < 60
        assert {len(message.activation) for message in messages} == {8}
