"""The command line of `ros2 run evodevo_sim driver`."""

from __future__ import annotations

import sys

from ..ros.command_line import Parser, whole_number
from ..ros.environment import EnvironmentFault, check_environment, without_ros

_EPILOG = """\
examples:
  ros2 run evodevo_sim driver --port /dev/ttyACM0 --calibration eel.yaml
      the body on that port, in the place of a simulator node: load, chase, evolve see no difference
  ros2 run evodevo_sim driver --port /tmp/eel --calibration eel.yaml --ros-args -r __ns:=/eel
      one that `ros2 run evodevo_sim emulate` plays, in a namespace of its own

names in the namespace: those of the simulator node (see `ros2 run evodevo_sim simulator --help`), and
  services  stop      std_srvs/srv/Trigger         emergency stop: vented until somebody arms it
            arm       std_srvs/srv/Trigger         it may move again
  topics    channels                               wiring and limits, latched
            command (subscribed)                   evodevo_msgs/msg/Actuation of your own brain, while no animat lives
            /diagnostics                           diagnostic_msgs/msg/DiagnosticArray

A managed node: with --managed it waits for `ros2 lifecycle set /driver configure` and activate; else it does both at once.
The body is vented when commands cease, when the line is lost, at too much pressure, and when the node is deactivated or ends.
Exit code: 0; 2 for bad input, a port that cannot be used, or another body on it: nothing has moved then.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("driver", "Drive a body of rubber and air on a serial line.", _EPILOG)
    parser.add_argument("--port", required=True, metavar="PORT", help="serial port of its firmware, e.g. /dev/ttyACM0")
    parser.add_argument("--calibration", required=True, metavar="FILE", help="its calibration (docs/guide/hardware.md)")
    parser.add_argument("--baud", type=whole_number, default=921600, metavar="N", help="bits a second (default %(default)s)")
    parser.add_argument("--managed", action="store_true", help="wait for a manager to configure and activate it")
    given = parser.parse_args(without_ros(arguments))
    from ..hardware.calibration import CalibrationError, load_calibration

    try:
        if not 300 <= given.baud <= 20_000_000:
            parser.error(f"--baud is {given.baud}: give 300 to 20000000")
        check_environment()
        calibration = load_calibration(given.calibration)
    except (EnvironmentFault, CalibrationError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    from ..hardware.serial_line import LineError
    from ..nodes.driver import Driver, activate
    from ..ros.process import run

    def make(stop):
        node = Driver(stop, given.port, given.baud, calibration)
        if not given.managed:
            try:
                activate(node)
            except LineError:
                node.close()
                raise
        return node

    try:
        return run(make, parser, arguments)
    except LineError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    from .entry import driver as entry

    sys.exit(entry())
