"""Evaluations that nobody waits for any more: they end at once, wherever they are, from another thread.

    halt = Halt()
    with halting(halt):             # in the thread that evaluates
        evaluate(genome, task)      # raises Halted, once another thread has called halt()

Kernels look at a flag in every step of growth and of control.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np


class Halted(Exception):
    """The evaluation was ended, and has no result."""


class Halt:
    """Whether evaluations are to end.  It can be called in any thread, and is never taken back."""

    def __init__(self) -> None:
        self.flag = np.zeros(1, np.int64)

    def __call__(self) -> None:
        self.flag[0] = 1

    def __bool__(self) -> bool:
        return bool(self.flag[0])


_NEVER = Halt()
_here = threading.local()


@contextmanager
def halting(halt: Halt) -> Iterator[None]:
    """Evaluations of this thread end when `halt` is called.  Raises Halted at once where it was already."""
    before = getattr(_here, "halt", _NEVER)
    _here.halt = halt
    try:
        raise_if_halted()
        yield
    finally:
        _here.halt = before


def flag() -> np.ndarray:
    """(1,) int64, of this thread, as kernels look at it."""
    return getattr(_here, "halt", _NEVER).flag


def raise_if_halted() -> None:
    """Raises Halted where the evaluations of this thread are to end."""
    if flag()[0]:
        raise Halted("nobody waits for it any more")
