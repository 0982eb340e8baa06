"""Layouts of the viewer by purpose: what each shows is what happened, to the last bit where it can be."""

import os
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
import recordings
from evodevo_sim.analysis.growth_story import Lineage, born, shared_genes, story_of_growth
from evodevo_sim.analysis.thinking import INPUT, OUTPUT, network_of, thoughts_of_life
from evodevo_sim.commands import replay as cli
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import Recorder, read_recording, record_performance
from evodevo_sim.recording.life import life_of
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.topics import CHAMPION, SETTINGS
from evodevo_sim.view.files import OutputError
from evodevo_sim.view.run_view import RunView
from genomes import dividing, first_viable
from hypothesis import given, settings
from hypothesis import strategies as some
from test_chemotaxis import pulsing_smeller

from evodevo_msgs import msg
from evodevo_sim import evaluate, perform


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return recordings.write(tmp_path_factory.mktemp("bags") / "run")


@pytest.fixture(autouse=True)
def headless(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


def entities(path):
    """Rows of each entity, on timelines, and how many layouts the file brings."""
    from rerun.chunk import RrdReader

    reader, rows = RrdReader(path), {}
    for chunk in reader.stream().to_chunks():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + (0 if chunk.is_static else chunk.num_rows)
    return rows, len(reader.blueprints())


NEEDS = {
    "watch": {"/animat/cells", "/animat/springs", "/plots/distance", "/evolution/best", "/summary"},
    "grow": {"/animat/cells", "/clones/cells", "/lineage/cells", "/lineage/now", "/plots/cells", "/summary"},
    "think": {"/network/drives", "/network/holds_back", "/plots/activation/cell_3", "/animat/cells", "/summary"},
    "evolve": {"/evolution/best", "/evolution/diversity", "/gallery/cells", "/gallery/names", "/evolution/shared", "/summary"},
}


@pytest.mark.parametrize("purpose", NEEDS)
def test_each_purpose_shows_its_part_in_a_layout_of_its_own(purpose, bag, tmp_path):
    more = ["--cell", "3"] if purpose == "think" else []
    assert cli.main([str(bag), "--show", purpose, *more, "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 0
    rows, layouts = entities(tmp_path / "a.rrd")
    assert set(rows) >= NEEDS[purpose] and layouts == 1
    steps = recordings.TASK.development.steps + 1
    if purpose == "grow":
        assert rows["/animat/cells"] == rows["/clones/cells"] == rows["/plots/cells"] == steps
    if purpose == "think":
        assert rows["/animat/cells"] == rows["/plots/activation/cell_3"] == recordings.TASK.control_steps + 1


def test_without_a_life_a_run_is_shown_by_default(tmp_path):
    recordings.write(tmp_path / "run", lived=False)
    assert cli.main([str(tmp_path / "run"), "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 0
    assert "/gallery/cells" in entities(tmp_path / "a.rrd")[0]


@pytest.mark.parametrize("cell", ["9", "-1"])
def test_a_cell_that_there_is_not_is_one_line(cell, bag, tmp_path, capsys):
    assert cli.main([str(bag), "--show", "think", "--cell", cell, "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 2
    assert capsys.readouterr().err == f"replay: --cell is {cell}: give one from 0 to 8\n" and not list(tmp_path.iterdir())


def test_a_run_of_another_body_is_not_told_as_thoughts(tmp_path, capsys):
    with Recorder(tmp_path / "bag") as recorder:
        other = with_settings(recordings.TASK, {"development.max_cells": 5})
        recorder.write(SETTINGS.name, msg.Evolution(task=task_message(other)), 1)
        champion = msg.Champion(genome=genome_message(dividing()))
        recorder.write(CHAMPION.name, champion, 1)
        record_performance(recorder, recordings.life(), 2)
    assert cli.main([str(tmp_path / "bag"), "--show", "think", "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 2
    assert "grows 5 cells here, and 9 are recorded" in capsys.readouterr().err


# --- what they show --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["swim", "walk", "chemotaxis"])
def test_a_brain_led_along_a_recorded_life_thinks_the_same_to_the_last_bit(name, tmp_path):
    small = {"development.max_cells": 12, "control_steps": 200}
    task = with_settings(default_task(name), small | ({"windows": 2} if name == "walk" else {}))
    genome = pulsing_smeller() if name == "chemotaxis" else first_viable(1)[0]
    with Recorder(tmp_path / "bag", drawn=False) as recorder:
        record_performance(recorder, perform(genome, task, 1), 1)
    life = life_of(read_recording(tmp_path / "bag"))
    thoughts = thoughts_of_life(genome, task, 1, life.position, life.activation, life.target, [0, 3])
    assert thoughts.error == 0.0 and thoughts.concentration.shape == (len(life.time), len(thoughts.nodes), 2)
    e, c = (next(k for k, node in enumerate(thoughts.nodes) if node.name == output) for output in ("expansion", "contraction"))
    told = thoughts.concentration[:, e] - thoughts.concentration[:, c]
    assert np.abs(told - life.activation[:, [0, 3]]).max() < 1e-6
    names = [node.name for node in thoughts.nodes]
    assert len(set(names)) == len(names) and all(thoughts.nodes[edge.target].role != INPUT for edge in thoughts.edges)
    assert all(thoughts.nodes[edge.source].role != OUTPUT for edge in thoughts.edges)
    moved = life.activation.copy()
    moved[50, 3] += 0.01
    assert thoughts_of_life(genome, task, 1, life.position, moved, life.target, [0]).error == pytest.approx(0.01)


def test_a_network_without_inputs_of_its_scene_has_none_of_them():
    from evodevo_sim.genetics.regulation import express

    genome = dividing()
    _, units = express(*genome.arrays())
    nodes, _ = network_of(genome, range(units + 4), np.array([True, True, True, False]))
    assert "scent" not in {node.name for node in nodes}


@pytest.mark.parametrize("genome", [dividing(), *first_viable(2)], ids=["dividing", "one", "two"])
def test_daughters_stand_beside_their_mothers_when_they_are_born(genome):
    task = with_settings(recordings.TASK, {"development.max_cells": 16})
    performance = perform(genome, task)
    alive = np.isfinite(performance.growth[..., 0])
    counts = alive.sum(axis=1).tolist()
    story = story_of_growth(genome, task, counts)
    lineage = story.lineage
    assert lineage.mother[0] == -1 and (lineage.mother[1:] >= 0).all() and (lineage.mother[1:] < np.arange(1, len(lineage.mother))).all()
    for cell in range(1, len(lineage.mother)):
        step, mother = lineage.born[cell], lineage.mother[cell]
        assert not alive[step - 1, cell] and alive[step, cell]
        assert np.hypot(*(performance.growth[step, cell] - performance.growth[step - 1, mother])) < 1.0
        others = [born_with for born_with in range(1, len(lineage.mother)) if lineage.born[born_with] == step and born_with != cell]
        assert mother not in lineage.mother[others]  # no cell divides twice in a step
    for step, values in zip(story.steps, story.perceived):
        assert values.shape == (len(story.morphogens), counts[step]) and np.isfinite(values).all()
    position, activation, _ = born(genome, task)
    assert np.array_equal(position, performance.growth[-1][alive[-1]])
    assert np.array_equal(activation, performance.growth_activation[-1][alive[-1]])


@given(some.lists(some.integers(0, 10**6), min_size=1, max_size=20))
@settings(max_examples=50, deadline=None)
def test_no_lines_of_a_tree_cross(draws):
    mother = np.array([-1, *(draw % (k + 1) for k, draw in enumerate(draws))])
    lineage = Lineage(mother, np.arange(len(mother)))
    order = lineage.order()
    assert sorted(order) == list(range(len(mother)))
    for cell in range(1, len(mother)):  # what lives between a mother and her newborn was born later, below the line between them
        low, high = sorted((order[mother[cell]], order[cell]))
        assert all(lineage.born[other] > cell for other in range(len(mother)) if low < order[other] < high)
    clones = lineage.clones()
    assert all(clones[cell] == (clones[mother[cell]] if cell >= 4 else cell) for cell in range(len(mother)))


def test_genes_that_are_shared():
    genome = dividing()
    assert shared_genes(genome, genome) == 1.0
    assert shared_genes(genome, genome.take(np.arange(8))) == 1.0
    assert shared_genes(genome.take(np.arange(8)), genome) == pytest.approx(8 / len(genome))


def test_ground_is_drawn_from_birth_on(tmp_path):
    from rerun.chunk import RrdReader

    task = with_settings(default_task("walk"), {"development.max_cells": 12, "control_steps": 100, "windows": 2})
    with Recorder(tmp_path / "bag", drawn=False) as recorder:
        recorder.write(SETTINGS.name, msg.Evolution(task=task_message(task)), 1)
        record_performance(recorder, perform(first_viable(1)[0], task), 2)
    assert cli.main([str(tmp_path / "bag"), "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 0
    first = life_of(read_recording(tmp_path / "bag")).time[0]
    begins = [
        chunk.to_record_batch().column("time")[0].value / 1e9 for chunk in RrdReader(tmp_path / "a.rrd").stream().to_chunks()
        if chunk.entity_path == "/animat/world" and not chunk.is_static
    ]
    assert begins == [pytest.approx(first)] and first > 1.0


# --- a run while it goes on ------------------------------------------------------------------------------------------------


def test_a_run_is_watched_into_a_file(tmp_path):
    messages = [message for _, message, _ in recordings.run_messages()]
    with RunView("run", recordings.TASK, tmp_path / "a.rrd") as view:
        for message in messages:
            view.hear(message)
    rows, layouts = entities(tmp_path / "a.rrd")
    assert rows["/evolution/best"] == sum(isinstance(message, msg.GenerationStatistics) for message in messages) == 5
    assert rows["/gallery/cells"] == sum(isinstance(message, msg.Champion) for message in messages) > 1 and layouts == 1


def evolving(directory, *more):
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "evodevo_ga.evolve", "--population", "8", "--cells", "8", "--generations", "2", "--simulators", "1"]
    return subprocess.run(
        [*command, "--set", "control_steps=60", "--out", directory / "run", *more], capture_output=True, text=True, timeout=180.0,
        env=environment,
    )


def test_evolve_is_watched_into_a_file_and_its_champions_are_the_same(tmp_path):
    done = evolving(tmp_path, "--view", tmp_path / "a.rrd", "--seed", "3")
    assert done.returncode in (0, 1), done.stderr
    rows, layouts = entities(tmp_path / "a.rrd")
    recording = read_recording(tmp_path / "run")
    assert rows["/evolution/best"] == len(recording.statistics) == 2 and layouts == 1
    assert rows.get("/gallery/names", 0) <= len(recording.champions)


def test_evolve_without_a_display_begins_nothing(tmp_path):
    done = evolving(tmp_path, "--view")
    assert done.returncode == 2 and "no display for --view" in done.stderr and done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_picture_that_fails_ends_no_run(tmp_path, capsys):
    with RunView("run", recordings.TASK, tmp_path / "a.rrd") as view:
        view.hear(msg.Champion())  # of no genome
        view.hear(msg.Champion())
    assert capsys.readouterr().out.count("the run goes on") == 1


@contextmanager
def stand_in(*_):
    """A viewer that shows nothing: it waits to be ended."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        yield process
        process.kill()


def test_a_viewer_that_is_closed_is_a_line_and_the_run_goes_on(monkeypatch, capfd):
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("evodevo_sim.view.run_view.opened", stand_in)
    with RunView("run", recordings.TASK) as view:
        view.hear(msg.GenerationStatistics())
        view._process.kill()
        view._process.wait()
        for _ in range(2):
            view.hear(msg.GenerationStatistics())
    out, err = capfd.readouterr()
    assert out.count("the viewer was closed; the run goes on") == 1 and "Close the viewer" not in out and "Traceback" not in err


def test_the_view_makes_room_for_more_champions(monkeypatch, tmp_path):
    monkeypatch.setattr("evodevo_sim.view.run_view._ROOM", 1)
    champions = [message for _, message, _ in recordings.run_messages() if isinstance(message, msg.Champion)]
    with RunView("run", recordings.TASK, tmp_path / "a.rrd") as view:
        sent = []
        view._stream.send_blueprint = sent.append
        for message in 3 * champions[:1]:
            view.hear(message)
    assert len(sent) == 2  # for two, and for four


def test_without_a_display_or_a_name_that_fits_nothing_begins(tmp_path):
    with pytest.raises(OutputError, match="no display for --view: give it a file"):
        RunView("run", recordings.TASK)
    with pytest.raises(OutputError, match=r"ends in \.rrd"):
        RunView("run", recordings.TASK, tmp_path / "a.png")
    assert evaluate(dividing(), recordings.TASK).metrics.cells == 9
