"""One run: ask for genomes, have them evaluated, tell the evaluations, record the generation; then the outcome."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from evodevo_sim.command_process import exit_code
from evodevo_sim.recording.writer import Recorder
from rich.console import Console
from tqdm import tqdm

from ..arguments import Options
from ..auditor import Auditor
from ..evolution import Evolution, Generation
from ..pool.driver import Pool
from ..pool.vigil import PoolError
from ..settings import UNLIMITED
from ..times import AUDITS, BREEDING, EVALUATION, RECORDING, Times, table
from .journal import Journal
from .outcome import go_on, record_life, told, why_nothing_evolved
from .recorded import Recorded
from .rig import Body, Rig
from .simulators import evaluator_of


class Run:
    """A run around an `Evolution`.

    Args: node, executor: of rclpy; began: s, by the monotonic clock, when the node was made; stop: whether the user asked to stop;
        recorded: what the recording holds of a run that goes on; body: of its hardware, if it has one.
    """

    def __init__(
        self, options: Options, recorder: Recorder, auditor: Auditor, stop: Callable[[], bool], times: Times, node: Any, executor: Any,
        began: float, *, recorded: Recorded, body: Body | None = None,
    ):
        self.options, self.recorder, self.auditor, self.stop, self.times = options, recorder, auditor, stop, times
        self._node, self._executor, self._began = node, executor, began
        self._body = body
        self._rig = Rig(node, executor, options.rig, tqdm.write, options.give_up_after) if body else None
        resumed = options.resumed
        self.evolution = resumed.evolution if resumed else Evolution(
            options.settings, options.seed, options.start, options.scheme, options.task
        )
        self.journal = Journal(options, recorder, node, auditor, self.evolution, recorded)

    def go(self) -> int:
        """Returns: the exit code.  Raises PoolError when nobody can evaluate any more; what was done is kept then too."""
        try:
            self.journal.begin(self._body and self._body.channels)
            if self._ended:  # after its last generation, while it was finishing
                return self._finish()
            if self._rig:
                print(f"Evolving on the body of {self.options.rig}; recording to {self.options.out}", flush=True)
                self._evolve(self._rig)
            else:
                with evaluator_of(self.options, self._node, self._executor, self.times, self.stop, self._began) as evaluator:
                    self._evolve(evaluator)
        except PoolError:
            if self.evolution.population:
                self._finish()
            raise
        return self._finish()

    def _evolve(self, evaluator: Pool | Rig) -> None:
        most = None if self.options.settings.generations == UNLIMITED else self.options.settings.generations
        done, often = self.evolution.generation + 1, 0.1 if sys.stderr.isatty() else 5.0
        with tqdm(total=most, initial=done, unit="gen", disable=self.options.quiet, mininterval=often) as bar:
            while not (self._ended or self.stop()):
                told = self._generation(evaluator)
                if told is None:
                    break
                generation, rate = told
                bar.set_postfix_str(
                    f"best {generation.best:.3f}, median {generation.median:.3f}, diversity {generation.diversity:.2f}, "
                    f"{rate:.0f} evaluations/s",
                    refresh=False,
                )
                bar.update()

    def _generation(self, evaluator: Pool | Rig) -> tuple[Generation, float] | None:
        """One generation, recorded, and its evaluations/s; None where the user asked to stop."""
        o, champion, began = self.options, self.journal.champion, time.monotonic()
        with self.times(BREEDING):
            asked = self.evolution.ask()
        ahead = threading.Thread(target=self.journal.expect, args=(asked,), name="checkpoint", daemon=True)
        ahead.start()
        with self.times(EVALUATION):
            best = champion.evaluation.fitness if champion else float("-inf")
            evaluations = evaluator.evaluate(asked, o.task, o.seed, self.stop, best, self.evolution.bars)
        if evaluations is None:
            return None
        with self.times(BREEDING):
            generation = self.evolution.tell(list(evaluations))
        ahead.join()
        rate = len(asked) / (time.monotonic() - began)
        with self.times(RECORDING):
            self.journal.take(generation, rate)
        return generation, rate

    @property
    def _ended(self) -> bool:
        """Whether the run has reached one of its limits."""
        return self.evolution.finished or bool(self.options.limits.reached(self.evolution.evaluations, self.journal.sessions.seconds))

    def _finish(self) -> int:
        champion = self.journal.champion
        if champion is None:  # it is found with the first generation
            print(f"Stopped before the first generation: {self.options.out} holds the settings alone.\n{go_on(self.options.out)}")
            return 130
        with self.times(RECORDING):
            self.journal.history.write()
        with self.times(AUDITS):
            self.journal.finish_audits(self.stop)
        gait = record_life(champion, self.options, self.recorder, self.times, self._rig, self.stop)
        viable = not champion.evaluation.cause
        if not viable:
            print(f"evolve: {why_nothing_evolved(self.evolution.population)}", file=sys.stderr)
        print(told(self.evolution, champion, self.journal.verdict, gait, self.options))
        if not self.evolution.finished:
            reached = self.options.limits.reached(self.evolution.evaluations, self.journal.sessions.seconds)
            print(go_on(self.options.out) + (f"  (ended by {reached}: give more)" if reached else ""))
        if not self.options.quiet:
            note = f"beside it: {self.auditor.done} audits, {self.auditor.cpu:.1f} s of one core"
            Console().print(table(self.times.seconds(), note))
        return exit_code() or (0 if viable else 1)
