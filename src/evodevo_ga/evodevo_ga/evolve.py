"""`ros2 run evodevo_ga evolve`: the node that evolves animats on simulator nodes and records the run."""

from __future__ import annotations

import signal
import sys
import time
from collections import Counter

import rclpy
from evodevo_sim.analysis.gait import GaitError, analyse, track_of_performance
from evodevo_sim.analysis.gait.table import headline
from evodevo_sim.command_process import exit_code, heeded
from evodevo_sim.recording import RecordingError, record_performance
from evodevo_sim.recording.guarded import GuardedRecorder
from evodevo_sim.ros import topics
from evodevo_sim.ros.command_line import see_it
from evodevo_sim.ros.environment import EnvironmentFault, started
from evodevo_sim.ros.messages import gait_message
from evodevo_sim.ros.own_simulators import OwnSimulators
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.tasks import audit
from evodevo_sim.tasks.evaluation import prepare
from evodevo_sim.tasks.outcome import FAILURE, Status
from rclpy.experimental import EventsExecutor
from rich.console import Console
from tqdm import tqdm

from evodevo_sim import perform, save_genome

from .arguments import Options, cores, parse
from .auditor import Auditor, Finding
from .evolution import Evolution, Individual
from .fleet import Fleet, FleetError, find_simulators
from .messages import audit_message, champion_message, evolution_message, statistics_message
from .settings import UNLIMITED
from .times import AUDITS, BREEDING, CHAMPION, EVALUATION, RECORDING, START, Times, table

_DISCOVERY_OF_ALL = 4.0  # s from the node's start to look on where one is found: others' DDS may announce itself every 3 s
_MORE = 0.5  # s at the least to look, and to wait for another one after each
_ANSWER = 5.0  # s for a simulator of the graph to answer; one that was killed is listed for a while
_START = 60.0  # s for one of our own to start
_NOT_AUDITED = "not audited"
_BLOWN = "lower drag, stiffness, damping or pressure, or shorten task.control_step, by --set"
_MEND = {Status.UNSTABLE: _BLOWN, Status.INVERTED: "raise material.pressure, by --set, or give another --seed"}


class _Stop:
    """Set by the first signal, which `process.heeded` hands it."""

    asked = False

    def ask(self, number: int) -> None:
        self.asked = True
        again = "" if number == signal.SIGHUP else " Once more to end at once."
        print(f"\nStopping: keeping what was done.{again}", file=sys.stderr)

    def __call__(self) -> bool:
        return self.asked


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    return evolve(parse(arguments), arguments)


def evolve(options: Options, arguments: list[str]) -> int:
    """Evolve as the command line says.  Args: arguments: those of ROS among them.  Returns: the exit code."""
    stop = _Stop()
    stay_on_this_host()
    try:
        with GuardedRecorder(options.out) as recorder, started("evolve", arguments):
            run = _Run(options, recorder, stop)
            with run.times(START):
                prepare(options.task)  # before simulators start, so that they only load the kernels
                audit.prepare(options.task)
            with heeded(stop.ask), Auditor(options.task, options.seed) as run.auditor:
                return run.go()
    except (EnvironmentFault, RecordingError, FleetError) as error:
        print(f"evolve: {error}", file=sys.stderr)
        return 2


class _Run:
    """One run: the node, its simulators and its recording, around an `Evolution`."""

    def __init__(self, options: Options, recorder, stop: _Stop):
        self.options, self.recorder, self.stop = options, recorder, stop
        self.node = rclpy.create_node("evolve")
        self.began = time.monotonic()
        self.times = Times()
        self.executor = EventsExecutor()
        self.executor.add_node(self.node)
        self.statistics, self.champions, self.audits = (
            self.node.create_publisher(topic.type, topic.name, topic.quality)
            for topic in (topics.STATISTICS, topics.CHAMPION, topics.AUDIT)
        )
        self.auditor: Auditor  # set before `go`
        self.champion: Individual | None = None  # the one recorded last; drift may put its equals before it
        self.verdict = _NOT_AUDITED  # on it
        self.evolution = Evolution(options.settings, options.seed, options.start, options.scheme, options.task)

    def go(self) -> int:
        try:
            self._find_simulators_and_evolve()
        except FleetError:
            if self.evolution.population:
                self._finish()
            raise
        return self._finish()

    def _find_simulators_and_evolve(self) -> None:
        o = self.options
        self.recorder.write(topics.SETTINGS.name, evolution_message(o.settings, o.task, o.seed, o.start, o.scheme), time.time_ns())
        count, log = o.simulators or cores(), o.out / "simulators.log"
        with OwnSimulators(count, log, task=o.task.name) as own:  # they start while we look for others
            with self.times(START):
                fleet = None if o.simulators else self._others()
                if fleet:
                    own.end()
                    log.unlink()
                else:
                    print(f"Evolving on {count} simulators of our own; recording to {o.out}", flush=True)
                    fleet = Fleet(self.node, self.executor, own.services, self.times)
                    fleet.wait(_START, own.alive, self.stop)
            self._evolve(fleet)

    def _others(self) -> Fleet | None:
        """The simulators of the graph, if there are any that answer."""
        services = self._find()
        if not services:
            return None
        fleet = Fleet(self.node, self.executor, services, self.times)
        try:
            fleet.wait(_ANSWER, stop=self.stop)
        except FleetError:  # those that were killed are listed for a while
            print(f"The simulators of the graph do not answer: {', '.join(services)}")
            return None
        print(f"Evolving on {len(services)} simulators of the graph: {', '.join(services)}; recording to {self.options.out}", flush=True)
        return fleet

    def _find(self) -> list[str]:
        """The simulators on the graph.  Discovery goes on in threads of its own since the node began, also while we compiled."""
        found: list[str] = []
        until = max(self.began + self.options.look, time.monotonic() + _MORE)
        while time.monotonic() < until and not self.stop():
            services = find_simulators(self.node)
            if services != found:
                found, until = services, max(self.began + max(self.options.look, _DISCOVERY_OF_ALL), time.monotonic() + _MORE)
            self.executor.spin_once(timeout_sec=0.05)
        return found

    def _evolve(self, fleet: Fleet) -> None:
        o = self.options
        most = None if o.settings.generations == UNLIMITED else o.settings.generations
        bar = tqdm(total=most, unit="gen", disable=o.quiet, mininterval=0.1 if sys.stderr.isatty() else 5.0)
        with bar:
            while not (self.evolution.finished or self.stop()):
                began = time.monotonic()
                with self.times(BREEDING):
                    asked = self.evolution.ask()
                with self.times(EVALUATION):
                    best = self.champion.evaluation.fitness if self.champion else float("-inf")
                    evaluations = fleet.evaluate(asked, o.task, o.seed, self.stop, best)
                if evaluations is None:
                    break
                with self.times(BREEDING):
                    generation = self.evolution.tell(evaluations)
                rate = len(asked) / (time.monotonic() - began)
                with self.times(RECORDING):
                    self._record(generation, rate)
                bar.set_postfix_str(
                    f"best {generation.best:.3f}, median {generation.median:.3f}, diversity {generation.diversity:.2f}, "
                    f"{rate:.0f} evaluations/s",
                    refresh=False,
                )
                bar.update()

    def _record(self, generation, rate: float) -> None:
        now = time.time_ns()
        message = statistics_message(generation, rate, now * 1e-9)
        self.recorder.write(topics.STATISTICS.name, message, now)
        if generation.improved:
            champion = self.champion = self.evolution.champion
            self.verdict = _NOT_AUDITED
            told = champion_message(generation.generation, champion, now * 1e-9)
            self.recorder.write(topics.CHAMPION.name, told, now)
        self.recorder.flush()  # before anybody hears of it
        self.statistics.publish(message)
        if generation.improved:
            self.champions.publish(told)
            _save(self.options, generation.generation, champion, self.verdict)
            if self.options.task.kind.audit is not None and not champion.evaluation.cause:
                self.auditor.submit(generation.generation, champion)
        while self.auditor.ready:
            self._record_finding(self.auditor.next_finding())

    def _record_finding(self, finding: Finding) -> None:
        now = time.time_ns()
        message = audit_message(finding, now * 1e-9)
        self.recorder.write(topics.AUDIT.name, message, now)
        self.audits.publish(message)
        verdict = audit.verdict_of(finding.audit)
        if finding.champion is self.champion:
            self.verdict = verdict
            _save(self.options, finding.generation, finding.champion, verdict)
        if not finding.audit.stands:
            tqdm.write(f"Audit of the champion of generation {finding.generation} {verdict}")

    def _finish_audits(self) -> None:
        if len(self.auditor) > 2 and not self.stop():
            print(f"Auditing the last {len(self.auditor)} champions", flush=True)
        while len(self.auditor):
            if self.stop():
                self.auditor.drop_all_but_the_last()
            self._record_finding(self.auditor.next_finding())

    def _finish(self) -> int:
        champion = self.champion
        if champion is None:  # it is found with the first generation
            print(f"Stopped before the first generation: {self.options.out} holds the settings alone.")
            return 130
        with self.times(AUDITS):
            self._finish_audits()
        with self.times(CHAMPION):
            performance = perform(champion.genome, self.options.task, self.options.seed)
            gait = self._gait(performance)
        with self.times(RECORDING):
            record_performance(self.recorder, performance, time.time_ns())
        m = champion.evaluation.metrics
        viable = not champion.evaluation.cause
        if not viable:
            print(f"evolve: {self._why_nothing_evolved()}", file=sys.stderr)
        print(
            f"{self.evolution.generation + 1} generations, {self.evolution.evaluations} evaluations. "
            f"{'Champion' if viable else 'Best of those that failed'}: fitness {champion.evaluation.fitness:.3f}, "
            f"{m.cells} cells, {m.chambers} chambers, "
            f"{m.distance:.2f} cell diameters in all, {m.distance_second_half:.2f} in the second half, "
            f"activation amplitude {m.activation_amplitude:.2f}.\n"
            f"Audit:    {self.verdict}\n"
            f"Gait:     {gait}.\n"
            f"{see_it(self.options.out)}\n"
            f"Genome:   {self.options.out / 'champion.yaml'}"
        )
        if not self.options.quiet:
            note = f"beside it: {self.auditor.done} audits, {self.auditor.cpu:.1f} s of one core"
            Console().print(table(self.times.seconds(), note))
        return exit_code() or (0 if viable else 1)

    def _why_nothing_evolved(self) -> str:
        """Of a run whose best individual failed: what most of the last population failed by, and the mend."""
        population = [one.evaluation for one in self.evolution.population]
        status, count = Counter(one.status for one in population).most_common(1)[0]
        return (
            f"nothing viable evolved: all of the last {len(population)} individuals failed, {count} of them because {FAILURE[status][1]}; "
            f"{_MEND.get(status, 'give more generations, or another --seed')}"
        )

    def _gait(self, performance) -> str:
        """Find and record the gait of the champion.  Returns: it in words."""
        try:
            gait = analyse(track_of_performance(performance, self.options.task)).gait
        except GaitError as error:
            return f"none, {error}"
        self.recorder.write(topics.GAIT.name, gait_message(gait), time.time_ns())
        return headline(gait)


def _save(options: Options, generation: int, champion: Individual, verdict: str) -> None:
    e = champion.evaluation
    about = {
        "task": options.task.name, "cells": options.task.development.max_cells, "seed": options.seed, "generation": generation,
        "fitness": repr(e.fitness), "distance": repr(e.metrics.distance), "audit": verdict,
    }
    save_genome(options.out / "champion.yaml", champion.genome, about)


if __name__ == "__main__":
    from .commands import evolve as entry

    sys.exit(entry())
