"""The command line of `ros2 run evodevo_ga evolve`."""

from __future__ import annotations

import sys

from evodevo_sim.ros.environment import EnvironmentFault, check_environment

from .arguments import parse


def main(arguments: list[str]) -> int:
    options = parse(arguments)
    try:
        check_environment()
    except EnvironmentFault as error:
        print(f"evolve: {error}", file=sys.stderr)
        return 2
    from .evolve import evolve

    return evolve(options, arguments)
