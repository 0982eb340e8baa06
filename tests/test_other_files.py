"""Recordings in other storages, compressed, damaged or of other scenes: read, or one line."""

import random

import numpy as np
import others
import pytest
import rewriting
from evodevo_sim.commands.gait import main as gait
from evodevo_sim.parameters import Scene
from evodevo_sim.recording import Recorder, RecordingError, read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.ros.messages import scene_message
from mcap.reader import make_reader
from others import SAMPLES, refused, replayed, same, states
from rosbags.convert.converter import convert

from evodevo_msgs.msg import Audit, CellStates

sample = pytest.fixture(scope="module", params=SAMPLES)(others.sample)
small = pytest.fixture(scope="module")(others.small)


# --- what cannot be read -------------------------------------------------------------------------------------------------


def test_compressed_messages_and_files_are_named(small, tmp_path, capsys):
    import zstandard

    rewriting.write(tmp_path / "a.mcap", rewriting.compressed(small[2]))
    refused(tmp_path / "a.mcap", tmp_path, capsys, "compressed by zstd")
    (tmp_path / "whole").mkdir()
    data = (small[0] / "life_0.mcap").read_bytes()
    (tmp_path / "whole/a.mcap.zstd").write_bytes(zstandard.compress(data))
    for path in (tmp_path / "whole", tmp_path / "whole/a.mcap.zstd"):
        refused(path, tmp_path, capsys, "compressed by zstd as a whole")
    rewriting.write(tmp_path / "json.mcap", small[2], message_encoding="json")
    refused(tmp_path / "json.mcap", tmp_path, capsys, "encoding 'json'")


@pytest.mark.parametrize("content", [b"SQLite format 3\0", b"SQLite format 3\0" + bytes(5000)])
def test_what_is_no_database_gets_one_line(tmp_path, capsys, content):
    (tmp_path / "a.db3").write_bytes(content)
    refused(tmp_path / "a.db3", tmp_path, capsys, "a.db3")


def test_a_device_is_called_one(tmp_path, capsys):
    code, err = replayed("/dev/null", tmp_path, capsys)
    assert code == 2 and "/dev/null is a device, no recording" in err and err.count("\n") == 1


# --- holes ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", ["its messages", "its length"])
def test_a_damaged_place_in_the_middle_is_a_hole_and_what_follows_is_read(tmp_path, capsys, place):
    with Recorder(tmp_path / "life") as recorder:
        for k, (topic, message, stamp) in enumerate(states(400)):
            recorder.write(topic, message, stamp)
            if k % 40 == 0:
                recorder.flush()
    path = tmp_path / "life/life_0.mcap"
    whole, data = read_recording(path), bytearray(path.read_bytes())
    with path.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[3]
    data[chunk.chunk_start_offset + (3 if place == "its length" else chunk.chunk_length // 2)] ^= 0xFF
    path.write_bytes(data)
    found = read_recording(path)
    assert not found.truncated and found.states[-1] == whole.states[-1] and 340 <= len(found.states) < 400
    assert "hole in the middle" in found.notes[0] and len(found.notes) == 1
    code, err = replayed(path, tmp_path, capsys)
    assert code == 0 and "hole in the middle" in err and "s of states are missing in the middle" in err and "end" not in err


def test_a_gait_is_not_measured_across_a_hole(tmp_path, capsys):
    for name, left in (("life", range(0)), ("hole", range(100, 160)), ("rest", range(160))):
        with Recorder(tmp_path / name) as recorder:
            for topic, message, stamp in states(400):
                if not (isinstance(message, CellStates) and message.step in left):
                    recorder.write(topic, message, stamp)
    told = {}
    for name in ("life", "hole", "rest"):
        assert gait([str(tmp_path / name)]) == 0
        told[name] = capsys.readouterr()
    assert told["hole"].out == told["rest"].out != told["life"].out
    assert all("does not say in what scene it is" in told[name].err for name in told) and told["rest"].err.count("\n") == 1
    assert "states are missing in the middle" in told["hole"].err and "longest whole stretch, 2.67 s to 6.65 s" in told["hole"].err


# --- what simulate recorded ----------------------------------------------------------------------------------------------


def test_a_walk_is_one_by_its_scene_and_stands_on_the_ground_in_it(tmp_path):
    from evodevo_sim.recording.gait import track_of_recording

    scene = Scene(0.0, 0.0, 9.81, 0.6, (-5.0, 0.0, 5.0), (0.0, 0.5, 0.0))
    with Recorder(tmp_path / "walk") as recorder:
        recorder.write("scene", scene_message(scene), 1)
        for topic, message, stamp in states():
            recorder.write(topic, message, stamp)
    recording = read_recording(tmp_path / "walk")
    for walks in (False, True):
        track = track_of_recording(recording, life_of(recording), walks)
        assert track.ground(np.array([0.0, 2.5])).tolist() == [0.5, 0.25] and track.world.gravity == 9.81


def test_audits_pass_through_their_message_with_the_names_of_their_runs(tmp_path):
    from evodevo_ga.auditor import Finding
    from evodevo_ga.messages import audit_message
    from evodevo_sim.tasks.audit import Audit as Found
    from evodevo_sim.tasks.audit import verdict_of
    from evodevo_sim.tasks.repetition import Run

    from evodevo_sim import Evaluation, Metrics, Status

    runs = tuple(Run(name, value, 0.0, value, (), 0.0, 1.0) for name, value in (("as evolved", 3.0), ("mean of 16 other starts", 2.5)))
    audit = Found(Evaluation(3.0, Status.OK, "", Metrics()), runs, ())
    message = audit_message(Finding(4, None, audit), 1.0)
    with Recorder(tmp_path / "run") as recorder:
        recorder.write("evolution/audit", message, 1)
    [found] = read_recording(tmp_path / "run").audits
    assert isinstance(found, Audit) and [(run.name, run.fitness) for run in found.runs] == [(run.name, run.fitness) for run in runs]
    assert verdict_of(audit) == "the fitness stands (2.5 m mean of 16 other starts)"


def test_random_bytes_in_a_database_do_no_harm(small, tmp_path):
    convert([small[0]], tmp_path / "a", "sqlite3", 9, None, "message", None, None, (), (), (), ())
    path, rng = next((tmp_path / "a").glob("*.db3")), random.Random(3)
    data = path.read_bytes()
    assert same(read_recording(tmp_path / "a"), small[1])
    for _ in range(25):
        damaged = bytearray(data)
        for _ in range(rng.choice((1, 20, 200))):
            damaged[rng.randrange(len(data))] = rng.randrange(256)
        (tmp_path / "b.db3").write_bytes(damaged)
        try:
            read_recording(tmp_path / "b.db3")
        except RecordingError as error:
            assert "\n" not in str(error)
