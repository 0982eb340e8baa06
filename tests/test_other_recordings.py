"""Recordings by other writers: the same lives in whatever order, storage and spelling; what cannot be read is named, in one line."""

import itertools
import random
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import rewriting
from evodevo_sim.commands import replay as cli
from evodevo_sim.commands.gait import main as gait
from evodevo_sim.parameters import Scene, default_task, preset, with_settings
from evodevo_sim.recording import Recorder, RecordingError, older, read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.recording.ordering import lives
from evodevo_sim.recording.schema import compare, types_of
from evodevo_sim.ros.messages import body_message, cell_states_message, scene_message, target_message, time_message
from evodevo_sim.view.summary import headline, markdown
from hypothesis import given, settings
from hypothesis import strategies as some
from mcap.reader import make_reader
from rosbags.convert.converter import convert

from evodevo_msgs.msg import Audit, CellStates, Task

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


@pytest.fixture(scope="module", params=SAMPLES)
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


@pytest.fixture(scope="module")
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


# --- the samples, by two libraries ---------------------------------------------------------------------------------------


def test_a_sample_in_the_order_and_spelling_of_rosbag2_is_the_same(sample, tmp_path):
    whole, rows = sample
    foreign = [rewriting.STRING._replace(topic=name, time=rows[0].time) for name in ("/leg/gait", "/x/body", "/cell_states")]
    by_topic = sorted(rewriting.by_rosbag2(rows), key=lambda row: row.topic, reverse=True)
    found = read_recording(rewriting.write(tmp_path / "a.mcap", foreign + by_topic, chunk=4096))
    assert same(found, whole) and notes_of(found) == notes_of(whole)


def test_a_sample_through_sqlite_and_back_by_rosbags_is_the_same(sample, tmp_path):
    whole, source = sample[0], sample[0].path
    for storage in ("sqlite3", "mcap"):
        convert([source], tmp_path / storage, storage, 9, None, "message", None, None, (), (), (), ())
        source = tmp_path / storage
        found = read_recording(source)
        assert same(found, whole)
        assert notes_of(found) == notes_of(whole)


def test_samples_tell_their_audits_by_name(sample):
    recording = sample[0]
    text = markdown(recording, life_of(recording))
    walks = recording.settings.task.name == "walk"
    assert ("| audit, mean of other starts |" in text) == walks and ("| audit, order 5, adaptive |" in text) != walks
    assert ("order 5" in headline(recording, life_of(recording))[1]) != walks and "by order 5" not in text


# --- order ---------------------------------------------------------------------------------------------------------------


@QUICK
@given(some.randoms(use_true_random=False), some.integers(64, 1 << 16), some.lists(some.sampled_from(
    ["/leg/gait", "/x/body", "/cell_states", "/a/growth/body", "/scene", "/evolution/audit", "/target_pose", "/chatter"]), max_size=4))
def test_neither_order_nor_chunks_nor_foreign_topics_matter(small, tmp_path_factory, rng, chunk, foreign):
    _, whole, rows = small
    shuffled = [*rows, *(rewriting.STRING._replace(topic=name, time=rng.randrange(10**10)) for name in foreign)]
    rng.shuffle(shuffled)
    path = tmp_path_factory.mktemp("shuffled") / "a.mcap"
    found = read_recording(rewriting.write(path, shuffled, chunk=chunk))
    assert same(found, whole) and notes_of(found) == notes_of(whole)
    assert np.array_equal(life_of(found).target, life_of(whole).target, equal_nan=True)


@QUICK
@given(some.data())
def test_late_messages_go_where_they_belong_and_a_reset_begins_a_life(data):
    counts = data.draw(some.lists(some.integers(2, 30), min_size=1, max_size=3))
    stamps = [k for count in counts for k in range(count)]
    order = list(range(len(stamps)))
    for k in data.draw(some.lists(some.integers(0, len(stamps) - 2), max_size=5, unique=True)):
        if stamps[order[k]] + 1 == stamps[order[k + 1]] and stamps[order[k]] > 0:
            order[k], order[k + 1] = order[k + 1], order[k]
    found = lives([stamps[i] for i in order], list(range(len(order))))
    ends = np.cumsum([0, *counts])
    assert [[order[i] for i in life] for life in found] == [list(range(a, b)) for a, b in itertools.pairwise(ends)]


def test_after_a_reset_in_a_recording_that_began_late_the_new_life_is_the_last():
    stamps = [*range(100, 140), *range(30)]
    times = [k * 10**8 for k in range(len(stamps))]
    assert lives(stamps, times)[-1] == list(range(40, 70))
    assert lives([5, 3, 9, 1], [0, 0, 0, 0]) == [[3, 1, 0, 2]]


def test_the_same_file_twice_is_one_run_and_said(small, tmp_path, capsys):
    directory, whole, _rows = small
    for name in ("run_0.mcap", "run_0 (copy).mcap"):
        shutil.copy(directory / "life_0.mcap", tmp_path / name)
    found = read_recording(tmp_path)
    assert same(found, whole) and len(found.notes) == 1 and "repeats messages of another file" in found.notes[0]


def test_states_and_body_of_two_animats_are_not_mixed(tmp_path):
    with Recorder(tmp_path / "two") as recorder:
        for number, late in ((1, 10**6), (0, 0)):
            for topic, message, stamp in states(6 + number):
                recorder.write(f"sim_{number}/{topic}", message, stamp + late)
    found = read_recording(tmp_path / "two")
    assert len(found.states) == 6 and "2 animats: /sim_0" in found.notes[0]


# --- types ---------------------------------------------------------------------------------------------------------------


@QUICK
@given(some.randoms(use_true_random=False), some.sampled_from(["Evolution", "Champion", "CellStates", "Body", "Task"]))
def test_spelling_makes_no_other_type(rng, name):
    ours = rewriting.our_schema(name)
    first, *parts = re.split(r"^=+$\n", ours, flags=re.MULTILINE)
    rng.shuffle(parts)
    lines = []
    for line in ("=====\n".join([first, *parts])).splitlines():
        bare = line.split("#")[0].rstrip() if not line.startswith("string[]") else line
        if re.match(r"^(float64|uint32) [a-z]", bare):
            bare += rng.choice(["", " 7", "  # 1 = 2", "\t"])
        if rng.random() < 0.2:
            bare += rng.choice(["\n", "\n# float64 not_there", "\nuint8 ODD = 3"]) if not bare.startswith(("=", "MSG")) else ""
        lines.append(bare.replace(" ", rng.choice([" ", "   "]), 1) if not bare.startswith("MSG") else bare)
    full = f"evodevo_msgs/msg/{name}"
    assert compare(full, types_of(full, "\n".join(lines)), types_of(full, ours)).same


def notes_of(recording):
    """What a recording says of itself, wherever it lies."""
    return [note.replace(str(recording.path), "") for note in recording.notes]


def changed(rows, pattern, to, data=lambda data: data):
    """The messages with another schema for the states."""
    return [
        row._replace(schema=re.sub(pattern, to, row.schema, flags=re.MULTILINE), data=data(row.data))
        if row.topic == "/cell_states" else row for row in rows
    ]


@pytest.mark.parametrize("pattern, to, says", [
    (r"^float64\[\] position_x", "float32[] position_x", "CellStates.position_x is float32[], not float64[]"),
    (r"^float64\[\] position_x.*\n", "", "CellStates.position_x is missing"),
    (r"^(float64\[\]) position_x", r"\1 place_x", "CellStates.position_x is missing"),
    (r"^uint32 nanosec", "uint64 nanosec", "nanosec is uint64"),
])
def test_a_type_of_ours_with_other_fields_is_named(small, tmp_path, capsys, pattern, to, says):
    rewriting.write(tmp_path / "a.mcap", changed(small[2], pattern, to))
    refused(tmp_path / "a.mcap", tmp_path, capsys, "other message types")
    with pytest.raises(RecordingError, match=re.escape(says)):
        life_of(read_recording(tmp_path / "a.mcap"))


def test_a_field_that_a_later_version_adds_is_ignored_and_said(small, tmp_path, capsys):
    rows = changed(small[2], r"(activation .*)$", r"\1\nfloat64 mood", lambda data: data + bytes(-(len(data) - 4) % 8 + 8))
    found = read_recording(rewriting.write(tmp_path / "a.mcap", rows))
    assert same(found, small[1])
    assert found.notes == [f"{tmp_path / 'a.mcap'} was recorded by another version: CellStates.mood is ignored"]
    code, err = replayed(tmp_path / "a.mcap", tmp_path, capsys)
    assert code == 0 and err.count("\n") == 1


@pytest.mark.parametrize("field, says", [
    ("settled_speed", "Task.settled_speed is missing (its default is taken)"),  # the last field of all of the message's part
    ("actuation", "Noise.actuation is missing (its default is taken)"),  # the last one of a part within
])
def test_a_field_that_an_older_version_lacks_has_its_default_where_that_is_true(tmp_path, field, says):
    from evodevo_ga.messages import evolution_message
    from evodevo_ga.settings import Settings
    from mcap_ros2._dynamic import serialize_dynamic

    from evodevo_sim import Task

    name = "evodevo_msgs/msg/Evolution"
    lacking = re.sub(rf"^float64 {field}.*\n", "", rewriting.our_schema("Evolution"), flags=re.MULTILINE)
    message = evolution_message(Settings(), Task(), 7)
    data = serialize_dynamic(name, lacking)[name](message)
    row = rewriting.Row("/evolution/settings", name, lacking, "", 1, data)
    found = read_recording(rewriting.write(tmp_path / "a.mcap", [row]))
    assert found.settings == message and says in found.notes[0]


def test_growth_that_an_older_recording_does_not_tell_of_is_the_law_of_its_day(monkeypatch):
    """Whatever the default is: no cell waited to divide."""
    inhibited = with_settings(default_task("walk"), preset("contact_inhibition"))
    monkeypatch.setattr(older, "default_task", lambda name: inhibited)
    told = SimpleNamespace(name="walk", development=SimpleNamespace(variant="continual_graph", max_cells=7, division_neighbours=3))
    law = older.message_of(told, Task).development
    assert (law.max_cells, law.division_room, law.division_neighbours, law.waiting_turn) == (7, 0.0, 3, 0.0)
    law = older.message_of(SimpleNamespace(name="walk"), Task).development
    assert (law.max_cells, law.division_room, law.division_neighbours, law.waiting_turn) == (32, 0.0, 0, 0.0)


@pytest.mark.parametrize("encoding, text", [("ros2idl", "module x {};"), ("", ""), ("ros2msg", "")])
def test_a_schema_in_another_language_is_named_and_a_hash_of_ours_tells_the_type(small, tmp_path, capsys, encoding, text):
    rows = [row._replace(schema=text) for row in small[2]]
    rewriting.write(tmp_path / "a.mcap", rows, encoding)
    refused(tmp_path / "a.mcap", tmp_path, capsys, "ros2idl" if text else "empty or absent")
    found = read_recording(rewriting.write(tmp_path / "b.mcap", rows, encoding, hashes=True))
    assert same(found, small[1]) and "read by its type's hash" in found.notes[0]


def test_an_older_audit_is_known_by_its_hash_whatever_its_schema_says(tmp_path):
    whole = read_recording(BAGS / "sample-swim")
    rows = [row for row in rewriting.rows_of(BAGS / "sample-swim/sample-swim_0.mcap") if row.topic.startswith("/evolution")]
    rows = [row._replace(schema=rewriting.our_schema("Audit")) if row.topic.endswith("audit") else row for row in rows]
    found = read_recording(rewriting.write(tmp_path / "a.mcap", rows, hashes=True))
    assert repr(found.audits) == repr(whole.audits) and notes_of(found) == notes_of(whole)


# --- from before a change, and from after the next one -------------------------------------------------------------------


def test_a_recording_from_before_schemes_and_actuation_opens_without_a_word(sample, tmp_path, capsys):
    recording, rows = sample
    assert not any("string scheme" in row.schema or row.topic == "/actuation" for row in rows)  # or this sample tells nothing of it
    assert not recording.notes and recording.settings.scheme == "" and recording.actuation == []
    assert "| scheme | not recorded |" in markdown(recording, life_of(recording))
    assert replayed(recording.path, tmp_path, capsys) == (0, "")


MOOD = rewriting.Row(
    "/mood", "evodevo_msgs/msg/Mood", "std_msgs/Header header\nMuscle[] muscles\n" + "=" * 80
    + "\nMSG: evodevo_msgs/Muscle\nfloat32 effort\n" + "=" * 80
    + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + "=" * 80
    + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n", "", 5, b"\0\1\0\0" + bytes(20),
)


def test_a_recording_from_after_a_change_opens_and_the_rest_is_shown(sample, tmp_path, capsys):
    """Fields at the end of two messages, a topic of a type that is not ours yet, and a type of ours on a topic that is not."""
    recording, rows = sample
    later = [MOOD, rows[0]._replace(topic="/evolution/plans"), rewriting.STRING._replace(topic="/plain", time=7)]
    for row in rows:
        name = row.type.rpartition("/")[2]
        if name in ("Evolution", "Body"):  # of Body the last field is an array that may be empty: alignment of what follows it counts
            first, *parts = re.split(r"(?m)^(?==+$)", row.schema)
            schema = "".join([first.rstrip("\n") + f"\nuint8 {name.lower()}_mood\nGenome[] ancestors\n", *parts])
            if "MSG: evodevo_msgs/Genome" not in schema:
                schema += "=" * 80 + "\nMSG: evodevo_msgs/Genome\nuint8[] kind\nint8[] sign\nfloat64[] x\nfloat64[] y\n"
            row = row._replace(schema=schema, data=row.data + b"\7" + bytes(-(len(row.data) + 1 - 4) % 4 + 4), hash="RIHS01_" + "7" * 64)
        later.append(row)
    found = read_recording(rewriting.write(tmp_path / "a.mcap", later, hashes=True))
    assert same(found, recording)
    [note] = found.notes
    for name in ("Evolution.evolution_mood", "Evolution.ancestors", "Body.body_mood", "Body.ancestors"):
        assert f"{name} is ignored" in note
    code, err = replayed(tmp_path / "a.mcap", tmp_path, capsys)
    assert code == 0 and err.count("\n") == 1


def test_what_is_recorded_now_opens_for_readers_that_know_less(tmp_path, monkeypatch):
    """A reader of before: its table lacks `actuation`, its Evolution the scheme.  Independent readers read all of it."""
    from evodevo_ga.messages import evolution_message
    from evodevo_ga.settings import Settings
    from evodevo_sim.recording import decoding, reader
    from evodevo_sim.ros import topics
    from evodevo_sim.ros.messages import actuation_message
    from rosbags.highlevel import AnyReader

    from evodevo_sim import Task

    run = evolution_message(Settings(), Task(), 7, scheme="niches")
    acts = [actuation_message(np.array([0.5, -1.0, 0.25]), k, k / 60) for k in range(1, 4)]
    with Recorder(tmp_path / "run") as recorder:
        recorder.write(topics.SETTINGS.name, run, 1)
        for topic, message, stamp in states():
            recorder.write(topic, message, stamp)
        for k, message in enumerate(acts):
            recorder.write(topics.ACTUATION.name, message, 10 + k)
    found = read_recording(tmp_path / "run")
    assert found.settings == run and found.actuation == acts and not found.notes
    assert "| scheme | niches |" in markdown(found, life_of(found))
    with AnyReader([tmp_path / "run"]) as foreign:
        read = [foreign.deserialize(raw, c.msgtype) for c, _, raw in foreign.messages() if c.topic == "/actuation"]
        assert [(m.step, m.activation.tolist()) for m in read] == [(m.step, m.activation.tolist()) for m in acts]
        settings = [foreign.deserialize(raw, c.msgtype) for c, _, raw in foreign.messages() if c.msgtype.endswith("Evolution")]
        assert [one.scheme for one in settings] == ["niches"]
    known = [topic for topic in topics.TOPICS if topic is not topics.ACTUATION]
    monkeypatch.setattr(topics, "TOPICS", known)
    ours = decoding.definition
    monkeypatch.setattr(decoding, "definition", lambda name: re.sub(r"(?m)^string scheme.*\n", "", ours(name)))
    decoding._by_schema.cache_clear()
    try:
        before = reader.read_recording(tmp_path / "run")
    finally:
        decoding._by_schema.cache_clear()
    assert before.states == found.states and before.body == found.body and before.settings.population == run.population
    assert before.actuation == [] and "Evolution.scheme is ignored" in before.notes[0] and len(before.notes) == 1


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
