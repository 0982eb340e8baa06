"""Recordings as others make them, for tests: a small one, and what holds of every one that is refused or replayed."""

from pathlib import Path

import numpy as np
import pytest
import rewriting
from evodevo_sim.commands import replay as cli
from evodevo_sim.commands.gait import main as gait
from evodevo_sim.recording import Recorder, read_recording
from evodevo_sim.ros.messages import body_message, cell_states_message, target_message, time_message
from hypothesis import settings

BAGS = Path(__file__).parents[1] / "bags"
SAMPLES = ["sample-swim", "sample-walk", "sample-chemotaxis"]
KEPT = (
    "settings", "statistics", "champions", "audits", "growth", "growth_bodies", "body", "states", "actuation", "targets", "gait", "scene",
)
QUICK = settings(max_examples=25, deadline=None)


def same(found, whole):
    """Whether two recordings hold equal messages; those with numbers that are none by their text."""
    for name in KEPT:
        one, other = getattr(found, name), getattr(whole, name)
        assert one == other or repr(one) == repr(other), name
    assert found.target_times == whole.target_times and found.state_times == whole.state_times and not found.truncated
    return True


def sample(request):
    """(recording, its messages) of a sample."""
    directory = BAGS / request.param
    return read_recording(directory), rewriting.rows_of(directory / f"{request.param}_0.mcap")


def states(count=40, first=0):
    """(topic, message, ns) of a small life with a target that moves in the middle."""
    yield "body", body_message(_triangle()), 1_000
    for k in range(first, count):
        if k in (3, count // 2):
            yield "target_pose", target_message((k, -k), time_message(0.0)), 1_000 + k * 10**7
        place = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)]) + 0.05 * k
        message = cell_states_message(place, np.zeros((3, 2)), np.sin([k, k + 1.0, k + 2.0]), k, k / 60)
        yield "cell_states", message, 1_001 + k * 10**7


def _triangle():
    from evodevo_sim.development.body import build_body
    from evodevo_sim.development.gabriel import adjacency, gabriel_graph

    position = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)])
    edges, start, neighbour = gabriel_graph(position), np.zeros(4, np.int64), np.empty(6, np.uint32)
    adjacency(edges, 3, 3, start, neighbour)
    return build_body(position, edges, start, neighbour, 1.0)


def small(tmp_path_factory):
    """(directory, recording, messages) of a small life."""
    directory = tmp_path_factory.mktemp("small") / "life"
    with Recorder(directory) as recorder:
        for topic, message, stamp in states():
            recorder.write(topic, message, stamp)
    return directory, read_recording(directory), rewriting.rows_of(directory / "life_0.mcap")


def replayed(path, tmp_path, capsys):
    """(exit code, stderr) of a picture of it; there is one if and only if all went well."""
    code = cli.main([str(path), "--no-viewer", "--png", str(tmp_path / "made.png")])
    assert (tmp_path / "made.png").exists() == (code == 0)
    (tmp_path / "made.png").unlink(missing_ok=True)
    return code, capsys.readouterr().err


def refused(path, tmp_path, capsys, says):
    code, err = replayed(path, tmp_path, capsys)
    assert code == 2 and says in err and err.count("\n") == 1 and len(err) <= 320, err
    with pytest.raises(SystemExit) as raised:
        gait([str(path)])
    err = capsys.readouterr().err
    assert raised.value.code == 2 and says in err and err.count("\n") == 1


def notes_of(recording):
    """What a recording says of itself, wherever it lies."""
    return [note.replace(str(recording.path), "") for note in recording.notes]
