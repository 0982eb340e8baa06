"""`ros2 run evodevo_ga status`: the simulators of the ROS graph, and how they do."""

from __future__ import annotations

import sys
import time
from functools import partial
from typing import TYPE_CHECKING, Any

from evodevo_sim.ros.command_line import Parser, real_number
from evodevo_sim.ros.environment import EnvironmentFault, check_environment, started, without_ros

if TYPE_CHECKING:
    from rich.table import Table

_TYPE = "evodevo_msgs/msg/Worker"
_MORE = 1.0  # s to wait for another one after each
_EPILOG = """\
examples:
  ros2 run evodevo_ga status
      simulators of the graph: hosts, threads, evaluations per second, faults, load
  ros2 run evodevo_ga status --look 10
      takes more time to find them, e.g. in a network

Those in a namespace /_evolve_N belong to the evolve of that process number.  Whose code is another one is marked, since evolve does
not use it.

Exit code: 0; 1 where there is none; 2 for bad input.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("status", "Show the simulators of the ROS graph, and how they do.", _EPILOG)
    parser.add_argument("--look", default=4.0, type=real_number, metavar="S", help="seconds to look for them (default %(default)s)")
    given = parser.parse_args(without_ros(arguments))
    if not 0.0 < given.look <= 3600.0:
        parser.error(f"--look is {given.look}: give more than 0, up to 3600 seconds")
    try:
        check_environment()
        from evodevo_sim.ros.process import stay_on_this_host

        stay_on_this_host()
        with started("status", arguments):
            found = listened(given.look)
    except EnvironmentFault as error:
        print(f"status: {error}", file=sys.stderr)
        return 2
    if not found:
        print("No simulator is on the graph: start one by ros2 run evodevo_sim simulator --ros-args -r __ns:=/sim_0", file=sys.stderr)
        return 1
    from rich.console import Console

    Console(width=None if sys.stdout.isatty() else 160).print(table(found))
    return 0


def listened(look: float) -> dict[str, Any]:
    """What the simulators tell of themselves, by their namespaces.  Args: look: s to look for them."""
    import rclpy
    from evodevo_sim.ros.topics import WORKER, namespace_of
    from rclpy.experimental import EventsExecutor

    node, executor = rclpy.create_node("status"), EventsExecutor()
    executor.add_node(node)
    found: dict[str, Any] = {}
    asked: set[str] = set()
    last, until = time.monotonic(), time.monotonic() + look
    while (now := time.monotonic()) < until and not (asked and len(found) == len(asked) and now > last + _MORE):
        for topic, types in node.get_topic_names_and_types():
            if _TYPE in types and topic not in asked:
                asked.add(topic)
                last = now
                name = namespace_of(topic, WORKER) or "/"
                node.create_subscription(WORKER.type, topic, partial(found.__setitem__, name), WORKER.quality)
        executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    return found


def table(found: dict[str, Any]) -> Table:
    """A row for each simulator, and one for all.  Args: found: messages `Worker`, by name."""
    from evodevo_sim.tasks.code import code_hash
    from rich.table import Table

    shown = Table(title=f"{len(found)} simulator{'s' * (len(found) > 1)}", title_justify="left")
    for name in ("simulator", "host"):
        shown.add_column(name, overflow="fold")
    for name in ("threads", "in work", "waiting", "evaluations", "per second", "faults", "load", "MB"):
        shown.add_column(name, justify="right")
    shown.add_column("code")
    for name, told in sorted(found.items()):
        code = told.version if told.code == code_hash() else f"{told.version} {told.code[:8]}, not ours"
        shown.add_row(
            name, told.host, f"{told.threads}", f"{told.under_way}", f"{told.waiting}", f"{told.evaluations}",
            f"{told.evaluations_per_second:.1f}", f"{told.faults}", f"{told.load:.2f}", f"{told.memory:.0f}", code,
        )
    if len(found) > 1:
        of = found.values()
        shown.add_section()
        shown.add_row(
            "all", f"{len({told.host for told in of})}", f"{sum(told.threads for told in of)}", f"{sum(told.under_way for told in of)}",
            f"{sum(told.waiting for told in of)}", f"{sum(told.evaluations for told in of)}",
            f"{sum(told.evaluations_per_second for told in of):.1f}", f"{sum(told.faults for told in of)}", "", "", "",
        )
    return shown
