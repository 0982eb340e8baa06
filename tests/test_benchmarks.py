"""Each benchmark runs in its smallest form and writes its tables, and what it claims of itself holds: equal bits, true theory."""

import csv
import runpy
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
TABLES = {
    "work_precision": ("work_precision.csv",),
    "stability_maps": ("stability.csv",),
    "cost": ("force_cost.csv", "graph_cost.csv"),
    "evaluation": ("evaluation.csv", "evaluation_error.csv"),
    "skipping": ("skipping.csv", "resting.csv"),
    "workers": ("workers.csv",),
    "peers": ("peers.csv",),
}


@pytest.fixture(autouse=True)
def on_path(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("part", TABLES)
def test_a_part_writes_its_tables_and_figures(part, tmp_path):
    import run
    from common import TINY

    figures, failed = run.run(TINY, tmp_path, [part])
    assert figures and not failed
    assert [row["what"] for row in rows_of(tmp_path / "summary.csv")] == [one.what for one in figures]
    for name in TABLES[part]:
        rows = rows_of(tmp_path / name)
        assert rows and all(len(row) == len(rows[0]) and None not in row for row in rows)


PROGRAMS = [path for path in sorted(BENCHMARKS.glob("*.py")) if '__name__ == "__main__"' in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_every_benchmark_imports_and_shows_its_help(path, monkeypatch, capsys):
    """In this process, where what they import is there already."""
    monkeypatch.setattr("sys.argv", [str(path), "--help"])
    with pytest.raises(SystemExit) as left:
        runpy.run_path(str(path), run_name="__main__")
    assert left.value.code == 0 and "usage" in capsys.readouterr().out


def test_every_part_of_the_run_is_tested():
    import run

    assert list(TABLES) == list(run.PARTS)


def test_a_part_that_fails_leaves_the_results_of_the_others(tmp_path, monkeypatch):
    import common
    import run
    import skipping
    import workers

    def fail(effort, out):
        raise AssertionError("other bits")

    monkeypatch.setattr(skipping, "run", fail)
    monkeypatch.setattr(workers, "run", lambda effort, out: [common.Figure("workers", "what", "1")])
    figures, failed = run.run(common.TINY, tmp_path, ["skipping", "workers"])
    assert [one.part for one in figures] == ["workers"] and failed == ["other bits"]


def test_other_bits_are_refused():
    from skipping import compare

    with pytest.raises(AssertionError, match="drag: other bits"):
        compare("drag", "term", lambda: (np.zeros(3),), lambda: (np.array([0.0, 0.0, 1e-300]),), 1, "")


def test_the_theory_of_a_step_is_that_of_two_masses_on_a_spring():
    from common import body_of
    from evodevo_sim.physics.forces import Law
    from evodevo_sim.physics.integrators import make_system
    from evodevo_sim.physics.step_size import EULER, RK4, VERLET
    from stability_maps import limit, linearised

    k, c = linearised(make_system(body_of(np.array([(0.0, 0.0), (1.0, 0.0)])), Law(50.0, 0.0, 0.0, 0.0, 0.0, 0.2)))
    for method, most in ((EULER, 2.0), (VERLET, 2.0), (RK4, 2.828)):  # h w, of w = sqrt(2 k / m) = 10
        assert limit(method, k, c, 0.01, 1.0) == pytest.approx(most / 10.0, rel=2e-3)


def test_scipys_graph_is_ours():
    from common import blob
    from cost import delaunay_gabriel
    from evodevo_sim.development.gabriel import gabriel_graph

    for seed in range(5):
        position = blob(64, seed).position
        assert np.array_equal(gabriel_graph(position), delaunay_gabriel(position))


def test_the_clock_takes_turns_in_both_orders():
    from common import race

    order = []
    race({name: lambda name=name: order.append(name) for name in "ab"}, 2, "turns")
    assert "".join(order) == "ab" + "ba" + "ab"


def test_figures_go_between_the_marks_of_the_page_and_nowhere_else():
    from page import DOCS, MARKS, fill
    from run import PARTS

    page = (DOCS / "results" / "benchmarks.md").read_text(encoding="utf-8")
    assert len(MARKS.findall(page)) == len(PARTS) + 1  # and the aims
    names = ("part", "what", "measured", "asked", "met")
    rows = [dict(zip(names, row)) for row in (("cost", "a", "1", "<= 2", "True"), ("cost", "b", "2", "", ""))]
    filled = fill(page, rows)
    assert "| a | 1 |\n| b | 2 |\n" in filled and "| cost: a | 1 | <= 2 | met |" in filled
    assert MARKS.sub(r"\1\3", filled) == MARKS.sub(r"\1\3", page)


CURVES = "settings,search,seed,evaluations,second_half,diversity\n"


def test_curves_take_the_last_value_known_at_each_number_of_evaluations(tmp_path):
    import curves

    (tmp_path / "a.csv").write_text(CURVES + ",paper,1,100,1.0,0.9\n,paper,1,200,3.0,0.5\n,paper,2,150,2.0,0.8\n,paper,2,250,8.0,0.4\n")
    (tmp_path / "b.csv").write_text(
        CURVES + ",random,1,10,0.5,1\n,random,1,200,0.5,1\nx=1,paper,1,100,7,0.9\n,random,1,10,0.25,1\n,random,1,90,0.5,1\n"
    )
    found = curves.read([tmp_path / "a.csv", tmp_path / "b.csv"], "second_half")
    assert {name: len(runs) for name, runs in found.items()} == {"paper": 2, "random": 1, "paper x=1": 1}
    assert found["random"][0].tolist() == [[10, 0.25], [90, 0.5]]  # the seed was run again
    evaluations, values = curves.spread(found["paper"])
    assert evaluations.tolist() == [150, 200] and values.tolist() == [[1.0, 3.0], [2.0, 2.0]]


def test_search_writes_curves_that_are_drawn(tmp_path, monkeypatch, capsys):
    import curves
    import search

    table = tmp_path / "curves.csv"
    small = ["--seeds", "2", "--generations", "3", "--workers", "1", "--scheme", "alps", "--curves", str(table)]
    small += [
        "--set", "settings.population=10", "--set", "settings.layers=2", "--set", "development.max_cells=8", "--set", "control_steps=80",
    ]
    monkeypatch.setattr("sys.argv", ["search.py", *small])
    search.main()
    rows = rows_of(table)
    assert {(row["search"], row["seed"]) for row in rows} == {("alps", "1"), ("alps", "2"), ("random", "1"), ("random", "2")}
    for seed in "12":
        for name in ("alps", "random"):
            run = [(int(row["evaluations"]), float(row["fitness"])) for row in rows if (row["search"], row["seed"]) == (name, seed)]
            assert run == sorted(run)  # the best so far
        ends = [max(int(row["evaluations"]) for row in rows if (row["search"], row["seed"]) == (name, seed)) for name in ("alps", "random")]
        assert ends[0] == ends[1]  # as many for the one as for the other
    assert curves.main([str(table), "--of", "fitness", "--out", str(tmp_path / "curves.png")]) == 0
    assert (tmp_path / "curves.png").stat().st_size > 5000 and "alps" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", CURVES + ",paper,1,100,far,1\n", CURVES + ",paper,1\n"])
def test_curves_refuse_other_files_in_one_line(tmp_path, capsys, text):
    import curves

    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(SystemExit) as left:
        curves.main([str(tmp_path / "a.csv"), "--out", str(tmp_path / "curves.png")])
    said = capsys.readouterr().err
    assert left.value.code == 2 and "a.csv" in said and said.count("\n") == 1 and not (tmp_path / "curves.png").exists()


@pytest.mark.parametrize(
    "text, says",
    [
        ("settings.islands=3", "setting 'settings.islands' is unknown: choose one of population"),
        ("settings.elite=two", "settings.elite is 'two': give a number"),
        ("settings.units=0", "settings.units is 0"),
        ("drag=1", "setting 'drag' is unknown"),
    ],
)
def test_search_refuses_settings_in_one_line(monkeypatch, capsys, text, says):
    import search

    monkeypatch.setattr("sys.argv", ["search.py", "--set", text])
    with pytest.raises(SystemExit) as left:
        search.main()
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.count("\n") == 1


def test_shares_of_mutants_add_up_and_what_does_not_move_is_refused(tmp_path, monkeypatch, capsys):
    import mutants
    from common import CHAMPION
    from genomes import dividing

    from evodevo_sim import save_genome

    found = dict(zip(mutants.SHARES, mutants.shares(np.array([2.1, 2.005, 2.0, 1.5, 0.5, 0.0, -1.0]), 2.0)))
    assert [round(7 * share) for share in found.values()] == [2, 1, 1, 1, 1, 2]
    small = ["--children", "3", "--rates", "0", "--scales", "1", "--workers", "1", "--set", "control_steps=80"]
    monkeypatch.setattr("sys.argv", ["mutants.py", str(CHAMPION), *small])
    mutants.main()
    assert "1 champions, 3 children each" in " ".join(capsys.readouterr().out.split())
    save_genome(tmp_path / "still.yaml", dividing())
    monkeypatch.setattr("sys.argv", ["mutants.py", str(tmp_path / "still.yaml"), *small])
    with pytest.raises(SystemExit) as left:
        mutants.main()
    assert left.value.code == 2 and "give champions that move" in capsys.readouterr().err
