"""Evaluations end wherever they are once nobody waits for them: in kernels, and at a node whose client says so or is gone."""

import threading
import time
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from evodevo_sim.nodes.open_requests import OpenRequests
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import evaluation_from_message, genome_message, task_message
from evodevo_sim.ros.own_simulators import UNLIMITED
from evodevo_sim.ros.requests import CANCELLED
from evodevo_sim.tasks.halt import Halt, Halted, flag, halting
from genomes import dividing
from lab import DEADLINE, Operator, simulators

from evodevo_msgs.srv import Cancel, Evaluate
from evodevo_sim import Task, evaluate, load_champion

MOST = 10_000_000
SMALL = with_settings(Task(), {"development.max_cells": 8, "control_steps": 40})
NAMESPACE = f"/giving_up_{time.monotonic_ns()}"


def endless(name, **settings):
    return with_settings(default_task(name), {"control_steps": MOST} | {key.replace("__", "."): value for key, value in settings.items()})


@pytest.mark.parametrize(
    "genome, task",
    [
        (load_champion("undulator"), endless("swim")),
        (load_champion("walker"), endless("walk")),
        (load_champion("walker"), endless("walk", settling_limit=MOST, settled_speed=1e-9)),
        (load_champion("seeker"), endless("chemotaxis")),
        (dividing(), endless("swim", development__steps=100_000, development__max_cells=1024, development__variant="graph_at_end")),
    ],
    ids=["swim", "walk", "settle", "seek", "grow"],
)
def test_an_evaluation_that_takes_hours_ends_deep_in_its_kernel(genome, task):
    halt, ended = Halt(), []

    def work():
        try:
            with halting(halt):
                ended.append(evaluate(genome, task))
        except Halted:
            ended.append(Halted)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    clock, deadline = time.pthread_getcpuclockid(thread.ident), time.monotonic() + DEADLINE
    while time.clock_gettime(clock) < 0.5 and thread.is_alive() and time.monotonic() < deadline:  # it is well within the kernel
        time.sleep(0.01)
    assert not ended
    halt()
    thread.join(DEADLINE)
    assert ended == [Halted]


def test_a_halt_counts_in_its_thread_and_its_context_alone():
    halt, right = Halt(), evaluate(dividing(), SMALL)
    with halting(halt):
        assert evaluate(dividing(), SMALL) == right
        halt()
        with pytest.raises(Halted):
            evaluate(dividing(), SMALL)
        found = []
        thread = threading.Thread(target=lambda: found.append(evaluate(dividing(), SMALL)))
        thread.start()
        thread.join()
        assert found == [right]
    assert evaluate(dividing(), SMALL) == right and not flag()[0]
    with pytest.raises(Halted), halting(halt):
        raise AssertionError("it was halted before")


def test_requests_are_given_up_by_id_by_client_and_when_a_client_that_was_seen_is_gone():
    present = set()
    table = OpenRequests(lambda clients: present & clients)
    one, two, late = (SimpleNamespace(id=number, client=client) for number, client in ((1, "/a"), (2, ""), (3, "/late")))
    for request in (one, two, late):
        table.arrived(request, 95.0)
    assert table.look(96.0) == 0 and table.look(100.0) == 0  # nobody was seen yet
    present |= {"/a", ""}
    assert table.look(101.0) == 0
    present.discard("/a")
    assert table.look(102.0) == 0  # missing for a moment
    present.add("/a")
    assert table.look(103.0) == 0 and table.look(104.0) == 0
    present.clear()
    assert table.look(104.5) == 0 and table.look(105.0) == 2 and table.look(105.5) == 0  # but for the one that was never seen
    assert table.look(106.0) == 1 and len(table) == 3  # nor will be
    for request in (one, two, late):
        with pytest.raises(Halted), table.in_work(request):
            pass
    table.arrived(late, 200.0)
    with table.in_work(late):
        assert table.give_up(99) == 0 and table.give_up(0, "/other") == 0 and not flag()[0]
        assert table.give_up(3, "/late") == 1 and flag()[0]
    assert len(table) == 0


@contextmanager
def asked(operator, **fields):
    """A request for an evaluation that takes hours: its future."""
    client = operator.node.create_client(Evaluate, f"{NAMESPACE}/evaluate")
    operator.until(client.service_is_ready)
    request = Evaluate.Request(task=task_message(endless("swim")), genomes=[genome_message(load_champion("undulator"))], **fields)
    yield client.call_async(request)


def given_up(operator, **which):
    """The answer of `cancel` once it found one request."""
    said = operator.call(Cancel, f"{NAMESPACE}/cancel", **which)
    return said if said.message == "1 request given up" else None


def small(operator):
    answer = operator.call(Evaluate, f"{NAMESPACE}/evaluate", task=task_message(SMALL), genomes=[genome_message(dividing())])
    assert [evaluation_from_message(one) for one in answer.evaluations] == [evaluate(dividing(), SMALL)], answer.error


def test_a_node_gives_up_what_was_cancelled_and_what_its_client_left_behind():
    arguments = [part for limit in UNLIMITED for part in ("-p", limit)]
    with simulators(NAMESPACE, arguments=arguments), Operator() as operator:
        name = operator.node.get_fully_qualified_name()
        with asked(operator, id=7, client=name) as first, asked(operator, id=8) as second:
            for which in ({"id": 8}, {"client": name}):  # one waits, one is in work; to be told again where it overtook the request
                said = operator.until(lambda which=which: given_up(operator, **which))
                assert said.success
            operator.until(lambda: first.done() and second.done())
            assert all(one.result().error.startswith(CANCELLED) and not one.result().evaluations for one in (first, second))
        refused = operator.call(Cancel, f"{NAMESPACE}/cancel")
        assert not refused.success and "give the id" in refused.message
        assert operator.call(Cancel, f"{NAMESPACE}/cancel", id=99).message == "0 requests given up"
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        # A client of its own node that leaves: by its name, while others stay.
        leaver = rclpy.create_node("leaver", context=operator.context)
        executor = SingleThreadedExecutor(context=operator.context)
        executor.add_node(leaver)
        client = leaver.create_client(Evaluate, f"{NAMESPACE}/evaluate")
        operator.until(client.service_is_ready)
        genomes = [genome_message(load_champion("undulator"))]
        client.call_async(Evaluate.Request(task=task_message(endless("swim")), genomes=genomes, client="/leaver"))
        watch = operator.node.create_client(Cancel, f"{NAMESPACE}/cancel")
        operator.until(watch.service_is_ready)
        until = time.monotonic() + 1.0
        operator.until(lambda: time.monotonic() > until)  # it is in work, and its node was seen
        executor.remove_node(leaver)
        leaver.destroy_node()
        small(operator)  # which the one thread of the node could not answer before
