"""The commands' entry points: see `evodevo_sim.commands.entry`."""

from __future__ import annotations

from evodevo_sim.command_process import Main, command


@command
def descent() -> Main:
    from .descent.command import main

    return main


@command(code_of=lambda number: 130)  # a run that any signal ended early is the same: what was done is kept
def evolve() -> Main:
    from .evolve_command import main

    return main


@command
def status() -> Main:
    from .status import main

    return main
