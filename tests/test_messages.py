"""Between objects and messages: not a bit is lost, and no field of one is missing in the other."""

import dataclasses
import re

import numpy as np
import pytest
from evodevo_sim.parameters import Chemotaxis, Noise
from evodevo_sim.ros.messages import (
    body_message,
    cell_states_message,
    evaluation_from_message,
    evaluation_message,
    genome_from_message,
    genome_message,
    task_from_message,
    task_message,
    time_message,
)
from evodevo_sim.tasks.outcome import Steering
from genomes import first_viable, random_genomes
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from evodevo_ga import Generation, Settings
from evodevo_msgs import msg
from evodevo_sim import Development, Evaluation, Material, Metrics, ParameterError, Scene, Status, Task, perform

finite = st.floats(allow_nan=False, allow_infinity=False)


def over_the_wire(message):
    return deserialize_message(serialize_message(message), type(message))


@given(random_genomes())
def test_a_genome_keeps_its_bits(genome):
    assert genome_from_message(over_the_wire(genome_message(genome))) == genome


@given(st.integers(1, 4096), st.floats(1e-3, 1.0), st.floats(0, 1e6), st.sampled_from(["continual_graph", "graph_at_end"]))
def test_a_task_keeps_its_bits(cells, rate, drag, variant):
    task = Task(development=Development(max_cells=cells, regulation_rate=rate, variant=variant), scene=Scene(drag_normal=drag))
    assert task_from_message(over_the_wire(task_message(task))) == task


@given(finite, st.sampled_from(list(Status)), finite, st.integers(0, 2**32 - 1))
def test_an_evaluation_keeps_its_bits(fitness, status, distance, cells):
    evaluation = Evaluation(fitness, status, "why", Metrics(cells=cells, distance=distance))
    assert evaluation_from_message(over_the_wire(evaluation_message(evaluation))) == evaluation


def test_an_unknown_status_is_refused():
    with pytest.raises(ValueError, match="99"):
        evaluation_from_message(msg.Evaluation(status=99))


def test_statuses_are_those_of_kernels_and_physics():
    from evodevo_sim.physics import soundness
    from evodevo_sim.plant import Outcome
    from evodevo_sim.tasks import ends

    assert {status.name: int(status) for status in Status} == {
        name: value for name, value in vars(ends).items() if name.isupper() and isinstance(value, int) and name != "TURNED_INSIDE_OUT"
    }
    assert [Outcome.SOUND, Outcome.UNSTABLE, Outcome.INVERTED] == [soundness.SOUND, soundness.UNSTABLE, soundness.INVERTED]
    assert [ends.end_of(how) for how in (soundness.UNSTABLE, soundness.INVERTED)] == [Status.UNSTABLE, Status.INVERTED]


def test_statuses_have_the_numbers_of_the_message():
    assert {status.name: int(status) for status in Status} == {
        name: value for name in dir(msg.Evaluation) if name.isupper() and isinstance(value := getattr(msg.Evaluation, name), int)
    }


@pytest.mark.parametrize(
    "cls, message, without",
    [
        (Task, msg.Task, set()), (Development, msg.Development, set()), (Material, msg.Material, set()), (Scene, msg.Scene, set()),
        (Noise, msg.Noise, set()), (Chemotaxis, msg.Chemotaxis, set()), (Steering, msg.Steering, set()),
        (Metrics, msg.Metrics, set()), (Settings, msg.Evolution, {"version", "task", "seed", "start", "scheme"}),
        (Generation, msg.GenerationStatistics, {"stamp", "evaluations_per_second"}),
    ],
)
def test_dataclasses_and_messages_have_the_same_fields(cls, message, without):
    ours = {re.sub("^(ground|ceiling)_[xy]$", r"\1", field.name) for field in dataclasses.fields(cls)} - {"improved"}
    assert ours == set(message.get_fields_and_field_types()) - without


def test_an_empty_task_message_is_refused_by_name():
    with pytest.raises(ParameterError, match="development"):
        task_from_message(msg.Task())


@given(st.floats(0, 1e9))
def test_stamps_are_whole_nanoseconds(seconds):
    stamp = time_message(seconds)
    assert 0 <= stamp.nanosec < 10**9
    assert stamp.sec + stamp.nanosec * 1e-9 == pytest.approx(seconds, abs=1e-6)


def test_a_body_and_its_cells_arrive_whole():
    performance = perform(first_viable(1)[0])
    body = performance.body
    message = over_the_wire(body_message(body))
    assert message.cells == len(body.position) and np.array_equal(message.rest_length, body.rest_length)
    rest = [np.linalg.norm(body.position[a] - body.position[b]) for a, b in zip(message.spring_a, message.spring_b)]
    assert message.rest_length.tolist() == pytest.approx(rest)
    for k, area in enumerate(message.chamber_area):
        x, y = body.position[message.chamber_cell[message.chamber_start[k] : message.chamber_start[k + 1]]].T
        assert 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) == pytest.approx(area)
    position, velocity, activation = performance.position[7], performance.velocity[7], performance.activation[7]
    states = over_the_wire(cell_states_message(position, velocity, activation, 7, 0.5))
    assert np.array_equal(np.column_stack((states.position_x, states.position_y)), position)
    assert np.array_equal(np.column_stack((states.velocity_x, states.velocity_y)), velocity)
    assert np.array_equal(states.activation, activation) and states.step == 7
