"""The gallery of a run: who is on the map and where, the files that are left, and one line where there is nothing to draw."""

import csv
import json
import math
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from evodevo_ga.gallery.command import main
from evodevo_ga.gallery.content import axis_of, read_content
from evodevo_ga.gallery.draw import gallery
from evodevo_ga.gallery.lives import FOLDER, TABLE, live
from evodevo_ga.keeping.checkpoint import Checkpoints
from evodevo_ga.keeping.limits import Limits
from evodevo_sim.tasks.grown import grow
from evodevo_sim.view.body_map import Axis, BodyMap, Shown, gaits_in, save_map, shade
from test_archive import evolution_of, run_on, task_of

from evodevo_ga import Evolution, Settings
from evodevo_sim import evaluate, load_genome

NO_HISTORY = json.dumps({"written": -1, "history": [], "generations": [], "hall_of_fame": []})


def written(directory, evolution, task):
    directory.mkdir(exist_ok=True)
    Checkpoints(directory, evolution, task, Limits(), ()).write(evolution.champion, evolution.generation, NO_HISTORY)
    return directory


@pytest.fixture(scope="module")
def evolution():
    one = evolution_of()
    run_on(one, task_of(), 2)
    return one


@pytest.fixture
def run(tmp_path, evolution):
    return written(tmp_path / "run", evolution, task_of())


def said(arguments, capsys):
    """The line of a refusal."""
    with pytest.raises(SystemExit) as left:
        main([str(one) for one in arguments])
    text = capsys.readouterr().err
    assert left.value.code == 2 and text.count("\n") == 1 and len(text) <= 301
    return text


def test_every_elite_is_on_the_map_in_the_cell_of_its_body(run, evolution):
    content, notes = read_content(run)
    assert not notes and content.task == task_of() and content.evaluations == evolution.evaluations
    assert {one.individual.number for one in content.animals} == {one.number for one in evolution.population}
    cells = [(one.column, one.row) for one in content.animals]
    assert len(set(cells)) == len(cells) and (content.x.bins, content.y.bins) == (12, 6)
    for one in content.animals:
        for axis, place, value in ((content.x, one.column, one.grown.elongation), (content.y, one.row, one.grown.share_of_chambers)):
            low = axis.edges[place] if place else -math.inf
            high = axis.edges[place + 1] if place + 1 < axis.bins else math.inf
            assert low - 1e-6 <= value <= high + 1e-6


def test_the_command_draws_the_map_and_leaves_each_genome_with_its_audit(run, evolution, tmp_path, capsys):
    (run / FOLDER).mkdir()
    (run / FOLDER / "98-99.yaml").write_text("of a cell that is empty by now")
    (run / FOLDER / "mine.yaml").write_text("kept")
    picture, log = tmp_path / "map.png", tmp_path / "map.rrd"
    assert main([str(run), "-o", str(picture), "--save", str(log)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG") and log.read_bytes().startswith(b"RRF") and log.stat().st_size > 10_000
    told = capsys.readouterr().out
    count = len(evolution.population)
    assert f"{count} of 72 kinds" in told and "audits stand" in told and told.count("\n") == 1
    with open(run / FOLDER / TABLE, newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["file"] for row in rows} | {"mine.yaml", TABLE} == {path.name for path in (run / FOLDER).iterdir()} and len(rows) == count
    assert max(float(row["fitness_m"]) for row in rows) == evolution.champion.evaluation.fitness
    for row in rows[:3]:
        genome = load_genome(run / FOLDER / row["file"])
        assert evaluate(genome, task_of(), evolution.seed).fitness == float(row["fitness_m"])
        assert grow(genome, task_of()).cells == int(row["cells"]) and row["audit"] != "not audited"
        assert f"audit: '{row['audit'].split(':')[0][:6]}" in (run / FOLDER / row["file"]).read_text() or row["audit"].startswith("the ")


@pytest.mark.parametrize("ending, begins", [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_without_audits_in_other_formats(run, tmp_path, ending, begins, capsys):
    assert main([str(run), "-o", str(tmp_path / f"map.{ending}"), "--no-audit"]) == 0
    assert (tmp_path / f"map.{ending}").read_bytes().startswith(begins)
    assert "audits stand" not in capsys.readouterr().out
    assert {row["audit"] for row in csv.DictReader(open(run / FOLDER / TABLE, newline=""))} == {"not audited"}  # noqa: SIM115  (a table)


def test_a_recorded_fitness_that_is_not_its_own_fails(tmp_path, evolution):
    state = evolution.state()
    state["population"][0]["evaluation"]["fitness"] += 1.0
    run = written(tmp_path / "changed", Evolution.resumed(state, task_of()), task_of())
    found = gallery(run, audits=False, say=pytest.fail)
    assert [one.stands for one in found.animals].count(False) == 1
    assert max(found.animals, key=lambda one: one.fitness).stands is False


def test_who_interrupts_it_does_not_wait_for_all_lives(run, monkeypatch):
    lived, left = [], threading.Event()

    class Pool(ThreadPoolExecutor):
        def shutdown(self, *arguments, **how):
            super().shutdown(False, cancel_futures=how.get("cancel_futures", False))
            left.set()
            super().shutdown()

    def life(animal, *_):
        lived.append(animal)
        assert len(lived) == 1 or left.wait(60.0)

    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr("evodevo_ga.gallery.lives._life", life)
    monkeypatch.setattr("evodevo_ga.gallery.lives.ThreadPoolExecutor", Pool)
    content, _ = read_content(run)
    with pytest.raises(KeyboardInterrupt):
        live(content, done=interrupt)
    assert len(content.animals) > 3 and len(lived) <= 2


def test_a_run_without_an_archive_says_what_can_be_drawn(tmp_path, capsys):
    plain = Evolution(Settings(population=4, elite=1, tournament=2, units=2, generations=1), 1)
    run_on(plain, task_of())
    run = written(tmp_path / "plain", plain, task_of())
    line = said([run, "-o", tmp_path / "map.png"], capsys)
    assert "scheme 'panmictic'" in line and "descent" in line and not (run / FOLDER).exists() and not (tmp_path / "map.png").exists()


def test_bad_input_is_one_line_before_anything_is_written(run, tmp_path, capsys):
    assert "does not exist" in said([tmp_path / "none", "-o", tmp_path / "map.png"], capsys)
    assert "ends in .png, .svg or .pdf" in said([run, "-o", tmp_path / "map.jpg"], capsys)
    assert "ends in .rrd" in said([run, "-o", tmp_path / "map.png", "--save", tmp_path / "map.png"], capsys)
    assert not (run / FOLDER).exists()
    (run / FOLDER).write_text("a file in the way")
    assert "cannot be written" in said([run, "-o", tmp_path / "map.png", "--no-audit"], capsys)
    (run / "checkpoint.json").write_text('{"evodevo_checkpoint":1')
    assert "damaged" in said([run, "-o", tmp_path / "map.png"], capsys) and not (tmp_path / "map.png").exists()


def map_with(*animals, bins=(3, 2)):
    axes = [Axis("a measure, m", tuple(np.linspace(0.0, 1.0, count + 1))) for count in bins]
    return BodyMap("a run", "facts", *axes, animals)


def animal(column, row, fitness, gait="", stands=None):
    position = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.9)])
    return Shown(column, row, fitness, position, np.array([(0, 1), (1, 2), (0, 2)]), gait, stands)


@pytest.mark.parametrize("bins", [(1, 1), (3, 2), (30, 10)])
def test_maps_of_any_size_are_drawn_and_tell_unlike_animals(tmp_path, bins):
    one, two = animal(0, 0, 3.0, "jellyfish", False), animal(bins[0] - 1, bins[1] - 1, 6.0, "a $name$", True)
    pictures = set()
    for k, animals in enumerate(((), (one,), (two,), (one, two), (animal(0, 0, -0.5),))):
        save_map(map_with(*animals, bins=bins), tmp_path / f"{k}.svg")
        pictures.add((tmp_path / f"{k}.svg").read_bytes())
    assert len(pictures) == 5


def test_colours_and_names():
    assert [shade(fitness, 4.0) for fitness in (-1.0, 0.0, 1.0, 4.0, 5.0)] == [0.0, 0.0, 0.25, 1.0, 1.0]
    assert gaits_in([animal(0, 0, 1.0, name) for name in ("run", "jump", "run", "")]) == "run 2, jump 1"
    assert axis_of("elongation", np.array([0.0, math.log(2.0)])).edges == pytest.approx((1.0, 2.0))
    assert axis_of("mine", np.array([0.0, 5.0])) == Axis("mine", (0.0, 5.0))
