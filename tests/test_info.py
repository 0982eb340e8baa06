"""`info`: what recordings and genomes are, in whatever state; what is neither is one line and exit code 2."""

import json
import shlex
from pathlib import Path

import pytest
import recordings
import rewriting
from evodevo_sim.commands import replay
from evodevo_sim.commands.info import main
from evodevo_sim.recording import Recorder
from evodevo_sim.ros.topics import GROWTH_STATES, STATISTICS
from mcap.reader import make_reader
from std_msgs.msg import String

BAGS = Path(__file__).resolve().parents[1] / "bags"


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return recordings.write(tmp_path_factory.mktemp("bags") / "run")


@pytest.fixture
def told(capsys):
    """(exit code, what is told of each source as JSON, stderr)."""

    def tell(*sources):
        code = main(["--json", *map(str, sources)])
        out, err = capsys.readouterr()
        return code, [json.loads(line) for line in out.splitlines()], err

    return tell


def test_a_whole_run_is_told_and_what_can_be_drawn_is_drawn(bag, told, capsys, tmp_path):
    code, [run], err = told(bag)
    assert (code, err) == (0, "") and run["is"] == "recording" and run["ended"] == "complete" and not run["notes"]
    assert run["run"]["generations"] == 5 and run["run"]["task"] == "swim" and run["champion"]["audit"] == "none"
    assert run["life"]["states"] == recordings.TASK.control_steps + 1 and run["life"]["cells"] == 9
    counted = {topic["topic"]: topic for topic in run["topics"]}
    assert counted["/cell_states"]["messages"] == run["messages"]["states"] and counted["/cell_states"]["read"]
    assert counted["/drawn/cells"]["messages"] == run["messages"]["states"] + run["messages"]["growth"]
    assert not counted["/drawn/cells"]["read"] and counted["/drawn/cells"]["type"] == "sensor_msgs/msg/PointCloud2"
    assert {one["command"].split()[-1] for one in run["drawn"] if "--show" in one["command"] and not one["missing"]} == {
        "watch", "grow", "think", "evolve",
    }
    [turning] = [one for one in run["drawn"] if one["command"].startswith("turning")]
    assert "not of chemotaxis" in turning["missing"]
    of_ga = {one["command"].split()[0]: one["missing"] for one in run["drawn"] if one["package"] == "evodevo_ga"}
    assert of_ga == {"report": "", "descent": "no history beside it", "gallery": "no archive"}
    assert main([str(bag)]) == 0
    out, _ = capsys.readouterr()
    assert "complete" in out and "sensor_msgs/PointCloud2" in out and f"ros2 run evodevo_sim replay {bag} --show watch" in out
    assert f"  ros2 run evodevo_ga report {bag} -o FILE.html" in out and f"  not descent {bag}" in out


@pytest.mark.parametrize("kind, can", [("statistics", {"evolve"}), ("growth", {"watch", "grow"}), ("life", {"watch", "grow"})])
def test_a_part_of_a_run_serves_what_it_holds(kind, can, told, tmp_path, capsys):
    if kind == "statistics":
        recordings.write(tmp_path / kind, lived=False)
    else:
        with Recorder(tmp_path / kind) as recorder:
            from evodevo_sim.recording import record_performance

            class Part:
                def write(self, topic, message, stamp):
                    if kind == "life" or topic.startswith(GROWTH_STATES.name.partition("/")[0]):
                        recorder.write(topic, message, stamp)

            record_performance(Part(), recordings.life(), recordings.START)
    code, [part], _ = told(tmp_path / kind)
    shows = {one["command"].split()[-1]: one["missing"] for one in part["drawn"] if "--show" in one["command"]}
    assert code == 0 and {name for name, missing in shows.items() if not missing} == can
    for name, missing in shows.items():
        if missing:
            assert replay.main([str(tmp_path / kind), "--show", name, "--no-viewer", "--save", str(tmp_path / "a.rrd")]) == 2
            _, err = capsys.readouterr()
            assert missing in err and err.count("\n") == 1 and "--show" in err and len(err) <= 300


def test_how_a_recording_ended(bag, told, tmp_path):
    whole = (bag / "run_0.mcap").read_bytes()

    def state(name, data, metadata=True):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.mcap").write_bytes(data)
        if metadata:
            (tmp_path / name / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
        code, [found], _ = told(tmp_path / name)
        assert code == 0
        return found["ended"]

    assert state("whole", whole) == "complete"
    assert state("killed", whole[: len(whole) // 2]) == "cut"
    assert state("renamed", whole, metadata=False) == "unfinished"
    torn = bytearray(whole)
    with (bag / "run_0.mcap").open("rb") as file:  # how many chunks there are depends on how long the writing took
        chunk = max(make_reader(file).get_summary().chunk_indexes, key=lambda one: one.chunk_length)
    middle = chunk.chunk_start_offset + chunk.chunk_length // 2
    torn[middle : middle + 40] = bytes(40)
    assert state("torn", bytes(torn)) == "torn"
    recordings.write(tmp_path / "stopped", lived=False)
    assert told(tmp_path / "stopped")[1][0]["ended"] == "unfinished"


def test_a_newer_recording_says_so(bag, told, tmp_path):
    rows = rewriting.rows_of(bag / "run_0.mcap")

    def newer(more):
        changed = [row._replace(schema="uint64 mood\n" + row.schema, hash="", data=row.data[:4] + more + row.data[4:]) for row in rows]
        path = rewriting.write(
            tmp_path / f"{len(more)}.mcap", [new if row.topic == "/cell_states" else row for row, new in zip(rows, changed)]
        )
        code, [found], _ = told(path)
        assert code == 0
        return found

    # The schema and the data fit each other, or they do not.
    fits, lies = newer(bytes(8)), newer(b"")
    assert any("CellStates.mood is ignored" in note for note in fits["notes"])
    assert fits["life"]["states"] == fits["messages"]["states"] > 100
    assert any("/cell_states" in note or "CellStates" in note for note in lies["notes"])


def test_what_is_none_is_a_line_after_the_others_and_exit_code_2(bag, told, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "begun.mcap").write_bytes((bag / "run_0.mcap").read_bytes()[:20])
    with Recorder(tmp_path / "foreign") as recorder:
        recorder.write("chatter", String(data="not ours"), 1)
    (tmp_path / "text").write_text("hello")
    bad = [tmp_path / name for name in ("empty", "empty.mcap", "begun.mcap", "foreign", "text", "nowhere", "nowhere.mcap")]
    code, found, err = told(*bad[:3], bag, *bad[3:])
    assert code == 2 and len(found) == 1
    lines = err.splitlines()
    assert len(lines) == len(bad) and all(str(path) in line and len(line) <= 300 for path, line in zip(bad, lines))


def test_a_genome_is_told_with_what_its_file_says(told, capsys):
    path = BAGS / "sample-swim/champion.yaml"
    code, [genome], _ = told(path)
    assert code == 0 and genome["is"] == "genome" and genome["about"]["task"] == "swim"
    assert genome["elements"] == 8 + genome["regulatory"] + genome["transcription_factor"] + genome["morphogen"]
    assert genome["units"] > 0 and genome["connections"] > 0
    assert main([str(path)]) == 0 and "units" in capsys.readouterr()[0]


def test_commands_that_it_names_quote_odd_names(told, tmp_path):
    bag = recordings.write(tmp_path / "my run; rm", lived=False)
    _, [found], _ = told(bag)
    assert all(str(bag) in shlex.split(one["command"]) for one in found["drawn"])
    assert STATISTICS.at("") in {topic["topic"] for topic in found["topics"]}
