"""What the command lines share: an error is one line with the mend, and exit code 2."""

from __future__ import annotations

import argparse
import os
import shlex

from ..parameters import ParameterError


class Parser(argparse.ArgumentParser):
    """A parser whose description and epilog keep their lines."""

    def __init__(self, prog: str, description: str, epilog: str):
        super().__init__(prog=prog, description=description, epilog=epilog, formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message} (see --help)\n")


def pairs(items: list[str]) -> dict[str, str]:
    """The settings of `--set NAME=VALUE` given any number of times.  Raises ParameterError."""
    given = dict(item.partition("=")[::2] for item in items)
    for name, value in given.items():
        if not value:
            raise ParameterError(f"--set {name}: give NAME=VALUE, e.g. material.stiffness=300")
    return given


def say_if_compiling(kernel_name: str) -> None:
    """Tell the user why a first run waits.  Args: kernel_name: module.function of the kernel that takes longest to compile."""
    from ..kernels.jit import is_compiled  # it takes Numba

    if not is_compiled(kernel_name):
        print("Compiling the simulation kernels, once: about a minute.", flush=True)


def without_remarks() -> None:
    """To be called before matplotlib is imported, which says on stderr where it keeps its fonts when there is no home."""
    import logging

    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def see_it(recording: str | os.PathLike) -> str:
    """The line that says how a recording is seen, to be typed as it stands."""
    return f"See it:   ros2 run evodevo_sim replay {shlex.quote(str(recording))}"
