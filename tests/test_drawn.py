"""What public tools draw: the file itself says so to readers that are not ours, every step, small, and nothing for nobody."""

import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import recordings
import yaml
from evodevo_sim.live.animat import Animat
from evodevo_sim.nodes import drawn as node
from evodevo_sim.palettes import activation_colours
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import Recorder, read_recording
from evodevo_sim.recording.drawn import Drawn
from evodevo_sim.ros.drawn import MARKERS_PER_SECOND
from evodevo_sim.ros.messages import cell_states_message, genome_message, target_message, task_message, time_message
from evodevo_sim.ros.topics import BODY, CELL_STATES, DRAWN, DRAWN_CELLS, DRAWN_MARKERS, DRAWN_POSE, STREAM, TARGET_POSE, TOPICS
from genomes import first_viable
from hypothesis import given, settings
from hypothesis import strategies as some
from lab import Operator, simulators
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from evodevo_msgs import msg
from evodevo_msgs.srv import Load
from evodevo_sim import Task

ROOT = Path(__file__).resolve().parents[1]
LAYOUTS = ROOT / "src/evodevo_sim/evodevo_sim/layouts"
NAMESPACE = f"/drawn_{os.getpid()}"
FLOAT32 = {"x": 0, "y": 4, "z": 8, "activation": 12, "rgb": 16}  # offsets; the convention of PCL packs a colour into a float32
LINE_STRIP, LINE_LIST, CYLINDER, TRIANGLE_LIST = 4, 5, 3, 11  # of visualization_msgs/Marker
ADD, DELETE, DELETE_ALL = 0, 2, 3
SMALL = 0.51 / 1024  # m, of what rounding may change


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return recordings.write(tmp_path_factory.mktemp("bags") / "run")


@pytest.fixture(scope="module")
def decoded(bag):
    """By topic: (schema's name, decoded message, ns) as `mcap_ros2` decodes the file by the schemas in it."""
    found = {}
    with open(bag / "run_0.mcap", "rb") as stream:
        for one in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            found.setdefault(one.channel.topic, []).append((one.schema.name, one.decoded_message, one.message.log_time))
    return found


def points_of(cloud):
    """A cloud's points as a public reader takes them: by its fields, its step and its width."""
    kinds = {7: "<f4"}
    record = np.dtype({
        "names": [field.name for field in cloud.fields], "formats": [kinds[field.datatype] for field in cloud.fields],
        "offsets": [field.offset for field in cloud.fields], "itemsize": cloud.point_step,
    })
    return np.frombuffer(bytes(cloud.data), record, cloud.width * cloud.height)


def seconds(header):
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def test_each_recorded_step_has_its_cloud_with_the_same_stamp_place_and_colour(decoded):
    states = [*decoded["/growth/cell_states"], *decoded["/cell_states"]]
    clouds = decoded["/drawn/cells"]
    assert len(clouds) == len(states) > 200
    for (name, cloud, at), (_, state, recorded) in zip(clouds, states):
        assert name == "sensor_msgs/msg/PointCloud2" and at == recorded
        assert seconds(cloud.header) == seconds(state.header) and cloud.header.frame_id == state.header.frame_id == "world"
        assert {field.name: field.offset for field in cloud.fields} == FLOAT32
        assert {(field.datatype, field.count) for field in cloud.fields} == {(7, 1)}
        assert (cloud.height, cloud.width, cloud.point_step, cloud.is_bigendian) == (1, len(state.activation), 20, False)
        assert cloud.row_step == 20 * cloud.width == len(cloud.data) and cloud.is_dense
        points = points_of(cloud)
        assert np.abs(points["x"] - np.array(state.position_x)).max() <= SMALL and not points["z"].any()
        assert np.abs(points["y"] - np.array(state.position_y)).max() <= SMALL
        assert np.abs(points["activation"] - np.array(state.activation)).max() <= SMALL
        packed = points["rgb"].view("<u4")
        rgb = np.stack((packed >> 16 & 255, packed >> 8 & 255, packed & 255), axis=-1)
        assert not (packed >> 24).any() and np.array_equal(rgb, activation_colours(points["activation"]))


def test_markers_are_whole_at_any_moment_and_lie_on_the_cells(decoded):
    clouds = {at: points_of(cloud) for _, cloud, at in decoded["/drawn/cells"]}
    bodies = [*decoded["/growth/body"], *decoded["/body"]]
    assert {name for name, *_ in decoded["/drawn/markers"]} == {"visualization_msgs/msg/MarkerArray"}
    for _, array, at in decoded["/drawn/markers"]:
        body = max((one for one in bodies if one[2] <= at), key=lambda one: one[2], default=(0, msg.Body()))[1]  # none of an egg
        place = np.column_stack((clouds[at]["x"], clouds[at]["y"]))
        by_name = {marker.ns: marker for marker in array.markers if marker.action != DELETE_ALL}
        assert len({(marker.ns, marker.id) for marker in array.markers}) == len(array.markers)
        assert by_name["target"].action == DELETE
        assert len(by_name["springs"].points) == 2 * len(body.spring_a) if len(body.spring_a) else "springs" not in by_name
        if len(body.outline_a):
            assert len(by_name["outline"].points) == 2 * len(body.outline_a)
            corners = np.diff([*body.chamber_start])
            assert len(by_name["chambers"].points) == 3 * int((corners - 2).sum())
        for marker in array.markers:
            assert marker.header.frame_id == "world" and marker.pose.orientation.w == 1.0
            assert marker.action == DELETE_ALL or (marker.scale.x > 0 and 0 < marker.color.a <= 1)
            each = {LINE_LIST: 2, TRIANGLE_LIST: 3}.get(marker.type)
            if each:
                assert len(marker.points) % each == 0
                at_cells = np.array([(point.x, point.y) for point in marker.points])
                assert (np.abs(at_cells[:, None] - place).max(axis=2).min(axis=1) == 0).all()
        kinds = {"springs": LINE_LIST, "outline": LINE_LIST, "chambers": TRIANGLE_LIST, "target": CYLINDER}
        assert all(by_name[name].type == kinds[name] for name in by_name)
    times = [seconds(array.markers[0].header) for _, array, _ in decoded["/drawn/markers"]]
    births = [seconds(body.header) for _, body, _ in bodies]
    for one, other in itertools.pairwise(times):
        assert other - one >= 1 / MARKERS_PER_SECOND - 1e-6 or any(one < birth <= other for birth in births)
        assert other - one <= 1 / MARKERS_PER_SECOND + 2 * recordings.TASK.control_step


def test_the_first_markers_of_a_body_take_away_what_was_drawn_before(decoded):
    firsts = {at for topic in ("/growth/body", "/body") for _, _, at in decoded[topic]}
    firsts.add(decoded["/drawn/markers"][0][2])
    for _, array, at in decoded["/drawn/markers"]:
        assert (array.markers[0].action == DELETE_ALL) == (at in firsts)


def test_the_pose_is_the_centre_turned_as_the_body(decoded, tmp_path):
    for (name, pose, _), (_, cloud, _) in zip(decoded["/drawn/pose"], decoded["/drawn/cells"], strict=True):
        points, place, turn = points_of(cloud), pose.pose.position, pose.pose.orientation
        assert name == "geometry_msgs/msg/PoseStamped" and pose.header.frame_id == "world"
        assert place.x == pytest.approx(points["x"].mean(), abs=SMALL + 1e-6) and place.z == 0.0
        assert turn.x == turn.y == 0.0 and turn.z**2 + turn.w**2 == pytest.approx(1.0)
    shape, drawn = np.array([(0.0, 0.0), (2.0, 0.0), (0.5, 1.0)]), Drawn()
    for angle in (0.0, 0.4, 2.0, -3.0):
        c, s = np.cos(angle), np.sin(angle)
        state = cell_states_message(shape @ np.array([(c, s), (-s, c)]) + 5.0, np.zeros((3, 2)), np.zeros(3), 0, 1.0)
        turn = dict(drawn.of(CELL_STATES.name, state))[DRAWN_POSE.name].pose.orientation
        assert 2 * np.arctan2(turn.z, turn.w) == pytest.approx(angle)


def test_rosbags_knows_the_types_by_itself(bag):
    """Its own definitions of public types read them, not those of the file."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([bag]) as reader:
        read = {
            topic.name: [store.deserialize_cdr(raw, c.msgtype) for c, _, raw in reader.messages() if c.topic.endswith(topic.name)]
            for topic in (DRAWN_CELLS, DRAWN_POSE)
        }
    assert len(read["drawn/cells"]) == len(read["drawn/pose"]) > 200
    assert read["drawn/cells"][-1].point_step == 20


def test_the_importer_of_rerun_makes_points_of_it(bag, tmp_path):
    from rerun.chunk import RrdReader

    rerun = shutil.which("rerun", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    done = subprocess.run(
        [rerun, "mcap", "convert", bag / "run_0.mcap", "-o", tmp_path / "a.rrd"], capture_output=True, text=True, timeout=120.0,
        env=os.environ | {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)},
    )
    assert done.returncode == 0, done.stderr
    rows = {}
    for chunk in RrdReader(tmp_path / "a.rrd").stream().to_chunks():
        for name in chunk.to_record_batch().schema.names:
            rows[chunk.entity_path, name] = rows.get((chunk.entity_path, name), 0) + chunk.num_rows
    steps = recordings.TASK.control_steps + recordings.TASK.development.steps + 2
    assert rows["/drawn/cells", "Points3D:positions"] == rows["/drawn/pose", "InstancePoses3D:translations"] == steps


def test_ground_and_target_are_drawn_from_birth_on(tmp_path):
    task = with_settings(default_task("walk"), {"development.max_cells": 8})
    drawn, state = Drawn(), cell_states_message(np.array([(31.0, 1.0), (32.0, 1.0)]), np.zeros((2, 2)), np.zeros(2), 0, 0.0)
    drawn.of("evolution/settings", msg.Evolution(task=task_message(task)))
    assert not grounds(drawn.of("growth/cell_states", state))
    drawn.of(BODY.name, msg.Body(cells=2))
    [ground] = grounds(drawn.of(CELL_STATES.name, state))
    ends = [point.x for point in ground.points]
    assert ground.type == LINE_STRIP and ends[0] <= 31 - 40 and ends[-1] >= 32 + 40 and all(np.isfinite(ends))
    drawn.of(TARGET_POSE.name, target_message((3.0, -4.0), time_message(0.0)))
    later = cell_states_message(np.array([(31.0, 1.0), (32.0, 1.0)]), np.zeros((2, 2)), np.zeros(2), 60, 1.0)
    [target] = [m for m in dict(drawn.of(CELL_STATES.name, later))[DRAWN_MARKERS.name].markers if m.ns == "target"]
    assert (target.action, target.pose.position.x, target.pose.position.y) == (ADD, 3.0, -4.0)


def grounds(drawn):
    return [marker for marker in dict(drawn)[DRAWN_MARKERS.name].markers if marker.ns in ("ground", "ceiling")]


def test_animats_of_other_namespaces_are_drawn_there():
    drawn = Drawn()
    for k, name in enumerate(("/sim_0", "/sim_1")):
        state = cell_states_message(np.full((2, 2), float(k)), np.zeros((2, 2)), np.zeros(2), 0, 0.0)
        found = drawn.of(CELL_STATES.at(name), state)
        assert [topic for topic, _ in found] == [topic.at(name) for topic in (DRAWN_CELLS, DRAWN_POSE, DRAWN_MARKERS)]
        assert points_of(found[0][1])["x"].tolist() == [k, k]


_numbers = some.floats(width=64) | some.floats(-50, 50)
_arrays = some.lists(_numbers, max_size=4)
_cells = some.lists(some.integers(0, 5), max_size=6)


@given(some.lists(some.tuples(_arrays, _arrays, _arrays, some.floats(0, 5)), max_size=4), _cells, _cells, some.booleans())
@settings(max_examples=60, deadline=None)
def test_whatever_states_and_bodies_come_what_is_drawn_is_of_numbers(states, a, b, body):
    drawn = Drawn()
    size = min(len(a), len(b))
    if body:
        drawn.of(BODY.name, msg.Body(cells=4, spring_a=a[:size], spring_b=b[:size], outline_a=a[:size], outline_b=b[:size]))
    for x, y, activation, when in states:
        state = msg.CellStates(position_x=x, position_y=y, activation=activation)
        state.header.stamp = time_message(when)
        found = dict(drawn.of(CELL_STATES.name, state))
        sound = len(x) == len(y) == len(activation) > 0 and np.isfinite([x, y, activation]).all()
        assert (DRAWN_CELLS.name in found) == sound
        for array in [found[DRAWN_MARKERS.name]] if DRAWN_MARKERS.name in found else []:
            for marker in array.markers:
                assert np.isfinite([(point.x, point.y) for point in marker.points]).all()


@pytest.mark.parametrize("sample", ["sample-swim", "sample-walk", "sample-chemotaxis"])
def test_recordings_grow_by_less_than_half_and_are_read_as_before(sample, tmp_path):
    bag = ROOT / "bags" / sample
    recording, size = read_recording(bag), {}
    messages = [
        (seconds(one.header) if hasattr(one, "header") else 0.0, topic.name, one)
        for topic in TOPICS if (value := getattr(recording, topic.attribute))
        for one in (value if isinstance(value, list) else [value])
    ]
    messages = [row for row in messages if row[0] < 15.0]
    for drawn in (False, True):
        with Recorder(tmp_path / str(drawn), drawn=drawn) as recorder:
            for when, name, one in sorted(messages, key=lambda row: row[0]):
                recorder.write(name, one, recordings.START + round(1e9 * when))
        size[drawn] = (tmp_path / str(drawn) / f"{drawn}_0.mcap").stat().st_size
    assert size[True] <= 1.5 * size[False], size
    with_it, without = read_recording(tmp_path / "True"), read_recording(tmp_path / "False")
    assert not with_it.notes
    for topic in TOPICS:  # a gait holds numbers that are none
        one, other = getattr(with_it, topic.attribute), getattr(without, topic.attribute)
        assert one == other or repr(one) == repr(other)


# --- live ----------------------------------------------------------------------------------------------------------------


def test_a_simulator_draws_its_animat_for_whoever_listens_reliably_or_not():
    task = with_settings(Task(), {"development.max_cells": 12})
    with simulators(NAMESPACE), Operator() as operator:
        heard = {
            topic: operator.listen(topic.type, topic.at(NAMESPACE), quality)
            for topic, quality in zip(DRAWN, (STREAM.profile(), DRAWN_MARKERS.quality, DRAWN_POSE.quality))
        }
        operator.until(lambda: all(operator.node.count_publishers(topic.at(NAMESPACE)) for topic in heard))
        request = {"task": task_message(task), "seed": 1, "genome": genome_message(first_viable(1)[0]), "real_time_factor": 2.0}
        assert operator.call(Load, f"{NAMESPACE}/load", **request).success
        operator.until(lambda: all(len(messages) > 4 for messages in heard.values()))
    cloud = heard[DRAWN_CELLS][-1]
    assert cloud.header.frame_id == "world" and points_of(cloud).shape == (12,)
    markers = {marker.ns for array in heard[DRAWN_MARKERS] for marker in array.markers}
    assert {"springs", "outline", "chambers", "target"} <= markers and "ground" not in markers


def test_where_nobody_listens_nothing_is_made(monkeypatch):
    made = []

    class Publisher:
        def __init__(self, name):
            self.name, self.heard = name, 0

        def get_subscription_count(self):
            return self.heard

        def publish(self, message):
            made.append(self.name)

    publishers = {}

    class Node:
        def create_publisher(self, kind, name, quality):
            return publishers.setdefault(name, Publisher(name))

    drawn, animat = node.DrawnTopics(Node(), "leg"), Animat(first_viable(1)[0], with_settings(Task(), {"development.max_cells": 12}))
    with monkeypatch.context() as patched:
        patched.setattr(node, "drawing_of", None)  # it would fail
        for _ in range(3):
            animat.step()
            drawn.show(animat)
    assert not made
    for topic in DRAWN:
        made.clear()
        publishers[topic.name].heard = 1
        animat.step()
        drawn.show(animat)
        assert set(made) <= {one.name for one in DRAWN if publishers[one.name].heard} and topic.name in made


# --- layouts -------------------------------------------------------------------------------------------------------------


def test_layouts_name_topics_that_there_are():
    names = {topic.at("") for topic in (*TOPICS, *DRAWN)}
    foxglove = json.loads((LAYOUTS / "foxglove.json").read_text())
    panels = foxglove["configById"]

    def leaves(layout):
        return {layout} if isinstance(layout, str) else leaves(layout["first"]) | leaves(layout["second"])

    assert leaves(foxglove["layout"]) == set(panels)
    assert set(panels["3D!animat"]["topics"]) <= names
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    assert paths and {path.partition(".")[0] for path in paths} <= names
    rviz = yaml.safe_load((LAYOUTS / "animat.rviz").read_text())["Visualization Manager"]
    kinds = {"PointCloud2": "PointCloud2", "MarkerArray": "MarkerArray", "Pose": "PoseStamped"}
    by_name = {topic.at(""): topic for topic in (*TOPICS, *DRAWN)}
    shown = [display for display in rviz["Displays"] if "Topic" in display]
    assert {display["Topic"]["Value"] for display in shown} >= {topic.at("") for topic in DRAWN}
    for display in shown:
        topic = by_name[display["Topic"]["Value"]]
        assert kinds[display["Class"].rpartition("/")[2]] == topic.type.__name__
        assert display["Topic"]["Reliability Policy"] == "Reliable" and topic.service.reliable
    assert rviz["Global Options"]["Fixed Frame"] == "world"
