"""The table of tasks: each entry has all that those who ask need, and a task from outside works like those from inside."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from evodevo_ga.arguments import parse
from evodevo_ga.feasible import check
from evodevo_ga.usual import usual_task
from evodevo_sim.analysis.gait.sources import ground_of_task
from evodevo_sim.live import Animat
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.messages import task_from_message, task_message
from evodevo_sim.task_kinds import kind_of, names, register
from evodevo_sim.tasks.audit import audit
from evodevo_sim.worlds import with_world
from genomes import pulsing

from evodevo_ga import SCHEMES, Settings, default_scheme, scheme
from evodevo_sim import ParameterError, Task, evaluate, perform

ROOT = Path(__file__).resolve().parents[1]
SMALL = {"development.max_cells": 9, "control_steps": 80, "starts": 1}


@pytest.mark.parametrize("name", names())
def test_whoever_asks_for_a_task_finds_what_it_needs(name):
    task = with_settings(default_task(name), SMALL)
    kind = task.kind
    for function in ("run", "begin"):
        assert callable(kind.function(function))
    check(task, Settings(**scheme(default_scheme(name), name)))
    assert kind.scheme in SCHEMES and set(kind.search) <= set(Settings.__dataclass_fields__)
    assert parse(["--task", name, "--out", "nowhere"]).task == usual_task(name) or name == "walk"
    assert task_from_message(task_message(task)) == task
    assert (ground_of_task(task) is not None) == kind.has_ground
    if kind.has_ground:
        assert with_world(task, "steps").scene.ground_x
    else:
        with pytest.raises(ParameterError, match="on the ground"):
            with_world(task, "steps")
    performance = perform(pulsing(), task)
    assert performance.evaluation == evaluate(pulsing(), task)
    animat = Animat(pulsing(), task)
    for _ in range(3):
        animat.step()
    assert np.isfinite(animat.position).all() and animat.steps == 3


@pytest.mark.parametrize("name", [name for name in names() if kind_of(name).audit is not None])
def test_whoever_has_an_audit_is_audited(name):
    found = audit(pulsing(), with_settings(default_task(name), {**SMALL, "control_steps": 40}), quick=True)
    assert found.runs[0].name == "as evolved"


@pytest.mark.parametrize("name", names())
def test_what_a_task_does_not_use_or_needs_is_refused_by_name(name):
    task = default_task(name)
    for setting in task.kind.unused:
        with pytest.raises(ParameterError, match=setting):
            with_settings(task, {setting: 0.5})
    if task.kind.needed:
        with pytest.raises(ParameterError, match=task.kind.needed[0]):
            check(with_settings(task, dict.fromkeys(task.kind.needed, 0.0)), Settings())


def test_an_unknown_task_names_those_that_exist():
    with pytest.raises(ParameterError, match="'fly' is unknown: choose one of swim, walk, chemotaxis"):
        Task("fly")
    with pytest.raises(ValueError, match="registered already"):
        register(kind_of("walk").__class__(**{**vars(kind_of("walk")), "what": "another"}))


def outside(**variables):
    path = os.pathsep.join(filter(None, (str(ROOT / "examples" / "climb"), os.environ.get("PYTHONPATH"))))
    return os.environ | {"PYTHONPATH": path, "EVODEVO_TASKS": "climb"} | variables


def test_a_task_from_outside_is_evaluated_by_its_own_fitness():
    code = (
        "from evodevo_sim import evaluate, load_genome, perform\n"
        "from evodevo_sim.parameters import default_task\n"
        f"genome = load_genome(r'{ROOT}/src/evodevo_sim/champions/jumper.yaml')\n"
        "task = default_task('climb'); seen = perform(genome, task)\n"
        "assert seen.evaluation == evaluate(genome, task)\n"
        "print(task.name, seen.evaluation.fitness, seen.position[-1, :, 1].mean() - seen.position[0, :, 1].mean())"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=outside(), timeout=120)
    name, fitness, gained = result.stdout.split()
    assert name == "climb" and 0.0 <= float(fitness) <= max(0.0, float(gained)) + 0.5 + 1e-9, result.stderr


def test_a_task_from_outside_evolves_on_simulator_nodes(tmp_path):
    command = [
        sys.executable, "-m", "evodevo_ga.evolve", "--task", "climb", "--generations", "1", "--population", "4", "--elite", "1",
        "--tournament",
        "2", "--simulators", "1", "--quiet", "--set", "control_steps=80", "--out", str(tmp_path / "run"),
        "--start", str(ROOT / "src/evodevo_sim/champions/walker.yaml"),
    ]
    result = subprocess.run(command, capture_output=True, text=True, env=outside(), timeout=200)
    assert result.returncode == 0, result.stderr
    assert "Champion: fitness" in result.stdout and "not audited" in result.stdout
