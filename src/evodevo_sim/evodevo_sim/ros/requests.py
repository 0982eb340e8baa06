"""Requests that are asked again: what a service answers to a client that cannot tell whether a request, or its answer, was lost.

A request with an id is evaluated once, however often it is asked: while it waits or is in work, who asks again waits with the first;
after that its answer is kept for a while.
"""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any

ENDING = "the simulator is ending: ask another one"
CANCELLED = "the request was cancelled"
BUSY = "too many requests wait"
UNREADY = "the body is not ready"  # of hardware: nothing moved
BROKEN = "the life was broken off"  # of hardware, in the middle
_KEPT = 256  # answers, at the most
_KEPT_EVALUATIONS = 20_000


def given_back(error: str) -> bool:
    """Whether an answer's error says that the request was not evaluated, by no fault of its own: others may be asked."""
    return error.startswith((ENDING, CANCELLED, BUSY, UNREADY, BROKEN))


def key_of(request: Any) -> Hashable:
    """What tells a request for evaluations from others that have its id by chance; None for one without an id."""
    if not request.id:
        return None
    digest = hashlib.blake2b(f"{request.seed} {len(request.genomes)} {request.task.name}".encode(), digest_size=16)
    digest.update(request.bars.tobytes())
    for genome in request.genomes:
        for values in (genome.kind, genome.sign, genome.x, genome.y):
            digest.update(values.tobytes())
    return request.id, digest.digest()


class Once:
    """Answers of a service by the keys of its requests.  Its methods may be called in any thread.

    Args: key: of a request, None where each counts for itself; whole: whether an answer holds, so that it may be given again.
    """

    def __init__(self, key: Callable[[Any], Hashable] = key_of, whole: Callable[[Any], bool] = lambda response: not response.error):
        self._key, self._whole = key, whole
        self._lock = threading.Lock()
        self._asked: dict[Hashable, list] = {}
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()

    def begin(self, request: Any, header: Any) -> tuple[Hashable, bool, Any]:
        """Who asked is noted.  Returns: the key; whether it is to be evaluated; else the answer, or None where it is in work."""
        key = self._key(request)
        if key is None:
            return None, True, None
        with self._lock:
            if key in self._kept:
                return key, False, self._kept[key]
            self._asked.setdefault(key, []).append(header)
            return key, len(self._asked[key]) == 1, None

    def end(self, key: Hashable, header: Any, response: Any) -> list:
        """Keep an answer.  Returns: the headers of all who asked for it."""
        if key is None:
            return [header]
        with self._lock:
            if self._whole(response):
                self._kept[key] = response
                while len(self._kept) > _KEPT or self._size() > _KEPT_EVALUATIONS:
                    self._kept.popitem(last=False)
            return self._asked.pop(key)

    def _size(self) -> int:
        return sum(len(response.evaluations) for response in self._kept.values())
