"""Who came from whom: ancestors from the history, and the picture of a champion's line."""

import dataclasses
import subprocess
import sys

import pytest
from crashes import Crashing
from evodevo_ga.descent.command import main
from evodevo_ga.descent.lineage import lineage
from evodevo_ga.descent.run import descent
from evodevo_ga.keeping.checkpoint import Checkpoints
from evodevo_ga.keeping.errors import ResumeError
from evodevo_ga.keeping.history import History, read_table
from evodevo_ga.keeping.limits import Limits
from searches import stand_in

from evodevo_ga import Evolution, Settings
from evodevo_sim import Task, load_champion


def kept(directory, generations=9, **numbers):
    """A run in process that keeps its checkpoints and its history.  Returns: it; all its individuals by number."""
    directory.mkdir()
    settings = Settings(**{"population": 12, "elite": 2, "tournament": 3, "generations": generations, "crossover": 0.5} | numbers)
    evolution, history = Evolution(settings, 2, (load_champion("ribbon"),)), History(directory, Crashing())
    checkpoints, everyone = Checkpoints(directory, evolution, Task(), Limits(), (), Crashing()), {}
    while not evolution.finished:
        generation = evolution.tell([stand_in(genome) for genome in evolution.ask()])
        everyone |= {one.number: one for one in evolution.children}
        history.take(generation, evolution)
        history.write_if_due(generation.generation)
        checkpoints.write(evolution.champion, generation.generation, history.kept())
    history.write()
    return evolution, everyone


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = tmp_path_factory.mktemp("runs") / "a run"
    return directory, *kept(directory)


def test_ancestors_are_all_that_parents_lead_to_and_the_line_goes_by_the_fitter_of_them(run):
    directory, evolution, everyone = run
    for number in (evolution.bred - 1, 0, evolution.bred // 2):
        found, ahead, line = descent(directory, number), {number}, [number]
        ancestors = set()
        while ahead:
            one = ahead.pop()
            ancestors.add(one)
            ahead |= set(everyone[one].parents) - ancestors
        while everyone[line[0]].parents:
            line.insert(0, max(everyone[line[0]].parents, key=lambda one: everyone[one].evaluation.fitness))
        assert found.number.tolist() == sorted(ancestors) and found.number[found.line].tolist() == line
        links = {(int(found.number[a]), int(found.number[b])) for a, b in found.links}
        assert links == {(parent, one) for one in ancestors for parent in everyone[one].parents}
        assert found.fitness.tolist() == [everyone[one].evaluation.fitness for one in sorted(ancestors)]
        assert found.operators == [everyone[one].operators for one in sorted(ancestors)]
        assert sum(found.counts().values()) == sum(len(everyone[one].operators) for one in line)
    champion = descent(directory)
    assert champion.fitness[-1] == evolution.champion.evaluation.fitness


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_the_picture_is_a_file_of_its_ending_and_the_same_at_any_time(run, tmp_path, capsys, ending):
    directory, evolution, _ = run
    pictures = []
    for name in ("one", "two"):
        assert main([str(directory), "-o", str(tmp_path / f"{name}.{ending}")]) == 0
        pictures.append((tmp_path / f"{name}.{ending}").read_bytes())
    assert pictures[0] == pictures[1] and len(pictures[0]) > 10_000
    told = capsys.readouterr().out.splitlines()[0]
    assert f"fitness {evolution.champion.evaluation.fitness:.3f} m" in told and "ancestors in all" in told


def test_a_run_of_one_generation_and_an_individual_of_failures_have_pictures_too(run, tmp_path):
    kept(tmp_path / "short", 1)
    assert main([str(tmp_path / "short"), "-o", str(tmp_path / "short.png")]) == 0
    _, _, everyone = run
    failed = max(number for number, one in everyone.items() if one.evaluation.cause)
    assert main([str(run[0]), "--number", str(failed), "-o", str(tmp_path / "failed.png")]) == 0


def test_bad_input_is_one_line(run, tmp_path, capsys):
    directory, evolution, _ = run
    (tmp_path / "empty").mkdir()
    kept(tmp_path / "young", 1)
    for name in ("history", "generations", "hall_of_fame"):
        for path in (tmp_path / "young" / name).iterdir():
            path.unlink()
        (tmp_path / "young" / name).rmdir()
    cases = [
        ([str(tmp_path / "nowhere"), "-o", "a.png"], "does not exist"),
        ([str(tmp_path / "empty"), "-o", "a.png"], "is empty"),
        ([str(tmp_path / "young"), "-o", "a.png"], "has no history yet"),
        ([str(directory), "-o", "a.gif"], "give a name that ends in"),
        ([str(directory), "-o", "nowhere/a.png"], "make the directory nowhere first"),
        ([str(directory), "--number", str(evolution.bred), "-o", str(tmp_path / "a.png")], f"no individual {evolution.bred}"),
        ([str(directory), "--number", "-1", "-o", str(tmp_path / "a.png")], "no individual -1"),
    ]
    for arguments, says in cases:
        with pytest.raises(SystemExit) as end:
            main(arguments)
        told = capsys.readouterr().err
        assert end.value.code == 2 and says in told and told.count("\n") == 1 and len(told) <= 300, (arguments, told)
    assert not (tmp_path / "a.png").exists()


def test_a_history_that_lacks_parents_is_told(run):
    table = read_table(run[0], "history")
    with pytest.raises(ResumeError, match="has no individual"):
        lineage(table.slice(12), run[1].bred - 1)
    with pytest.raises(ResumeError, match="not in order"):
        lineage(table.take(list(range(len(table)))[::-1]), run[1].bred - 1)


def test_the_lineage_is_read_without_ros_and_pictures(run):
    code = "import sys; from pathlib import Path; from evodevo_ga.descent.lineage import lineage; "
    code += "from evodevo_ga.keeping.history import read_table; print(lineage(read_table(Path(sys.argv[1]), 'history'), 0).number); "
    code += "assert not {'rclpy', 'matplotlib', 'rerun'} & set(sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, run[0]], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[0]\n"), done.stderr
    assert dataclasses.is_dataclass(descent(run[0]))
