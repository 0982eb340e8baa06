"""Chasing targets end to end: a real simulator node, targets from files and recordings, and one line for what is wrong."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import life_of
from lab import DEADLINE
from test_chemotaxis import pulsing_smeller

from evodevo_sim import save_genome

SMALL = ["--quiet", "--set=development.max_cells=8", "--set=development.steps=60", "--real-time-factor", "8"]


@pytest.fixture(scope="module")
def genome(tmp_path_factory):
    path = tmp_path_factory.mktemp("genomes") / "smeller.yaml"
    save_genome(path, pulsing_smeller())
    return path


def start(*arguments):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "evodevo_sim.commands.chase", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def run(*arguments):
    process = start(*arguments)
    stdout, stderr = process.communicate(timeout=DEADLINE)
    return process.returncode, stdout, stderr


def test_drawn_targets_are_chased_recorded_shown_and_chased_again(genome, tmp_path):
    (tmp_path / "path.csv").write_text("x,y\n0.5,0.5\n40,0\n-3,0\n")
    bag, view = tmp_path / "bag", tmp_path / "run.rrd"
    code, stdout, stderr = run(
        genome, "--targets", tmp_path / "path.csv", "--capture", 5, "--each", 2, "--out", bag, "--save", view, *SMALL
    )
    assert code == 0, stderr
    assert "2 of 3 targets captured within 5 m" in stdout  # the one at 40 m is out of reach in 2 s
    recording = read_recording(bag)
    assert [(p.pose.position.x, p.pose.position.y) for p in recording.targets] == [(0.5, 0.5), (40.0, 0.0), (-3.0, 0.0)]
    assert all(p.header.frame_id == "world" and p.header.stamp.sec > 0 for p in recording.targets)
    life = life_of(recording)
    assert len(life.time) == len(life.target) and np.isfinite(life.target_distance[1:]).all() and life.position.shape[1] == 8
    assert view.stat().st_size > 1000 and view.read_bytes().startswith(b"RRF2")
    code, again, stderr = run(genome, "--targets", bag, "--capture", 5, "--each", 2, *SMALL)
    assert code == 0 and "2 of 3 targets" in again, stderr


def test_ctrl_c_keeps_what_was_recorded(genome, tmp_path):
    bag = tmp_path / "bag"
    process = start(genome, "--each", 1000, "--capture", 0.001, "--out", bag, *SMALL)
    while not (bag.is_dir() and any(file.stat().st_size > 20_000 for file in bag.glob("*.mcap"))):
        assert process.poll() is None, process.communicate()[1]
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130 and "Traceback" not in stderr
    recording = read_recording(bag)
    assert len(recording.states) > 10 and len(recording.targets) == 1 and not recording.truncated


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["nowhere.yaml"], "nowhere.yaml"),
        (["GENOME", "--targets", "nowhere.csv"], "nowhere.csv"),
        (["GENOME", "--count", "0"], "--count is 0"),
        (["GENOME", "--capture", "nan"], "--capture is nan"),
        (["GENOME", "--distance", "9", "2"], "the nearer first"),
        (["GENOME", "--set", "chemotaxis.scent=1"], "did you mean"),
        (["GENOME", "--set", "name=swim"], "without targets"),
        (["GENOME", "--view"], "no display"),
        (["GENOME", "--out", "."], "exists already"),
        (["GENOME", "--save", "picture.png"], "picture.png"),
        (["GENOME", "--simulator", "/nobody_here"], "no simulator answers at /nobody_here"),
    ],
)
def test_bad_input_gets_one_line_and_exit_code_2(genome, arguments, says):
    code, stdout, stderr = run(*[genome if a == "GENOME" else a for a in arguments])
    lines = stderr.strip().splitlines()
    assert code == 2 and len(lines) == 1 and says in lines[0] and not stdout, stderr


def test_an_animat_that_cannot_live_is_refused_by_the_simulator(tmp_path):
    from genomes import hand_made

    save_genome(tmp_path / "egg.yaml", hand_made())
    code, _, stderr = run(tmp_path / "egg.yaml", *SMALL)
    assert code == 2 and "the egg never divided" in stderr and stderr.count("\n") == 1
