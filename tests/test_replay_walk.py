"""Replay of a walker: ground, ceiling and contacts are drawn, in the picture and in Rerun."""

import dataclasses
import time

import numpy as np
import pytest
from evodevo_ga.messages import evolution_message
from evodevo_sim.commands.replay import main
from evodevo_sim.parameters import Scene, default_task, with_settings
from evodevo_sim.recording import Recorder, read_recording, record_performance
from evodevo_sim.recording.life import life_of
from genomes import beating
from PIL import Image

from evodevo_ga import Settings
from evodevo_sim import perform

SHORT = {"development.max_cells": 9, "control_steps": 120, "starts": 1}


@pytest.fixture(scope="module", params=["flat", "hilly"])
def bag(request, tmp_path_factory):
    task = with_settings(default_task("walk"), SHORT)
    if request.param == "hilly":
        hills = {"ground_x": (-9.0, 0.0, 9.0), "ground_y": (0.0, 0.5, 0.0), "ceiling_x": (-9.0, 9.0), "ceiling_y": (20.0, 20.0)}
        task = dataclasses.replace(task, scene=Scene(0.0, 0.0, task.scene.gravity, task.scene.friction, **hills))
    path = tmp_path_factory.mktemp("walk") / request.param
    with Recorder(path) as recorder:
        now = time.time_ns()
        recorder.write("evolution/settings", evolution_message(Settings(), task, 1), now)
        record_performance(recorder, perform(beating(), task, 1), now)
    return path


def test_a_walker_is_drawn_on_its_ground(bag, tmp_path, capsys):
    assert main([str(bag), "--no-viewer", "--png", str(tmp_path / "a.png"), "--save", str(tmp_path / "a.rrd")]) == 0
    assert "Traceback" not in capsys.readouterr().err
    with Image.open(tmp_path / "a.png") as picture:
        colours = np.unique(np.asarray(picture.convert("RGB").resize((400, 300))).reshape(-1, 3), axis=0)
    assert len(colours) > 100
    life = life_of(read_recording(bag))
    assert life.contact[0].any()  # it begins at rest on the ground
    [ground, *ceiling] = life.surfaces(-5.0, 5.0)
    assert np.ptp(ground[:, 1]) == (0.0 if bag.name == "flat" else pytest.approx(5 / 18)) and len(ceiling) == (bag.name == "hilly")
