"""Who evaluates the genomes of a run: the simulator nodes of the graph, or nodes of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from evodevo_sim.ros.own_simulators import OwnSimulators

from ..arguments import Options, cores
from ..backends.ros import RosBackend, find_simulators
from ..pool.driver import Pool
from ..pool.vigil import PoolError
from ..times import START, Times

_DISCOVERY_OF_ALL = 4.0  # s from the node's start to look on where one is found: others' DDS may announce itself every 3 s
_MORE = 0.5  # s at the least to look, and to wait for another one after each
_ANSWER = 5.0  # s for a simulator of the graph to answer; one that was killed is listed for a while
_START = 60.0  # s for one of our own to start


@contextmanager
def evaluator_of(
    options: Options, node: Any, executor: Any, times: Times, stop: Callable[[], bool], began: float
) -> Iterator[Pool]:
    """Who evaluates for a run, as its options say.  Ends at the end what it started.  Raises PoolError where there is nobody.

    Args: node, executor: of rclpy, whose owner is the caller; times: told how long the start takes; began: s, by the monotonic clock,
        when the node was made.
    """
    mine = options.simulators is not None or options.threads is not None
    count = options.simulators or 1
    threads = options.threads or (1 if options.simulators else cores())
    log = options.out / "simulators.log"
    with OwnSimulators(count, log, task=options.task.name, threads=threads) as own:  # they start while we look for others
        with times(START):
            pool = None if mine else _others(options, node, executor, times, stop, began)
            if pool:
                own.end()
                log.unlink()
            else:
                of = f" of {threads} threads" if threads > 1 else ""
                print(f"Evolving on {count} simulator{'s' * (count > 1)}{of} of our own; recording to {options.out}", flush=True)
                pool = _pool(options, RosBackend(node, executor, own=own, graph=not mine, times=times))
                pool.wait(_START, lambda: stop() or not own.alive())
                if not (own.alive() or stop()):
                    raise PoolError("a simulator ended at once: run `ros2 run evodevo_sim simulator` to see why")
        try:
            yield pool
        finally:
            pool.backend.close()


def _pool(options: Options, backend: RosBackend) -> Pool:
    return Pool(backend, quarantine=options.out, give_up_after=options.give_up_after)


def _others(options: Options, node: Any, executor: Any, times: Times, stop: Callable[[], bool], began: float) -> Pool | None:
    """The simulators of the graph, if there are any that answer."""
    services = _find(options.look, node, executor, stop, began)
    if not services:
        return None
    pool = _pool(options, RosBackend(node, executor, services, graph=True, times=times))
    if not pool.wait(_ANSWER, stop) and not stop():  # those that were killed are listed for a while
        print(f"The simulators of the graph do not answer: {', '.join(services)}")
        pool.backend.close()
        return None
    print(f"Evolving on {len(services)} simulators of the graph: {', '.join(services)}; recording to {options.out}", flush=True)
    return pool


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
