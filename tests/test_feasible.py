"""Settings under which nothing could evolve are refused before a run begins, in one line that tells the mend."""

from pathlib import Path

import evodevo_ga.usual as usual_settings
import numpy as np
import pytest
from evodevo_ga.arguments import parse
from evodevo_ga.feasible import check
from evodevo_ga.settings import UNLIMITED
from evodevo_sim.parameters import Development, default_task, preset, with_settings
from evodevo_sim.physics.forces import make_law
from evodevo_sim.physics.step_size import choose_substeps
from genomes import first_viable
from searches import stand_in

from evodevo_ga import Evolution, Settings, scheme
from evodevo_sim import ParameterError, Status, Task, evaluate, perform, random_genome, save_genome

STILL = ["--point-mutation", "0", "--crossover", "0", "--duplication", "0", "--deletion", "0", "--flip", "0"]


@pytest.mark.parametrize(
    "arguments, says",
    [
        ("--scheme newton", "scheme 'newton' is unknown: choose one of panmictic, paper, alps, niches"),
        ("--units 0", "settings.units is 0: give 1 or more, or genomes by --start"),
        ("--cells 2", "development.max_cells is 2: give 3 or more"),
        ("--set development.steps=1", "development.division_threshold is 0.5: give less than 0.3, which no cell can pass in 1 steps"),
        ("--set development.division_threshold=1", "development.division_threshold is 1: give less than 1"),
        ("--set control_step=1 --set material.stiffness=1e9",
         "task.control_step is 1: give less than 0.0335 s, or lower material.stiffness"),
        ("--set control_step=1 --set material.damping=1e6", "task.control_step is 1: give less than"),
        ("--set material.pressure=1e9 --set control_step=1", "task.control_step is 1: give less than"),
        ("--set scene.drag_normal=0 --set scene.drag_tangential=0", "without a fluid nothing can swim"),
        ("--task walk --set scene.gravity=0", "scene.gravity is 0"),
        ("--set control_steps=1001", "task.control_steps is 1001: give a multiple of the 4 windows"),
        ("--layers 3", "settings.layers is 3: give a number that divides the population of 100"),
        ("--scheme alps --population 14", "settings.layers is 5: give a number that divides the population of 14"),
        ("--scheme alps --elite 20", "settings.elite is 20: give less than the 20 individuals of a layer"),
        ("--scheme alps --tournament 21", "settings.tournament is 21: give no more than the 20 individuals of a layer"),
        ("--scheme niches --population 14", "settings.niches is 5: give a number that divides the population of 14"),
        ("--scheme niches --elite 20", "settings.elite is 20: give less than the 20 individuals of a niche"),
        ("--scheme niches --layers 5", "settings.niches is 5 and settings.layers 5: give 1 for one of them"),
        ("--scheme niches --tournament 21", "settings.tournament is 21: give no more than the 20 individuals of a niche"),
        ("--scheme panmictic --tournament 101", "settings.tournament is 101: give no more than the population of 100"),
        (" ".join(STILL), "settings.point_mutation is 0, and so is every other operator"),
        (" ".join(["--scent-mutation", "1", *STILL]), "and so is every other operator"),  # a swimmer smells nothing
    ],
)
def test_what_cannot_work_gets_one_line_and_exit_code_2(capsys, arguments, says):
    with pytest.raises(SystemExit) as left:
        parse(arguments.split())
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.startswith("evolve: ") and said.count("\n") == 1


def test_what_can_work_is_not_refused(tmp_path):
    save_genome(tmp_path / "one.yaml", random_genome(np.random.default_rng(1)))
    for arguments in (
        [], ["--cells", "3"], ["--cells", "5"], ["--scheme", "alps"], ["--scheme", "niches"], ["--scheme", "paper"],
        ["--units", "0", "--start", str(tmp_path / "one.yaml")],
        ["--set", "control_step=1"], ["--set", "material.stiffness=1e9"], ["--set", "development.steps=2"], [*STILL, "--flip", "0.1"],
        ["--task", "walk"], ["--task", "chemotaxis", "--scent-mutation", "1", *STILL],
    ):
        assert parse(arguments)


def test_a_scheme_sets_its_numbers_and_single_settings_go_over_it():
    assert parse(["--scheme", "panmictic"]).settings == Settings()
    paper = parse(["--scheme", "paper"]).settings
    assert (paper.population, paper.elite, paper.tournament, paper.crossover, paper.patience) == (100, 2, 2, 0.2, 500)
    assert (paper.point_mutation, paper.point_scale, paper.layers) == (0.1, 3.0, 1)
    assert parse(["--scheme", "paper", "--tournament", "7"]).settings.tournament == 7
    assert parse(["--scheme", "alps", "--layers", "4"]).settings.layers == 4
    assert parse(["--scheme", "paper", "--task", "chemotaxis"]).settings.point_mutation == 0.1


def test_animats_have_an_archive_but_where_the_settings_part_one_population():
    assert parse([]).scheme == parse(["--population", "50"]).scheme == parse(["--layers", "1"]).scheme == "archive"
    assert parse(["--layers", "5"]).scheme == parse(["--niches", "5"]).scheme == "panmictic"
    assert parse(["--population", "49"]).scheme == parse(["--cells", "4"]).scheme == "panmictic"
    assert parse(["--task", "walk"]).scheme == parse(["--task", "chemotaxis"]).scheme == "archive"
    seeker = ["--task", "chemotaxis", "--start", str(Path(__file__).resolve().parents[1] / "src/evodevo_sim/champions/seeker.yaml")]
    assert parse(seeker).scheme == "panmictic" and parse([*seeker[2:], "--task", "swim"]).scheme == "archive"
    assert parse(["--tournament", "3"]).settings == Settings(**scheme("archive") | {"tournament": 3})


def test_the_search_of_the_paper_holds_its_hundred_and_ends_by_patience_alone():
    options = parse(["--scheme", "paper", "--set", "task.fitness=distance"])
    s, evolution = options.settings, Evolution(options.settings, 2, scheme=options.scheme)
    assert (s.population, s.patience, s.generations, s.niches, s.layers, options.task.fitness) == (100, 500, UNLIMITED, 1, 1, "distance")
    for _ in range(4):
        evolution.tell([stand_in(genome) for genome in evolution.ask()])
        assert len(evolution.population) == 100


def test_genomes_without_units_stay_still():
    for k in range(20):
        assert evaluate(random_genome(np.random.default_rng(k), 0)).metrics.activation_amplitude < 1e-6


@pytest.mark.parametrize("pushes", [{"material.stiffness": 1e9}, {"material.damping": 1e6}, {"material.pressure": 1e9}])
def test_what_is_refused_for_its_steps_ends_every_life_before_it_begins(pushes):
    """No body takes fewer steps than the bound: where it first refuses, all that grow are unstable."""
    step = refused_from(pushes)
    task = with_settings(Task(), {"control_steps": 4, "control_step": step, **pushes})
    for genome in first_viable(4):
        assert evaluate(genome, task).status == Status.UNSTABLE
        substeps = choose_substeps(perform(genome).body, make_law(task.material.arguments(), task.scene.arguments()), step)
        assert substeps > 1000


def refused_from(pushes):
    """The shortest control step, but for a hundredth, that is refused."""
    low, high = 1e-9, 1.0
    while high / low > 1.01:
        middle = (low * high) ** 0.5
        try:
            check(with_settings(Task(), {"control_step": middle, **pushes}), Settings())
            low = middle
        except ParameterError:
            high = middle
    return high


def test_a_run_grows_bodies_as_the_genomes_it_begins_from_were_bred(tmp_path, capsys, monkeypatch):
    inhibited = with_settings(default_task("swim"), preset("contact_inhibition")).development
    for name, law in (("old", Development()), ("new", inhibited)):
        save_genome(tmp_path / name, random_genome(np.random.default_rng(1)), None, law)
    for usual in ("", "contact_inhibition"):
        monkeypatch.setattr(usual_settings, "GROWTH", usual)
        assert parse([]).task.development == (inhibited if usual else Development())
        assert parse(["--start", str(tmp_path / "new"), "--cells", "32"]).task.development == inhibited
        assert parse(["--start", str(tmp_path / "old"), "--task", "walk"]).task.development == Development()
        assert capsys.readouterr().err == ""
    other = parse(["--start", str(tmp_path / "old"), str(tmp_path / "new"), "--set", "development.division_room=0"])
    said = capsys.readouterr().err.splitlines()
    assert other.task.development.division_room == 0.0 and len(said) == 2 and all("its body is another one" in line for line in said)
