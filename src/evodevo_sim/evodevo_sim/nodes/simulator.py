"""`ros2 run evodevo_sim simulator`: evaluates batches of genomes, and runs one animat live as a hardware driver would."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from evodevo_msgs.srv import Evaluate

from ..genetics.genome import Genome, GenomeError
from ..parameters import ParameterError, default_task
from ..ros.barrier import Callbacks, Desk, brief, told
from ..ros.messages import evaluation_message, genome_from_message, task_of_request
from ..ros.node_parameters import fixed, seconds
from ..task_kinds import names
from ..tasks.evaluation import evaluate, invalid, prepare
from ..tasks.outcome import Evaluation
from .living import ENDING, Living


class Simulator(Node):
    """The node.  Evaluations are answered one after the other in one thread, births of live animats in another, and the live
    animat goes on meanwhile in a thread of its own; so what controls it waits for none of them.

    Args: stop: an Event; set, a batch ends early.
    """

    def __init__(self, stop: Any):
        super().__init__("simulator")
        self._stop = stop
        self._frame = self.declare_parameter("frame_id", "world", fixed("frame of positions and targets")).value
        if not self._frame:
            raise ParameterError("frame_id is empty: give the name of a frame, e.g. world")
        self._most = self.declare_parameter("max_batch", 1000, fixed("genomes in one request, at the most", 1, 10_000)).value
        every = self.declare_parameter("publish_every", 1, fixed("control steps between cell states", 1, 100_000)).value
        first = self.declare_parameter("task", names()[0], fixed("task whose first request does not wait")).value
        oldest = seconds(self, "target_age", 1.0, "s, of the oldest target that counts")
        prepare(default_task(first), self.get_logger().info)
        self._callbacks = Callbacks(self)
        self._evaluations, self._births = Desk("evaluations"), Desk("births")

        self._living = Living(self, self._callbacks, self._births, self._frame, every, oldest, stop.is_set)
        self._callbacks.service(Evaluate, "evaluate", self._evaluate, self._evaluations)
        self.get_logger().info("ready")

    def close(self) -> None:
        self._evaluations.close()
        self._births.close()
        self._living.close()
        self.destroy_node()

    # --- evaluation ------------------------------------------------------------------------------------------------------

    def _evaluate(self, request, response):
        if not 0 < len(request.genomes) <= self._most:
            response.error = f"{len(request.genomes)} genomes in a request: give 1 to {self._most}"
            return response
        try:
            task = task_of_request(request.task)
        except ParameterError as error:
            response.error = brief(error)
            return response
        # Messages before and after all evaluations: one by one between them, where caches hold a body, they cost a generation 1.7 % more.
        genomes, evaluations = [_genome_or_fault(message) for message in request.genomes], []
        for genome in genomes:
            if self._stop.is_set():
                response.error = ENDING
                return response
            evaluations.append(genome if isinstance(genome, Evaluation) else self._evaluation(genome, task, request.seed))
        response.evaluations = [evaluation_message(evaluation) for evaluation in evaluations]
        return response

    def _evaluation(self, genome, task, seed) -> Evaluation:
        """Of one genome: what goes wrong with it harms no other of its batch."""
        try:
            return evaluate(genome, task, seed)
        except Exception as error:
            cause = told(error)
        self._callbacks.warn("evaluation", f"the evaluation of a genome of {len(genome)} elements failed: {cause}", error=True)
        return invalid(brief(f"its evaluation failed: {cause}"))


def _genome_or_fault(message) -> Genome | Evaluation:
    """The genome of a message, or the evaluation that a malformed one gets."""
    try:
        return genome_from_message(message)
    except GenomeError as error:
        return invalid(brief(error))
