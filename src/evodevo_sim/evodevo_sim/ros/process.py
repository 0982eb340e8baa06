"""What the main functions of nodes share: staying on this host, help, and ending in good order."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable

import rclpy
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor  # 1 to 2 % of a generation less work than SingleThreadedExecutor (benchmarks/services.py)
from rclpy.impl.implementation_singleton import rclpy_implementation as _rcl
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from ..parameters import ParameterError
from .barrier import spin
from .loopback import loopback_alone, prefer_loopback

END_WITHIN = 2.0  # s for good order after SIGINT or SIGTERM


def stay_on_this_host() -> None:
    """No packet leaves the host, unless the user says so, and nodes find each other soon.  To be called before `rclpy.init`."""
    prefer_loopback()


def without_ros(parser: argparse.ArgumentParser, arguments: list[str]) -> list[str]:
    """The arguments that are not ROS's.  Leaves with exit code 2 and one line where ROS's own are malformed."""
    try:
        return remove_ros_args([parser.prog, *arguments])[1:]
    except (_rcl.RCLInvalidROSArgsError, _rcl.UnknownROSArgsError) as error:
        parser.error(str(error).partition(", at ")[0])


def run(make_node: Callable, parser: argparse.ArgumentParser, arguments: list[str] | None = None) -> int:
    """Run a node until SIGINT or SIGTERM.

    Everything happens in a second thread, so that a signal is heard even while a kernel computes.

    Args: make_node: called with an Event that is set when the node shall end; the node has `close()`.
    Returns: the exit code.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    parser.parse_args(without_ros(parser, arguments))
    stay_on_this_host()
    failure: list[BaseException] = []
    thread = threading.Thread(target=_live, args=(make_node, arguments, stop, failure), name="executor", daemon=True)
    thread.start()
    stop.wait()
    thread.join(END_WITHIN)
    if thread.is_alive():  # deep in a kernel: nothing is lost by leaving it there
        sys.stderr.flush()
        os._exit(0)
    if failure:
        if not isinstance(failure[0], _USER_ERRORS):
            raise failure[0]
        print(f"{parser.prog}: {failure[0]}", file=sys.stderr)
        return 2
    return 0


_USER_ERRORS = (
    InvalidParameterTypeException, InvalidParameterValueException, rclpy.exceptions.ROSInterruptException, ParameterError,
)


def _live(make_node, arguments, stop, failure):
    node = None
    try:
        with loopback_alone():
            rclpy.init(args=[sys.argv[0], *arguments], signal_handler_options=SignalHandlerOptions.NO)
        node = make_node(stop)
        executor = EventsExecutor()
        executor.add_node(node)
        spin(executor, node, stop)
    except ExternalShutdownException:
        pass
    except BaseException as error:
        failure.append(error)
    finally:
        if node is not None:
            node.close()
        rclpy.try_shutdown()
        stop.set()
