"""What a run keeps to go on from: whole after a crash at any moment, refused where it would not be the same run."""

import errno
import itertools
import json
import os
import shutil
import subprocess
import sys
from contextlib import suppress

import numpy as np
import pandas as pd
import pytest
from crashes import Crash, Crashing, Disk, Failing
from evodevo_ga.arguments import parse
from evodevo_ga.evolve import main as evolve
from evodevo_ga.individual import Individual, individual_of_plain, plain_individual
from evodevo_ga.keeping import history as history_module
from evodevo_ga.keeping.checkpoint import BEFORE, NAME, Checkpoints, read_checkpoint
from evodevo_ga.keeping.errors import KeepingError, ResumeError
from evodevo_ga.keeping.files import FILES
from evodevo_ga.keeping.history import TABLES, History, read_table
from evodevo_ga.keeping.limits import Limits
from evodevo_ga.keeping.lock import Lock, refuse_if_held
from evodevo_ga.keeping.resume import resumed
from evodevo_ga.keeping.text import Texts
from evodevo_sim.parameters import with_settings
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from searches import stand_in

from evodevo_ga import Evolution, Settings
from evodevo_sim import Evaluation, Genome, Metrics, Status, Task, load_champion, save_genome

SMALL = Settings(population=6, elite=1, tournament=2, generations=5, units=3)
TASK = with_settings(Task(), {"development.max_cells": 8, "control_steps": 80})


@pytest.fixture(autouse=True)
def often(monkeypatch):
    """Parts are written often, and are small."""
    monkeypatch.setattr(history_module, "EVERY", 2)
    monkeypatch.setattr(history_module, "MOST_ROWS", 15)


class Run:
    """A run in process with a stand-in for evaluation, which keeps what `evolve` keeps, in the same order."""

    def __init__(self, directory, files=FILES, numbers=SMALL, found=None):
        self.evolution = found.evolution if found else Evolution(numbers, 4)
        limits = found.limits if found else Limits()
        self.checkpoints = Checkpoints(directory, self.evolution, TASK, limits, (), files)
        self.history = History(directory, files)
        self.champion, self.of = (found.champion, found.champion_generation) if found else (None, -1)
        self.kept = None  # generation, of the last checkpoint that was written whole
        if found:
            self.history.restore(found.history)
        else:
            self.keep()

    def keep(self):
        self.checkpoints.write(self.champion, self.of, self.history.kept())
        self.kept = self.evolution.generation

    def go(self, end=None):
        while not self.evolution.finished and self.evolution.generation != end:
            generation = self.evolution.tell([stand_in(genome) for genome in self.evolution.ask()])
            if generation.improved:
                self.champion, self.of = self.evolution.champion, generation.generation
            self.history.take(generation, self.evolution)
            self.history.write_if_due(generation.generation)
            self.keep()
        return self


def finish(directory):
    """Resume the run in a directory and go on to its end."""
    run = Run(directory, Crashing(), found=resumed(directory)).go()
    run.history.write()


def read(directory, name):
    return read_table(directory, name).to_pylist()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Its directory, and the bytes of the checkpoint of each generation."""
    directory = tmp_path_factory.mktemp("undisturbed")
    patch = pytest.MonkeyPatch()
    patch.setattr(history_module, "EVERY", 2)
    patch.setattr(history_module, "MOST_ROWS", 15)
    counted = Crashing()
    run = Run(directory, counted)
    checkpoints = {-1: (directory / NAME).read_bytes()}
    while not run.evolution.finished:
        run.go(run.evolution.generation + 1)
        checkpoints[run.evolution.generation] = (directory / NAME).read_bytes()
    run.history.write()
    patch.undo()
    return directory, checkpoints, counted.calls


def same(directory, undisturbed):
    first, checkpoints, _ = undisturbed
    assert (directory / NAME).read_bytes() == checkpoints[SMALL.generations - 1]
    for name in TABLES:
        parts = sorted(path.name for path in (first / name).iterdir())
        assert [path.name for path in sorted((directory / name).glob("0*"))] == parts
        for part in parts:
            assert (directory / name / part).read_bytes() == (first / name / part).read_bytes(), (name, part)


def test_a_process_that_ends_at_any_call_loses_the_current_generation_at_most_and_goes_on_to_the_same_bytes(tmp_path, undisturbed):
    calls = undisturbed[2]
    assert calls > 80
    for at in range(calls):
        directory = tmp_path / str(at)
        directory.mkdir()
        run = None
        with suppress(Crash):
            run = Run(directory, Crashing(at))
            run.go()
            run.history.write()
            raise AssertionError("it went on")
        if run is None:  # before there was anything to keep
            continue
        content, _ = read_checkpoint(directory)
        assert content["evolution"]["generation"] in (run.kept, run.kept + 1), at
        finish(directory)
        same(directory, undisturbed)
        shutil.rmtree(directory)


def test_a_power_cut_at_any_call_loses_the_current_generation_at_most_and_mixes_none(tmp_path, undisturbed):
    _, checkpoints, calls = undisturbed
    expected = {name: read(undisturbed[0], name) for name in TABLES}
    seen, states = set(), {}  # generation that is read of what may be left
    for at in range(calls):
        directory, after = tmp_path / "run", tmp_path / "after"
        directory.mkdir()
        disk, run = Disk(directory, at), None
        with suppress(Crash):
            run = Run(directory, disk)
            run.go()
            run.history.write()
        for left in disk.left():
            if run is None:  # before there was anything to keep
                break
            key = hash(frozenset(left.items()))
            if key in states:
                assert states[key] in (run.kept, run.kept + 1), (at, states[key], run.kept)
                continue
            after.mkdir()
            for path, data in left.items():
                place = after / path.relative_to(directory)
                place.parent.mkdir(exist_ok=True)
                place.write_bytes(data)
            content, _ = read_checkpoint(after)
            generation = content["evolution"]["generation"]
            assert generation in (run.kept, run.kept + 1), (at, generation, run.kept)
            assert {"run": content} == json.loads(b"{" + checkpoints[generation].partition(b"\n")[2])
            history = History(after)
            history.restore(content["history"])
            for name in TABLES:
                rows = list(history._tables[name].rows())
                assert rows == [row for row in expected[name] if row["generation"] <= generation], (at, name)
            states[key] = generation
            seen.add(generation - run.kept)
            shutil.rmtree(after)
        shutil.rmtree(directory)
    assert seen == {0, 1} and len(states) > 60


def test_a_disk_that_is_full_is_one_line_and_the_run_goes_on_once_there_is_room(tmp_path, undisturbed):
    for at, number in zip(range(7, undisturbed[2], 5), itertools.cycle([errno.ENOSPC, errno.EIO, errno.EDQUOT])):
        directory = tmp_path / str(at)
        directory.mkdir()
        run = Run(directory, Failing(at, OSError(number, os.strerror(number))))
        with pytest.raises(KeepingError) as error:
            run.go().history.write()
        told = str(error.value)
        assert os.strerror(number) in told and f"--resume {directory}" in told and "\n" not in told and len(told) <= 300
        assert read_checkpoint(directory)[0]["evolution"]["generation"] in (run.kept, run.kept + 1)
        finish(directory)
        same(directory, undisturbed)
        shutil.rmtree(directory)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(where=st.floats(0.0, 1.0), how=st.sampled_from(["cut", "changed", "empty", "zeros", "gone", "other text"]))
def test_a_damaged_checkpoint_is_told_and_the_one_before_it_used(tmp_path_factory, undisturbed, where, how):
    directory = tmp_path_factory.mktemp("damaged")
    data = undisturbed[1][SMALL.generations - 1]
    place = int(where * (len(data) - 1))
    changed = {
        "cut": data[:place], "changed": data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :], "empty": b"",
        "zeros": bytes(len(data)), "other text": b"{}\n",
    }
    if how in changed:
        (directory / NAME).write_bytes(changed[how])
    (directory / BEFORE).write_bytes(undisturbed[1][SMALL.generations - 2])
    try:
        content, notes = read_checkpoint(directory)
    except ResumeError as error:  # a changed digit of the version, or of the code
        assert how == "changed" and place < 100 and "version" in str(error)
        return
    assert content["evolution"]["generation"] == SMALL.generations - 2
    assert bool(notes) == (how != "gone") and all("is damaged" in note and "generation 3" in note for note in notes)


coordinates = st.floats(-9.0, 9.0) | st.sampled_from([0.0, -0.0, 1e-300, 5e-324, 1.0])


def test_texts_of_numbers_that_nobody_has_any_more_are_not_kept(monkeypatch):
    monkeypatch.setattr("evodevo_ga.keeping.text._NUMBERS", 50)
    texts, genome = Texts(), load_champion("ribbon")
    for k in range(20):
        moved = Genome(genome.kind, genome.sign, genome.x + k, genome.y - k)
        texts.of([Individual(moved, stand_in(moved))])
        assert len(texts._numbers) <= 4 * len(genome)


@given(st.lists(st.tuples(st.sampled_from([-1, 1]), coordinates, coordinates), min_size=8, max_size=9), st.floats(-5, 5), st.integers(0, 8))
def test_the_text_of_an_individual_is_that_of_its_plain_data_to_the_last_bit(elements, fitness, status):
    sign, x, y = (np.array(column) for column in zip(*elements))
    genome = Genome(np.array([0] * 8 + [2] * (len(elements) - 8)), sign, x, y)
    cause = 'the "body"\n\u00e9' if status else ""
    evaluation = Evaluation(fitness, Status(status), cause, Metrics(cells=3, distance=fitness / 3))
    one = Individual(genome, evaluation, 1, 2, 3, (1, 2), ("points",))
    texts, ahead = Texts(), Texts()
    ahead.expect([genome])
    for text in (*texts.of([one, one]), *texts.of([one]), *ahead.of([one])):
        assert repr(json.loads(text)) == repr(json.loads(json.dumps(plain_individual(one))))
        assert individual_of_plain(json.loads(text)).genome == genome


def flags(directory, *arguments):
    """What `evolve --resume` says to flags."""
    try:
        return parse(["--resume", str(directory), *arguments])
    except SystemExit as end:
        assert end.code == 2
        return None


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--seed", "5"], "--seed is 5, and the run in"),
        (["--cells", "9"], "--cells is 9, and the run in"),
        (["--task", "walk"], "--task is 'walk', and the run in"),
        (["--population", "7"], "--population is 7"),
        (["--crossover", "0.3"], "--crossover is 0.3"),
        (["--scheme", "alps"], "--scheme is 'alps'"),
        (["--set", "control_steps=84"], "--set is 'control_steps=84', and the run in"),
        (["--preset", "high_drag"], "--preset is 'high_drag'"),
        (["--world", "rough"], "swim has no ground"),
        (["--start", "GENOME"], "--start is"),
        (["--out", "elsewhere"], "--out is 'elsewhere'"),
        (["--generations", "4"], "--generations is 4, less than the run's 5"),
        (["--patience", "3"], "--patience is 3, less than the run's 500"),
        (["--generations", "0"], "generations is 0"),
        (["--set", "nonsense=3"], "'nonsense' is unknown"),
        (["--hours", "0"], "--hours is 0"),
        (["--evaluations", "0"], "--evaluations is 0"),
    ],
)
def test_a_change_is_refused_and_named_and_nothing_is_touched(tmp_path, capsys, arguments, says):
    directory = tmp_path / "run"
    directory.mkdir()
    Run(directory, Crashing()).go()
    save_genome(tmp_path / "one.yaml", load_champion("ribbon"))
    before = {path: path.stat().st_mtime_ns for path in directory.rglob("*")}
    assert flags(directory, *(str(tmp_path / "one.yaml") if one == "GENOME" else one for one in arguments)) is None
    told = capsys.readouterr().err
    assert says in told and told.count("\n") == 1 and len(told) <= 300
    assert {path: path.stat().st_mtime_ns for path in directory.rglob("*")} == before


def test_what_is_as_it_was_may_be_given_and_limits_raised(tmp_path):
    directory = tmp_path / "run"
    directory.mkdir()
    Run(directory, Crashing()).go()
    same = ["--seed", "4", "--cells", "8", "--task", "swim", "--population", "6", "--scheme", "panmictic", "--set", "control_steps=80"]
    options = flags(directory, *same, "--out", str(directory), "--simulators", "3", "--quiet")
    assert options.settings == SMALL and options.task == TASK and options.seed == 4 and options.simulators == 3 and options.quiet
    options = flags(directory, "--generations", "9", "--patience", "600", "--evaluations", "1000", "--hours", "2.5")
    assert (options.settings.generations, options.settings.patience, options.limits) == (9, 600, Limits(1000, 2.5))
    assert options.resumed.evolution.settings == options.resumed.evolution.search.settings == options.settings


def test_a_raised_run_is_the_run_that_was_so_long_from_the_start(tmp_path):
    long, short = tmp_path / "long", tmp_path / "short"
    for directory, generations in ((long, 11), (short, 4)):
        directory.mkdir()
        Run(directory, Crashing(), numbers=Settings(**vars(SMALL) | {"generations": generations})).go().history.write()
    Run(short, Crashing(), found=resumed(short, {"generations": 11})).go().history.write()
    assert (long / NAME).read_bytes() == (short / NAME).read_bytes()
    assert (long / BEFORE).read_bytes() == (short / BEFORE).read_bytes()
    for name in TABLES:
        assert read(long, name) == read(short, name)


def changed(directory, change):
    """A checkpoint with a valid hash and another content."""
    import hashlib

    data = (directory / NAME).read_bytes()
    line, _, rest = data.partition(b"\n")
    first, run = json.loads(line[:-1] + b"}"), json.loads(b"{" + rest)
    change(first, run["run"])
    rest = json.dumps(run)[1:].encode()
    first["sha256"] = hashlib.sha256(rest).hexdigest()
    (directory / NAME).write_bytes(json.dumps(first)[:-1].encode() + b",\n" + rest)


@pytest.mark.parametrize(
    "change, says",
    [
        (lambda first, run: first.update(program="9.9.9"), "version '9.9.9'"),
        (lambda first, run: first.update(code="0123456789abcdef"), "code '0123456789abcdef' of version"),
        (lambda first, run: first.update(evodevo_checkpoint=2), "format 2 of version"),
        (lambda first, run: run["evolution"].update(seed=5), "do not fit their hash"),
        (lambda first, run: run["task"].update(control_steps=84), "do not fit their hash"),
        (lambda first, run: run["task"].pop("windows"), "task that is not whole"),
        (lambda first, run: run["evolution"].pop("population"), "state that is not whole"),
        (lambda first, run: run["evolution"].update(scheme="mine"), "scheme 'mine' is unknown"),
        (lambda first, run: run.pop("limits"), "lacks what it should hold"),
        (lambda first, run: run["champion"].update(individual=[]), "lacks what it should hold"),
        (lambda first, run: run["champion"]["individual"]["genome"].update(sign=[3]), "genome"),
    ],
)
def test_a_checkpoint_of_another_version_or_of_another_hand_is_one_line(tmp_path, change, says):
    Run(tmp_path, Crashing()).go(2)
    changed(tmp_path, change)
    with pytest.raises(ResumeError) as error:
        resumed(tmp_path)
    assert says in str(error.value) and len(str(error.value)) <= 280 and "\n" not in str(error.value)


@pytest.mark.parametrize("change", [{"program": "9.9.9"}, {"code": "0123456789abcdef"}])
def test_a_checkpoint_of_other_code_can_be_drawn_and_a_note_says_so(tmp_path, change):
    run = Run(tmp_path, Crashing()).go(2)
    changed(tmp_path, lambda first, _: first.update(change))
    found, notes = read_checkpoint(tmp_path, "look at it")
    assert found["evolution"]["generation"] == run.evolution.generation and len(notes) == 1 and "of other code" in notes[0]
    changed(tmp_path, lambda first, _: first.update(evodevo_checkpoint=2))
    with pytest.raises(ResumeError, match="format 2"):
        read_checkpoint(tmp_path, "look at it")


def test_directories_that_hold_no_run_are_told_by_what_they_are(tmp_path):
    for name in ("empty", "foreign", "older", "damaged"):
        (tmp_path / name).mkdir()
    (tmp_path / "file").write_text("text")
    (tmp_path / "foreign/photo.jpg").write_text("text")
    (tmp_path / "older/older_0.mcap").write_text("text")
    (tmp_path / "damaged" / NAME).write_text("{")
    says = {
        "nowhere": "does not exist", "file": "is no directory", "empty": "is empty", "foreign": "holds no checkpoint.json",
        "older": "holds a recording without a checkpoint", "damaged": "checkpoint.json is damaged",
    }
    for name, told in says.items():
        with pytest.raises(ResumeError, match=told):
            resumed(tmp_path / name)
    assert sorted(path.name for path in (tmp_path / "foreign").iterdir()) == ["photo.jpg"]


def test_the_lock_says_who_holds_it_and_is_free_once_they_are_killed(tmp_path):
    Run(tmp_path, Crashing()).go(1)
    code = "import sys; from pathlib import Path; from evodevo_ga.keeping.lock import Lock; Lock(Path(sys.argv[1])).__enter__(); print(1, "
    code += "flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", code, tmp_path], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        other.stdout.readline()
        for attempt in (lambda: resumed(tmp_path), lambda: refuse_if_held(tmp_path), Lock(tmp_path).__enter__):
            with pytest.raises(ResumeError, match=rf"in use by process {other.pid} on \S+ since"):
                attempt()
        other.kill()
    with Lock(tmp_path):
        assert resumed(tmp_path).evolution.generation == 1
        refuse_if_held(tmp_path)  # not by another process


def test_a_second_run_in_the_directory_of_another_is_refused_with_the_way_to_go_on(tmp_path, capsys):
    Run(tmp_path, Crashing()).go(1)
    before = sorted(tmp_path.iterdir())
    assert evolve(["--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "holds a run already: go on with it by --resume" in told and told.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_the_history_is_read_in_two_lines(undisturbed):
    run, _, _ = undisturbed
    individuals = pd.read_parquet(run / "history")
    generations, champions = pd.read_parquet(run / "generations"), pd.read_parquet(run / "hall_of_fame")
    assert individuals.number.tolist() == list(range(len(individuals))) and len(individuals) == 6 + 4 * 5
    assert generations.generation.tolist() == list(range(5)) and generations.evaluations.is_monotonic_increasing
    best = individuals.groupby("generation").fitness.max().cummax()
    assert best.tolist() == generations.best.tolist()
    assert champions.fitness.tolist() == generations[generations.improved].best.tolist()
    parents = individuals[individuals.generation > 0].parents
    assert all(len(of) in (1, 2) and max(of) < number for of, number in zip(parents, parents.index))
    assert individuals[individuals.generation == 0].operators.map(list).tolist() == [["random"]] * 6
    assert len(champions.x[0]) == champions.elements[0] and champions.cells.min() >= 3


def test_budgets_end_a_run_by_what_they_count():
    assert Limits().reached(10**9, 1e9) == "" and Limits(evaluations=10).reached(9, 0.0) == ""
    assert Limits(evaluations=10).reached(10, 0.0) == "--evaluations 10"
    assert Limits(hours=0.5).reached(0, 1799.0) == "" and Limits(hours=0.5).reached(0, 1800.0) == "--hours 0.5"
