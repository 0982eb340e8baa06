"""Recordings: every message comes back, for us and for independent readers, and nothing lets a damaged file do harm."""

import dataclasses
import errno
import os
import random
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import recordings
import yaml
from evodevo_sim.recording import Recorder, RecordingError, read_recording, record_performance, writer
from evodevo_sim.recording.definitions import definition
from evodevo_sim.recording.drawn import Drawn
from evodevo_sim.ros.messages import cell_states_message
from std_msgs.msg import String

from evodevo_msgs.msg import CellStates, GenerationStatistics

DEADLINE = 60.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return recordings.write(tmp_path_factory.mktemp("bags") / "run")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """(topic, message, stamp) of every message of a run and a life, in order."""

    class Sink(list):
        drawn = Drawn()

        def write(self, topic, message, stamp):
            self += [("/" + name, one, stamp) for name, one in ((topic, message), *self.drawn.of(topic, message))]

    sink = Sink()
    for topic, message, stamp in recordings.run_messages():
        sink.write(topic, message, stamp)
    record_performance(sink, recordings.life(), recordings.START + 60 * recordings.SECOND)
    return sink


def plain(message):
    """A message of any reader as nested dicts of numbers, lists and text."""
    if hasattr(message, "get_fields_and_field_types"):
        return {name: plain(getattr(message, name)) for name in message.get_fields_and_field_types()}
    if dataclasses.is_dataclass(message):
        names = [field.name for field in dataclasses.fields(message) if field.name[0].islower()]  # others are constants
        return {name: plain(getattr(message, name)) for name in names}
    if hasattr(message, "__slots__") and not isinstance(message, (str, bytes, bytearray)):
        return {name: plain(getattr(message, name)) for name in message.__slots__ if not name.startswith("_")}
    if isinstance(message, (bytes, bytearray)):
        return list(message)
    if isinstance(message, list) and message and not isinstance(message[0], (int, float, str)):
        return [plain(one) for one in message]
    return np.asarray(message).tolist()


# --- what comes back -----------------------------------------------------------------------------------------------------


def test_every_kind_of_message_comes_back(run, written):
    recording = read_recording(run)
    by_topic = {}
    for topic, message, _ in written:
        by_topic.setdefault(topic, []).append(message)
    assert [recording.settings] == by_topic["/evolution/settings"] and [recording.body] == by_topic["/body"]
    assert recording.statistics == by_topic["/evolution/statistics"]
    assert recording.champions == by_topic["/evolution/champion"]
    assert recording.growth == by_topic["/growth/cell_states"]
    assert recording.growth_bodies == by_topic["/growth/body"]
    assert recording.states == by_topic["/cell_states"]
    assert not recording.truncated


def test_a_life_is_recorded_step_by_step_in_running_time(run):
    recording, life, task = read_recording(run), recordings.life(), recordings.TASK
    assert len(recording.growth) == task.development.steps + 1 and len(recording.states) == task.control_steps + 1
    assert np.array_equal([s.position_x for s in recording.states], life.position[..., 0])
    stamps = [s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec for s in recording.growth + recording.states]
    assert np.diff(stamps) == pytest.approx(task.control_step, abs=2e-9)


def test_a_single_file_is_a_recording_too(run):
    assert read_recording(run / "run_0.mcap").states == read_recording(run).states


def test_the_files_of_a_split_recording_follow_their_numbers(tmp_path):
    for number in (0, 2, 10):
        with Recorder(tmp_path / f"part_{number}") as recorder:
            recorder.write("evolution/statistics", GenerationStatistics(generation=number), number)
        (tmp_path / f"part_{number}/part_{number}_0.mcap").rename(tmp_path / f"part_{number}.mcap")
    assert [s.generation for s in read_recording(tmp_path).statistics] == [0, 2, 10]


def test_topics_count_in_any_namespace_and_of_two_animats_the_first(tmp_path):
    with Recorder(tmp_path / "two") as recorder:
        for k, name in enumerate(("sim_0", "sim_1")):
            state = cell_states_message(np.full((2, 2), float(k)), np.zeros((2, 2)), np.zeros(2), 0, 0.0)
            recorder.write(f"{name}/cell_states", state, 1)
        recorder.write("chatter", String(data="not ours"), 2)
    assert [list(state.position_x) for state in read_recording(tmp_path / "two").states] == [[0.0, 0.0]]


# --- independent readers -------------------------------------------------------------------------------------------------


def test_rosbags_reads_equal_messages(run, written):
    from rosbags.highlevel import AnyReader

    with AnyReader([run]) as reader:
        read = [(c.topic, plain(reader.deserialize(raw, c.msgtype)), stamp) for c, stamp, raw in reader.messages()]
    assert read == [(topic, plain(message), stamp) for topic, message, stamp in written]


def test_mcap_decoder_reads_equal_messages(run, written):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with open(run / "run_0.mcap", "rb") as stream:
        decoded = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        read = [(d.channel.topic, plain(d.decoded_message), d.message.log_time) for d in decoded]
    assert read == [(topic, plain(message), stamp) for topic, message, stamp in written]


def test_metadata_is_what_rosbag2_asks_for(run, written):
    about = yaml.safe_load((run / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    stamps = [stamp for *_, stamp in written]
    assert (about["version"], about["storage_identifier"], about["ros_distro"]) == (9, "mcap", "jazzy")
    assert about["relative_file_paths"] == ["run_0.mcap"] and about["message_count"] == len(written)
    assert about["starting_time"]["nanoseconds_since_epoch"] == min(stamps)
    assert about["duration"]["nanoseconds"] == max(stamps) - min(stamps)
    counts = {t["topic_metadata"]["name"]: t["message_count"] for t in about["topics_with_message_count"]}
    assert counts == {topic: sum(t == topic for t, *_ in written) for topic in {t for t, *_ in written}}
    for topic in about["topics_with_message_count"]:
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
        [quality] = topic["topic_metadata"]["offered_qos_profiles"]
        assert (quality["durability"] == "transient_local") == topic["topic_metadata"]["name"].endswith(("body", "settings"))


def test_a_recording_that_ends_just_when_its_keeper_wakes_does_not_wait_for_ever(tmp_path):
    class Ending(threading.Event):
        def wait(self, timeout=None):
            if self.is_set():
                return True
            self.set()  # as `close` does, between the end of the keeper's wait and what it does next
            recorder._waiting.set()
            return False

    recorder = Recorder(tmp_path / "bag")
    recorder._ending = Ending()
    recorder.write("evolution/statistics", GenerationStatistics(), 1)
    recorder._keeper.join(DEADLINE)
    assert not recorder._keeper.is_alive()
    recorder.close()
    assert len(read_recording(tmp_path / "bag").statistics) == 1


# --- places --------------------------------------------------------------------------------------------------------------


def test_an_existing_directory_is_refused_and_left_alone(tmp_path):
    (tmp_path / "precious").write_text("data")
    with pytest.raises(RecordingError, match="never overwritten: choose another"):
        Recorder(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["precious"]


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"cannot be written .*: choose another directory"):
        Recorder(tmp_path / "file/run")


def test_nothing_is_left_where_nothing_was_written(tmp_path):
    with Recorder(tmp_path / "run"):
        assert (tmp_path / "run").is_dir()
    assert list(tmp_path.iterdir()) == []


def test_files_of_others_stay_where_nothing_was_written(tmp_path):
    with Recorder(tmp_path / "run"):
        (tmp_path / "run/simulators.log").write_text("why")
    assert (tmp_path / "run/simulators.log").read_text() == "why"


# --- damage --------------------------------------------------------------------------------------------------------------


def is_part(part, whole):
    """Whether messages are some of all, in their order."""
    rest = iter(whole)
    return all(any(message == other for other in rest) for message in part)


def read_or_refuse(path, whole):
    """How much of a damaged copy is read: some of the messages, and a note that not all, or nothing with one line."""
    try:
        recording = read_recording(path)
    except RecordingError as error:
        assert "\n" not in str(error)
        return None
    for name in ("statistics", "champions", "growth", "growth_bodies", "states"):
        assert is_part(getattr(recording, name), getattr(whole, name)), name
        assert recording.notes or getattr(recording, name) == getattr(whole, name)
    assert recording.settings in (None, whole.settings) and recording.body in (None, whole.body)
    return recording


def test_a_recording_cut_anywhere_is_read_as_far_as_it_goes(tmp_path):
    long = tmp_path / "long"
    with Recorder(long) as recorder:
        for topic, message, stamp in recordings.run_messages():
            recorder.write(topic, message, stamp)
            recorder.flush()  # many chunks
    data, whole = (long / "long_0.mcap").read_bytes(), read_recording(long)
    kept = []
    for size in [*np.linspace(0, len(data) - 1, 30).astype(int), 8, len(data) - 8]:
        (tmp_path / "cut.mcap").write_bytes(data[:size])
        recording = read_or_refuse(tmp_path / "cut.mcap", whole)
        assert recording is None or recording.truncated
        kept.append(0 if recording is None else len(recording.statistics))
    assert kept[:30] == sorted(kept[:30]) and len(set(kept)) > 3


def test_damaged_bytes_do_no_harm(run, tmp_path):
    data, whole, rng = (run / "run_0.mcap").read_bytes(), read_recording(run), random.Random(1)
    for _ in range(40):
        damaged = bytearray(data)
        for _ in range(rng.choice((1, 5, 50))):
            damaged[rng.randrange(len(data))] = rng.randrange(256)
        (tmp_path / "damaged.mcap").write_bytes(damaged)
        read_or_refuse(tmp_path / "damaged.mcap", whole)


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"hello", bytes(range(256)) * 40])
def test_what_is_no_recording_gets_one_line(tmp_path, content):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match="evolve` or `ros2 bag record -s mcap` made") as error:
        read_recording(tmp_path)
    assert ("\n" not in str(error.value) and "a.mcap" in str(error.value)) or str(tmp_path) in str(error.value)


def test_an_empty_or_missing_directory_gets_one_line(tmp_path):
    for path in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(RecordingError, match=str(path)):
            read_recording(path)


def test_a_recording_of_others_is_refused(tmp_path):
    with Recorder(tmp_path / "chatter") as recorder:
        recorder.write("chatter", String(data="hello"), 1)
    with pytest.raises(RecordingError, match="holds nothing of evodevo's"):
        read_recording(tmp_path / "chatter")


def test_other_comments_make_no_other_type(tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "definition", lambda name: "# of an older version\n" + definition(name).replace("#", "# so "))
    with Recorder(tmp_path / "old") as recorder:
        recorder.write("cell_states", CellStates(step=7), 1)
    assert read_recording(tmp_path / "old").states[0].step == 7


# --- a writer that is killed ---------------------------------------------------------------------------------------------

WRITER = """
    import sys, threading, time
    from evodevo_msgs.msg import GenerationStatistics
    from evodevo_sim.recording import Recorder

    recorder, wait, times = Recorder(sys.argv[1]), threading.Event(), []
    {flush}
    while True:
        recorder.write("evolution/statistics", GenerationStatistics(generation=len(times)), len(times))
        times.append(time.monotonic())
        print(sum(t < times[-1] - 1.2 for t in times), flush=True)
        wait.wait(0.05)
"""


def killed(directory, flush, enough):
    """Start a writer, kill it once a line that it printed is `enough`, and return that line's number."""
    code = textwrap.dedent(WRITER.format(flush=flush))
    process = subprocess.Popen([sys.executable, "-c", code, str(directory)], stdout=subprocess.PIPE, text=True, env=os.environ)
    try:
        return next(number for number in map(int, process.stdout) if enough(number))
    finally:
        process.kill()
        process.communicate(timeout=DEADLINE)


def test_what_is_older_than_a_second_survives_a_kill(tmp_path):
    number = killed(tmp_path / "run", "", lambda number: number > 5)
    recording = read_recording(tmp_path / "run")
    assert recording.truncated
    generations = [s.generation for s in recording.statistics]
    assert generations == list(range(len(generations))) and len(generations) >= number


def test_what_was_flushed_survives_a_kill(tmp_path):
    flush = """
    for k in range(7):
        recorder.write("evolution/statistics", GenerationStatistics(generation=k), k)
    recorder.flush()
    """
    killed(tmp_path / "run", textwrap.indent(textwrap.dedent(flush), "    ").strip(), lambda number: True)
    assert [s.generation for s in read_recording(tmp_path / "run").statistics][:7] == list(range(7))



LONE = """
    import sys, threading
    from evodevo_msgs.msg import GenerationStatistics
    from evodevo_sim.recording import Recorder

    recorder = Recorder(sys.argv[1])
    recorder.write("evolution/statistics", GenerationStatistics(generation=7), 1)
    print("written", flush=True)
    threading.Event().wait()
"""


def test_a_lone_message_is_in_the_file_though_nothing_follows_it_and_survives_a_kill(tmp_path):
    """No write and no close comes after it: only the recorder's own clock can put it there."""
    command = [sys.executable, "-c", textwrap.dedent(LONE), str(tmp_path / "run")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ)
    try:
        assert process.stdout.readline() == "written\n"
        file, deadline = tmp_path / "run/run_0.mcap", time.monotonic() + DEADLINE
        while not holds_one(file):
            assert time.monotonic() < deadline and process.poll() is None
            os.sched_yield()
    finally:
        process.kill()
        process.communicate(timeout=DEADLINE)
    [found] = read_recording(file).statistics
    assert found.generation == 7


def holds_one(file):
    try:
        return bool(read_recording(file).statistics)
    except RecordingError:
        return False


def test_an_error_of_the_disk_between_two_writes_is_one_line_at_the_next(tmp_path, monkeypatch):
    failed = threading.Event()

    def full(self):
        failed.set()
        raise OSError(errno.ENOSPC, "No space left on device")

    recorder = Recorder(tmp_path / "run")
    monkeypatch.setattr(recorder._writer, "flush", lambda: full(recorder))
    recorder.write("evolution/statistics", GenerationStatistics(generation=7), 1)
    assert failed.wait(DEADLINE)
    recorder._keeper.join(DEADLINE)
    with pytest.raises(RecordingError, match=r"recording stopped .No space left on device.: what came before is kept; make room"):
        recorder.write("evolution/statistics", GenerationStatistics(generation=8), 2)
    recorder.close()


def test_several_threads_write_one_recording(tmp_path):
    with Recorder(tmp_path / "run") as recorder:
        threads = [
            threading.Thread(target=lambda k=k: [
                recorder.write(f"sim_{k}/cell_states", CellStates(step=n), n) or recorder.flush() for n in range(30)
            ]) for k in range(3)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    about = yaml.safe_load((tmp_path / "run/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["message_count"] == 90 and [t["message_count"] for t in about["topics_with_message_count"]] == [30] * 3
    assert not read_recording(tmp_path / "run").truncated
