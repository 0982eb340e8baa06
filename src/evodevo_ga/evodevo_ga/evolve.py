"""`ros2 run evodevo_ga evolve`: the node that evolves animats on simulator nodes and records the run."""

from __future__ import annotations

import signal
import sys
import time

import rclpy
from evodevo_sim.command_process import heeded
from evodevo_sim.recording import RecordingError
from evodevo_sim.recording.guarded import GuardedRecorder
from evodevo_sim.ros.environment import EnvironmentFault, started
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.tasks import audit
from evodevo_sim.tasks.evaluation import prepare
from rclpy.experimental import EventsExecutor

from .arguments import Options, parse
from .auditor import Auditor
from .fleet import FleetError
from .run.loop import Run
from .times import START, Times


class _Stop:
    """Set by the first signal, which `process.heeded` hands it."""

    asked = False

    def ask(self, number: int) -> None:
        self.asked = True
        again = "" if number == signal.SIGHUP else " Once more to end at once."
        print(f"\nStopping: keeping what was done.{again}", file=sys.stderr)

    def __call__(self) -> bool:
        return self.asked


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    return evolve(parse(arguments), arguments)


def evolve(options: Options, arguments: list[str]) -> int:
    """Evolve as the command line says.  Args: arguments: those of ROS among them.  Returns: the exit code."""
    stop, times = _Stop(), Times()
    stay_on_this_host()
    try:
        with GuardedRecorder(options.out) as recorder, started("evolve", arguments):
            node, began, executor = rclpy.create_node("evolve"), time.monotonic(), EventsExecutor()
            executor.add_node(node)
            with times(START):
                prepare(options.task)  # before simulators start, so that they only load the kernels
                audit.prepare(options.task)
            with heeded(stop.ask), Auditor(options.task, options.seed) as auditor:
                return Run(options, recorder, auditor, stop, times, node, executor, began).go()
    except (EnvironmentFault, RecordingError, FleetError) as error:
        print(f"evolve: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    from .commands import evolve as entry

    sys.exit(entry())
