"""A rig in the simulated body: the actuators of the emulated one, the same bits where it does nothing, and carried wherever a task goes."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest
from evodevo_ga.arguments import parse
from evodevo_ga.keeping.checkpoint import settings_hash, task_of_plain
from evodevo_ga.keeping.resume import _refuse_changes as refuse
from evodevo_ga.report.differences import command, differences
from evodevo_sim.brain.eyes import eyes_of, see
from evodevo_sim.commands.request import main as request
from evodevo_sim.hardware.calibration import calibration_of
from evodevo_sim.hardware.chain import ActuatorChain, SensorChain
from evodevo_sim.hardware.emulator import EmulatedBody
from evodevo_sim.hardware.rig import Rig as File
from evodevo_sim.hardware.rig import make_rig, plant_settings, rig_of, settings_of
from evodevo_sim.hardware.stepped import SteppedBody
from evodevo_sim.hardware.trial import trial
from evodevo_sim.live import Animat
from evodevo_sim.parameters import MOST_WAIT, ParameterError, Rig, default_task, with_settings
from evodevo_sim.plant.muscles import muscles_had
from evodevo_sim.ros.messages import task_from_message, task_message
from evodevo_sim.tasks.audit import audit
from genomes import beating, pulsing
from hypothesis import given, settings
from hypothesis import strategies as some

from evodevo_ga import Evolution, Settings
from evodevo_sim import evaluate, load_champion, perform, save_genome

STEP, CELLS = 1 / 60, 5
SWIM = with_settings(default_task("swim"), {"control_steps": 240, "development.max_cells": 12})
SLOW = {"rig.lag": 0.15, "rig.dead_time": 0.04, "rig.rate": 4.0, "rig.resolution": 0.02}
SLOW |= {"rig.dead_cells": "1", "rig.failures": 2, "rig.fail_at": 1}


def off_or(low, high):
    return some.just(0.0) | some.floats(low, high)


@settings(deadline=None, max_examples=40)
@given(
    off_or(1e-4, 1.0), off_or(0.0, 0.3), off_or(0.05, 100.0), off_or(1e-12, 1.0), some.sets(some.integers(0, CELLS - 1), max_size=2),
    some.integers(0, 3), some.floats(0.0, 0.5), some.integers(0, 2**32),
)
def test_simulated_actuators_follow_those_of_the_emulator(lag, dead_time, rate, resolution, dead, failures, fail_at, seed):
    rig = Rig(lag, dead_time, rate, resolution, tuple(dead), failures=failures, fail_at=fail_at)
    asked = np.random.default_rng(seed).uniform(-1, 1, (50, CELLS))
    asked[0] = 0.0  # as the emulator begins
    found = muscles_had(asked, dataclasses.replace(SWIM, rig=rig), seed)
    chain = ActuatorChain(rig_of(rig).actuators, CELLS, STEP)
    for step, row in enumerate(asked[1:]):
        if step == Rig.steps(fail_at, STEP):
            chain.fail_by_lot(failures, seed)
        assert np.allclose(chain.step(row), found[step + 1], rtol=0.0, atol=1e-12)


@settings(deadline=None, max_examples=20)
@given(off_or(0.0, 0.2), off_or(1e-3, 0.5), some.integers(0, 2**32))
def test_simulated_eyes_follow_those_of_the_emulator(delay, resolution, seed):
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": CELLS, "rig.sensor_resolution": resolution})
    task = with_settings(task, {"rig.sensor_delay": delay, "rig.sensor_noise": 1e-15})
    eyes, path = eyes_of(task), np.random.default_rng(seed).uniform(-5, 5, (40, CELLS, 2))
    sensors = SensorChain(make_rig({"sensors": {"delay": delay, "resolution": resolution}}).sensors, path[0], STEP, 0)
    random = np.array([seed, 1], np.uint64)
    for step, place in enumerate(path):
        see(eyes, np.ascontiguousarray(place.T), random, step)
        assert np.allclose(eyes.seen[:2].T, sensors.see(place), atol=1e-9)


def test_eyes_are_noisy_and_keep_what_they_lose():
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": 100, "rig.sensor_noise": 0.1, "rig.sensor_lost": 0.25})
    eyes, random, place, before, lost, off = eyes_of(task), np.array([3, 0], np.uint64), np.zeros((2, 100)), None, [], []
    for step in range(200):
        see(eyes, place, random, step)
        if before is not None:
            lost.append((eyes.seen[0] == before[0]) & (eyes.seen[1] == before[1]))
        before = eyes.seen[:2].copy()
        off.append(before)
    assert abs(np.mean(lost) - 0.25) < 0.02 and abs(np.std(off) - 0.1) < 0.005


@pytest.mark.parametrize("nothing", [
    {"rig.dead_time": 0.4 * STEP, "rig.sensor_delay": 0.4 * STEP, "rig.resolution": 1e-10}, {"rig.fail_at": 3.0},
    {"rig.dead_cells": "40", "rig.failing_cells": "12"}, {"rig.rate": 1e6}, {"rig.failures": 1, "rig.fail_at": 1000.0},
])
def test_a_rig_that_does_nothing_changes_no_bit(nothing):
    assert evaluate(beating(), with_settings(SWIM, nothing), 1) == evaluate(beating(), SWIM, 1)


def test_a_swimmer_feels_its_rig_and_equal_seeds_fail_alike():
    slow = with_settings(SWIM, SLOW)
    plain, first, other = evaluate(beating(), SWIM, 1), evaluate(beating(), slow, 1), evaluate(beating(), slow, 2)
    assert first == evaluate(beating(), slow, 1) and first.fitness != other.fitness
    assert plain.metrics.activation_amplitude > first.metrics.activation_amplitude > 0.0
    every = with_settings(SWIM, {"rig.failures": 4096})
    assert evaluate(beating(), every, 1).fitness < 0.01 * plain.fitness
    until = with_settings(SWIM, {"rig.failures": 4096, "rig.fail_at": 2.0})
    assert np.array_equal(perform(beating(), until, 1).position[:121], perform(beating(), SWIM, 1).position[:121])


def test_the_audit_of_a_swimmer_with_a_rig_stands():
    found = audit(beating(), with_settings(SWIM, SLOW), 3, quick=True)  # its muscles alone, by another method, go as far
    assert found.stands, found.faults


@pytest.mark.parametrize("name", ["walk", "chemotaxis"])
def test_the_other_tasks_feel_it_too(name):
    short = {"control_steps": 80, "starts": 1, "chemotaxis.pairs": 1, "chemotaxis.least_distance": 0.0, "development.max_cells": 12}
    task = with_settings(default_task(name), short)
    slow = with_settings(task, {"rig.lag": 0.3})
    assert evaluate(pulsing(), slow, 1) == evaluate(pulsing(), slow, 1) != evaluate(pulsing(), task, 1)
    late, seeker = with_settings(task, {"rig.sensor_delay": 0.2, "rig.sensor_noise": 0.5}), load_champion("seeker")
    assert evaluate(seeker, late, 1) == evaluate(seeker, late, 1)
    assert (evaluate(seeker, late, 1) != evaluate(seeker, task, 1)) == task.has_target


# --- wherever a task goes ---------------------------------------------------------------------------------------------------


def test_a_task_carries_its_rig(tmp_path, capsys):
    task = with_settings(SWIM, SLOW | {"rig.failing_cells": "3,7", "rig.sensor_noise": 0.01})
    assert task.rig.failing_cells == (3, 7) and task_from_message(task_message(task)) == task
    assert task_of_plain(json.loads(json.dumps(dataclasses.asdict(task)))) == task
    evolution = Evolution(Settings(generations=2, population=4), 1)
    assert settings_hash(evolution, task) != settings_hash(evolution, SWIM)
    again = command(task, evolution.settings, 1, "panmictic")
    assert "rig.failing_cells=3,7" in again
    assert "rig.failing_cells" in {one.name for one in differences(task, evolution.settings, "panmictic")}
    save_genome(tmp_path / "g.yaml", beating())
    plant = written(tmp_path, "actuators: {lag: 0.25, dead: [2]}\nevents: [{at: 3, what: fail, cells: [1], count: 2}]")
    assert request([str(tmp_path / "g.yaml"), "--plant", plant, "--set", "rig.rate=2"]) == 0
    asked = capsys.readouterr().out
    assert "lag: 0.25" in asked and "rate: 2.0" in asked and "failures: 2" in asked and "dead_cells: [2]" in asked


def written(directory, text):
    (directory / "plant.yaml").write_text(text)
    return str(directory / "plant.yaml")


def test_a_file_says_what_has_no_part_in_simulation(tmp_path, capsys):
    plant = written(tmp_path, "seed: 3\nline: {lost: 0.1}\nsensors: {noise: 0.1}\nevents: [{at: 1, what: unplug}]\nactuators: {lag: 0.2}")
    options = parse(["--plant", plant, "--out", str(tmp_path / "run")])
    said = capsys.readouterr().err
    assert options.task.rig == Rig(lag=0.2, sensor_noise=0.1) and said.count("\n") == 1
    assert all(word in said for word in ("unplug", "line", "seed", "sensors"))
    assert parse(["--plant", plant, "--set", "rig.lag=0.1", "--out", str(tmp_path / "run")]).task.rig.lag == 0.1


def test_a_run_is_resumed_with_its_own_plant_alone(tmp_path):
    task = with_settings(SWIM, {"rig.lag": 0.2})
    found = SimpleNamespace(evolution=Evolution(Settings(generations=2, population=4), 1), task=task, rig="", directory="run")
    refuse(found, {"plant": written(tmp_path, "actuators: {lag: 0.2}")})
    refuse(found, {"plant": written(tmp_path, "actuators: {lag: 0.3}"), "set": ["rig.lag=0.2"]})
    with pytest.raises(ParameterError, match=r"--plant is .* has rig.lag = 0.2"):
        refuse(found, {"plant": written(tmp_path, "actuators: {lag: 0.3}")})


@pytest.mark.parametrize("arguments, says", [
    (["--plant", "nowhere.yaml"], "nowhere.yaml"), (["--plant", ""], "a rig's file"), (["--set", "rig.lga=1"], "did you mean 'rig.lag'"),
    (["--rig", "/eel", "--plant", "p.yaml"], "leave it out"),
])
def test_flags_that_cannot_be_are_one_line(capsys, arguments, says):
    with pytest.raises(SystemExit) as end:
        parse(arguments)
    said = capsys.readouterr().err
    assert end.value.code == 2 and said.count("\n") == 1 and len(said) <= 300 and says in said


@pytest.mark.parametrize("text, says", [
    ("actuators: {lag: -1}", "actuators.lag is -1"),
    ("actuators: {lga: 1}", "did you mean 'actuators.lag'"),
    ("actuators: {dead_time: 10}\nsensors: [", "plant.yaml"),
    ("events: [{at: 1, what: fail, cells: [1]}, {at: 2, what: fail, count: 1}]", "at 1 s and at 2 s"),
    ("events: [{at: 1, what: fail, count: 5000}]", "events[0].count is 5000"),
    ("actuators: {dead: [1, 1]}", "is 1 again"),
])
def test_a_bad_file_is_one_line(tmp_path, capsys, text, says):
    plant = written(tmp_path, text)
    with pytest.raises(SystemExit) as end:
        parse(["--plant", plant])
    said = capsys.readouterr().err
    assert end.value.code == 2 and said.count("\n") == 1 and len(said) <= 300
    assert says.replace("actuators.lag'", "") in said


@pytest.mark.parametrize("values, says", [
    ({"rig.dead_cells": "1,1"}, "rig.dead_cells has 1 twice"),
    ({"rig.failing_cells": "x"}, "rig.failing_cells is 'x': give numbers of cells"),
    ({"rig.failing_cells": 3}, "rig.failing_cells is 3: give the numbers of cells"),
    ({"rig.dead_time": 9.0, "control_step": 1e-3}, f"rig.dead_time is 9: give at most 1 s, {MOST_WAIT} control steps"),
    ({"rig.lag": -1}, "rig.lag is -1"),
])
def test_a_bad_setting_names_itself_and_the_mend(values, says):
    with pytest.raises(ParameterError) as error:
        with_settings(SWIM, values)
    assert says in str(error.value)


def test_files_and_settings_lead_there_and_back(tmp_path):
    task = with_settings(SWIM, SLOW | {"rig.sensor_delay": 0.1, "rig.failing_cells": "3"})
    assert with_settings(SWIM, settings_of(rig_of(task.rig))) == task
    assert with_settings(SWIM, settings_of(File())) == SWIM
    assert with_settings(SWIM, plant_settings(written(tmp_path, "{}"), True)) == SWIM


# --- on the emulated rig ----------------------------------------------------------------------------------------------------


def on_the_rig(genome, task, rig):
    """The distance of a swimmer on an emulated body, by the clock of its brain."""
    animat = Animat(genome, dataclasses.replace(task, rig=Rig()), 1)
    calibration = calibration_of(animat.body.position)
    body = EmulatedBody(animat.plant, calibration, rig, task.control_step)
    return trial(genome, task, 1, SteppedBody(body, calibration, task.control_step)).metrics.distance


def test_the_emulated_body_swims_as_far_as_the_simulated_one_of_its_rig():
    task = with_settings(SWIM, {"rig.lag": 0.15, "rig.rate": 4.0, "control_steps": 400, "development.max_cells": 16})
    genome = load_champion("undulator")
    simulated, ideal = (evaluate(genome, one, 1).metrics.distance for one in (task, dataclasses.replace(task, rig=Rig())))
    emulated = on_the_rig(genome, task, rig_of(task.rig))
    assert abs(emulated - simulated) < 0.15 * simulated and ideal > 2 * simulated


def test_a_body_that_is_there_has_its_own_rig():
    there = SimpleNamespace(position=np.zeros((3, 2)), velocity=np.zeros((3, 2)))
    assert Animat(beating(), with_settings(SWIM, SLOW), 1, lambda grown: there).task == SWIM
