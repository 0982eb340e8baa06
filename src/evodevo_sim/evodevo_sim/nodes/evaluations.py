"""The service `evaluate` of the simulator, in threads of its own, and what it tells of itself on the topic `worker`."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from itertools import repeat
from typing import Any

from evodevo_msgs.msg import Worker
from evodevo_msgs.srv import Cancel, Evaluate

from .. import __version__
from ..genetics.genome import Genome, GenomeError
from ..parameters import ParameterError, Task
from ..ros.barrier import Callbacks, Desk, brief, told
from ..ros.host import host_name, load, memory, process_identity
from ..ros.messages import evaluation_message, genome_from_message, task_of_request
from ..ros.requests import CANCELLED, ENDING, Once
from ..ros.topics import WORKER
from ..tasks.code import code_hash
from ..tasks.evaluation import evaluate, invalid
from ..tasks.halt import Halted
from ..tasks.outcome import Evaluation
from .limits import Limits
from .open_requests import LOOK_EVERY, OpenRequests, present_on

_TELL_EVERY = 1.0  # s
_RATE_OVER = 60.0  # s


class Evaluations:
    """Requests are evaluated side by side, one a thread; kernels release the interpreter's lock.

    Args: threads: requests at once; limits: of what is asked; ending: says whether the node ends, and a batch with it; judge: what
    evaluates a genome, a task, a seed and a bar, where it is not `tasks.evaluation.evaluate`; it may raise ParameterError, which refuses
    the request; code: hash of what evaluates.
    """

    def __init__(
        self, node: Any, callbacks: Callbacks, threads: int, limits: Limits, ending: Callable[[], bool],
        judge: Callable[[Genome, Task, int, float], Evaluation] | None = None, code: str = "",
    ):
        self._node, self._callbacks, self._threads, self._limits, self._ending = node, callbacks, threads, limits, ending
        self._judge, self._code = judge, code or code_hash()
        self._lock = threading.Lock()
        self._under_way = self._evaluated = self._faults = 0
        self._recent: deque[tuple[float, int]] = deque([(time.monotonic(), 0)])  # (s, evaluations until then)
        self._desk = Desk("evaluations", threads)
        self._worker = node.create_publisher(WORKER.type, WORKER.name, WORKER.quality)
        self._open = OpenRequests(present_on(node, "evaluate"))
        callbacks.service(Evaluate, "evaluate", self._answer, self._desk, Once(), self)
        callbacks.service(Cancel, "cancel", self._cancel)
        node.create_timer(LOOK_EVERY, self._mind_who_is_gone)
        self._tell()
        node.create_timer(_TELL_EVERY, self._tell_listeners)

    def close(self) -> None:
        self._desk.close()

    def refuse(self, request: Any) -> str:
        """See `barrier.Gate`."""
        return self._limits.refuse(request.genomes, request.task, len(self._open)) or _fault_of_bars(request)

    def arrived(self, request: Any) -> None:
        """See `barrier.Gate`."""
        self._open.arrived(request)

    def _cancel(self, request, response):
        if not (request.id or request.client):
            response.message = "neither an id nor a client is given: give the id of a request, or the full name of the node that asked"
            return response
        count = self._open.give_up(request.id, request.client)
        response.success, response.message = True, f"{count} request{'s' * (count != 1)} given up"
        return response

    def _mind_who_is_gone(self) -> None:
        if count := self._open.look():
            self._callbacks.warn("gone", f"{count} request{'s' * (count != 1)} given up: who asked is gone")

    def _answer(self, request, response):
        with self._lock:
            self._under_way += 1
        try:
            with self._open.in_work(request):
                return self._evaluate(request, response)
        except Halted:
            response.error = f"{CANCELLED}: nobody waits for it any more"
            return response
        finally:
            with self._lock:
                self._under_way -= 1

    def _evaluate(self, request, response):
        task = task_of_request(request.task)
        # Messages before and after all evaluations: one by one between them, where caches hold a body, they cost a generation 1.7 % more.
        genomes, evaluations = [_genome_or_fault(message) for message in request.genomes], []
        began = time.perf_counter()
        for genome, bar in zip(genomes, request.bars or repeat(-math.inf)):
            if self._ending():
                response.error = ENDING
                return response
            try:
                evaluations.append(genome if isinstance(genome, Evaluation) else self._evaluation(genome, task, request.seed, bar))
            except ParameterError as error:
                response.error = brief(error)
                return response
        response.seconds = time.perf_counter() - began
        response.evaluations = [evaluation_message(evaluation) for evaluation in evaluations]
        with self._lock:
            self._evaluated += len(evaluations)
        return response

    def _evaluation(self, genome: Genome, task: Task, seed: int, bar: float) -> Evaluation:
        """Of one genome: what goes wrong with it harms no other of its batch."""
        try:
            return (self._judge or evaluate)(genome, task, seed, bar)
        except (Halted, ParameterError):
            raise
        except Exception as error:
            cause = told(error)
        with self._lock:
            self._faults += 1
        self._callbacks.warn("evaluation", f"the evaluation of a genome of {len(genome)} elements failed: {cause}", error=True)
        return invalid(brief(f"its evaluation failed: {cause}"))

    # --- what it tells of itself ------------------------------------------------------------------------------------------

    def _tell_listeners(self) -> None:
        if self._worker.get_subscription_count():
            self._tell()

    def _tell(self) -> None:
        now, done = time.monotonic(), self._evaluated
        self._recent.append((now, done))
        while len(self._recent) > 2 and self._recent[1][0] <= now - _RATE_OVER:
            self._recent.popleft()
        since, before = self._recent[0]
        self._worker.publish(
            Worker(
                stamp=self._node.get_clock().now().to_msg(), host=host_name(), process=process_identity(), version=__version__,
                code=self._code, threads=self._threads, under_way=self._under_way, waiting=self._desk.waiting, evaluations=done,
                faults=self._faults, evaluations_per_second=(done - before) / max(now - since, 1e-9), load=load(), memory=memory(),
            )
        )


def _fault_of_bars(request) -> str:
    """What is wrong with the bars of a request, or nothing."""
    bars, count = request.bars, len(request.genomes)
    if len(bars) not in (0, count):
        return f"{len(bars)} bars for {count} genomes: give one for each, -inf where a life is not to stop, or none at all"
    for k, bar in enumerate(bars):
        if math.isnan(bar):
            return f"bars[{k}] is not a number: give metres, or -inf where a life is not to stop"
    return ""


def _genome_or_fault(message) -> Genome | Evaluation:
    """The genome of a message, or the evaluation that a malformed one gets."""
    try:
        return genome_from_message(message)
    except GenomeError as error:
        return invalid(brief(error))
