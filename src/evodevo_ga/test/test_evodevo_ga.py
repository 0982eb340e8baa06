"""The installed package, as `colcon test` runs it.  The suite is in `tests/` of the repository."""

from importlib.metadata import distribution

from evodevo_ga.in_process import evaluate_all
from evodevo_sim.parameters import with_settings

from evodevo_ga import Evolution, Settings
from evodevo_sim import Task


def test_a_search_of_two_generations_keeps_the_best():
    evolution = Evolution(Settings(population=4, elite=1, tournament=2, generations=2), seed=1)
    best = []
    while not evolution.finished:
        best.append(evolution.tell(evaluate_all(evolution.ask(), with_settings(Task(), {"control_steps": 60}))).best)
    assert len(best) == 2 and best[1] >= best[0] and evolution.champion.evaluation.fitness == best[1]


def test_entry_points_load():
    commands = [one for one in distribution("evodevo_ga").entry_points if one.group == "console_scripts"]
    assert commands and all(callable(one.load()) for one in commands)
