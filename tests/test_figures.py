"""Figures for papers: each kind from recordings alone, in the size of a column, told apart by the colour-blind and in grey."""

import itertools
import re
import struct

import numpy as np
import pytest
from evodevo_sim.commands import figure as command
from evodevo_sim.recording import Recorder, record_performance
from evodevo_sim.view.colours import SERIES
from evodevo_sim.view.figures import KINDS
from evodevo_sim.view.figures.work_precision import curves
from evodevo_sim.view.film.raster import smooth
from recordings import START, TASK, life, run_messages, write
from test_docs import ROOT
from test_pictures import BLIND, lab

SEEKER = ROOT / "src/evodevo_sim/champions/seeker.yaml"
RIBBON = ROOT / "src/evodevo_sim/champions/ribbon.yaml"
SHORT = ("--set", "control_steps=400")


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp("figures") / "a run")


def sources(kind, bag):
    return [str(SEEKER), *SHORT] if kind == "turning" else [str(RIBBON), *SHORT] if kind == "work-precision" else [str(bag), str(bag)]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_with_its_fonts_in_the_width_of_a_column(kind, bag, tmp_path):
    out = tmp_path / f"{kind}.pdf"
    assert command.main([kind, *sources(kind, bag), "-o", str(out)]) == 0
    data = out.read_bytes()
    box = [float(number) for number in re.search(rb"/MediaBox \[ ?([\d. ]+)\]", data)[1].split()]
    assert box[2] == pytest.approx(KINDS[kind].width / 25.4 * 72, abs=0.1)
    assert b"/FontFile2" in data and b"/Type3" not in data  # TrueType, embedded; journals refuse Type 3


def test_formats_and_widths(bag, tmp_path):
    for ending in ("png", "svg"):
        assert command.main(["fitness", str(bag), "-o", str(tmp_path / f"a.{ending}"), "--width", "100"]) == 0
    wide, _ = struct.unpack(">II", (tmp_path / "a.png").read_bytes()[16:24])
    assert wide == pytest.approx(100 / 25.4 * 300, abs=1)
    text = (tmp_path / "a.svg").read_text()
    assert "<text" not in text and 'width="283' in text  # points; letters are paths
    assert command.main(["fitness", str(bag), "-o", str(tmp_path / "b.svg"), "--width", "100"]) == 0
    assert (tmp_path / "b.svg").read_text() == text


def test_many_runs_have_a_median_and_quartiles(bag, tmp_path):
    assert command.main(["fitness", *[str(bag)] * 6, "-o", str(tmp_path / "many.svg")]) == 0
    assert command.main(["fitness", *[str(bag)] * 3, "-o", str(tmp_path / "few.svg")]) == 0
    assert (tmp_path / "many.svg").read_text() != (tmp_path / "few.svg").read_text()


@pytest.mark.parametrize("kind", [*BLIND, "all colours"])
def test_curves_are_told_apart_by_all_eyes(kind):
    seen = lab(SERIES, BLIND.get(kind, np.eye(3)))
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2)) > 30.0


def test_curves_are_told_apart_in_grey_and_from_the_paper():
    lightness = np.sort(lab(SERIES)[:, 0])
    assert np.diff(lightness).min() > 15.0 and lightness.max() < 80.0


def test_precision_grows_with_work():
    from evodevo_sim.recording.champion import champion_of

    found, own = curves(champion_of(RIBBON, {"control_steps": "400"}))
    assert own >= 6.0 and set(found) == {"symplectic Euler", "Verlet", "RK4", "Lawson"}
    for points in found.values():
        error = np.array(points)[:, 1]
        assert error[-1] < 0.5 * error[0]
    assert min(error for _, error in found["RK4"]) < 0.1 * min(error for _, error in found["symplectic Euler"])


def test_a_smooth_way_keeps_its_ends_and_its_middle():
    way = np.column_stack((np.arange(50.0), 3.0 * np.arange(50.0)))
    assert np.allclose(smooth(way, 6), way) and smooth(way[:1], 6).tolist() == way[:1].tolist()


# --- what a recording cannot serve -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def others(tmp_path_factory):
    """A recording of a life alone, of generations alone, and of a run of walkers."""
    place = tmp_path_factory.mktemp("others")
    with Recorder(place / "lived") as recorder:
        record_performance(recorder, life(), START)
    with Recorder(place / "told") as recorder:
        for topic, message, stamp in run_messages():
            if topic != "evolution/champion":
                recorder.write(topic, message, stamp)
    with Recorder(place / "walkers") as recorder:
        for topic, message, stamp in run_messages():
            if topic == "evolution/settings":
                message.task.name = "walk"
            recorder.write(topic, message, stamp)
    (place / "empty.mcap").write_bytes(b"")
    return place


CANNOT = [
    ("fitness", "lived", "no generations", "draw gait or traces"), ("traces", "told", "no states of a body", "figure fitness"),
    ("gait", "told", "no states of a body", "figure fitness"), ("growth", "told", "no growth", "instead"),
    ("turning", "walkers", "no target", "draw gait, traces, growth or fitness"), ("work-precision", "walkers", "walks", "instead"),
    ("turning", "lived", "no champion", "give a run"), ("traces", "empty.mcap", "empty.mcap", ""), ("gait", "nowhere", "nowhere", ""),
]


@pytest.mark.parametrize("kind, source, missing, instead", CANNOT)
def test_what_cannot_be_drawn_is_one_line_that_says_what_can(kind, source, missing, instead, others, tmp_path, capsys):
    with pytest.raises(SystemExit) as leaving:
        command.main([kind, str(others / source), "-o", str(tmp_path / "a.pdf")])
    said = capsys.readouterr().err.splitlines()[-1]
    assert leaving.value.code == 2 and missing in said and instead in said and len(said) <= 300
    assert list(tmp_path.iterdir()) == [] and TASK.name == "swim"


def test_kinds_and_numbers_are_checked_first(bag, tmp_path, capsys):
    for arguments in (["lineage", str(bag)], ["gait", str(bag), "--width", "5"], ["gait", str(bag), "--width", "nan"], ["gait"]):
        with pytest.raises(SystemExit) as leaving:
            command.main([*arguments, "-o", str(tmp_path / "a.pdf")])
        assert leaving.value.code == 2 and len(capsys.readouterr().err.splitlines()[-1]) <= 300
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("free", [(0, 1), (1, 1), (0, 0), (1, 0)])
def test_the_bar_stands_where_no_cell_is_in_its_way(free):
    import matplotlib.pyplot as plt
    from evodevo_sim.view.figures.sheet import bar

    figure, axes = plt.subplots()
    axes.set(xlim=(-10.0, 10.0), ylim=(-10.0, 10.0))
    cells = np.array([(19.0 * x - 9.5, 19.0 * y - 9.5) for x in (0, 1) for y in (0, 1) if (x, y) != free])
    bar(axes, 4.0, cells)
    x, y = axes.lines[0].get_data()
    plt.close(figure)
    assert np.ptp(x) == pytest.approx(4.0) and (np.mean(x) > 0, np.mean(y) > 0) == tuple(map(bool, free))
