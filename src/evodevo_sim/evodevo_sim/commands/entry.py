"""The commands' entry points.  Each says which `main` it runs; `process` hears signals before that is imported."""

from __future__ import annotations

from ..command_process import command


@command
def audit():
    from .audit import main

    return main


@command
def chase():
    from .chase import main

    return main


@command
def gait():
    from .gait import main

    return main


@command
def replay():
    from .replay import main

    return main


@command
def request():
    from .request import main

    return main


@command
def simulate():
    from .simulate import main

    return main


@command(code_of=lambda number: 0)  # a signal is how a node is told to end
def simulator():
    from .simulator import main

    return main


@command
def turning():
    from .turning import main

    return main
