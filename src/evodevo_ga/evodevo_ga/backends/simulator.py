"""One simulator node as a worker: what is known of it, and requests to it that are asked again where an answer may be lost."""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from evodevo_sim.ros.barrier import brief, told
from evodevo_sim.ros.host import has_ended, runs
from evodevo_sim.ros.messages import evaluation_from_message
from evodevo_sim.ros.requests import given_back
from evodevo_sim.ros.topics import WORKER
from evodevo_sim.tasks.code import code_hash

from evodevo_msgs.msg import Worker
from evodevo_msgs.srv import Cancel, Evaluate
from evodevo_sim import Evaluation, Status

from ..times import MESSAGES, Times
from .contract import Answer, AnswerError, NotEvaluated, WorkerLost

LOOK_EVERY = 0.25  # s
_SAYS_WHO_IT_IS = 1.5  # s until a node counts as one that does not say
_SILENT = 3.5  # s without a word, where each second has one
_MUTE = 15.0  # s without a word of one that is in reach, as a busy host may keep it waiting
_FAR = 10.0  # s without a word of one on another host
_LOST = 1.0  # s after which a request is lost of which the simulator knows nothing
_ASK_AGAIN = 5.0  # s without an answer at the least, and doubled each time
_TIMES = 4.0  # the longest that it took to answer
HARDWARE = "hardware"  # what a driver says in the place of its code
_ids = itertools.count(random.SystemRandom().getrandbits(62) + 1)


@dataclass
class Request:
    """A batch on its way.  asked: each time that it was sent; again: s, when it is sent once more; pause: s, until then."""

    id: int
    message: Any
    future: Future[Answer]
    worker: str
    began: float
    asked: list = field(default_factory=list)
    sent: float = 0.0
    pause: float = _ASK_AGAIN


class Simulator:
    """The worker behind a service `evaluate`, in one life after the other.

    Args: node: of rclpy; service: its name; group: of callbacks; say: is told what people must know; times: told how long messages take;
        away: s out of reach after which it counts as lost, if nobody can tell.
    """

    def __init__(self, node: Any, service: str, group: Any, say: Callable[[str], object], times: Times, away: float):
        self.service, self._group, self._say, self._times, self._away = service, group, say, times, away
        self.about: Worker | None = None
        self._heard = 0.0
        self._join(node)
        self._life = 1
        self._open: dict[int, Request] = {}
        self.ready = False
        self._changed = time.monotonic()  # when it came into reach, or went out of it
        self._over = ""  # why this life is of no use
        self._refused = False
        self._answered, self._longest, self._looked = 0.0, 0.0, 0.0
        self._stopped, self._runs_since = False, 0.0

    @property
    def name(self) -> str:
        return self.service if self._life == 1 else f"{self.service} #{self._life}"

    @property
    def threads(self) -> int:
        return max(1, self.about.threads) if self.about else 1

    @property
    def usable(self) -> bool:
        known = self.about is not None or time.monotonic() > self._changed + _SAYS_WHO_IT_IS
        return self.ready and known and not self._over and not self._refused

    @property
    def gone(self) -> bool:
        """Whether nothing will come of it any more."""
        return not self.ready and not self._open and time.monotonic() > self._changed + self._away

    def _join(self, node: Any) -> None:
        self.node = node
        self._client = node.create_client(Evaluate, self.service, callback_group=self._group)
        self._canceller = node.create_client(Cancel, f"{self.service.rpartition('/')[0]}/cancel", callback_group=self._group)
        topic = WORKER.at(self.service.rpartition("/")[0])
        self._subscription = node.create_subscription(WORKER.type, topic, self._hear, WORKER.quality, callback_group=self._group)

    def close(self) -> None:
        self.node.destroy_client(self._client)
        self.node.destroy_client(self._canceller)
        self.node.destroy_subscription(self._subscription)

    def move(self, node: Any) -> None:
        """Talk to it through another node, by which it may be in reach.  What it was asked is asked again there."""
        self.close()
        self.ready, self._heard = False, time.monotonic()
        for request in self._open.values():
            for asked in request.asked:
                asked.cancel()
            request.asked = []
        self._join(node)

    def excuse(self) -> None:
        """Silence until this moment says nothing."""
        self._heard = self._runs_since = time.monotonic()

    @property
    def estranged(self) -> bool:
        """Whether it has been out of reach, or silent, though it runs as far as one can tell: DDS may have lost it for good."""
        if self.about is None or self._over or self._refused:
            return False
        now = time.monotonic()
        since, silent = (self._heard, _MUTE) if self.ready else (max(self._heard, self._changed), _SILENT)
        running = runs(self.about.process)
        if running and self._stopped:
            self._stopped, self._runs_since = False, now
        self._stopped = running is False
        return running is not False and now > max(since, self._runs_since) + (silent if running else _FAR)

    # --- requests ---------------------------------------------------------------------------------------------------------

    def submit(self, message: Any) -> Future[Answer]:
        message.id = next(_ids)
        future: Future[Answer] = Future()
        request = Request(message.id, message, future, self.name, time.monotonic())
        request.pause = max(_ASK_AGAIN, _TIMES * self._longest)
        self._open[request.id] = request
        future.add_done_callback(lambda _: self._forget(request))
        self._send(request)
        return future

    def _send(self, request: Request) -> None:
        request.sent = time.monotonic()
        request.message.client = self.node.get_fully_qualified_name()
        asked = self._client.call_async(request.message)
        request.asked.append(asked)
        asked.add_done_callback(lambda answered: self._take(request, answered))

    def _forget(self, request: Request) -> None:
        """Nobody waits for a request any more: who has it in work is told so."""
        given_up = self._open.pop(request.id, None) is not None and self.node.context.ok()
        if given_up and self.ready and request.future.cancelled() and self._canceller.service_is_ready():
            self._canceller.call_async(Cancel.Request(id=request.id))
        for asked in request.asked:
            asked.cancel()
        request.asked = []

    def _take(self, request: Request, answered: Any) -> None:
        """The answer to one sending of a request; only the first one counts."""
        if answered.cancelled() or self._open.pop(request.id, None) is None:
            return
        now = time.monotonic()
        took, self._answered = now - max(request.began, self._answered), now
        self._longest = max(self._longest, now - request.began)
        with self._times(MESSAGES):
            try:
                response = answered.result()
                if given_back(response.error):
                    raise NotEvaluated(request.worker, brief(response.error))
                answer = Answer(evaluations_of(response, len(request.message.genomes)), request.worker, response.seconds or took)
            except (AnswerError, NotEvaluated) as error:
                request.future.set_exception(error)
            except Exception as error:
                request.future.set_exception(AnswerError(f"its answer cannot be read: {told(error)}"))
            else:
                request.future.set_result(answer)

    def drop(self, reason: str) -> None:
        """This life is of no use."""
        self._finish(reason, lambda: NotEvaluated(self.name, reason))

    def end(self, reason: str) -> None:
        """This life is over, for certain."""
        self._finish(reason, lambda: WorkerLost(self.name, reason))

    def _finish(self, reason: str, error: Callable[[], Exception]) -> None:
        self._over = self._over or reason
        for request in list(self._open.values()):
            del self._open[request.id]
            if not request.future.done():
                request.future.set_exception(error())

    # --- who it is, and whether it is there -------------------------------------------------------------------------------

    def _hear(self, about: Worker) -> None:
        now = time.monotonic()
        if self.about is None or self.about.process == about.process:
            if self.about is None:
                self._check(about)
        elif has_ended(self.about.process) or now > self._heard + _SILENT:
            self._begin_a_life("it was started anew")
            self._check(about)
        else:
            if not self._refused:
                self._say(f"two simulators share the name {self.service}: give each a namespace of its own, by -r __ns:=/NAME")
            self._refused = True
            return
        self.about, self._heard = about, now
        if not about.under_way and not about.waiting:
            for request in self._open.values():
                if now > request.sent + _LOST:
                    self._send(request)

    def _check(self, about: Worker) -> None:
        self._refused = about.code != code_hash()
        if about.code == HARDWARE:
            self._say(f"{self.service} is of hardware, which is not used beside simulators: evolve on it by --rig")
        elif self._refused:
            self._say(
                f"simulator {self.service} on {about.host} is not used: its code ({about.version}, {about.code[:16]}) is not ours "
                f"({code_hash()}): install the same version on both"
            )

    def _begin_a_life(self, reason: str) -> None:
        self.end(reason)
        self._life += 1
        self._over, self.about = "", None

    def look(self) -> None:
        """Notice that it went or came, and ask again what may be lost."""
        now = time.monotonic()
        if now < self._looked + LOOK_EVERY:
            return
        self._looked = now
        ready = self._client.service_is_ready()
        if ready != self.ready:
            self.ready, self._changed = ready, now
            if ready and self._over and self.about is None:  # it does not say who it is: it may be another one
                self._begin_a_life(self._over)
            if ready:
                for request in self._open.values():
                    self._send(request)
        if self._open or self.usable:
            if self.about is not None and has_ended(self.about.process):
                self.end("it has ended")
            elif not ready and now > self._changed + self._away:
                self.end("it is gone")
        for request in self._open.values():
            if ready and now > request.sent + request.pause:
                request.pause *= 2.0
                self._send(request)


def evaluations_of(response: Any, count: int) -> list[Evaluation]:
    """The evaluations of a simulator's answer.  Raises AnswerError where it is an error, or cannot be read."""
    if response.error:
        raise AnswerError(brief(response.error))
    if len(response.evaluations) != count:
        raise AnswerError(f"it answers {len(response.evaluations)} evaluations for {count} genomes")
    known = {*Status}
    for message in response.evaluations:
        if message.status not in known:
            raise AnswerError(f"it answers a status of {message.status}, which is unknown")
    return [evaluation_from_message(message) for message in response.evaluations]
