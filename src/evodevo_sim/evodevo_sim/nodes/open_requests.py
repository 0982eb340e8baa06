"""Requests that wait or are in work at a node, and how they are given up: when somebody says so, or when who asked is gone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from ..tasks.halt import Halt, halting

LOOK_EVERY = 0.25  # s, at who is there, while anything is open
_GONE_AFTER = 0.4  # s, for which a client must be missing
_NEWS = 10.0  # s within which the news of a client comes, whose request may be faster


@dataclass(eq=False)
class _Open:
    """A request.  since: s, when it came; seen: whether its client was on the graph since then; missing: s, since when it is not, or
    None."""

    request: Any
    since: float
    halt: Halt = field(default_factory=Halt)
    seen: bool = False
    missing: float | None = None


class OpenRequests:
    """The table of them.  Its methods may be called in any thread.

    Args: present(clients): of full names of nodes, and "" for any client of the service, those that are on the graph.
    """

    def __init__(self, present: Callable[[set[str]], set[str]]):
        self._present = present
        self._open: dict[int, _Open] = {}  # by the request's place in memory, which it keeps as long as it stands here
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._open)

    def arrived(self, request: Any, now: float | None = None) -> None:
        """It waits now.  Args: now: see `look`."""
        with self._lock:
            self._open[id(request)] = _Open(request, time.monotonic() if now is None else now)

    @contextmanager
    def in_work(self, request: Any) -> Iterator[None]:
        """Evaluate it in this context.  Raises Halted where it was given up, then or before."""
        with self._lock:
            one = self._open.setdefault(id(request), _Open(request, time.monotonic()))
        try:
            with halting(one.halt):
                yield
        finally:
            with self._lock:
                self._open.pop(id(request), None)

    def give_up(self, number: int = 0, client: str = "") -> int:
        """Those of this id, this client, or both.  Returns: how many there were."""
        with self._lock:
            found = [
                one for one in self._open.values()
                if (not number or one.request.id == number) and (not client or one.request.client == client)
            ]
        for one in found:
            one.halt()
        return len(found)

    def look(self, now: float | None = None) -> int:
        """Give up what nobody waits for any more.  Returns: how many.  Args: now: s, by the monotonic clock.

        A client that has not been seen yet counts as there for a while: its request came faster than the news of it.
        """
        now = time.monotonic() if now is None else now
        with self._lock:
            there = list(self._open.values())
        if not there:
            return 0
        present, gone = self._present({one.request.client for one in there}), 0
        for one in there:
            if one.request.client in present:
                one.seen, one.missing = True, None
            elif one.seen or now - one.since > _NEWS:
                one.missing = now if one.missing is None else one.missing
                if now - one.missing >= _GONE_AFTER and not one.halt:
                    one.halt()
                    gone += 1
        return gone


def present_on(node: Any, service: str) -> Callable[[set[str]], set[str]]:
    """`OpenRequests.present` of a service of a node of rclpy."""
    name = node.resolve_service_name(service)

    def present(clients: set[str]) -> set[str]:
        found = {f"{namespace.rstrip('/')}/{one}" for one, namespace in node.get_node_names_and_namespaces()} if clients - {""} else set()
        if "" in clients and node.count_clients(name):
            found.add("")
        return found & clients

    return present
