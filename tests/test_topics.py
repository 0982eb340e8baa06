"""The table of topics: whoever publishes, hears, records or tells of a topic has its name, type and quality from there alone."""

import ast
import dataclasses
import importlib.util
from pathlib import Path

import pytest
import yaml
from evodevo_sim.recording import Recorder, Recording
from evodevo_sim.ros import topics
from evodevo_sim.ros.topics import DRAWN, TOPICS, namespace_of, role_of
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy, qos_profile_sensor_data

ROOT = Path(__file__).resolve().parents[1]
_spec = importlib.util.spec_from_file_location("topics_page", ROOT / "scripts" / "topics.py")
page = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(page)

TABLE = Path(topics.__file__).resolve()
PEOPLE = {"write", "_write", "create_publisher", "create_subscription", "subscription", "count_publishers", "count_subscribers"}
QUALITIES = ("QoS", "qos_profile", "ReliabilityPolicy", "DurabilityPolicy", "HistoryPolicy")


def texts_of(node):
    """String constants below a node, e.g. of an f-string; the ends of names in a namespace are among them."""
    return [one.value for one in ast.walk(node) if isinstance(one, ast.Constant) and isinstance(one.value, str)]


def strays(source):
    """(line, what) of topic names, qualities of service and latched flags that stand in a source."""
    tree, found = ast.parse(source), []
    told = {
        id(node.body[0].value) for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in PEOPLE:
            given = [*node.args, *(keyword.value for keyword in node.keywords)]
            found += [(node.lineno, text) for one in given for text in texts_of(one) if role_of(text)]
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            entry = role_of(node.value)
            if entry and ("_" in entry.name or "/" in entry.name) and " " not in node.value:  # no other word is spelt so
                found.append((node.lineno, node.value))
        names = [node.id] if isinstance(node, ast.Name) else [one.name for one in node.names] if isinstance(node, ast.ImportFrom) else []
        found += [(node.lineno, name) for name in names if name.startswith(QUALITIES)]
        if isinstance(node, ast.keyword) and node.arg == "latched":
            found.append((node.value.lineno, "latched"))
    return found


def test_no_topic_is_spelt_outside_the_table():
    files = [file for file in sorted((ROOT / "src").rglob("*.py")) if file.resolve() != TABLE]
    assert len(files) > 100
    assert {file.relative_to(ROOT): found for file in files if (found := strays(file.read_text(encoding="utf-8")))} == {}


@pytest.mark.parametrize("source", [
    'recorder.write("body", message, 1)', 'node.create_publisher(Body, f"{namespace}/body", 1)', 'name = "/sim_0/cell_states"',
    'callbacks.subscription(Gait, topic="gait")', "from rclpy.qos import qos_profile_sensor_data", "QoSProfile(depth=1)",
    "recorder.write(BODY.name, message, 1, latched=True)", 'where = {"evolution/audit": 1}',
])
def test_a_stray_is_seen(source):
    assert strays(source)
    assert not strays('"""Publishes `body` and cell_states."""\nrecorder.write(BODY.name, message, 1)\nsys.stdout.write("x")')


def test_names_and_attributes_are_unlike_and_recordings_have_them():
    assert len({topic.name for topic in (*TOPICS, *DRAWN)}) == len(TOPICS) + len(DRAWN)
    assert len({topic.attribute for topic in TOPICS}) == len(TOPICS) and not any(topic.attribute for topic in DRAWN)
    attributes = {field.name: field for field in dataclasses.fields(Recording)}
    for topic in (*TOPICS, *DRAWN):
        for namespace in ("", "/sim_0", "/a/b"):
            assert role_of(topic.at(namespace)) is topic and namespace_of(topic.at(namespace), topic) == namespace
    for topic in TOPICS:
        assert (attributes[topic.attribute].default_factory is list) == topic.many and (topic.many or not topic.lives)
    named = {value for value in vars(topics).values() if isinstance(value, topics.Topic)}
    assert named == {*TOPICS, *DRAWN}


@pytest.mark.parametrize("topic", [*TOPICS, *DRAWN], ids=lambda topic: topic.name)
def test_a_recording_tells_the_quality_that_nodes_have(topic, tmp_path):
    with Recorder(tmp_path / "bag") as recorder:
        recorder.write(topic.at("/sim_0"), topic.type(), 1)
    about = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    [told] = about["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"]
    live = topic.quality
    assert told["depth"] == live.depth and told["history"] == "keep_last"
    assert (told["reliability"] == "reliable") == (live.reliability == ReliabilityPolicy.RELIABLE)
    assert (told["durability"] == "transient_local") == (live.durability == DurabilityPolicy.TRANSIENT_LOCAL) == topic.service.latched


def test_a_stream_is_what_subscribers_of_sensor_data_expect():
    ours, theirs = topics.CELL_STATES.quality, qos_profile_sensor_data
    for part in ("reliability", "durability", "history", "depth"):
        assert getattr(ours, part) == getattr(theirs, part)


def test_the_page_has_the_table_of_the_code():
    text = page.PAGE.read_text(encoding="utf-8")
    assert text == page.with_table(text) and page.table() in text, "run python scripts/topics.py"
    live = [line for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    for topic in (*TOPICS, *DRAWN):
        if topic.by in ("simulator", "chase"):
            assert any(line.startswith(f"| `{topic.name}` |") and page.type_name(topic.type) in line for line in live), topic.name
