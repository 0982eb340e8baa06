"""Recordings for tests: short lives and runs, written without any node."""

from evodevo_ga.evolution import Individual
from evodevo_ga.messages import champion_message, evolution_message, statistics_message
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import Recorder, record_performance
from genomes import dividing

from evodevo_ga import Evolution, Settings
from evodevo_sim import Evaluation, Metrics, Status, Task, evaluate, perform

TASK = with_settings(Task(), {"development.max_cells": 9, "development.steps": 80, "control_steps": 120})
START = 1_700_000_000_000_000_000  # ns
SECOND = 1_000_000_000


def life():
    """Growth and swim of nine cells."""
    return perform(dividing(), TASK)


def run_messages(generations=5):
    """(topic, message, stamp) of a small run: settings, statistics of each generation, champions."""
    settings = Settings(population=8, generations=generations)
    evolution = Evolution(settings, 4)
    yield "evolution/settings", evolution_message(settings, TASK, 4), START
    for k in range(generations):
        scores = [Evaluation(0.1 * k + 0.01 * i, Status.OK, "", Metrics()) for i in range(len(evolution.ask()))]
        generation, now = evolution.tell(scores), START + (k + 1) * SECOND
        yield "evolution/statistics", statistics_message(generation, 40.0, now * 1e-9), now
        if generation.improved:
            best = Individual(dividing(), evaluate(dividing(), TASK))
            yield "evolution/champion", champion_message(k, best, now * 1e-9), now


def write(directory, run=True, lived=True):
    """Record a run, a life, or both.  Returns the directory."""
    with Recorder(directory) as recorder:
        if run:
            for topic, message, stamp in run_messages():
                recorder.write(topic, message, stamp)
        if lived:
            record_performance(recorder, life(), START + 60 * SECOND)
    return directory

