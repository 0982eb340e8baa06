"""Who evaluates the genomes of a run: the simulator nodes of the graph, or nodes of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from evodevo_sim.ros.own_simulators import OwnSimulators

from evodevo_sim import Evaluation, Genome, Task

from ..arguments import Options, cores
from ..fleet import Fleet, FleetError, find_simulators
from ..times import START, Times

_DISCOVERY_OF_ALL = 4.0  # s from the node's start to look on where one is found: others' DDS may announce itself every 3 s
_MORE = 0.5  # s at the least to look, and to wait for another one after each
_ANSWER = 5.0  # s for a simulator of the graph to answer; one that was killed is listed for a while
_START = 60.0  # s for one of our own to start


class Evaluator(Protocol):
    """What a run asks for its evaluations."""

    def evaluate(
        self, genomes: list[Genome], task: Task, seed: int, stop: Callable[[], bool], best: float, bars: Sequence[float]
    ) -> Sequence[Evaluation] | None:
        """The evaluations of genomes, in order; None when `stop()` said to stop.  Raises FleetError when nobody can go on.

        Args: best: fitness from which on the best of these genomes is evaluated here too.
        """


@contextmanager
def evaluator_of(
    options: Options, node: Any, executor: Any, times: Times, stop: Callable[[], bool], began: float
) -> Iterator[Evaluator]:
    """Who evaluates for a run, as its options say.  Ends at the end what it started.  Raises FleetError where there is nobody.

    Args: node, executor: of rclpy, whose owner is the caller; times: told how long the start takes; began: s, by the monotonic clock,
        when the node was made.
    """
    count, log = options.simulators or cores(), options.out / "simulators.log"
    with OwnSimulators(count, log, task=options.task.name) as own:  # they start while we look for others
        with times(START):
            fleet = None if options.simulators else _others(options, node, executor, times, stop, began)
            if fleet:
                own.end()
                log.unlink()
            else:
                print(f"Evolving on {count} simulators of our own; recording to {options.out}", flush=True)
                fleet = Fleet(node, executor, own.services, times)
                fleet.wait(_START, own.alive, stop)
        yield fleet


def _others(options: Options, node: Any, executor: Any, times: Times, stop: Callable[[], bool], began: float) -> Fleet | None:
    """The simulators of the graph, if there are any that answer."""
    services = _find(options.look, node, executor, stop, began)
    if not services:
        return None
    fleet = Fleet(node, executor, services, times)
    try:
        fleet.wait(_ANSWER, stop=stop)
    except FleetError:  # those that were killed are listed for a while
        print(f"The simulators of the graph do not answer: {', '.join(services)}")
        return None
    print(f"Evolving on {len(services)} simulators of the graph: {', '.join(services)}; recording to {options.out}", flush=True)
    return fleet


def _find(look: float, node: Any, executor: Any, stop: Callable[[], bool], began: float) -> list[str]:
    """The simulators on the graph.  Args: look: s; began: s, by the monotonic clock, since when discovery goes on in its threads."""
    found: list[str] = []
    until = max(began + look, time.monotonic() + _MORE)
    while time.monotonic() < until and not stop():
        services = find_simulators(node)
        if services != found:
            found, until = services, max(began + max(look, _DISCOVERY_OF_ALL), time.monotonic() + _MORE)
        executor.spin_once(timeout_sec=0.05)
    return found
