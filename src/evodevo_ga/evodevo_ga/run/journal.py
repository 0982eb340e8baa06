"""What a run leaves while it goes on: its recording, its topics, the file of its champion, and the audits beside it."""

from __future__ import annotations

import time
from typing import Any

from evodevo_sim.recording.writer import Recorder
from evodevo_sim.ros import topics
from evodevo_sim.tasks import audit
from tqdm import tqdm

from evodevo_sim import save_genome

from ..arguments import Options
from ..auditor import Auditor, Finding
from ..evolution import Evolution, Generation, Individual
from ..messages import audit_message, champion_message, evolution_message, statistics_message

_NOT_AUDITED = "not audited"


class Journal:
    """Records and publishes the generations of a run, and has its new champions audited.

    Attributes: champion: the one recorded last, or None; drift may put its equals before it; verdict: on it.
    """

    def __init__(self, options: Options, recorder: Recorder, node: Any, auditor: Auditor):
        self._options, self._recorder, self._auditor = options, recorder, auditor
        self._statistics, self._champions, self._audits = (
            node.create_publisher(topic.type, topic.name, topic.quality) for topic in (topics.STATISTICS, topics.CHAMPION, topics.AUDIT)
        )
        self.champion: Individual | None = None
        self.verdict = _NOT_AUDITED

    def begin(self) -> None:
        """Record the settings of the run."""
        o = self._options
        self._recorder.write(topics.SETTINGS.name, evolution_message(o.settings, o.task, o.seed, o.start, o.scheme), time.time_ns())

    def take(self, generation: Generation, evolution: Evolution, rate: float) -> None:
        """Record and publish a generation, and the findings that are there.  Args: rate: evaluations/s."""
        now = time.time_ns()
        message = statistics_message(generation, rate, now * 1e-9)
        self._recorder.write(topics.STATISTICS.name, message, now)
        if generation.improved:
            champion = self.champion = evolution.champion
            self.verdict = _NOT_AUDITED
            told = champion_message(generation.generation, champion, now * 1e-9)
            self._recorder.write(topics.CHAMPION.name, told, now)
        self._recorder.flush()  # before anybody hears of it
        self._statistics.publish(message)
        if generation.improved:
            self._champions.publish(told)
            self._save(generation.generation, champion)
            if self._options.task.kind.audit is not None and not champion.evaluation.cause:
                self._auditor.submit(generation.generation, champion)
        while self._auditor.ready:
            self._take_finding(self._auditor.next_finding())

    def finish_audits(self, stop) -> None:
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
        if finding.champion is self.champion:
            self.verdict = verdict
            self._save(finding.generation, finding.champion)
        if not finding.audit.stands:
            tqdm.write(f"Audit of the champion of generation {finding.generation} {verdict}")

    def _save(self, generation: int, champion: Individual) -> None:
        e, task = champion.evaluation, self._options.task
        about = {
            "task": task.name, "cells": task.development.max_cells, "seed": self._options.seed, "generation": generation,
            "fitness": repr(e.fitness), "distance": repr(e.metrics.distance), "audit": self.verdict,
        }
        save_genome(self._options.out / "champion.yaml", champion.genome, about)
