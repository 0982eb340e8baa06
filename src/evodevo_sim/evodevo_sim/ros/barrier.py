"""One barrier for every callback of a node: what goes wrong in it is that request's own error and a line in the log, and the node lives on.

Services answer in the executor's thread, or at a `Desk`: threads of its own in which long requests wait for one another, while
others are answered.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.executors import ExternalShutdownException

from .requests import Once

MOST_TEXT = 300  # characters of what is said in an answer or in a line of the log
_WARN_EVERY = 1.0  # s between lines of one kind


def brief(text: object, most: int = MOST_TEXT) -> str:
    """A text, or the text of an error, as one line of at most `most` characters."""
    line = " ".join(str(text)[: 4 * most].split())
    return line if len(line) <= most else line[: most - 3] + "..."


def told(error: BaseException) -> str:
    """An exception in one line: its type, which says most of what nobody expected, and its message."""
    return brief(f"{type(error).__name__}: {error}" if str(error) else type(error).__name__)


class Desk:
    """Threads that do what they are given, in its order."""

    def __init__(self, name: str, threads: int = 1):
        self._waiting: queue.SimpleQueue = queue.SimpleQueue()
        self._threads = [threading.Thread(target=self._run, name=f"{name} {k}", daemon=True) for k in range(threads)]
        for thread in self._threads:
            thread.start()

    def put(self, work: Callable[[], object]) -> None:
        """Do `work()` when its turn comes; it must not raise."""
        self._waiting.put(work)

    @property
    def waiting(self) -> int:
        """What has not begun."""
        return self._waiting.qsize()

    def close(self) -> None:
        """End the threads, when all that waits is done."""
        for _ in self._threads:
            self._waiting.put(None)
        for thread in self._threads:
            thread.join()

    def _run(self):
        while (work := self._waiting.get()) is not None:
            work()
            del work  # a large request is not kept until the next one


class Gate(Protocol):
    """Looks at the requests of a service at a desk, in the executor's thread."""

    def refuse(self, request: Any) -> str:
        """Why a request is not taken, which is its answer at once; empty where it is."""

    def arrived(self, request: Any) -> None:
        """It is taken, and waits for its turn."""


class _Request:
    """What waits at a desk, in the place of a response."""

    def __init__(self, request):
        self.request = request


class Callbacks:
    """Makes the subscriptions and services of a node behind the barrier.

    Args: node; through: exceptions that are meant to end the node.
    """

    def __init__(self, node: Any, through: tuple[type[BaseException], ...] = ()):
        self._node, self._through = node, through
        self._warned: dict[str, float] = {}

    def subscription(self, message_type: type, topic: str, callback: Callable, quality: Any) -> Any:
        def guarded(message):
            try:
                callback(message)
            except self._through:
                raise
            except Exception as error:
                self.warn(f"topic {topic}", f"a message on {topic} ignored: {told(error)}")

        return self._node.create_subscription(message_type, topic, guarded, quality)

    def service(
        self, service_type: Any, name: str, answer: Callable, desk: Desk | None = None, once: Once | None = None, gate: Gate | None = None
    ) -> Any:
        """A service.

        Args: answer(request, response) -> response; desk: where it is answered, if not in the executor's thread; once: of a service at
            a desk, what knows requests that are asked again; gate: likewise, what refuses some before they wait.
        """

        def guarded(request, answer=answer):
            response = service_type.Response()
            try:
                return answer(request, response)
            except self._through:
                raise
            except Exception as error:
                cause = told(error)
            self.warn(f"service {name}", f"a request to {name} failed: {cause}", error=True)
            return failed(service_type.Response(), cause)

        def send(response, header):
            try:
                sends(response, header)
            except Exception as error:
                self.warn(f"answer {name}", f"an answer of {name} was not sent: {told(error)}")

        def looked_at(request, response):
            why = gate.refuse(request) if gate else ""
            return failed(response, why) if why else _Request(request)

        def later(waiting, header, desk=desk):
            if not isinstance(waiting, _Request):
                send(waiting, header)
                return
            key, new, kept = once.begin(waiting.request, header) if once else (None, True, None)
            if new:
                if gate:
                    gate.arrived(waiting.request)
                desk.put(lambda: work(waiting.request, header, key))
            elif kept is not None:
                send(kept, header)

        def work(request, header, key):
            response = guarded(request)
            for asked in once.end(key, header, response) if once else [header]:
                send(response, asked)

        # Executors hand what the callback returns to `send_response`.
        service = self._node.create_service(service_type, name, lambda request, _: guarded(request, looked_at if desk else answer))
        sends = service.send_response
        service.send_response = later if desk else send
        return service

    def warn(self, kind: str, text: str, error: bool = False) -> None:
        """Log a line, at most one of a kind in a second."""
        now = time.monotonic()
        if now >= self._warned.get(kind, -math.inf) + _WARN_EVERY:
            self._warned[kind] = now
            logger = self._node.get_logger()
            logger.error(brief(text)) if error else logger.warning(brief(text))


def failed(response: Any, cause: str) -> Any:
    """A response that says what went wrong, in the field that its type has for that."""
    setattr(response, "error" if hasattr(response, "error") else "message", cause)
    return response


def spin(executor: Any, node: Any, stop: Any) -> None:
    """Spin until `stop` is set.  What a callback of ROS's own raises, e.g. that of a clock, is a line in the log."""
    lines = Callbacks(node)
    while not stop.is_set():
        try:
            executor.spin_once(timeout_sec=0.1)
        except ExternalShutdownException:
            return
        except Exception as error:
            lines.warn("callback", f"a message was ignored: {told(error)}", error=True)
