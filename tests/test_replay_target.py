"""Recordings with targets: the swim to the left and its target come back, and are drawn."""

import dataclasses

import numpy as np
import pytest
from evodevo_sim.commands import replay as cli
from evodevo_sim.parameters import Chemotaxis, default_task
from evodevo_sim.recording import Recorder, read_recording, record_performance
from evodevo_sim.recording.life import life_of
from evodevo_sim.ros.messages import cell_states_message, target_message, time_message
from test_chemotaxis import pulsing_smeller

from evodevo_sim import Development, perform

TASK = dataclasses.replace(
    default_task("chemotaxis"), development=Development(max_cells=9, steps=80), control_steps=120, chemotaxis=Chemotaxis(least_distance=0.0)
)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bags") / "seeker"
    with Recorder(directory) as recorder:
        record_performance(recorder, perform(pulsing_smeller(), TASK), 10**18)
    return directory


def test_the_recorded_swim_has_its_target(bag):
    performance, life = perform(pulsing_smeller(), TASK), life_of(read_recording(bag))
    assert np.array_equal(life.position, performance.position) and life.target.shape == (121, 2)
    assert (life.target == performance.target).all()
    assert life.target_distance[0] == pytest.approx(performance.evaluation.metrics.steering.distance)


def test_a_target_counts_from_where_it_came_and_the_last_life_keeps_it(tmp_path):
    with Recorder(tmp_path / "bag") as recorder:
        for k in range(6):  # stamps run back once: a second life
            if k in (1, 4):
                recorder.write("sim_0/target_pose", target_message((k, -k), time_message(100.0 + k)), k)
            state = cell_states_message(np.array([(0.0, 0.0), (1.0, 0.0)]), np.zeros((2, 2)), np.zeros(2), k % 3, (k % 3) / 60)
            recorder.write("sim_0/cell_states", state, k)
    life = life_of(read_recording(tmp_path / "bag"))
    assert life.target.tolist() == [[1.0, -1.0], [4.0, -4.0], [4.0, -4.0]]


def test_a_life_before_its_first_target_has_none(tmp_path):
    with Recorder(tmp_path / "bag") as recorder:
        for k in range(3):
            state = cell_states_message(np.array([(0.0, 0.0), (1.0, 0.0)]), np.zeros((2, 2)), np.zeros(2), k, k / 60)
            recorder.write("cell_states", state, 2 * k)
            if k == 1:
                recorder.write("target_pose", target_message((2.5, 0.0), time_message(1.0)), 2 * k + 1)
    life = life_of(read_recording(tmp_path / "bag"))
    assert np.isnan(life.target[:2]).all() and life.target_distance[2] == pytest.approx(2.0)


@pytest.mark.parametrize("kind", ["seeker", "late"])
def test_it_becomes_a_picture_and_a_rerun_file(bag, tmp_path, capsys, kind, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    source = bag
    if kind == "late":
        source = tmp_path / "late"
        with Recorder(source) as recorder:
            for k in range(30):
                if k == 10:
                    recorder.write("target_pose", target_message((2.5, 0.0), time_message(1.0)), k)
                place = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)]) + 0.1 * k
                recorder.write("cell_states", cell_states_message(place, np.zeros((3, 2)), np.full(3, 0.01 * k), k, k / 60), k)
    assert cli.main([str(source), "--no-viewer", "--png", str(tmp_path / "a.png"), "--save", str(tmp_path / "a.rrd")]) == 0
    assert (tmp_path / "a.png").stat().st_size > 10_000 and (tmp_path / "a.rrd").stat().st_size > 1000
