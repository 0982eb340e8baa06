"""Audits: a sound fitness stands, one that the step made up does not, and every bad input is one line."""

import dataclasses
import time
from pathlib import Path

import numpy as np
import pytest
from evodevo_sim.commands.audit import main
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import Recorder
from evodevo_sim.recording.champion import champion_of
from evodevo_sim.tasks.audit import audit
from genomes import beating, pulsing

from evodevo_sim import Task, evaluate, perform, save_genome

SHORT = {"control_steps": 400}


@pytest.fixture(scope="module")
def genome():
    return pulsing()


@pytest.mark.parametrize("name", ["sample-swim", "sample-walk", "sample-chemotaxis"])
def test_samples_are_of_the_physics_that_is(name):
    champion = champion_of(Path(__file__).parents[1] / "bags" / name, {})
    assert evaluate(champion.genome, champion.task, champion.seed).fitness == pytest.approx(champion.fitness, rel=1e-6)


@pytest.mark.parametrize("name", ["swim", "walk", "chemotaxis"])
def test_any_number_of_finer_steps_runs_the_kernel_that_evaluations_compiled(name):
    from inspect import signature

    from evodevo_sim.tasks.chemotaxis.kernel import trials
    from evodevo_sim.tasks.swim.kernel import swim
    from evodevo_sim.tasks.walk.kernel import walk
    from numba import float64

    task = with_settings(default_task(name), {"control_steps": 8, "starts": 1, "settling_limit": 20})
    kernel = {"swim": swim, "walk": walk, "chemotaxis": trials}[name]
    steps = {finer: perform(beating(), task, finer=finer).evaluation.metrics.substeps for finer in (1, 1.5, 2, 2.0)}
    assert steps[2] == steps[2.0] and (name != "walk" or steps[1.5] == np.ceil(1.5 * steps[1]))
    place = list(signature(kernel.py_func).parameters).index("finer")
    assert {found.args[place] for found in kernel.nopython_signatures} == {float64}


def test_a_finer_run_differs_in_its_steps_alone(genome):
    task = with_settings(Task(), SHORT)
    coarse, fine = perform(genome, task), perform(genome, task, finer=8)
    assert not np.array_equal(coarse.position, fine.position)
    assert coarse.evaluation == evaluate(genome, task)
    assert np.array_equal(coarse.activation, fine.activation)
    assert np.abs(coarse.position - fine.position).max() < 0.02


def test_the_fitness_of_a_sound_genome_stands(genome):
    result = audit(genome, with_settings(Task(), SHORT))
    assert result.stands, result.faults
    assert [run.name for run in result.runs] == ["as evolved", "8 x finer", "order 5, adaptive"]
    assert result.evaluation.fitness > 0.5 and 0 < abs(result.runs[2].change) < 5e-3
    assert result.runs[2].fitness == pytest.approx(result.runs[1].fitness, rel=1e-6)  # scored from muscles and path by itself
    assert [run.gap < most for run, most in zip(result.runs, (5e-3, 1e-6, 1e-9))] == [True] * 3


def test_a_fitness_that_changes_more_than_asked_does_not_stand(genome):
    task = with_settings(Task(), {**SHORT, "control_step": 0.05, "material.damping": 0.0})
    result = audit(genome, task, most_change=1e-9)
    assert not result.stands and len(result.faults) == 2
    assert result.faults[0].startswith("8 x finer: fitness changes by ")


def test_a_quick_audit_finds_the_same_in_much_fewer_steps(genome):
    task = with_settings(Task(), SHORT)
    whole, quick = audit(genome, task), audit(genome, task, quick=True)
    assert quick.stands and dataclasses.astuple(quick.runs[0]) == dataclasses.astuple(whole.runs[0])
    assert not any(run.ledger for run in quick.runs[1:])
    for a, b in zip(whole.runs[1:], quick.runs[1:]):
        assert b.fitness == pytest.approx(a.fitness, rel=1e-4) and b.chamber == pytest.approx(a.chamber, rel=1e-4)


def test_motion_is_judged_apart_from_the_bonus_for_activity(genome):
    from evodevo_sim.tasks.audit import _faults

    task = with_settings(Task(), {**SHORT, "activity_bonus": 1e5})
    runs = list(audit(genome, task, quick=True).runs)
    assert runs[0].fitness > 1e4 and list(_faults(runs, 0.01)) == []
    runs[1] = dataclasses.replace(runs[1], sustained=runs[0].sustained * 1.5)
    assert abs(runs[1].change) < 1e-4 and [f[:46] for f in _faults(runs, 0.01)] == ["4 x finer: the sustained distance changes by +"]


def test_energy_that_nobody_put_in_does_not_stand(genome, monkeypatch):
    import evodevo_sim.tasks.audit

    monkeypatch.setattr(evodevo_sim.tasks.audit, "MOST_GAP", 1e-6)  # of the 5e-5 that default steps lose
    result = audit(genome, with_settings(Task(), SHORT))
    assert len(result.faults) == 1 and "of the energy is unexplained" in result.faults[0]


def test_what_fails_as_evolved_does_not_stand():
    from evodevo_sim import random_genome

    result = audit(random_genome(np.random.default_rng(0), 1))
    assert not result.stands and "as evolved" in result.faults[0]


def test_the_command_audits_a_file_and_a_recording(genome, tmp_path, capsys):
    from evodevo_ga.evolution import Individual, Settings
    from evodevo_ga.messages import champion_message, evolution_message

    save_genome(tmp_path / "a.yaml", genome)
    assert main([str(tmp_path / "a.yaml"), "--set", "control_steps=400"]) == 0
    said = capsys.readouterr().out
    assert said.count("\n") == 5 and said.endswith("The fitness stands.\n")

    task = with_settings(Task(), SHORT)
    with Recorder(tmp_path / "run") as recorder:
        now = time.time_ns()
        recorder.write("evolution/settings", evolution_message(Settings(), task, 1), now)
        recorder.write("evolution/champion", champion_message(0, Individual(genome, evaluate(genome, task)), 0.0), now)
    assert main([str(tmp_path / "run")]) == 0
    assert "The fitness stands." in capsys.readouterr().out


def test_bad_input_is_one_line(genome, tmp_path, capsys):
    save_genome(tmp_path / "a.yaml", genome)
    (tmp_path / "b.yaml").write_text("position: []")
    a = str(tmp_path / "a.yaml")
    for arguments, says in (
        ([str(tmp_path / "none.yaml")], "No such file"), ([str(tmp_path / "b.yaml")], "not a genome file"),
        ([str(tmp_path)], "holds no .mcap file"), ([a, "--within", "nan"], "--within is nan"),
        ([a, "--set", "control_step=0"], "task.control_step is 0"),
        ([str(tmp_path), "--set", "control_steps=4"], "names its own task"),
    ):
        with pytest.raises(SystemExit) as raised:
            main(arguments)
        said = capsys.readouterr().err
        assert raised.value.code == 2 and says in said and said.count("\n") == 1


# --- seekers ------------------------------------------------------------------------------------------------------------

SEEKER = with_settings(default_task("chemotaxis"), {**SHORT, "development.max_cells": 12, "chemotaxis.least_distance": 0.0})


@pytest.fixture(scope="module")
def seeker(genome):
    x, y = genome.x.copy(), genome.y.copy()
    x[3], y[3] = genome.x[7] + 3.5, genome.y[7]  # scent within reach of the contraction output
    return dataclasses.replace(genome, x=x, y=y)


@pytest.mark.parametrize("quick", [False, True])
def test_every_swim_of_a_seeker_is_audited(seeker, quick):
    result = audit(seeker, SEEKER, quick=quick)
    assert result.stands, result.faults
    evolved, finer, better = result.runs
    metrics = result.evaluation.metrics
    assert result.evaluation == evaluate(seeker, SEEKER) and evolved.fitness == pytest.approx(result.evaluation.fitness, rel=1e-9)
    assert evolved.near[0] == pytest.approx(metrics.steering.left_distance, abs=1e-9) and len(evolved.near) == len(better.near)
    assert 0 < abs(better.near[0] - evolved.near[0]) < 0.02 and better.near == pytest.approx(finer.near, abs=1e-2)
    assert bool(finer.ledger) != quick and evolved.gap < 5e-3


def test_a_seeker_that_ends_elsewhere_in_finer_steps_does_not_stand(seeker):
    from evodevo_sim.tasks.audit import _faults

    runs = list(audit(seeker, SEEKER, quick=True).runs)
    runs[2] = dataclasses.replace(runs[2], near=(runs[2].near[0] + 0.2, *runs[2].near[1:]))
    assert [fault[:26] for fault in _faults(runs, 0.01)] == ["order 5, adaptive: it ends"]
