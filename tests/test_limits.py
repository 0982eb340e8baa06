"""What a request asks is looked at by lengths and numbers alone: nothing of its size is converted or evaluated before."""

import dataclasses

import numpy as np
import pytest
from evodevo_sim.genetics.limits import MAX_ELEMENTS
from evodevo_sim.nodes.limits import PARAMETERS, Limits
from evodevo_sim.parameters import ParameterError, default_task, with_settings
from evodevo_sim.profiles import MOST_POINTS
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.task_kinds import names
from evodevo_sim.tasks.cost import seconds_of, steps_of
from genomes import beating
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Genome, GenomeError, Task

LIMITS = Limits(**{name: default for name, (default, *_) in PARAMETERS.items()})


class Sized:
    """Stands for an array of any length: it can be asked for that, and for nothing else."""

    def __init__(self, length):
        self._length = length

    def __len__(self):
        return self._length

    def __getitem__(self, place):
        if place == slice(None, 0):
            return ()
        raise AssertionError("what is too long was read")

    __array__ = __iter__ = property(lambda self: self[0])


class Message:
    def __init__(self, **fields):
        self.__dict__.update(fields)


def of(elements):
    return Message(kind=Sized(elements), sign=Sized(elements), x=Sized(elements), y=Sized(elements))


def message(**values):
    return task_message(with_settings(default_task("swim"), values))


SMALL, BEATING = task_message(default_task("swim")), genome_message(beating())


@pytest.mark.parametrize(
    "genomes, task, says",
    [
        (Sized(0), SMALL, "0 genomes in a request: give 1 to 1000"),
        (Sized(10**12), SMALL, "1000000000000 genomes in a request: give 1 to 1000"),
        ([BEATING], message(**{"development.max_cells": 4096}), "-p max_cells:=4096"),
        ([BEATING], message(control_steps=10_000_000), "-p max_steps:=10000400"),
        ([BEATING] * 1000, message(control_steps=999_600), "-p max_seconds:="),
        ([BEATING], Message(scene=Message(ground=Sized(10**9), ceiling=())), f"ground has {10**9} points: give none, or 2 to {MOST_POINTS}"),
    ],
)
def test_what_is_too_much_is_refused_in_one_line_with_the_mend(genomes, task, says):
    line = LIMITS.refuse(genomes, task)
    assert says in line and len(line) <= 300 and "\n" not in line


def test_defaults_take_what_runs_ask_for_and_the_mend_that_a_refusal_names_mends_it():
    for name in names()[:3]:
        assert LIMITS.refuse([BEATING] * 100, task_message(default_task(name))) == ""
    line = LIMITS.refuse([BEATING] * 1000, message(control_steps=999_600))
    raised = dataclasses.replace(LIMITS, max_seconds=int(line.rpartition(":=")[2]))
    assert raised.refuse([BEATING] * 1000, message(control_steps=999_600)) == ""


def test_a_lower_limit_of_elements_names_the_genome_and_the_librarys_own_fails_alone():
    low = dataclasses.replace(LIMITS, max_elements=10)
    eight = genome_message(beating().take(np.arange(8)))
    assert "genome 1 has 11 elements: give up to 10" in low.refuse([eight, of(11)], SMALL)
    assert LIMITS.refuse([of(10**9)], SMALL) == ""  # whoever evaluates it finds it invalid, and reads nothing of it


def test_requests_that_wait_are_limited():
    assert "100 requests wait already" in LIMITS.refuse([BEATING], SMALL, waiting=100)


@given(st.integers(MAX_ELEMENTS + 1, 10**12), st.integers(0, 3))
@settings(deadline=None)
def test_a_genome_too_long_is_refused_before_anything_of_its_length_is_made(elements, which):
    parts = [np.zeros(8)] * 4
    parts[which] = Sized(elements)
    with pytest.raises(GenomeError, match=f"{elements} elements"):
        Genome(*parts)


@given(st.sampled_from(names()[:3]), st.integers(1, 64), st.integers(1, 5000), st.integers(0, 300))
@settings(deadline=None)
def test_the_cost_grows_with_everything_that_costs(name, cells, windows, units):
    def cost(cells, windows, units, starts):
        task = with_settings(default_task(name), {"development.max_cells": cells, "control_steps": 4 * windows, "starts": starts})
        return steps_of(task), seconds_of(np.array([0] * 8 + [1, 2] * units, np.uint8), task)

    steps, seconds = cost(cells, windows, units, 2)
    assert steps >= 4 * windows and seconds > 0.0
    for more in ((cells + 1, windows, units, 2), (cells, windows + 1, units, 2), (cells, windows, units + 1, 2)):
        assert cost(*more)[0] >= steps and cost(*more)[1] > seconds


def test_a_profile_of_too_many_points_is_a_parameter_error_of_the_library_too():
    with pytest.raises(ParameterError, match="points: give none"):
        dataclasses.replace(Task().scene, ground_x=range(MOST_POINTS + 1), ground_y=range(MOST_POINTS + 1))
