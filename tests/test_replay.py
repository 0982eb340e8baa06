"""Replay: a recording becomes a Rerun file and a picture, whatever it holds, and mistakes get one line."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import recordings
from evodevo_sim.commands import replay as cli
from evodevo_sim.recording import Recorder, RecordingError, read_recording
from evodevo_sim.recording.life import contrasting_cells, life_of
from evodevo_sim.ros.messages import cell_states_message
from evodevo_sim.view import viewer
from evodevo_sim.view.colours import activation_colours

STEPS, GROWTH = recordings.TASK.control_steps + 1, recordings.TASK.development.steps + 1
DEADLINE = 120.0


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bags")
    recordings.write(directory / "whole")
    recordings.write(directory / "statistics", lived=False)
    recordings.write(directory / "life", run=False)
    with Recorder(directory / "states") as recorder:  # no growth, no body
        for k in range(5):
            position = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)]) + 0.1 * k
            state = cell_states_message(position, np.zeros((3, 2)), np.full(3, 0.1 * k), k, k / 60)
            recorder.write("sim_0/cell_states", state, k)
    with Recorder(directory / "growth") as recorder:  # an egg that never divided
        for k in range(5):
            state = cell_states_message(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros(1), k, k / 60)
            recorder.write("growth/cell_states", state, k)
    with Recorder(directory / "settings") as recorder:
        recorder.write(*next(recordings.run_messages()))
    return directory


KINDS = ["whole", "statistics", "life", "states", "growth", "settings"]


@pytest.fixture(autouse=True)
def headless(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


def run(capsys, *arguments):
    """(exit code, stdout, stderr) of the command line."""
    try:
        code = cli.main([str(argument) for argument in arguments])
    except SystemExit as leaving:
        code = leaving.code
    return code, *capsys.readouterr()


# --- colours -------------------------------------------------------------------------------------------------------------


def test_contracting_is_blue_at_rest_is_green_expanding_is_red():
    for activation, strongest in ((-1.0, 2), (0.0, 1), (1.0, 0)):
        assert activation_colours(activation).argmax() == strongest


def test_colours_run_from_blue_to_red_without_turning_back():
    red, _, blue = activation_colours(np.linspace(-1, 1, 501)).T.astype(int)
    assert (np.diff(red) >= 0).all() and (np.diff(blue) <= 0).all()
    assert len(np.unique(red - blue)) > 200


def test_colours_take_any_shape_and_bad_numbers():
    assert activation_colours(np.zeros((4, 5))).shape == (4, 5, 3) and activation_colours([]).shape == (0, 3)
    assert np.array_equal(activation_colours([-9.0, np.nan, 9.0]), activation_colours([-1.0, 0.0, 1.0]))


# --- arrays --------------------------------------------------------------------------------------------------------------


def test_a_life_comes_back_as_arrays(bags):
    life, performance = life_of(read_recording(bags / "whole")), recordings.life()
    assert np.array_equal(life.position, performance.position) and np.array_equal(life.activation, performance.activation)
    assert [len(pose.position) for pose in life.growth] == np.isfinite(performance.growth[..., 0]).sum(axis=1).tolist()
    assert all(np.array_equal(a, b) for a, b in zip(life.growth_springs, performance.growth_edges, strict=True))
    assert np.array_equal(life.springs, np.column_stack((performance.body.spring_a, performance.body.spring_b)))
    assert np.array_equal(life.outline, performance.body.outline)
    assert len(life.chambers) == performance.evaluation.metrics.chambers
    assert life.time[0] > life.growth_time[-1]


def test_of_several_lives_the_last_is_shown(tmp_path):
    with Recorder(tmp_path / "reset") as recorder:
        for k, seconds in enumerate((0.0, 0.1, 0.2, 0.0, 0.1)):
            recorder.write("cell_states", cell_states_message(np.full((2, 2), k), np.zeros((2, 2)), np.zeros(2), k, seconds), k)
    assert life_of(read_recording(tmp_path / "reset")).position[:, 0, 0].tolist() == [3.0, 4.0]


def test_states_that_blew_up_are_left_out(tmp_path):
    with Recorder(tmp_path / "unstable") as recorder:
        for k, x in enumerate((0.0, 1.0, np.nan, np.inf)):
            recorder.write("cell_states", cell_states_message(np.full((2, 2), x), np.zeros((2, 2)), np.zeros(2), k, k / 60), k)
    assert life_of(read_recording(tmp_path / "unstable")).position[:, 0, 0].tolist() == [0.0, 1.0]


def test_bodies_that_do_not_fit_their_cells_get_one_line(bags):
    recording = read_recording(bags / "life")
    recording.body.spring_a[0] = 99
    with pytest.raises(RecordingError, match="do not fit each other: record it again"):
        life_of(recording)


def test_the_cells_of_the_activation_plot_are_active_and_apart(bags):
    life = life_of(read_recording(bags / "whole"))
    phase = np.array([0.0, 0.1, np.pi, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    amplitude = np.array([1.0, 0.9, 0.8, 0.9, 0.1, 0.1, 0.1, 0.1, 0.1])
    life.activation[:] = amplitude * np.sin(np.arange(STEPS)[:, None] / 5 + phase)
    assert contrasting_cells(life.activation) == [0, 2]


# --- Rerun ---------------------------------------------------------------------------------------------------------------


def rows(path):
    """Rows of each entity of a Rerun file on the timelines, by Rerun's own reader; 0 for what is on none."""
    from rerun.chunk import RrdReader

    count = {}
    for chunk in RrdReader(path).stream().to_chunks():
        count[chunk.entity_path] = count.get(chunk.entity_path, 0) + (0 if chunk.is_static else chunk.num_rows)
    return count


def test_a_rerun_file_holds_every_step(bags, tmp_path, capsys):
    code, out, err = run(capsys, bags / "whole", "--save", tmp_path / "a.rrd")
    assert code == 0 and f"rerun --bind 127.0.0.1 {tmp_path / 'a.rrd'}" in out
    assert not err.split("\r")[-1].strip()  # bars come where it takes 2 s
    count = rows(tmp_path / "a.rrd")
    assert count["/animat/cells"] == count["/animat/centre"] == GROWTH + STEPS
    assert count["/animat/chambers"] == count["/animat/outline"] == count["/plots/distance"] == STEPS
    assert count["/evolution/best"] == count["/evolution/median"] == count["/evolution/diversity"] == 5
    assert {"/summary", "/animat/springs", "/animat/trail", "/evolution/chart"} <= set(count)


def test_a_rerun_file_brings_its_layout(bags, tmp_path, capsys):
    from rerun.chunk import RrdReader

    run(capsys, bags / "whole", "--save", tmp_path / "a.rrd")
    assert len(RrdReader(tmp_path / "a.rrd").blueprints()) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_a_recording_holds_is_shown(bags, tmp_path, capsys, kind):
    if kind == "settings":
        code, out, err = run(capsys, bags / kind, "--png", tmp_path / "a.png")
        assert (code, out) == (2, "") and "nothing to draw" in err and err.count("\n") == 1 and list(tmp_path.iterdir()) == []
        assert run(capsys, bags / kind, "--save", tmp_path / "a.rrd")[0] == 0 and "/summary" in rows(tmp_path / "a.rrd")
        return
    code, out, err = run(capsys, bags / kind, "--save", tmp_path / "a.rrd", "--png", tmp_path / "a.png")
    assert (code, err) == (0, "") and out.count("Saved") == 2
    assert "/summary" in rows(tmp_path / "a.rrd")
    check_picture(tmp_path / "a.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.rrd"]


# --- picture -------------------------------------------------------------------------------------------------------------


def check_picture(path, colours=8):
    import matplotlib.image

    pixels = matplotlib.image.imread(path)
    height, width = pixels.shape[:2]
    assert width == 1600 and 100 < height < 2000
    assert len(np.unique((pixels[::2, ::2, :3] * 8).astype(int) @ (100, 10, 1))) >= colours


def test_a_picture_shows_cells_in_their_colours(bags, tmp_path, capsys):
    code, _, err = run(capsys, bags / "whole", "--no-viewer", "--png", tmp_path / "a.png")
    assert (code, err) == (0, "")
    check_picture(tmp_path / "a.png", colours=40)
    assert not (bags / "whole/whole.rrd").exists()


def test_one_frame_of_a_body(bags, tmp_path):
    import matplotlib.image
    from evodevo_sim.view.picture import save_frame

    save_frame(life_of(read_recording(bags / "whole")), tmp_path / "frame.png", step=3, pixels=400)
    pixels = matplotlib.image.imread(tmp_path / "frame.png")
    assert pixels.shape[1] == 400 and pixels.shape[2] == 4 and pixels[0, 0, 3] == 0.0
    green = activation_colours(0.0) / 255
    assert (np.abs(pixels[..., :3] - green).max(axis=-1) < 0.02).mean() > 0.2


def test_a_picture_needs_no_rerun(bags, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(viewer, "is_installed", lambda: False)
    code, _, err = run(capsys, bags / "whole", "--png", tmp_path / "a.png")
    assert code == 0 and "pip install rerun-sdk" in err and (tmp_path / "a.png").exists()
    code, _, err = run(capsys, bags / "whole", "--save", tmp_path / "a.rrd")
    assert code == 2 and "pip install rerun-sdk" in err and err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


# --- command line --------------------------------------------------------------------------------------------------------


def test_without_a_display_the_newest_recording_is_saved_beside_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recordings.write("bags/old", run=False)
    recordings.write("bags/new", run=False)
    os.utime("bags/old/old_0.mcap", (1, 1))
    code, out, err = run(capsys)
    assert (code, err) == (0, "") and "bags/new/new.rrd" in out and "rerun --bind 127.0.0.1 bags/new/new.rrd" in out
    assert rows("bags/new/new.rrd")["/animat/cells"] == GROWTH + STEPS
    code, out, _ = run(capsys)  # once more: the older file gives way
    assert code == 0 and "bags/new/new.rrd" in out


def test_with_a_display_the_viewer_opens_on_a_whole_file(bags, capsys, monkeypatch):
    shown = []
    monkeypatch.setenv("DISPLAY", ":99")
    monkeypatch.setattr(viewer, "show", lambda path: shown.append((str(path), rows(path)["/animat/cells"])) or 0)
    assert run(capsys, bags / "whole") == (0, "", "")
    [(path, count)] = shown
    assert count == GROWTH + STEPS and not os.path.exists(path)


def test_a_cut_recording_is_shown_as_far_as_it_goes(tmp_path, capsys):
    with Recorder(tmp_path / "run") as recorder:
        for topic, message, stamp in recordings.run_messages():
            recorder.write(topic, message, stamp)
            recorder.flush()
    data = (tmp_path / "run/run_0.mcap").read_bytes()
    (tmp_path / "run/run_0.mcap").write_bytes(data[: len(data) // 2])
    code, out, err = run(capsys, tmp_path / "run", "--save", tmp_path / "a.rrd", "--png", tmp_path / "a.png")
    assert code == 0 and out.count("Saved") == 2
    assert err.count("\n") == 1 and "the end of" in err and "missing" in err


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["{}/nowhere"], "nowhere does not exist"),
        (["{}/whole", "--save", "{}/whole/none/a.rrd"], "make the directory"),
        (["{}/whole", "--save", "{}/whole/whole_0.mcap/a.rrd"], "make the directory"),
        (["{}/whole", "--save", "{}/whole"], "ends in .rrd"),
        (["{}/whole", "--png", "{}/a.jpg"], "ends in .png, .svg or .pdf"),
        (["{}/whole", "--picture", "{}/picture"], "ends in .png, .svg or .pdf"),
        (["{}/whole", "--palette", "grey"], "'paper', 'safe'"),
        (["{}/whole", "--fly"], "--fly (see --help)"),
        (["{}/whole", "{}/life"], "unrecognized arguments"),
        ([], "holds no recording: make one by `ros2 run evodevo_ga evolve`"),
    ],
)
def test_mistakes_get_one_line_and_exit_code_2(bags, tmp_path, capsys, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *(argument.format(bags) for argument in arguments))
    assert code == 2 and out == "" and says in err and err.startswith("replay: ") and err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_something_else_is_never_overwritten(bags, tmp_path, capsys):
    for name, flag in (("a.rrd", "--save"), ("a.png", "--png"), ("a.svg", "--picture"), ("a.pdf", "--picture")):
        (tmp_path / name).write_text("my notes")
        code, _, err = run(capsys, bags / "whole", flag, tmp_path / name)
        assert code == 2 and "never overwritten: choose another name" in err and err.count("\n") == 1
        assert (tmp_path / name).read_text() == "my notes"


def test_an_older_file_stays_until_the_new_one_is_whole(bags, tmp_path, capsys, monkeypatch):
    run(capsys, bags / "statistics", "--save", tmp_path / "a.rrd")
    before = (tmp_path / "a.rrd").read_bytes()

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(viewer, "save", stopped)
    assert run(capsys, bags / "whole", "--save", tmp_path / "a.rrd")[0] == 130
    assert (tmp_path / "a.rrd").read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def test_help_teaches(capsys):
    code, out, _ = run(capsys, "--help")
    assert code == 0
    for word in (
        "--save", "--picture", "--png", "--palette {paper,safe}", "--no-viewer", "ros2 run evodevo_sim replay bags/long",
        "without a display", "replaced",
    ):
        assert word in out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_viewer_and_leaves_nothing(bags, tmp_path, number):
    """The real command line, with a stand-in for the viewer that runs until it is ended."""
    stand_in = "import sys; print('shown', sys.argv[-1], flush=True); import signal; signal.pause()"
    code = (
        "import subprocess, sys; from evodevo_sim.commands.entry import replay; real = subprocess.Popen\n"
        f"subprocess.Popen = lambda command, env: real([sys.executable, '-c', {stand_in!r}, command[-1]], env=env)\n"
        "subprocess.run = lambda *_, **__: None\n"
        "sys.exit(replay())"
    )
    environment = os.environ | {"DISPLAY": ":99", "TMPDIR": str(tmp_path)}
    command, pipe = [sys.executable, "-c", code, str(bags / "life")], subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment)
    try:
        shown = process.stdout.readline()
        assert shown.startswith("shown") and os.path.exists(shown.split()[1]), shown
        process.send_signal(number)
        _out, err = process.communicate(timeout=DEADLINE)  # ends when the viewer, too, has closed its output
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 128 + number and not err.split("\r")[-1].strip()  # a bar comes where it takes 2 s
    assert list(tmp_path.iterdir()) == []


def test_the_viewer_keeps_to_this_host(tmp_path, monkeypatch):
    """A stand-in for the viewer's program writes down how it was called."""
    import rerun_cli

    program = tmp_path / "rerun"
    program.write_text(f'#!/bin/sh\necho "$XDG_CONFIG_HOME $*" >> {tmp_path}/calls\n')
    program.chmod(0o755)
    monkeypatch.setattr(rerun_cli, "__file__", str(tmp_path / "__init__.py"))
    assert viewer.show("a.rrd") == 0
    calls = [line.split() for line in (tmp_path / "calls").read_text().splitlines()]
    assert [call[1:] for call in calls] == [["analytics", "disable"], ["--bind", "127.0.0.1", "--port", "auto", "a.rrd"]]
    assert calls[0][0] == calls[1][0] and not os.path.exists(calls[0][0])


def test_rerun_switched_off_by_the_environment_still_saves_what_was_asked_for(bags, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("RERUN", "off")
    code, out, err = run(capsys, bags / "life", "--save", tmp_path / "a.rrd")
    assert (code, err) == (0, "") and "Saved" in out and rows(tmp_path / "a.rrd")["/animat/cells"] == GROWTH + STEPS
    assert os.environ["RERUN"] == "off"


def test_an_empty_rerun_file_is_never_called_saved(bags, tmp_path, capsys, monkeypatch):
    from contextlib import nullcontext

    monkeypatch.setenv("RERUN", "off")
    monkeypatch.setattr(viewer, "switched_on", nullcontext)
    code, out, err = run(capsys, bags / "life", "--save", tmp_path / "a.rrd")
    assert code == 2 and out == "" and "Rerun wrote nothing" in err and list(tmp_path.iterdir()) == []
