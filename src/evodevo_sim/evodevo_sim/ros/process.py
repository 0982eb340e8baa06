"""What the main functions of nodes share: staying on this host, help, and ending in good order."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable

import rclpy
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor  # 1 to 2 % of a generation less work than SingleThreadedExecutor (benchmarks/services.py)

from ..command_process import end_now, heeded
from ..parameters import ParameterError
from .barrier import spin
from .environment import EnvironmentFault, started
from .loopback import prefer_loopback

END_WITHIN = 2.0  # s for good order after SIGINT or SIGTERM


def stay_on_this_host() -> None:
    """No packet leaves the host, unless the user says so, and nodes find each other soon.  To be called before `rclpy.init`."""
    prefer_loopback()


def run(make_node: Callable, parser: argparse.ArgumentParser, arguments: list[str]) -> int:
    """Run a node until SIGINT, SIGTERM or SIGHUP.

    Args: make_node: called with an Event that is set when the node shall end; the node has `close()`.
    Returns: the exit code.
    """
    stop = threading.Event()

    def ask(_number: int) -> None:
        stop.set()
        late = threading.Timer(END_WITHIN, end_now, (0,))  # deep in a kernel: nothing is lost by leaving it there
        late.daemon = True
        late.start()

    stay_on_this_host()
    try:
        with heeded(ask), started(parser.prog, arguments):
            _live(make_node, stop)
    except _USER_ERRORS as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    return 0


_USER_ERRORS = (
    EnvironmentFault, InvalidParameterTypeException, InvalidParameterValueException, rclpy.exceptions.ROSInterruptException, ParameterError,
)


def _live(make_node, stop) -> None:
    node = None
    try:
        node = make_node(stop)
        executor = EventsExecutor()
        executor.add_node(node)
        spin(executor, node, stop)
    except ExternalShutdownException:
        pass
    finally:
        if node is not None:
            node.close()
