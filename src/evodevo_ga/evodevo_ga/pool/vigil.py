"""What a pool does where nobody is left: it waits, says so, and gives up after a while."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

from evodevo_sim.inputs import one_line

from ..backends.contract import Backend

_MOMENT = 3.0  # s without a worker that are not worth a line


class PoolError(RuntimeError):
    """Nobody can evaluate any more; the message says why and what to do."""


def raise_if_hopeless(backend: Backend) -> None:
    """Raises PoolError where no worker will ever come."""
    if why := backend.hopeless():
        raise PoolError(why)


class Vigil:
    """Watches whether there is anybody.  Args: say: is told a line; give_up_after: s."""

    def __init__(self, say: Callable[[str], object], give_up_after: float):
        self._say, self._give_up_after = say, give_up_after
        self._since: float | None = None
        self._told = False
        self._last = ""

    @property
    def waits(self) -> bool:
        """Whether it waits at all."""
        return self._give_up_after > 0.0

    def lost(self, worker: str, reason: str) -> None:
        """Somebody is gone, who may have been the last one."""
        self._last = f", the last one was {worker}: {one_line(reason, 160)}"

    def keep(self, workers: Collection[str], backend: Backend) -> None:
        """To be called again and again with who is there.  Raises PoolError where there is no hope, or no patience left."""
        now = time.monotonic()
        if workers:
            if self._told:
                self._say(f"going on with simulator {next(iter(workers))}")
            self._since, self._told = None, False
            return
        raise_if_hopeless(backend)
        since = self._since = now if self._since is None else self._since
        if now - since >= self._give_up_after:
            raise PoolError(f"no simulator is left{self._last}: run again with --simulators 2 to start two")
        if now - since >= _MOMENT and not self._told:
            self._told = True
            self._say(f"no simulator is left{self._last}: waiting for one; start it by ros2 run evodevo_sim simulator")
