"""What a run leaves while it goes on: its recording, history and checkpoint, its topics, the file of its champion, and audits."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any

from evodevo_sim.recording.writer import Recorder
from evodevo_sim.ros import topics
from evodevo_sim.tasks import audit
from tqdm import tqdm

from evodevo_sim import Genome, save_genome

from ..arguments import Options
from ..auditor import Auditor, Finding
from ..evolution import Evolution, Generation, Individual
from ..keeping.checkpoint import Checkpoints
from ..keeping.files import FILES
from ..keeping.history import History
from ..keeping.sessions import Sessions
from ..messages import audit_message, champion_message, evolution_message, statistics_message
from .recorded import Recorded

_NOT_AUDITED = "not audited"
_ON_HARDWARE = "none: it lived on hardware, which no audit repeats"


class Journal:
    """Records, keeps and publishes the generations of a run, and has its new champions audited.

    A generation is durable before `take` returns.

    Attributes: champion: the one recorded last, or None; drift may put its equals before it; verdict: on it; sessions; history.
    """

    def __init__(self, options: Options, recorder: Recorder, node: Any, auditor: Auditor, evolution: Evolution, recorded: Recorded):
        self._options, self._recorder, self._auditor, self._evolution, self._recorded = options, recorder, auditor, evolution, recorded
        self._statistics, self._champions, self._audits = (
            node.create_publisher(topic.type, topic.name, topic.quality) for topic in (topics.STATISTICS, topics.CHAMPION, topics.AUDIT)
        )
        self.champion: Individual | None = None
        self._of = -1  # generation of the champion
        self.verdict = self._not_audited = _ON_HARDWARE if options.rig else _NOT_AUDITED
        self.history = History(options.out)
        self.sessions = Sessions(options.out, evolution.generation)
        self._checkpoints = Checkpoints(options.out, evolution, options.task, options.limits, options.sources, rig=options.rig)

    def begin(self, channels: Any = None) -> None:
        """Record the settings of the run; and take up what it did before, if it did anything.  Args: channels: of its hardware."""
        o = self._options
        self._recorder.write(topics.SETTINGS.name, evolution_message(o.settings, o.task, o.seed, o.start, o.scheme), time.time_ns())
        if channels is not None:
            self._recorder.write(topics.CHANNELS.name, channels, time.time_ns())
        if o.resumed is None:
            FILES.sync_directory(o.out.resolve().parent)
            self._checkpoints.write(None, -1, self.history.kept())
        else:
            self.champion, self._of = o.resumed.champion, o.resumed.champion_generation
            self.history.restore(o.resumed.history)
            self._take_up()
        self._recorder.flush()

    def _take_up(self) -> None:
        """Record what the recording lacks of what is kept; audit the champions of whom no audit is recorded."""
        times = dict(self._recorded.statistics)  # of those that are missing just behind the one before, so that they stand in order
        now = min(times.values(), default=time.time_ns()) - 2 - self._evolution.generation
        for generation in self.history.generations():
            number = generation.generation
            now = times.setdefault(number, now + 1)
            if number not in self._recorded.statistics:
                self._recorder.write(topics.STATISTICS.name, statistics_message(generation, 0.0, now * 1e-9), now)
        for number, champion in self.history.champions():
            if number not in self._recorded.champions:
                self._recorder.write(topics.CHAMPION.name, champion_message(number, champion, times[number] * 1e-9), times[number])
            if number not in self._recorded.audits:
                self._audit(number, champion)
        if self._of in self._recorded.audits:
            self.verdict = audit.verdict_of(self._recorded.audits[self._of])
        if self.champion is not None:
            self._save(self._of, self.champion)

    def expect(self, genomes: Sequence[Genome]) -> None:
        """Prepare to keep a generation, while its genomes are evaluated; in whatever thread."""
        self._checkpoints.expect(genomes)

    def take(self, generation: Generation, rate: float) -> None:
        """Record, keep and publish a generation, and the findings that are there.  Args: rate: evaluations/s."""
        now, number = time.time_ns(), generation.generation
        message = statistics_message(generation, rate, now * 1e-9)
        if number not in self._recorded.statistics:  # by a run that was ended before it was kept
            self._recorder.write(topics.STATISTICS.name, message, now)
        if generation.improved:
            champion = self.champion = self._evolution.champion
            self._of, self.verdict = number, self._not_audited
            told = champion_message(number, champion, now * 1e-9)
            if number not in self._recorded.champions:
                self._recorder.write(topics.CHAMPION.name, told, now)
        self._recorder.flush()  # before anybody hears of it
        self._keep(generation)
        self._statistics.publish(message)
        if generation.improved:
            self._champions.publish(told)
            self._save(number, champion)
            self._audit(number, champion)
        while self._auditor.ready:
            self._take_finding(self._auditor.next_finding())

    def _keep(self, generation: Generation) -> None:
        self.history.take(generation, self._evolution)
        self.history.write_if_due(generation.generation)
        self._checkpoints.write(self.champion, self._of, self.history.kept())
        self.sessions.write(generation.generation)

    def _audit(self, generation: int, champion: Individual) -> None:
        if self._options.task.kind.audit is not None and not champion.evaluation.cause and not self._options.rig:
            self._auditor.submit(generation, champion)

    def finish_audits(self, stop: Callable[[], bool]) -> None:
        """Wait for the audits that are under way; once `stop()` says to stop, for that of the last champion alone."""
        if len(self._auditor) > 2 and not stop():
            print(f"Auditing the last {len(self._auditor)} champions", flush=True)
        while len(self._auditor):
            if stop():
                self._auditor.drop_all_but_the_last()
            self._take_finding(self._auditor.next_finding())

    def _take_finding(self, finding: Finding) -> None:
        now = time.time_ns()
        message = audit_message(finding, now * 1e-9)
        self._recorder.write(topics.AUDIT.name, message, now)
        self._audits.publish(message)
        verdict = audit.verdict_of(finding.audit)
        if self.champion is not None and finding.generation == self._of:
            self.verdict = verdict
            self._save(finding.generation, self.champion)
        if not finding.audit.stands:
            tqdm.write(f"Audit of the champion of generation {finding.generation} {verdict}")

    def _save(self, generation: int, champion: Individual) -> None:
        e, task = champion.evaluation, self._options.task
        about = {
            "task": task.name, "cells": task.development.max_cells, "seed": self._options.seed, "generation": generation,
            "fitness": repr(e.fitness), "distance": repr(e.metrics.distance), "audit": self.verdict,
        }
        rig = {f"rig.{name}": value for name, value in dataclasses.asdict(task.rig).items() if value}
        about |= {name: ",".join(map(str, value)) if isinstance(value, tuple) else value for name, value in rig.items()}
        save_genome(self._options.out / "champion.yaml", champion.genome, about, task.development)
