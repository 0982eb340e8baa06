"""The commands' entry points.  Each says which `main` it runs; `process` hears signals before that is imported."""

from __future__ import annotations

from .process import command


@command
def audit():
    from .audit_command import main

    return main


@command
def chase():
    from .nodes.chase_command import main

    return main


@command
def gait():
    from .gait.cli import main

    return main


@command
def replay():
    from .replay.cli import main

    return main


@command
def simulate():
    from .simulate import main

    return main


@command(code_of=lambda number: 0)  # a signal is how a node is told to end
def simulator():
    from .nodes.simulator_command import main

    return main


@command
def turning():
    from .turning_command import main

    return main
