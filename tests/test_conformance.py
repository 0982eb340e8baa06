"""The checks of the contract: a simulator passes them all, and each of twenty faults is found by the check that should."""

import json
import math
import subprocess
import sys
import threading

import numpy as np
import pytest
import rclpy
from evodevo_sim.live.animat import Animat
from evodevo_sim.nodes import living
from evodevo_sim.nodes.conformance import checks
from evodevo_sim.nodes.conformance.session import CHECKS, Session, examine
from evodevo_sim.nodes.simulator import Simulator
from evodevo_sim.parameters import default_task
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.topics import ACTUATION, BODY, EVENTS, STREAM
from genomes import pulsing
from lab import DEADLINE, simulators
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor

from evodevo_sim import champions, load_champion

assert checks  # they are in the table once their module is there


class Through:
    """A publisher that changes what it is given."""

    def __init__(self, publisher, change):
        self._publisher, self._change = publisher, change

    def publish(self, message):
        for one in self._change(message):
            self._publisher.publish(one)

    def get_subscription_count(self):
        return self._publisher.get_subscription_count()


def each(change):
    """A change of one message."""
    def changed(message):
        change(message)
        return [message]
    return changed


def on_states(change):
    return lambda node: setattr(node._living, "_states", Through(node._living._states, change))


def on_actuation(change):
    return lambda node: setattr(node._living, "_actuation", Through(node._living._actuation, change))


def on_body(change):
    return lambda node: setattr(node._living, "_body", Through(node._living._body, change))


def swapped():
    """Every twentieth state comes after the one that follows it."""
    waiting, count = [], [0]

    def changed(message):
        count[0] += 1
        if count[0] % 20 == 0:
            waiting.append(message)
            return []
        return [message, *(waiting.pop() for _ in range(len(waiting)))]
    return changed


def late(messages=()):
    """Commands come a step late: each has the activation of the one before."""
    last = list(messages)

    def changed(message):
        now, message.activation = message.activation, last[-1] if last else message.activation
        last.append(now)
        return [message]
    return changed


def by_rote(message):
    """A lost marker: its cell's position is missing, and it has a speed."""
    message.position_x[0] = message.position_y[0] = math.nan


def half(message):
    message.position_x[0] = math.nan


def backwards(message):
    message.velocity_x, message.velocity_y = [[-v for v in values] for values in (message.velocity_x, message.velocity_y)]


def strong(message):
    message.activation = [1.5 * np.sign(value) for value in message.activation]


def unstamped(message):
    message.header.stamp.sec = message.header.stamp.nanosec = 0


def elsewhere(message):
    message.header.frame_id = "camera"


def shorter(message):
    message.velocity_x = message.velocity_x[:-1]


def beyond(message):
    message.spring_a[0] = message.cells


def volatile(node):
    its = node._living
    node.destroy_publisher(its._body)
    its._body = node.create_publisher(BODY.type, "body", EVENTS.profile())


def best_effort(node):
    its = node._living
    node.destroy_publisher(its._actuation)
    its._actuation = node.create_publisher(ACTUATION.type, "actuation", STREAM.profile())


def no_evaluate(node):
    node.destroy_service(next(one for one in node.services if one.srv_name.endswith("evaluate")))


def credulous(node):
    """Takes whatever it is given for a genome."""
    node._living._make = lambda *_: Animat(pulsing(), default_task("swim"))
    node.patch.setattr(living, "genome_from_message", lambda message: None)


def patient(node):
    """Takes every pace."""
    right = node._living.stage.load
    node.patch.setattr(living, "check_pace", lambda pace: None)
    node._living.stage.load = lambda animat, pace: right(animat, 1.0)


def hasten(node):
    right = node._living.stage.load
    node._living.stage.load = lambda animat, pace: right(animat, 2.0 * pace)


def let_go(node):
    stage = node._living.stage
    stage.reset = lambda: stage.pause(False)


def blind(node):
    """A target that is no number reaches the muscles."""
    its = node._living
    its._states = Through(its._states, each(lambda message: setattr(message, "activation", [math.nan] * len(message.activation))))


# fault: (what is broken, the check that must name it)
FAULTS = {
    "no evaluate": (no_evaluate, "services"),
    "a volatile body": (volatile, "quality of body"),
    "best-effort commands": (best_effort, "quality of actuation"),
    "a body that names no cell": (on_body(each(beyond)), "body"),
    "short arrays": (on_states(each(shorter)), "arrays"),
    "swapped states": (on_states(swapped()), "steps in order"),
    "missing states": (on_states(lambda message: [message] if message.step % 2 else []), "steps in order"),
    "states without a stamp": (on_states(each(unstamped)), "stamps"),
    "another frame": (on_states(each(elsewhere)), "frame"),
    "half a position": (on_states(each(half)), "validity"),
    "a speed of what is lost": (on_states(each(by_rote)), "validity"),
    "speeds backwards": (on_states(each(backwards)), "velocities"),
    "activation beyond 1": (on_states(each(strong)), "activation"),
    "commands a step late": (on_actuation(late()), "actuation"),
    "missing commands": (on_actuation(lambda message: [message] if message.step % 3 else []), "actuation"),
    "a genome that is none": (credulous, "a malformed genome"),
    "a pace that is none": (patient, "an odd pace"),
    "a pause that is none": (lambda node: setattr(node._living.stage, "pause", lambda paused: True), "pause"),
    "a reset that is none": (lambda node: setattr(node._living.stage, "reset", lambda: True), "reset"),
    "a reset that lets go": (let_go, "reset while paused"),
    "twice the pace": (hasten, "pace"),
    "a target that is no number": (blind, "odd targets"),
}


@pytest.fixture
def node(monkeypatch):
    """A simulator in this process, spinning, in a namespace of its own."""
    stop = threading.Event()
    with loopback_alone():
        rclpy.init(args=["--ros-args", "-r", "__ns:=/broken"])
    made = Simulator(stop)
    made.patch = monkeypatch
    executor = EventsExecutor()
    executor.add_node(made)

    def spin():
        while not stop.is_set():
            try:
                executor.spin_once(timeout_sec=0.05)
            except ExternalShutdownException:
                return
            except Exception:
                continue  # as a fault has it

    thread = threading.Thread(target=spin)
    thread.start()
    yield made
    stop.set()
    thread.join()
    made.close()
    rclpy.try_shutdown()


def session():
    return Session("/broken", genome_message(pulsing()), task_message(default_task("swim")))


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_by_the_check_that_should(node, fault):
    break_it, named = FAULTS[fault]
    break_it(node)
    asking = session()
    asking.patience = 10.0
    try:
        finding, = examine(asking, [named])
    finally:
        asking.close()
    assert finding.outcome == "fail" and 0 < len(finding.seen) <= 300, finding


def test_a_simulator_passes_every_check(tmp_path):
    report = tmp_path / "report.json"
    with simulators("/sim_c"):
        command = [sys.executable, "-m", "evodevo_sim.commands.conform", "/sim_c", "--json", str(report)]
        command += ["--genome", str(champions()["undulator"])]
        done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 0, done.stdout + done.stderr
    findings = json.loads(report.read_text())["findings"]
    assert len(findings) == len(CHECKS) >= 25 and {one["outcome"] for one in findings} == {"pass", "not asked"}
    assert [one["name"] for one in findings if one["outcome"] == "not asked"] == [
        "channels", "diagnostics", "emergency stop", "command", "silence", "odd commands",
    ]
    assert load_champion("undulator")


def test_nobody_there_is_one_line_and_exit_code_2():
    command = [sys.executable, "-m", "evodevo_sim.commands.conform", "/nobody", "--patience", "3"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "nobody offers /nobody/load" in done.stderr
