"""What runs on a Dask worker: plain data in, plain data out, so that neither side makes objects of what the other one sends."""

from __future__ import annotations

import os
import platform
import threading
from collections import OrderedDict
from importlib.metadata import version
from typing import Any

import numpy
from evodevo_sim.tasks.code import code_hash
from evodevo_sim.tasks.evaluation import prepare
from evodevo_sim.tasks.halt import Halt

from evodevo_sim import __version__

from .evaluating import evaluated
from .plain import batch_of_plain, plain_answer

_lock = threading.Lock()
_halts: OrderedDict[str, Halt] = OrderedDict()  # of requests, by their names: those in work, and those that were given up
_MOST = 10_000


IDENTITY = {
    "evodevo": __version__, "code": code_hash(), "python": platform.python_version(), "numba": version("numba"),
    "numpy": numpy.__version__, "machine": platform.machine(), "host": platform.node(), "pid": os.getpid(),
}


def get_ready(task: dict[str, Any]) -> None:
    """Load the kernels of a plain task, compiled by the first process of the host that needs them."""
    prepare(batch_of_plain({"genomes": [], "task": task, "seed": 0, "bars": []}).task, lambda line: None)


def answer(name: str, batch: dict[str, Any]) -> dict[str, Any] | None:
    """The plain answer to a plain batch; None where it was given up.  Args: name: of the request, unlike any other."""
    halt = _halt_of(name)
    try:
        found = None if halt else evaluated(batch_of_plain(batch), "", halt)
    finally:
        with _lock:
            _halts.pop(name, None)
    return plain_answer(found) if found else None


def give_up(names: list[str]) -> None:
    """Nobody waits for these requests; what of them is in work ends at once, and what comes later never begins."""
    for name in names:
        _halt_of(name)()


def _halt_of(name: str) -> Halt:
    with _lock:
        halt = _halts.setdefault(name, Halt())
        while len(_halts) > _MOST:
            _halts.popitem(last=False)
        return halt
