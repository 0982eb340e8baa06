"""Where the wall time of a run goes: parts that add up to the whole."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.table import Table

START, EVALUATION, MESSAGES = "start: kernels, simulators", "waiting for simulators", "making, sending, reading messages"
BREEDING, RECORDING, AUDITS = "breeding (ask, tell)", "recording, publishing", "waiting for the last audits"
CHAMPION, REST = "champion's life and gait", "rest"


class Times:
    """A stopwatch: each moment counts for the innermost part that is under way, or else for the rest.

        with times(EVALUATION): ...
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter):
        self._clock, self._mark = clock, clock()
        self._under_way = [REST]
        self._seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        self._charge()
        self._under_way.append(part)
        try:
            yield
        finally:
            self._charge()
            self._under_way.pop()

    def seconds(self) -> dict[str, float]:
        """Wall time of each part until now, s, in the order in which they began; the rest comes last."""
        self._charge()
        return {part: value for part, value in self._seconds.items() if part != REST} | {REST: self._seconds[REST]}

    def _charge(self) -> None:
        now = self._clock()
        part = self._under_way[-1]
        self._seconds[part] = self._seconds.get(part, 0.0) + now - self._mark
        self._mark = now


def table(seconds: dict[str, float], note: str = "") -> Table:
    """The parts of a run's wall time, with their shares."""
    whole = sum(seconds.values())
    shown = Table("part", title=f"{whole:.1f} s of wall time", caption=note or None, title_justify="left", caption_justify="left")
    shown.add_column("s", justify="right")
    shown.add_column("share", justify="right")
    for part, value in seconds.items():
        shown.add_row(part, f"{value:.2f}", f"{100 * value / whole:.1f} %" if whole else "")
    return shown
