"""Reports: one page of a run that a browser shows without a network, whose command repeats it, and which says what a run does not hold."""

import re
import shlex
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import missing, visit
from evodevo_ga.arguments import parse
from evodevo_ga.evolution import Generation
from evodevo_ga.individual import Individual
from evodevo_ga.keeping.history import History
from evodevo_ga.report.charts import Curve, _thinned, chart
from evodevo_ga.report.descent import descent_of
from evodevo_ga.report.differences import command, differences, world_text
from evodevo_ga.report.page import report_page
from evodevo_ga.report.runs import read_run
from evodevo_ga.report.unlike import archive_section
from evodevo_ga.report_command import main
from evodevo_ga.schemes import scheme
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import Recorder, read_recording, record_performance
from evodevo_sim.recording.life import life_of
from evodevo_sim.worlds import with_world
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import START, life, run_messages, write

from evodevo_ga import Settings
from evodevo_sim import Evaluation, Metrics, Status, random_genome

needs_browser = pytest.mark.skipif(bool(missing()), reason=missing() or "there is one")
READY = "document.querySelectorAll('figure.film[data-ready]').length === document.querySelectorAll('figure.film').length"
ASIDE = {"console": [], "requests": []}
VOID = {"meta", "link", "input", "br"}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp("report") / "a run")


@pytest.fixture(scope="module")
def page(bag):
    out = bag.parent / "report.html"
    assert main([str(bag), str(bag), "-o", str(out)]) == 0
    return out


class Balance(HTMLParser):
    """Whether every tag that opens closes; SVG and HTML alike."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append((tag, self.getpos()))


def test_a_page_is_whole_and_tells_all_that_a_run_holds(page, bag):
    text = page.read_text(encoding="utf-8")
    balance = Balance()
    balance.feed(text)
    assert not balance.wrong and not balance.open
    for heading in ("What was run", "Curves", "Gait", "Energy", "Audit", "Descent", "Commands"):
        assert text.count(f"<h3>{heading}</h3>") == 2
    assert text.count("<figcaption>") == 2 and f"a run ({bag})" in text and "no history of its individuals" in text


# --- the command that repeats it ---------------------------------------------------------------------------------------------

CASES = [
    ("swim", "niches", {}, {}, 3), ("swim", "panmictic", {"material.stiffness": 123.25, "noise.sensing": 1e-5}, {"tournament": 3}, 0),
    ("swim", "", {"development.max_cells": 7}, {"population": 60, "niches": 5, "founders": 70}, 1),
    ("swim", "paper", {"fitness": "distance"}, {}, 2**63 - 1), ("swim", "alps", {"control_steps": 400}, {"age_gap": 3, "elite": 1}, 5),
    ("walk", "panmictic", {"starts": 2, "scene.friction": 0.35}, {"generations": 7}, 9), ("walk", "panmictic", {}, {}, 1),
    ("chemotaxis", "panmictic", {"chemotaxis.distance": 6.5, "material.muscle_range": 0.1}, {"crossover": 0.125}, 4),
]


@pytest.mark.parametrize("name, chosen, numbers, own, seed", CASES)
def test_the_command_gives_the_same_task_and_search(name, chosen, numbers, own, seed):
    for world in ("gap", "rough") if "starts" in numbers else ["flat"]:
        task = with_settings(default_task(name), {"development.max_cells": 32, **numbers})
        if world != "flat":
            task = with_settings(with_world(task, world), {name: value for name, value in numbers.items() if "friction" in name})
        made = Settings(**scheme(chosen or "panmictic", name) | own)
        line = shlex.split(command(task, made, seed, chosen))
        assert line[:4] == ["ros2", "run", "evodevo_ga", "evolve"]
        again = parse(line[4:])
        assert (again.task, again.settings, again.seed) == (task, made, seed) and again.scheme == (chosen or "panmictic")
        plain = parse(["--task", name])
        same = (task, made) == (plain.task, plain.settings) and chosen in ("", plain.scheme)
        assert bool(differences(task, made, chosen)) == (not same)


def test_a_world_of_ones_own_goes_into_a_file_that_evolve_takes(tmp_path):
    scene = replace(default_task("walk").scene, ground_x=(-9.0, 0.0, 9.0), ground_y=(0.0, 0.5, 0.0), friction=0.7)
    task = replace(with_settings(default_task("walk"), {"development.max_cells": 32}), scene=scene)
    file = tmp_path / "hill.yaml"
    file.write_text(world_text(task))
    again = parse(shlex.split(command(task, Settings(), 1, "panmictic", {"world": str(file)}))[4:])
    assert again.task == task and "of a file" in [one.value for one in differences(task, Settings(), "panmictic")]


# --- descent ---------------------------------------------------------------------------------------------------------------


def history(directory):
    """A history of five individuals, written by a run's own: 4 comes of 2 and 3, 2 of 1, 1 and 0 of nobody."""
    rows = [
        (0, 0, (), ("random",), 0.1), (0, 1, (), ("random",), 0.2), (1, 2, (1,), ("points",), 0.5), (1, 3, (0,), ("flip",), 0.3),
        (2, 4, (2, 3), ("crossover", "points"), 0.9),
    ]
    genome = random_genome(np.random.default_rng(0), 2)
    written = History(directory)
    for generation in range(3):
        born = [
            Individual(genome, Evaluation(fitness, Status.OK, "", Metrics()), now, 0, number, parents, operators)
            for now, number, parents, operators, fitness in rows if now == generation
        ]
        told = Generation(generation, 0.0, 0.0, 0.0, 0.0, 8.0, 2 * (generation + 1), 0, (2,), True)
        written.take(told, SimpleNamespace(population=born, children=born, search=None, champion=born[-1]))
    written.write()


def test_the_line_of_a_champion_goes_back_through_fitter_parents(tmp_path):
    run = write(tmp_path / "run")
    assert descent_of(run) == ([], [])
    history(run)
    line, said = descent_of(run)
    assert [one.number for one in line] == [4, 2, 1] and not said and set(line[0].parents) == {2, 3}
    text = report_page([read_run(run)])
    assert "number 4, has 2 ancestors" in text and "gained most" in text and "2 by points" in text


@pytest.mark.parametrize("table", ["history", "hall_of_fame"])
def test_a_history_that_is_damaged_is_said_and_left_out(tmp_path, table):
    history(tmp_path)
    for part in (tmp_path / table).iterdir():
        part.write_bytes(part.read_bytes()[:40])
    line, said = descent_of(tmp_path)
    assert line == [] and "is left out" in said[0]


# --- charts ----------------------------------------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=1, max_size=1500))
def test_a_chart_is_well_formed_and_keeps_the_ends_and_extremes(values):
    curve = Curve("a < b & c", [float(k) for k in range(len(values))], values)
    thin = _thinned(curve)
    finite = [y for y in values if y == y]
    kept = [y for y in thin.y if y == y]
    assert len(thin.x) <= 304 and (thin.x[0], thin.x[-1]) == (0.0, len(values) - 1.0)
    assert not finite or (min(kept), max(kept)) == (min(finite), max(finite))
    made = chart("T <", "x & y", [curve, curve])
    assert bool(made) == bool(finite)
    if made:
        root = ElementTree.fromstring(made)
        assert root.find("svg").get("role") == "img" and "a < b & c" in root.find("svg").get("aria-label")
        assert "nan" not in made and "inf" not in made


# --- in the browser --------------------------------------------------------------------------------------------------------


@needs_browser
def test_the_page_renders_at_both_widths_and_its_films_end_where_the_lives_did(page, bag):
    recorded = life_of(read_recording(bag))
    last = len(recorded.growth) + len(recorded.time) - 1
    film = "document.querySelectorAll('figure.film')[{}]".format
    visited = visit(page, [
        ["until", READY], ["run", f"{film(0)}.dataset.playing"],
        ["run", f"{film(1)}.querySelector('canvas').focus()"], ["key", "End"], ["until", f"{film(1)}.dataset.step === '{last}'"],
        ["run", f"[{film(1)}.dataset.centre, {film(0)}.dataset.step, {film(1)}.dataset.frame]"],
        ["run", "document.documentElement.scrollWidth <= innerWidth"], ["size", 390, 844], ["grab", str(page.with_suffix(".png"))],
        ["run", "document.documentElement.scrollWidth <= innerWidth"],
        ["run", "[...document.querySelectorAll('svg')].every(e => e.getAttribute('aria-label') || e.getAttribute('aria-hidden'))"],
        ["run", "[...document.querySelectorAll('canvas, [role=region]')].every(e => e.getAttribute('aria-label') && e.tabIndex === 0)"],
        ["run", "[...document.querySelectorAll('nav a')].every(e => document.getElementById(e.getAttribute('href').slice(1)))"],
        ["run", "document.querySelectorAll('h1').length"],
    ])
    centre, other, frame = visited[5]
    scale = float(frame.split()[2])
    assert np.abs(np.array(centre.split(), float) - recorded.centre[-1]).max() * scale <= 1.0
    assert visited[1] == "false" and other == str(len(recorded.growth))  # the other film was not asked
    assert visited[6] is True and all(visited[9:13]) and visited[13] == 1 and visited[-1] == ASIDE


# --- what a run does not hold ----------------------------------------------------------------------------------------------


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as leaving:
        main([str(argument) for argument in arguments])
    said = capsys.readouterr().err.splitlines()[-1]
    assert leaving.value.code == 2 and len(said) <= 300
    return said


def test_bad_input_is_one_line_and_leaves_no_file(bag, tmp_path, capsys):
    with Recorder(tmp_path / "lived") as recorder:
        record_performance(recorder, life(), START)
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "taken.html").write_text("a letter")
    out = tmp_path / "report.html"
    assert "holds no settings of a run" in refused(capsys, tmp_path / "lived", "-o", out)
    assert "empty.mcap" in refused(capsys, tmp_path / "empty.mcap", bag, "-o", out)
    assert "never overwritten" in refused(capsys, bag, "-o", tmp_path / "taken.html")
    assert ".html" in refused(capsys, bag, "-o", tmp_path / "report.pdf") and not out.exists()


def test_what_gallery_left_of_an_archive_is_told_by_gait(tmp_path):
    run = SimpleNamespace(path=tmp_path, told=SimpleNamespace(scheme="niches"))
    assert archive_section(run) == ""
    run.told.scheme = "gaits"
    assert "not drawn yet" in archive_section(run)
    (tmp_path / "archive").mkdir()
    table = tmp_path / "archive" / "archive.csv"
    table.write_text(
        "gait,fitness_m,audit\nundulation,3.5,FAILED: x\nundulation,2.5,the fitness stands (2.5 m)\njellyfish,9,not audited\n,1,FAILED: y\n"
    )
    cells = re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", archive_section(run))[5:]
    assert cells == ["jellyfish", "1", "9", "not audited", "-", "undulation", "2", "3.5", "1 of 2", "2.5", "none", "1", "1", "0 of 1", "-"]
    table.write_text("gait,fitness_m\nundulation,far\n")
    assert "cannot be read" in archive_section(run) and "run gallery again" in archive_section(run)


def test_a_run_that_was_cut_off_is_told_as_far_as_it_goes(bag, tmp_path, capsys):
    file = next(bag.glob("*.mcap"))
    (tmp_path / "cut").mkdir()
    (tmp_path / "cut" / "cut.mcap").write_bytes(file.read_bytes()[: file.stat().st_size * 3 // 4])
    out = tmp_path / "report.html"
    assert main([str(tmp_path / "cut"), "-o", str(out)]) == 0
    text = out.read_text(encoding="utf-8")
    assert "what was saved before it is read" in text and "the end of the recording is missing" in text
    assert "before it is read" in capsys.readouterr().err


def test_a_run_without_a_life_or_champion_says_so(tmp_path):
    run = write(tmp_path / "run", lived=False)
    text = report_page([read_run(run)])
    assert "no motion whose gait" in text and '<figure class="film"' in text and "was not audited" in text
    with Recorder(tmp_path / "bare") as recorder:
        for topic, message, stamp in run_messages():
            if topic != "evolution/champion":
                recorder.write(topic, message, stamp)
    text = report_page([read_run(tmp_path / "bare")])
    assert "There is no champion." in text and "<figcaption>" not in text


def test_settings_of_another_version_are_said(tmp_path):
    with Recorder(tmp_path / "newer") as recorder:
        for topic, message, stamp in run_messages():
            if topic == "evolution/settings":
                message.task.name = "fly"
            recorder.write(topic, message, stamp)
    run = read_run(tmp_path / "newer")
    assert run.task is None and "not of this version" in report_page([run]) and not Path(tmp_path / "newer.html").exists()
