"""The gait command: genomes and recordings, their table, CSV file and picture; every bad input is one line."""

import csv
import math
import time

import gaits
import numpy as np
import pytest
from evodevo_sim.analysis.gait import Gait, analyse, track_of_performance
from evodevo_sim.commands.gait import main
from evodevo_sim.commands.simulate import record_motion
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import Recorder, read_recording, record_performance
from evodevo_sim.recording.gait import gait_of_recording, track_of_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.ros.messages import gait_from_message, gait_message
from evodevo_sim.view.summary import headline, markdown
from genomes import pulsing
from values import same

from evodevo_sim import Task, make_own_body, perform, save_genome, simulate_body

TASK = with_settings(Task(), {"control_steps": 400})


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A directory with the genome a.yaml, the recording `run` of its life, and `old`, the same without a gait."""
    from evodevo_ga.evolution import Settings
    from evodevo_ga.messages import evolution_message

    directory, genome = tmp_path_factory.mktemp("gait"), pulsing()
    save_genome(directory / "a.yaml", genome)
    life, now = perform(genome, TASK), time.time_ns()
    for name in ("run", "old"):
        with Recorder(directory / name) as recorder:
            recorder.write("evolution/settings", evolution_message(Settings(), TASK, 1), now)
            record_performance(recorder, life, now)
            if name == "run":
                recorder.write("gait", gait_message(analyse(track_of_performance(life, TASK)).gait), now)
    return directory


def refused(arguments, capsys):
    with pytest.raises(SystemExit) as raised:
        main([str(item) for item in arguments])
    said = capsys.readouterr().err
    assert raised.value.code == 2 and said.startswith("gait: ") and said.count("\n") == 1
    return said


def test_a_genome_and_its_recording_have_one_gait(run, capsys):
    assert main([str(run / "a.yaml"), "--set", "control_steps=400"]) == 0
    of_genome = capsys.readouterr().out
    assert main([str(run / "run"), "--csv", str(run / "cells.csv"), "--out", str(run / "gait.png")]) == 0
    assert capsys.readouterr().out == of_genome
    for said in ("frequency of the muscles", "phase gradient along", "cost of transport", "J/(kg m)"):
        assert said in of_genome
    rows = list(csv.DictReader((run / "cells.csv").open()))
    track = track_of_recording(read_recording(run / "run"), life_of(read_recording(run / "run")))
    wave = analyse(track).rhythm.wave
    assert [float(row["amplitude"]) for row in rows] == pytest.approx(np.abs(wave).tolist(), rel=1e-6)
    assert (run / "gait.png").read_bytes().startswith(b"\x89PNG")


def test_a_recorded_gait_is_read_again_and_an_older_run_has_one_too(run):
    recording, old = read_recording(run / "run"), read_recording(run / "old")
    gait = gait_from_message(recording.gait)
    assert old.gait is None and same(gait_of_recording(recording, life_of(recording)), gait)
    found = gait_of_recording(old, life_of(old))
    assert found.name == gait.name and found.frequency == pytest.approx(gait.frequency, rel=1e-6)
    assert found.muscle_work == pytest.approx(gait.muscle_work, rel=1e-9)
    life = life_of(recording)
    assert gait.name in headline(recording, life)[1] and f"**Gait:** {gait.name}" in markdown(recording, life)


def test_a_gait_passes_through_its_message():
    gait = Gait("jump", "because", frequency=1.5, feet=2, flight=0.25)
    again = gait_from_message(gait_message(gait))
    assert (again.name, again.why, again.frequency, again.feet, again.flight) == ("jump", "because", 1.5, 2, 0.25)
    assert math.isnan(again.cost_of_transport)


def test_a_walk_that_simulate_recorded(tmp_path, capsys):
    rest = gaits.standing(gaits.lattice(8, 3))
    drive = {"amplitude": 0.5, "frequency": 1.5, "phase": (-2 * np.pi * rest[:, 0] / 8).tolist()}
    own = make_own_body({"position": rest.tolist(), "activation": drive})
    with Recorder(tmp_path / "walk") as recorder:
        record_motion(recorder, own, simulate_body(own, "walk", 6.0), time.time_ns())
    assert main([str(tmp_path / "walk"), "--out", str(tmp_path / "walk.png"), "--csv", str(tmp_path / "w.csv")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("mass shift: ") and "time in the air" in said and "work" not in said  # nobody recorded its material
    duty = [float(row["duty"]) for row in csv.DictReader((tmp_path / "w.csv").open())]
    assert max(duty) > 0.3 and sum(share > 0 for share in duty) >= 8
    assert gait_of_recording(read_recording(tmp_path / "walk"), life_of(read_recording(tmp_path / "walk"))).name == "mass shift"


def test_bad_input_is_one_line(run, tmp_path, capsys):
    a = run / "a.yaml"
    (tmp_path / "b.yaml").write_text("position: []")
    (tmp_path / "c.csv").write_text("mine")
    assert "No such file" in refused([tmp_path / "none.yaml"], capsys)
    assert "not a genome file" in refused([tmp_path / "b.yaml"], capsys)
    assert "holds no .mcap file" in refused([tmp_path], capsys)
    assert "names its own task" in refused([run / "run", "--set", "control_steps=4"], capsys)
    assert "--walk is for a recording" in refused([a, "--walk"], capsys)
    assert "ends in .png, .svg or .pdf" in refused([a, "--out", "gait.jpg"], capsys)
    assert "never overwritten" in refused([a, "--csv", tmp_path / "c.csv"], capsys)
    assert "the motion has 21 frames" in refused([a, "--set", "control_steps=20", "--set", "windows=2"], capsys)
    assert "nothing moved" in refused([a, "--set", "development.max_cells=1"], capsys)


def test_a_run_without_a_life_and_one_that_was_cut(run, tmp_path, capsys):
    from evodevo_ga.evolution import Settings
    from evodevo_ga.messages import evolution_message

    with Recorder(tmp_path / "short") as recorder:
        recorder.write("evolution/settings", evolution_message(Settings(), TASK, 1), 1)
    assert "holds no motion of a body" in refused([tmp_path / "short"], capsys)
    whole = next((run / "run").glob("*.mcap")).read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) * 9 // 10])
    assert main([str(tmp_path / "cut.mcap")]) == 0
    assert capsys.readouterr().err == f"gait: the end of {tmp_path / 'cut.mcap'} is missing: what was saved before it is read\n"
