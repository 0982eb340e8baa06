"""Recordings by other versions of the messages, older and later ones: what can be read is, and what cannot is said."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import others
import pytest
import rewriting
from evodevo_sim.parameters import default_task, preset, with_settings
from evodevo_sim.recording import Recorder, RecordingError, older, read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.view.summary import markdown
from others import SAMPLES, notes_of, refused, replayed, same, states

from evodevo_msgs.msg import Task

OLDER = Path(__file__).with_name("older.mcap")  # a run of version 0.1.0 before schemes were recorded, the first second of its life
sample = pytest.fixture(scope="module", params=SAMPLES)(others.sample)
small = pytest.fixture(scope="module")(others.small)


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


@pytest.mark.parametrize("encoding, text", [("ros2idl", "module x {};"), ("", ""), ("ros2msg", "")])
def test_a_schema_in_another_language_is_named_and_a_hash_of_ours_tells_the_type(small, tmp_path, capsys, encoding, text):
    rows = [row._replace(schema=text) for row in small[2]]
    rewriting.write(tmp_path / "a.mcap", rows, encoding)
    refused(tmp_path / "a.mcap", tmp_path, capsys, "ros2idl" if text else "empty or absent")
    found = read_recording(rewriting.write(tmp_path / "b.mcap", rows, encoding, hashes=True))
    assert same(found, small[1]) and "read by its type's hash" in found.notes[0]


def test_an_older_audit_is_known_by_its_hash_whatever_its_schema_says(tmp_path):
    whole = read_recording(OLDER)
    rows = [row for row in rewriting.rows_of(OLDER) if row.topic.startswith("/evolution")]
    rows = [row._replace(schema=rewriting.our_schema("Audit")) if row.topic.endswith("audit") else row for row in rows]
    found = read_recording(rewriting.write(tmp_path / "a.mcap", rows, hashes=True))
    assert repr(found.audits) == repr(whole.audits) and notes_of(found) == notes_of(whole)


# --- from before a change, and from after the next one -------------------------------------------------------------------


def test_a_recording_from_before_schemes_and_actuation_opens_without_a_word(tmp_path, capsys):
    recording, rows = read_recording(OLDER), rewriting.rows_of(OLDER)
    assert not any("string scheme" in row.schema or row.topic == "/actuation" for row in rows)  # or it tells nothing of that
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


def test_growth_that_an_older_recording_does_not_tell_of_is_the_law_of_its_day(monkeypatch):
    """Whatever the default is: no cell waited to divide."""
    inhibited = with_settings(default_task("walk"), preset("contact_inhibition"))
    monkeypatch.setattr(older, "default_task", lambda name: inhibited)
    told = SimpleNamespace(name="walk", development=SimpleNamespace(variant="continual_graph", max_cells=7, division_neighbours=3))
    law = older.message_of(told, Task).development
    assert (law.max_cells, law.division_room, law.division_neighbours, law.waiting_turn) == (7, 0.0, 3, 0.0)
    law = older.message_of(SimpleNamespace(name="walk"), Task).development
    assert (law.max_cells, law.division_room, law.division_neighbours, law.waiting_turn) == (32, 0.0, 0, 0.0)
