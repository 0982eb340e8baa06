"""What a run tells at its end: the life and the gait of its champion, recorded and in words."""

from __future__ import annotations

import shlex
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from evodevo_sim.analysis.gait import GaitError, analyse, track_of_performance
from evodevo_sim.analysis.gait.table import headline
from evodevo_sim.recording import record_performance
from evodevo_sim.recording.performance import seen_alone
from evodevo_sim.recording.writer import Recorder
from evodevo_sim.ros import topics
from evodevo_sim.ros.command_line import see_it
from evodevo_sim.ros.messages import gait_message
from evodevo_sim.tasks.outcome import FAILURE, Status

from evodevo_sim import perform

from ..arguments import Options
from ..evolution import Evolution, Individual
from ..times import CHAMPION, RECORDING, Times
from .rig import Rig

_BLOWN = "lower drag, stiffness, damping or pressure, or shorten task.control_step, by --set"
_MEND = {Status.UNSTABLE: _BLOWN, Status.INVERTED: "raise material.pressure, by --set, or give another --seed"}


def record_life(
    champion: Individual, options: Options, recorder: Recorder, times: Times, rig: Rig | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> str:
    """Record the whole life of a champion, and its gait.  Returns: the gait in words.  Args: rig: on which it lives, until `stop()`."""
    with times(CHAMPION):
        genome, task, seed = champion.genome, options.task, options.seed
        performance = rig.perform(genome, task, seed, stop) if rig else perform(genome, task, seed)
        try:
            gait = analyse(track_of_performance(seen_alone(performance), options.task)).gait
        except GaitError as error:
            told = f"none, {error}"
        else:
            recorder.write(topics.GAIT.name, gait_message(gait), time.time_ns())
            told = headline(gait)
    with times(RECORDING):
        record_performance(recorder, performance, time.time_ns())
    return told


def told(evolution: Evolution, champion: Individual, verdict: str, gait: str, options: Options) -> str:
    """The outcome of a run.  Args: verdict: of the champion's audit; gait: in words."""
    m = champion.evaluation.metrics
    return (
        f"{evolution.generation + 1} generations, {evolution.evaluations} evaluations. "
        f"{'Best of those that failed' if champion.evaluation.cause else 'Champion'}: fitness {champion.evaluation.fitness:.3f}, "
        f"{m.cells} cells, {m.chambers} chambers, "
        f"{m.distance:.2f} cell diameters in all, {m.distance_second_half:.2f} in the second half, "
        f"activation amplitude {m.activation_amplitude:.2f}.\n"
        f"Audit:    {verdict}\n"
        f"Gait:     {gait}.\n"
        f"{see_it(options.out)}\n"
        f"Genome:   {options.out / 'champion.yaml'}"
    )


def go_on(directory: Path) -> str:
    """The line that says how a run goes on, to be typed as it stands."""
    return f"Go on:    ros2 run evodevo_ga evolve --resume {shlex.quote(str(directory))}"


def why_nothing_evolved(population: Sequence[Individual]) -> str:
    """Of a run whose best individual failed: what most of the last population failed by, and the mend."""
    status, count = Counter(one.evaluation.status for one in population).most_common(1)[0]
    return (
        f"nothing viable evolved: all of the last {len(population)} individuals failed, {count} of them because {FAILURE[status][1]}; "
        f"{_MEND.get(status, 'give more generations, or another --seed')}"
    )
