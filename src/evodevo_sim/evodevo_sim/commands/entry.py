"""The commands' entry points.  Each says which `main` it runs; `process` hears signals before that is imported."""

from __future__ import annotations

from ..command_process import Main, command


@command
def audit() -> Main:
    from .audit import main

    return main


@command
def chase() -> Main:
    from .chase import main

    return main


@command
def compare() -> Main:
    from .compare import main

    return main


@command
def conform() -> Main:
    from .conform import main

    return main


@command(code_of=lambda number: 0)  # a signal is how a node is told to end
def driver() -> Main:
    from .driver import main

    return main


@command(code_of=lambda number: 0)
def emulate() -> Main:
    from .emulate import main

    return main


@command
def figure() -> Main:
    from .figure import main

    return main


@command
def film() -> Main:
    from .film import main

    return main


@command
def gait() -> Main:
    from .gait import main

    return main


@command
def identify() -> Main:
    from .identify import main

    return main


@command
def info() -> Main:
    from .info import main

    return main


@command
def replay() -> Main:
    from .replay import main

    return main


@command
def request() -> Main:
    from .request import main

    return main


@command
def simulate() -> Main:
    from .simulate import main

    return main


@command(code_of=lambda number: 0)  # a signal is how a node is told to end
def simulator() -> Main:
    from .simulator import main

    return main


@command
def turning() -> Main:
    from .turning import main

    return main
