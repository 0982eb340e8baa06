"""Pictures for screen and print: formats by the ending, the same bytes at any time, colours for everyone, texts that fit."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
import recordings
from evodevo_sim.commands import replay as cli
from evodevo_sim.commands.turning import main as turning_main
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import contrasting_cells, life_of, period_of
from evodevo_sim.view import files, summary, views
from evodevo_sim.view.colours import activation_colours
from evodevo_sim.view.drawing import fit
from evodevo_sim.view.figure_file import save_figure
from evodevo_sim.view.palettes import PALETTES, legend_of
from hypothesis import example, given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from evodevo_msgs import msg

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    directory = tmp_path_factory.mktemp("pictures")
    recordings.write(directory / "whole")
    return directory / "whole"


# --- formats -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", files.PICTURES)
def test_a_picture_has_the_format_of_its_ending_and_the_same_bytes_at_any_time(whole, tmp_path, monkeypatch, ending):
    found = []
    for name, now in ((f"a{ending}", 1.0e9), (f"b{ending.upper()}", 1.7e9)):
        monkeypatch.setattr(time, "time", lambda now=now: now)
        assert cli.main([str(whole), "--no-viewer", "--picture", str(tmp_path / name), "--palette", "safe"]) == 0
        found.append((tmp_path / name).read_bytes())
    assert found[0] == found[1]
    begin = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[ending]
    assert found[0].startswith(begin) and b"CreationDate" not in found[0] and b"<dc:date>" not in found[0]
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{ending}", f"b{ending.upper()}"]


def test_fonts_are_in_the_file(tmp_path):
    figure = Figure()
    figure.text(0.5, 0.5, "e − c")
    for ending in (".svg", ".pdf"):
        save_figure(figure, tmp_path / f"a{ending}")
    pdf, svg = (tmp_path / "a.pdf").read_bytes(), (tmp_path / "a.svg").read_bytes()
    assert b"/FontFile2" in pdf and b"/Type3" not in pdf  # TrueType, which journals take; Type 3 they refuse
    assert b"<text" not in svg and b"<path" in svg


def test_other_files_of_the_same_language_are_left_alone(whole, tmp_path, capsys):
    (tmp_path / "a.svg").write_text('<?xml version="1.0"?><launch/>')
    assert cli.main([str(whole), "--no-viewer", "--picture", str(tmp_path / "a.svg")]) == 2
    assert "never overwritten" in capsys.readouterr().err and "launch" in (tmp_path / "a.svg").read_text()
    (tmp_path / "a.svg").unlink()
    for _ in range(2):  # an older picture is replaced
        assert cli.main([str(whole), "--no-viewer", "--picture", str(tmp_path / "a.svg")]) == 0


def test_turning_names_the_endings(tmp_path, capsys):
    with pytest.raises(SystemExit) as leaving:
        turning_main(["nowhere.yaml", "--out", str(tmp_path / "a.eps")])
    assert leaving.value.code == 2 and "ends in .png, .svg or .pdf" in capsys.readouterr().err


# --- colours -------------------------------------------------------------------------------------------------------------

# Machado, Oliveira and Fernandes (2009), A physiologically-based model for simulation of color vision deficiency, severity 1,
# on linear RGB.
BLIND = {
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritanopia": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}
APART = 30.0  # of CIELAB: colours of cells this far apart are told from each other at a glance


_ALL = np.eye(3)  # of linear RGB is seen


def lab(colours, seen=_ALL):
    """(..., 3) CIELAB, D65, of sRGB 0..255 (..., 3).  Args: seen (3, 3): what the eye does to linear RGB."""
    c = np.asarray(colours) / 255
    linear = np.clip(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ np.transpose(seen), 0.0, 1.0)
    to_xyz = np.array([(0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041)])
    xyz = linear @ to_xyz.T / (0.95047, 1.0, 1.08883)
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack((116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])), axis=-1)


def nearest(palette, seen=_ALL):
    """The least CIELAB distance between contracting, rest and expanding."""
    a, b, c = lab(activation_colours([-1.0, 0.0, 1.0], palette), seen)
    return min(np.linalg.norm(one - other) for one, other in ((a, b), (b, c), (a, c)))


@pytest.mark.parametrize("kind", BLIND)
def test_the_safe_palette_is_told_apart_by_the_colour_blind(kind):
    assert nearest("safe", BLIND[kind]) > APART


def test_the_papers_palette_is_for_those_who_see_all_colours():
    assert nearest("paper") > APART > nearest("paper", BLIND["deuteranopia"])


def test_the_safe_palette_gets_lighter_all_the_way_so_that_grey_tells():
    lightness = lab(activation_colours(np.linspace(-1, 1, 201), "safe"))[:, 0]
    assert (np.diff(lightness) > -0.3).all()  # a step of 1 of 255
    assert np.diff(lightness[[0, 100, 200]]).min() > 20.0 and 30.0 < lightness.min() and lightness.max() < 90.0  # off ink and paper


@given(st.floats(-2.0, 2.0), st.sampled_from(sorted(PALETTES)))
def test_every_palette_colours_every_activation(activation, palette):
    colour = activation_colours(activation, palette)
    assert colour.dtype == np.uint8 and colour.shape == (3,)


def test_legends_have_numbers(whole):
    recording = read_recording(whole)
    life = life_of(recording)
    assert "(−1)" in legend_of("paper") and "yellow expanding (+1)" in summary.markdown(recording, life, "safe")
    assert "red expanding (+1)" in summary.markdown(recording, life)


# --- texts ---------------------------------------------------------------------------------------------------------------


LETTERS = st.characters(min_codepoint=32, max_codepoint=126) | st.sampled_from("é−·…")


@settings(max_examples=30, deadline=None)
@given(st.text(LETTERS, min_size=1, max_size=40), st.integers(1, 12))
@example("$\\frac", 3)
@example("W" * 40, 12)
def test_a_text_of_any_length_fits(words, times):
    figure = Figure((8.0, 2.0))
    text = figure.text(0.1, 0.5, " ".join([words] * times), fontsize=10)
    fit(text, 3.0, lines=2)
    assert text.get_window_extent().width <= 3.0 * figure.dpi + 0.5
    assert text.get_text().count("\n") <= 1 and text.get_fontsize() >= 7.4


def test_tables_of_the_summary_hold_no_long_text(whole):
    recording = read_recording(whole)
    recording.champions[-1].evaluation.cause = "a cause " * 30
    recording.audits.append(msg.Audit(generation=recording.champions[-1].generation, faults=["a fault that takes long to tell " * 9]))
    said = summary.markdown(recording, life_of(recording))
    assert said.count("a fault that takes") == 9 and "a cause" in said
    assert max(len(line) for line in said.splitlines() if line.startswith("|")) < 80


# --- Rerun ---------------------------------------------------------------------------------------------------------------


def test_the_view_of_activation_shows_some_beats_at_a_time(whole):
    life = life_of(read_recording(whole))
    life.activation[:] = np.sin(2 * np.pi * np.arange(len(life.time)) / 10)[:, None]
    period = 10 * (life.time[1] - life.time[0])
    assert period_of(life, contrasting_cells(life.activation)) == pytest.approx(period, rel=0.1)
    window = views.some_beats(life)
    assert (window is None) == (8 * period_of(life, contrasting_cells(life.activation)) >= life.time[-1] - life.time[0])
    life.activation[:] = 0.0  # no beat: the whole life
    assert views.some_beats(life) is None


def test_whatever_we_recommend_for_rerun_files_keeps_to_this_host():
    """In code, help and documents: a line that a user types."""
    sources = [*(ROOT / "src").rglob("*.py"), *(ROOT / "docs").rglob("*.md"), ROOT / "README.md", *(ROOT / "benchmarks").glob("*.py")]
    found = [line for path in sources for line in re.findall(r"\brerun (?:--[^\n`]*)?\S*\.rrd", path.read_text())]
    assert found and all("--bind 127.0.0.1" in line for line in found), found
