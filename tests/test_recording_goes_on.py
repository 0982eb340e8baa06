"""A recording that goes on in another file: what a killed writer or a power cut left is mended, and every reader reads the whole."""

import os
import shutil

import pytest
import yaml
from evodevo_sim.recording import Recorder, RecordingError, read_recording
from evodevo_sim.recording.parts import files_of_recorder
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recordings import START, run_messages
from rosbags.rosbag2 import Reader

from evodevo_msgs.msg import GenerationStatistics

FIRST = 6  # generations of the first file


def more(recorder, generations):
    for number in generations:
        recorder.write("evolution/statistics", GenerationStatistics(generation=number), START + (number + 1) * 10**9)


def statistics(directory):
    return [message.generation for message in read_recording(directory).statistics]


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A recording of one file with many chunks."""
    directory = tmp_path_factory.mktemp("recordings") / "run"
    with Recorder(directory) as recorder:
        for topic, message, stamp in run_messages(FIRST):
            recorder.write(topic, message, stamp)
            recorder.flush()
    return directory


def goes_on(directory):
    with Recorder(directory, go_on=True) as recorder:
        more(recorder, range(FIRST, 2 * FIRST))


def by_metadata(directory):
    """Generations that a reader of another hand finds, by metadata.yaml."""
    with Reader(directory) as bag:
        found = [(time - START) // 10**9 - 1 for connection, time, _ in bag.messages() if connection.topic == "/evolution/statistics"]
        assert bag.message_count == sum(connection.msgcount for connection in bag.connections)
    return found


def test_a_whole_recording_goes_on_untouched_in_the_next_file(first, tmp_path):
    directory = shutil.copytree(first, tmp_path / "renamed")
    before = (directory / "run_0.mcap").read_bytes()
    for _ in range(2):
        goes_on(directory)
    assert (directory / "run_0.mcap").read_bytes() == before
    about = yaml.safe_load((directory / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["relative_file_paths"] == ["run_0.mcap", "run_1.mcap", "run_2.mcap"]
    assert [file["message_count"] for file in about["files"]][1:] == [FIRST, FIRST] and not list(directory.glob(".*"))
    assert about["message_count"] == sum(file["message_count"] for file in about["files"])
    recording = read_recording(directory)
    assert sorted({s.generation for s in recording.statistics}) == list(range(2 * FIRST)) and recording.settings.seed == 4


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(where=st.floats(0.0, 1.0), damage=st.sampled_from(["cut", "changed"]))
def test_a_torn_file_is_mended_with_all_that_can_be_read_of_it(first, tmp_path_factory, where, damage):
    directory = tmp_path_factory.mktemp("torn") / "run"
    shutil.copytree(first, directory)
    file = directory / "run_0.mcap"
    data = bytearray(file.read_bytes())
    place = int(where * (len(data) - 1))
    if damage == "cut":
        data = data[:place]
        (directory / "metadata.yaml").unlink()  # which only a recording that was closed has
    else:
        place = max(place, 8)  # without its first bytes it is no MCAP file
        data[place] ^= 0x55
    file.write_bytes(data)
    try:
        readable = statistics(directory)
    except RecordingError:
        readable = []
    goes_on(directory)
    assert statistics(directory) == sorted({*readable, *range(FIRST, 2 * FIRST)})
    if damage == "cut":  # other readers want every index to be right, also those that nobody needs
        assert sorted(by_metadata(directory)) == statistics(directory)
    recording = read_recording(directory)
    assert not recording.truncated and not [note for note in recording.notes if "missing" in note or "hole" in note]


def test_files_without_messages_and_those_of_other_hands_are_in_nobodys_way(first, tmp_path):
    directory = shutil.copytree(first, tmp_path / "run")
    (directory / "run_1.mcap").write_bytes(b"")  # of a process that was killed at once
    (directory / "notes.mcap").write_bytes(b"mine")
    assert [path.name for path in files_of_recorder(directory)] == ["run_0.mcap", "run_1.mcap"]
    goes_on(directory)
    assert (directory / "notes.mcap").read_bytes() == b"mine" and (directory / "run_2.mcap").exists()
    os.unlink(directory / "notes.mcap")
    assert statistics(directory) == list(range(2 * FIRST))
    with Recorder(directory, go_on=True):
        pass
    assert not (directory / "run_3.mcap").exists() and by_metadata(directory) == list(range(2 * FIRST))


def test_a_recording_that_is_killed_while_it_goes_on_hides_nothing(first, tmp_path):
    directory = shutil.copytree(first, tmp_path / "run")
    recorder = Recorder(directory, go_on=True)
    more(recorder, range(FIRST, FIRST + 2))
    recorder.flush()
    assert not (directory / "metadata.yaml").exists()  # it would name the first file alone
    shutil.copytree(directory, tmp_path / "killed")
    recorder.close()
    assert statistics(tmp_path / "killed") == list(range(FIRST + 2)) and statistics(directory) == list(range(FIRST + 2))


def test_a_directory_that_is_not_there_or_cannot_be_written_is_one_line(tmp_path):
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path / "nowhere", go_on=True)
