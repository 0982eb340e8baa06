"""No callback ends a node: what is raised in it is the answer's own error, and a line in the log at most once a second."""

import os
import subprocess
import sys

import pytest
from evodevo_sim.parameters import with_settings
from evodevo_sim.ros.barrier import MOST_TEXT, Callbacks, Desk, brief
from evodevo_sim.ros.messages import genome_message, task_message
from genomes import beating, dividing
from hypothesis import given
from hypothesis import strategies as st
from lab import Operator
from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.srv import Evaluate
from evodevo_sim import Status, Task

NAMESPACE = f"/barrier_{os.getpid()}"
TASK = with_settings(Task(), {"development.max_cells": 12, "control_steps": 40})
# A simulator that has no memory for one genome, whatever its library says.
WITHOUT_MEMORY = """
import sys
from evodevo_sim.nodes import evaluations
right = evaluations.evaluate
def evaluate(genome, *given):
    if len(genome) == {length}:
        raise MemoryError("no room" * 1000)
    return right(genome, *given)
evaluations.evaluate = evaluate
from evodevo_sim.commands.entry import simulator as entry
sys.argv = ["simulator", "--ros-args", "-r", "__ns:={namespace}"]
sys.exit(entry())
"""


@pytest.mark.parametrize("own_thread", [False, True])
@pytest.mark.parametrize(
    "error", [MemoryError(), MemoryError("no room\n" * 10_000), ValueError("seconds must be positive"), RecursionError()]
)
def test_an_exception_is_the_answers_error_and_the_next_request_is_answered(error, own_thread):
    def answer(request, response):
        if hasattr(request, "data") and not request.data:
            return response
        raise error

    with Operator() as operator:
        desk = Desk("desk") if own_thread else None
        callbacks, name = Callbacks(operator.node), f"{NAMESPACE}/{'desk' if own_thread else 'here'}"
        for kind in (Evaluate, Trigger, SetBool):
            callbacks.service(kind, f"{name}/{kind.__name__.lower()}", answer, desk)
        said = operator.call(Evaluate, f"{name}/evaluate").error
        assert said.startswith(type(error).__name__) and len(said) <= MOST_TEXT and "\n" not in said
        assert operator.call(Trigger, f"{name}/trigger").message == said and not operator.call(Trigger, f"{name}/trigger").success
        assert operator.call(SetBool, f"{name}/setbool", data=True).message == said
        assert operator.call(SetBool, f"{name}/setbool", data=False).message == ""
        if desk:
            desk.close()


@given(st.text(max_size=2000), st.integers(10, 400))
def test_a_brief_text_is_a_line_of_bounded_length(text, most):
    line = brief(text, most)
    assert len(line) <= most and len(line.splitlines()) <= 1


def test_a_genome_without_memory_fails_alone_and_the_simulator_lives_on():
    code = WITHOUT_MEMORY.format(length=len(dividing()), namespace=NAMESPACE)
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        with Operator() as operator:
            for _ in range(2):
                request = dict(task=task_message(TASK), seed=1, genomes=[genome_message(g) for g in (beating(), dividing(), beating())])
                answer = operator.call(Evaluate, f"{NAMESPACE}/evaluate", **request)
                good, bad, again = answer.evaluations
                assert good == again and good.status == Status.OK
                assert bad.status == Status.INVALID_GENOME and "MemoryError" in bad.cause and len(bad.cause) <= MOST_TEXT
    finally:
        process.terminate()
        _, stderr = process.communicate(timeout=20)
    assert process.returncode == 0 and "MemoryError" in stderr and "Traceback" not in stderr
