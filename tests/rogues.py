"""Service nodes of the tests' own, each in a thread and a DDS participant of its own: honest ones, and ones with a fault."""

import copy
import math
import threading
from contextlib import contextmanager

import rclpy
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.messages import evaluation_message, genome_from_message, task_from_message
from rclpy.executors import SingleThreadedExecutor

from evodevo_msgs.msg import Evaluation
from evodevo_msgs.srv import Evaluate
from evodevo_sim import evaluate


class Death(Exception):
    """Raised by a fault: the node is gone, without an answer."""


def honest(request, response):
    task = task_from_message(request.task)
    bars = request.bars or [-math.inf] * len(request.genomes)
    response.evaluations = [
        evaluation_message(evaluate(genome_from_message(g), task, request.seed, bar)) for g, bar in zip(request.genomes, bars)
    ]
    return response


def changed(place=0, **values):
    """A fault: fields of one evaluation of each answer are others."""

    def fault(request, response, _):
        for name, value in values.items():
            part, _, last = f"evaluations.{name}".rpartition(".")
            target = response.evaluations[place]
            for step in part.split(".")[1:]:
                target = getattr(target, step)
            setattr(target, last, value)
        return response

    return fault


def _answer(**fields):
    def fault(request, response, _):
        for name, value in fields.items():
            setattr(response, name, value)
        return response

    return fault


def _later(fault):
    """A fault that begins with the second answer."""
    return lambda request, response, count: fault(request, response, count) if count else response


def _of_another_request(request, response, count, kept=[]):  # noqa: B006  (kept from call to call is what is meant)
    kept.append(copy.deepcopy(response.evaluations[0]))
    response.evaluations = [kept[0] if count else Evaluation(fitness=0.25)] * len(response.evaluations)
    return response


def _number(request, response, _):
    response.evaluations = [*response.evaluations, *response.evaluations]
    return response


def _short(request, response, _):
    response.evaluations = response.evaluations[:-1]
    return response


def _invalid(request, response, _):
    response.evaluations = [Evaluation(fitness=-5.0, status=6, cause="no genome") for _ in request.genomes]
    return response


def _invalid_later(request, response, count):
    return _invalid(request, response, count) if count else response


FAULTS = {
    "nan": changed(fitness=math.nan),
    "inf": changed(fitness=math.inf),
    "minus inf, last": changed(-1, fitness=-math.inf),
    "metric nan": changed(**{"metrics.slowest_window": math.nan}),
    "steering nan": changed(**{"metrics.steering.left_gain": math.nan}),
    "status 99": changed(status=99),
    "cause of a success": changed(status=0, cause="it failed"),
    "well paid failure": changed(status=4, cause="it blew up", fitness=7.0),
    "short": _short,
    "too many": _number,
    "none, no error": _answer(evaluations=[]),
    "refuses": _answer(evaluations=[], error="sensor lost"),
    "a long refusal": _answer(evaluations=[], error="lost\n" * 2_000_000),
    "neg": changed(fitness=-5.0),
    "flatters": changed(fitness=1e6, status=0, cause=""),
    "flatters later": _later(changed(fitness=1e6, status=0, cause="")),
    "another metric": changed(**{"metrics.distance": 123.0}),
    "another request": _of_another_request,
    "stops without a bar": changed(status=9, cause="", fitness=0.1),
    "all are invalid": _invalid,
    "all are invalid later": _invalid_later,
}


@contextmanager
def service(name, fault=lambda request, response, count: response):
    """An `evaluate` service that answers rightly, changed by a fault(request, response, number of answers before)."""
    context = rclpy.Context()
    with loopback_alone():
        rclpy.init(context=context)
    node = rclpy.create_node("driver", namespace=name.rpartition("/")[0], context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    count, stop = [0], threading.Event()

    def answer(request, response):
        count[0] += 1
        return fault(request, honest(request, response), count[0] - 1)

    node.create_service(Evaluate, name, answer)

    def live():
        try:
            while not stop.is_set():
                executor.spin_once(timeout_sec=0.05)
        except Death:
            pass
        finally:
            node.destroy_node()
            context.try_shutdown()

    thread = threading.Thread(target=live, daemon=True)
    thread.start()
    try:
        yield count
    finally:
        stop.set()
        thread.join()
