"""This host and its processes, as others on the ROS graph are told of them."""

from __future__ import annotations

import os
import socket
from functools import cache
from pathlib import Path

_ENDED, _STOPPED = "ZX", "Tt"  # states of a process


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def host_name() -> str:
    return socket.gethostname()


def load() -> float:
    """Processes that want a core, for each core: mean over the last minute."""
    return os.getloadavg()[0] / (os.cpu_count() or 1)


def memory() -> float:
    """MB that this process has in main memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


@cache
def _space() -> str:
    """Where numbers of processes mean the same: a start of the system, and a namespace."""
    boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return f"{boot}/{os.stat('/proc/self/ns/pid').st_ino}"


def process_identity() -> str:
    """A text that no other process has, nor has had."""
    return f"{_space()}/{os.getpid()}/{_start_and_state(os.getpid())[0]}"


def has_ended(identity: str) -> bool | None:
    """Whether the process of that identity has ended; None where nobody here can tell, as for one of another host."""
    state = _state(identity)
    return None if state is None else state in _ENDED


def runs(identity: str) -> bool | None:
    """Whether it has neither ended nor been stopped; None where nobody here can tell."""
    state = _state(identity)
    return None if state is None else state not in _ENDED + _STOPPED


def _state(identity: str) -> str | None:
    space, number, started = ["", "", "", *identity.rsplit("/", 2)][-3:]
    if space != _space() or not (number.isascii() and number.isdigit()):
        return None
    try:
        found, state = _start_and_state(int(number))
    except OSError:
        return _ENDED[0]
    return state if found == started else _ENDED[0]


def _start_and_state(number: int) -> tuple[str, str]:
    """(ticks from the system's start to the process's, state).  Raises OSError where there is none."""
    fields = Path(f"/proc/{number}/stat").read_text().rpartition(") ")[2].split()
    return fields[19], fields[0]
