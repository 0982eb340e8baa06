"""What checks stand on: a node that asks and listens, a report, and the table of checks."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor

from ...ros.barrier import brief
from ...ros.topics import Quality

ANSWER_WITHIN = 30.0  # s


class Failed(AssertionError):
    """A check that did not hold; the message says what was seen."""


class NotAsked(Exception):
    """A check that this node need not meet; the message says why."""


@dataclass(frozen=True)
class Check:
    """A check: name, which a report and its readers go by; what must hold, in a sentence; run: it, given a Session."""

    name: str
    what: str
    run: Callable[[Session], None] = field(repr=False)


@dataclass(frozen=True)
class Finding:
    """What a check found.  outcome: pass, fail, or not asked."""

    name: str
    what: str
    outcome: str
    seen: str = ""
    seconds: float = 0.0

    def plain(self) -> dict[str, Any]:
        return asdict(self)


CHECKS: dict[str, Check] = {}


def check(name: str, what: str) -> Callable[[Callable[[Session], None]], Callable[[Session], None]]:
    """Add a check to the table; they run in the order in which they are added."""

    def added(run: Callable[[Session], None]) -> Callable[[Session], None]:
        CHECKS[name] = Check(name, what, run)
        return run

    return added


def must(holds: Any, seen: str) -> None:
    """Raises Failed with what was seen unless it holds."""
    if not holds:
        raise Failed(seen)


class Heard:
    """Messages of a topic and when each came, s of the steady clock."""

    def __init__(self) -> None:
        self.messages: list[Any] = []
        self.times: list[float] = []

    def add(self, message: Any) -> None:
        self.messages.append(message)
        self.times.append(time.monotonic())

    def __len__(self) -> int:
        return len(self.messages)


class Session:
    """Asks one node.  Args: namespace: its, e.g. /sim_0; genome: a message of one that grows its body; task: a message.

    Attributes: times: of real time, the pace that it keeps.
    """

    def __init__(self, namespace: str, genome: Any, task: Any, patience: float = ANSWER_WITHIN):
        self.namespace, self.genome, self.task, self.patience = "/" + namespace.strip("/"), genome, task, patience
        if self.namespace == "/":
            self.namespace = ""
        self.node = rclpy.create_node("conform")
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self._stop = threading.Event()
        self._clients: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._spin, name="conform", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        while not self._stop.is_set():
            try:
                self._executor.spin_once(timeout_sec=0.05)
            except ExternalShutdownException:
                return

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.node.destroy_node()

    def at(self, name: str) -> str:
        return f"{self.namespace}/{name}"

    # --- asking ----------------------------------------------------------------------------------------------------------

    def until(self, ready: Callable[[], Any], seconds: float | None = None) -> bool:
        """Whether it comes true in time."""
        end = time.monotonic() + (self.patience if seconds is None else seconds)
        while not ready():
            if time.monotonic() > end:
                return bool(ready())
            time.sleep(0.005)
        return True

    def call(self, service_type: Any, name: str, **request: Any) -> Any:
        """The answer of a service.  Raises Failed where none comes in time."""
        if name not in self._clients:
            self._clients[name] = self.node.create_client(service_type, self.at(name))
        client = self._clients[name]
        must(self.until(client.service_is_ready), f"there is no service {self.at(name)}")
        future = client.call_async(service_type.Request(**request))
        must(self.until(future.done), f"{self.at(name)} did not answer within {self.patience:g} s")
        return future.result()

    def listen(self, topic: Any, reliable: bool = False, kept: bool = False, depth: int = 1000) -> Heard:
        """What comes on a topic of the table from now on."""
        heard = Heard()
        quality = Quality("of a check", reliable, kept, depth)
        self.node.create_subscription(topic.type, self.at(topic.name), heard.add, quality.profile())
        return heard

    def publishers(self, name: str) -> list[Any]:
        self.until(lambda: self.node.get_publishers_info_by_topic(self.at(name)), 5.0)
        return self.node.get_publishers_info_by_topic(self.at(name))

    def has(self, name: str) -> bool:
        """Whether somebody offers the service."""
        return self.at(name) in dict(self.node.get_service_names_and_types())


def finite(values: Any) -> bool:
    return all(math.isfinite(value) for value in values)


def examine(session: Session, names: list[str] | None = None, say: Callable[[Finding], None] = lambda finding: None) -> list[Finding]:
    """Run checks, all or those named, in their order.  Args: say: called with each finding.  Returns: the findings."""
    findings = []
    for one in CHECKS.values():
        if names is not None and one.name not in names:
            continue
        began = time.monotonic()
        outcome, seen = "pass", ""
        try:
            one.run(session)
        except NotAsked as error:
            outcome, seen = "not asked", brief(error)
        except Failed as error:
            outcome, seen = "fail", brief(error)
        except Exception as error:
            outcome, seen = "fail", brief(f"{type(error).__name__}: {error}")
        findings.append(Finding(one.name, one.what, outcome, seen, time.monotonic() - began))
        say(findings[-1])
    return findings
