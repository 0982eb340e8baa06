"""The command's entry point: see `evodevo_sim.commands`."""

from __future__ import annotations

from evodevo_sim.process import command


@command
def evolve():
    from .evolve_command import main

    return main
