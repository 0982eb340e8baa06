"""Recordings by other writers: the same lives in whatever order, storage and spelling; what cannot be read is named, in one line."""

import itertools
import re
import shutil

import numpy as np
import others
import pytest
import rewriting
from evodevo_sim.recording import Recorder, read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.recording.ordering import lives
from evodevo_sim.recording.schema import compare, types_of
from evodevo_sim.view.summary import headline, markdown
from hypothesis import given
from hypothesis import strategies as some
from others import QUICK, SAMPLES, notes_of, same, states
from rosbags.convert.converter import convert

sample = pytest.fixture(scope="module", params=SAMPLES)(others.sample)
small = pytest.fixture(scope="module")(others.small)


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
    assert ("other starts |" in text) == walks and ("| audit, order 5, adaptive |" in text) != walks
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
