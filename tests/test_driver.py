"""The driver as a node in the simulator's place, on a body that is emulated behind a pseudo-terminal: processes over DDS."""

import subprocess
import sys
from contextlib import ExitStack

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.topics import ACTUATION, BODY, CELL_STATES, CHANNELS, COMMAND_STREAM
from lab import DEADLINE, Operator
from rclpy.qos import qos_profile_sensor_data
from rigs import GENOME, driver, rig
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.msg import Actuation
from evodevo_msgs.srv import Evaluate, Load
from evodevo_sim import champions, load_champion


@pytest.fixture(scope="module")
def eel(tmp_path_factory):
    """(calibration, what the driver says, an operator) of a body to which nothing happens, with JointState too."""
    with ExitStack() as stack:
        link, calibration, _ = stack.enter_context(rig(tmp_path_factory.mktemp("eel")))
        said = stack.enter_context(driver(link, calibration, "-p", "joints:=true"))
        yield calibration, said, stack.enter_context(Operator())


@pytest.fixture
def free(eel):
    """The same, with nobody on the body."""
    operator = eel[2]
    assert operator.call(Trigger, "/eel/stop").success and operator.call(Trigger, "/eel/arm").success
    return eel


def loaded(operator, name=GENOME, namespace="/eel"):
    genome, task = genome_message(load_champion(name)), task_message(default_task("swim"))
    return operator.call(Load, f"{namespace}/load", task=task, genome=genome, real_time_factor=1.0)


def test_an_animat_lives_on_hardware_as_it_does_in_a_simulator(free):
    _, _, operator = free
    bodies = operator.listen(BODY.type, "/eel/body", BODY.quality)
    states = operator.listen(CELL_STATES.type, "/eel/cell_states", CELL_STATES.quality)
    actuation = operator.listen(ACTUATION.type, "/eel/actuation", ACTUATION.quality)
    channels = operator.listen(CHANNELS.type, "/eel/channels", CHANNELS.quality)
    diagnostics = operator.listen(DiagnosticArray, "/diagnostics", 10)
    answer = loaded(operator)
    assert answer.success, answer.message
    cells = operator.until(lambda: bodies and bodies[-1].cells)
    operator.until(lambda: len(states) > 150 and len(actuation) > 100)
    assert channels[-1].name and list(channels[-1].channel) == list(range(cells))
    last = states[-1]
    assert len(last.position_x) == len(last.activation) == cells and np.isfinite(last.position_x).all()
    steps = np.diff([state.step for state in states])
    assert (steps > 0).all()
    # It swims: the muscles that the network drives carry the body away from where it was born.
    far = np.hypot(np.mean(last.position_x) - np.mean(states[0].position_x), np.mean(last.position_y) - np.mean(states[0].position_y))
    assert far > 0.3
    operator.until(lambda: diagnostics and any("health" in value.key for value in diagnostics[-1].status[0].values))
    assert operator.call(SetBool, "/eel/pause", data=True).success
    assert operator.call(Trigger, "/eel/reset").success
    assert operator.call(SetBool, "/eel/pause", data=False).success
    seen = len(states)
    operator.until(lambda: len(states) > seen + 20)
    assert operator.call(Trigger, "/eel/stop").success
    operator.until(lambda: diagnostics[-1].status[0].message.startswith("emergency stop"))
    assert diagnostics[-1].status[0].level == b"\x02"
    assert operator.call(Trigger, "/eel/arm").success
    assert loaded(operator).success
    seen = len(states)
    operator.until(lambda: len(states) > seen + 20)


def test_another_body_and_what_is_no_task_are_refused(free):
    _, _, operator = free
    answer = loaded(operator, name="peristalsis")
    assert (not answer.success and "m from where the body" in answer.message) or "cells, and the body" in answer.message
    walk = operator.call(
        Evaluate, "/eel/evaluate", task=task_message(default_task("walk")), genomes=[genome_message(load_champion(GENOME))],
    )
    assert "cannot be evaluated on hardware" in walk.error and not walk.evaluations


def test_hardware_evaluates_genomes_of_its_body(free):
    task = with_settings(default_task("swim"), {"control_steps": 240})
    _, _, operator = free
    genomes = [genome_message(load_champion(name)) for name in (GENOME, "peristalsis")]
    answer = operator.call(Evaluate, "/eel/evaluate", task=task_message(task), genomes=genomes)
    assert answer.error == "" and len(answer.evaluations) == 2
    fits, other = answer.evaluations
    assert fits.status == 0 and fits.metrics.distance > 0.2 and fits.fitness > 0.0 and fits.metrics.chambers > 0
    assert other.status != 0 and other.fitness < 0.0 and "the body" in other.cause


def test_commands_of_your_own_brain_are_limited_and_time_out(free):
    calibration, said, operator = free
    diagnostics = operator.listen(DiagnosticArray, "/diagnostics", 10)
    publisher = operator.node.create_publisher(Actuation, "/eel/command", COMMAND_STREAM.quality)
    operator.until(publisher.get_subscription_count)
    operator.until(lambda: diagnostics)
    cells = len(load_cells(calibration))
    def healthy(name):
        return any(v.key == "health" and v.value == name for v in diagnostics[-1].status[0].values)

    def streaming():
        publisher.publish(Actuation(activation=[0.5] * cells))
        return healthy("FINE")

    operator.until(streaming)
    operator.until(lambda: healthy("STALE") or healthy("VENTED"))

    def refused(odd, says):
        publisher.publish(odd)
        return says in said()

    operator.until(lambda: refused(Actuation(activation=[0.5]), "a command for 1 cells ignored"))
    operator.until(lambda: refused(Actuation(activation=[float("nan")] * cells), "not finite ignored"))
    operator.until(streaming)


def test_ros2_control_drives_it_by_joint_states(free):
    """As joint_state_topic_hardware_interface does: commands name joints in any order, positions alone, and NaN before it has a command;
    states are looked up by name."""
    calibration, _, operator = free
    states = operator.listen(JointState, "/eel/joint_states", qos_profile_sensor_data)
    publisher = operator.node.create_publisher(JointState, "/eel/joint_commands", 1)
    operator.until(publisher.get_subscription_count)
    cells = len(load_cells(calibration))
    asked = {f"cell_{i}": 0.5 - i / cells for i in reversed(range(cells))}

    def there():
        publisher.publish(JointState(name=list(asked), position=list(asked.values())))
        found = dict(zip(states[-1].name, states[-1].position)) if states else {}
        return found.keys() == asked.keys() and all(abs(found[name] - asked[name]) < 1e-3 for name in asked)

    operator.until(there)
    assert len(states[-1].effort) == cells and not states[-1].velocity
    publisher.publish(JointState(name=["cell_0"], position=[float("nan")]))
    publisher.publish(JointState(name=["elbow"], position=[0.0]))
    publisher.publish(JointState(name=["cell_0"], position=[]))
    operator.until(there)


def test_the_driver_keeps_the_contract(free):
    """Without an evaluation, which another test tries, and what takes long in real time."""
    only = ["services", "topics", "quality of body", "a malformed genome", "load", "arrays", "stamps", "validity", "velocities"]
    only += ["actuation", "channels", "diagnostics", "emergency stop", "command", "silence", "odd commands"]
    command = [sys.executable, "-m", "evodevo_sim.commands.conform", "/eel", "--genome", str(champions()[GENOME]), "--only", *only]
    done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
    says = f"{len(only)} checks: {len(only)} passed, 0 failed, 0 not asked"
    assert done.returncode == 0 and says in done.stdout, done.stdout + done.stderr


def load_cells(calibration):
    from evodevo_sim.hardware.calibration import load_calibration

    return load_calibration(calibration).channel


@pytest.mark.parametrize("fault, name", [("unplug 0.5", "UNPLUGGED"), ("restart", "VENTED"), ("silence 0.5", "SILENT")])
def test_the_node_outlives_what_happens_to_the_body(tmp_path, fault, name):
    with rig(tmp_path) as (link, calibration, emulated), driver(link, calibration, namespace="/ray"), Operator() as operator:
        diagnostics = operator.listen(DiagnosticArray, "/diagnostics", 100)
        states = operator.listen(CELL_STATES.type, "/ray/cell_states", CELL_STATES.quality)
        assert loaded(operator, namespace="/ray").success
        operator.until(lambda: len(states) > 10 and diagnostics)
        emulated.hear(fault)
        own = str(link)
        operator.until(lambda: name in {
            v.value for m in diagnostics if m.status[0].hardware_id == own for v in m.status[0].values if v.key == "health"
        })
        lived = len(states)
        operator.until(lambda: len(states) > lived + 60)
        assert (np.diff([state.step for state in states]) > 0).all()  # the same life goes on


@pytest.mark.parametrize("arguments, says", [
    (("--port", "/dev/null", "--calibration", "{}"), "/dev/null"),
    (("--port", "{}/none", "--calibration", "{}"), "there is no such port"),
    (("--port", "{}/none", "--calibration", "{}/none.yaml"), "No such file"),
])
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, arguments, says):
    with rig(tmp_path) as (_, calibration, _):
        pass
    given = [str(calibration) if argument == "{}" else argument.replace("{}", str(tmp_path)) for argument in arguments]
    command = [sys.executable, "-m", "evodevo_sim.commands.driver", *given]
    process = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=DEADLINE)
    out = process.stdout
    assert process.returncode == 2 and says in out and len(out.strip().splitlines()) == 1, out
