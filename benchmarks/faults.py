#!/usr/bin/env python
"""A run under faults: `evolve` and its simulators are stopped and killed, and its results are held against the undisturbed run's.

    python benchmarks/faults.py [--simulators 2] [--threads 1] [--evolve-stop 15] [--stops 8 60] [--kills 5] [--cells 12] [--steps 400]

Simulators are `evolve`'s own.  Each fault is made while generations go on.  Printed are the seconds from the end of each stop, or from
each kill, to the next generation, and whether every generation's best, median and diversity, and the champion, have the bits of the
same run in this process.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
import rclpy
from evodevo_ga.in_process import evaluate_all
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.ros.topics import STATISTICS
from rclpy.executors import SingleThreadedExecutor
from rich.console import Console
from rich.table import Table

from evodevo_ga import Evolution, Settings
from evodevo_sim import Task, load_genome

SEED, POPULATION = 3, 20
LONGEST = 180.0  # s to wait for a generation


class Watched:
    """An `evolve` whose generations are heard, as a context."""

    def __init__(self, *arguments, out):
        stay_on_this_host()
        with loopback_alone():
            rclpy.init()
        self.node, self.executor = rclpy.create_node("watch"), SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.generation = -1
        self.node.create_subscription(STATISTICS.type, STATISTICS.name, self._hear, STATISTICS.quality)
        command = [sys.executable, "-m", "evodevo_ga.evolve", "--seed", str(SEED), "--quiet", *arguments, "--out", str(out)]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL)

    def _hear(self, message):
        self.generation = max(self.generation, message.generation)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.node.destroy_node()
        rclpy.try_shutdown()

    def more(self, generations=2):
        """Wait for so many new generations.  Returns: s until the first one was heard."""
        began, before, first = time.monotonic(), self.generation, None
        while self.generation < before + generations:
            if self.process.poll() is not None or time.monotonic() > began + LONGEST:
                raise SystemExit(f"no generation after {before} in {time.monotonic() - began:.0f} s: exit code {self.process.poll()}")
            self.executor.spin_once(timeout_sec=0.02)
            if first is None and self.generation > before:
                first = time.monotonic() - began
        return first

    def simulators(self):
        return [child for child in psutil.Process(self.process.pid).children() if "evodevo_sim.commands.simulator" in child.cmdline()]

    def stopped(self, processes, seconds):
        """Stop processes for so long.  Returns: s from its end to the next generation."""
        for number in processes:
            os.kill(number, signal.SIGSTOP)
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.executor.spin_once(timeout_sec=0.05)
        for number in processes:
            os.kill(number, signal.SIGCONT)
        return self.more()

    def end(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(120.0)


def differences(out, task):
    """Generations, and what differs from the same run in this process, in words."""
    recording = read_recording(out)
    evolution, wrong = Evolution(Settings(population=POPULATION, generations=10**6), SEED), []
    for told in recording.statistics:
        found = evolution.tell(evaluate_all(evolution.ask(), task, SEED, len(os.sched_getaffinity(0))))
        if (found.best, found.median, found.diversity, found.evaluations) != (told.best, told.median, told.diversity, told.evaluations):
            wrong.append(f"generation {found.generation}")
        if found.improved:
            champion = evolution.champion.genome
    if load_genome(out / "champion.yaml") != champion:
        wrong.append("champion")
    return len(recording.statistics), wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--simulators", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--evolve-stop", type=float, default=15.0)
    parser.add_argument("--stops", type=float, nargs="*", default=[8.0, 60.0])
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--cells", type=int, default=12)
    parser.add_argument("--steps", type=int, default=400)
    given = parser.parse_args()
    task = with_settings(Task(), {"development.max_cells": given.cells, "control_steps": given.steps})
    arguments = ["--generations", "1000000", "--population", str(POPULATION), "--scheme", "panmictic", "--cells", str(given.cells)]
    arguments += ["--set", f"control_steps={given.steps}", "--simulators", str(given.simulators), "--threads", str(given.threads)]
    rows = []
    with tempfile.TemporaryDirectory() as directory:
        out = Path(directory, "run")
        with Watched(*arguments, out=out) as run:
            run.more(3)
            rows.append((f"evolve stopped for {given.evolve_stop:g} s", run.stopped([run.process.pid], given.evolve_stop)))
            for seconds in given.stops:
                for count in sorted({1, given.simulators}):
                    numbers = [one.pid for one in run.simulators()[:count]]
                    what = f"{len(numbers)} of {given.simulators} simulators stopped for {seconds:g} s"
                    rows.append((what, run.stopped(numbers, seconds)))
            for k in range(given.kills):
                simulators = run.simulators()
                simulators[k % len(simulators)].kill()
                rows.append(("a simulator killed", run.more()))
            code = run.end()
        generations, wrong = differences(out, task)
    shown = Table("fault", title=f"{generations} generations of {POPULATION}, {given.simulators} simulators of {given.threads} threads")
    shown.add_column("s to the next generation", justify="right")
    for what, seconds in rows:
        shown.add_row(what, f"{seconds:.2f}")
    Console().print(shown)
    print(f"exit code {code}; differs from the undisturbed run in: {', '.join(wrong[:5]) or 'nothing'}")


if __name__ == "__main__":
    main()
