"""What the command lines share: an error is one line with the mend, and exit code 2."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Callable
from typing import NoReturn

from ..inputs import decimal, one_line, shown
from ..parameters import ParameterError


def whole_number(text: str) -> int:
    """An argument's whole number, in decimal digits."""
    number = decimal(text)
    if not isinstance(number, int):
        raise argparse.ArgumentTypeError(f"{shown(text)} is no whole number: give one in up to 20 decimal digits, e.g. 12")
    return number


def real_number(text: str) -> float:
    """An argument's number, in decimal digits; inf and nan are left to whoever names the range."""
    number = float(text) if text.lower() in ("inf", "-inf", "nan") else decimal(text)
    if number is None:
        raise argparse.ArgumentTypeError(f"{shown(text)} is no number: give one in decimal digits, e.g. 12 or 1e-5")
    return float(number)


class Parser(argparse.ArgumentParser):
    """A parser whose description and epilog keep their lines."""

    def __init__(self, prog: str, description: str, epilog: str):
        super().__init__(prog=prog, description=description, epilog=epilog, formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {one_line(message)} (see --help)\n")


def pairs(items: list[str]) -> dict[str, str]:
    """The settings of `--set NAME=VALUE` given any number of times.  Raises ParameterError."""
    given = dict(item.partition("=")[::2] for item in items)
    for name, value in given.items():
        if not value:
            raise ParameterError(f"--set {shown(name)}: give NAME=VALUE, e.g. material.stiffness=300")
    return given


def add_plant(parser: argparse.ArgumentParser, what: str = "for a genome: ") -> None:
    """The flag by which the simulated body has a rig's actuators and sensors."""
    parser.add_argument("--plant", metavar="FILE", help=f"{what}actuators and sensors of a rig, e.g. plant.yaml (docs/guide/hardware.md)")


def settings_of(given: argparse.Namespace, task: str, say: Callable[[str], None]) -> dict[str, object]:
    """The settings of `--plant`, and over them those of `--set`.  Args: task: its name, which may be none.  Raises ParameterError."""
    found: dict[str, object] = {}
    if given.plant is not None:
        from ..hardware.rig import plant_settings  # it takes YAML
        from ..task_kinds import kind_of

        kind = kind_of(task)
        found = plant_settings(given.plant, kind is None or kind.has_target, say)
    return found | pairs(given.set)


def warn(prog: str) -> Callable[[str], None]:
    """What prints a line on stderr under a command's name."""
    return lambda line: print(f"{prog}: {line}", file=sys.stderr)


def say_if_compiling(kernel_name: str) -> None:
    """Tell the user why a first run waits.  Args: kernel_name: module.function of the kernel that takes longest to compile."""
    from ..kernels.jit import compiling  # it takes Numba

    if notice := compiling(kernel_name):
        print(notice, flush=True)


def without_remarks() -> None:
    """To be called before matplotlib is imported, which says on stderr where it keeps its fonts when there is no home."""
    import logging

    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def see_it(recording: str | os.PathLike) -> str:
    """The line that says how a recording is seen, to be typed as it stands."""
    return f"See it:   ros2 run evodevo_sim replay {shlex.quote(str(recording))}"
