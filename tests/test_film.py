"""Films: numbers made small and read again, one page that a browser plays without a network, frames where the recording has them."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest
from browser import missing, visit
from evodevo_sim.commands import film as command
from evodevo_sim.parameters import default_task
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import Life, Pose, life_of
from evodevo_sim.view.film.clock import clock_of, frames_of
from evodevo_sim.view.film.packing import LEVELS, kept, pack, padded
from evodevo_sim.view.film.raster import Painter, smooth
from evodevo_sim.view.sources import life_of_performance, shown_of
from evodevo_sim.worlds import with_world
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from recordings import TASK, life, write

from evodevo_sim import random_genome, save_genome

needs_browser = pytest.mark.skipif(bool(missing()), reason=missing() or "there is one")
READY = "document.querySelectorAll('figure.film[data-ready]').length === document.querySelectorAll('figure.film').length"
ASIDE = {"console": [], "requests": []}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp("film") / "a bag")


@pytest.fixture(scope="module")
def page(bag):
    path = bag.parent / "film.html"
    assert command.main([str(bag), "-o", str(path)]) == 0
    return path


def document_of(page):
    return json.loads(re.search(r'<script type="application/json">(.*?)</script>', page.read_text(encoding="utf-8"))[1])


def unpacked(part, data, steps):
    """(position (T, N, 2), activation (T, N)) as the page's script reads them."""
    start, size = part["position"]
    low, high = np.frombuffer(data[start : start + size], np.uint8).reshape(2, -1).astype(np.int64)
    folded = low | high << 8
    second = ((folded >> 1) ^ -(folded & 1)).reshape(-1, steps)
    quanta = np.array(part["first"])[:, None] + second.cumsum(axis=1).cumsum(axis=1)
    start, size = part["activation"]
    first = np.frombuffer(data[start : start + size], np.int8).reshape(-1, steps).astype(np.int64)
    level = (first.cumsum(axis=1) + 128) % 256 - 128
    return np.moveaxis(quanta.reshape(2, -1, steps), (0, 1, 2), (2, 1, 0)) / part["scale"], level.T / LEVELS


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 9), st.integers(1, 40), st.floats(0.01, 3.0), st.integers(0, 2**32 - 1))
def test_a_packed_life_is_that_life_within_a_quantum(cells, steps, pace, seed):
    rng = np.random.default_rng(seed)
    position = rng.normal(0, 5, (1, cells, 2)) + rng.normal(0, pace, (steps, cells, 2)).cumsum(axis=0)
    activation = rng.uniform(-1.2, 1.2, (steps, cells))
    made = pack(Life(np.zeros(0), [], [], np.arange(steps) / 60, position, activation))
    data = zlib.decompress(base64.b64decode(made["data"]))
    there, level = unpacked(made["life"], data, steps)
    assert np.abs(there - position).max() <= 0.5 / made["life"]["scale"] + 1e-9
    assert np.abs(level - np.clip(activation, -1, 1)).max() <= 0.5 / LEVELS + 1e-9


def test_cells_of_an_embryo_wait_where_they_will_be_born():
    poses = [Pose(np.array([(float(k), 0.0), (5.0, 1.0), (6.0, 1.0)])[:n], np.zeros(n)) for k, n in enumerate((1, 2, 2, 3, 2))]
    position, _, count = padded(poses)
    assert count.tolist() == [1, 2, 2, 3, 2] and np.isfinite(position).all()
    assert position[0, 1].tolist() == [5.0, 1.0] and position[:, 2].tolist() == [[6.0, 1.0]] * 5


@given(st.integers(0, 300), st.integers(1, 40))
def test_the_last_step_is_always_kept(count, every):
    steps = kept(count, every)
    assert (steps[-1:] == [count - 1]) == (count > 0) and np.all(np.diff(steps) <= every)


def test_sixty_four_cells_in_two_thousand_steps_are_less_than_a_megabyte():
    from evodevo_sim.view.film.page import film_page

    def noise(steps):  # no motion is harder to make small
        rng = np.random.default_rng(1)
        position = rng.normal(0, 4, (1, 64, 2)) + rng.normal(0, 0.02, (steps, 64, 2)).cumsum(axis=0)
        return Life(np.zeros(0), [], [], np.arange(steps) / 60, position, rng.uniform(-1, 1, (steps, 64)))

    assert len(film_page(pack(noise(2001)), "noise").encode()) <= 1_000_000 and not pack(noise(2001))["notes"]
    longer = pack(noise(6001))
    assert len(film_page(longer, "noise").encode()) <= 1_000_000 and "is shown" in longer["notes"][0]


def test_a_page_asks_for_nothing(page):
    text = page.read_text(encoding="utf-8")
    assert "default-src 'none'" in text and not re.search(r"""(src|href)=["'](?!data:)|url\((?!data:)|https?://""", text)


def test_the_life_of_a_genome_is_that_of_its_recording(bag):
    shown, recorded = life_of_performance(life(), TASK), life_of(read_recording(bag))
    for name in ("position", "activation", "velocity", "springs", "outline"):
        assert np.array_equal(getattr(shown, name), getattr(recorded, name)), name
    assert np.allclose(shown.time, recorded.time) and np.allclose(shown.growth_time, recorded.growth_time)
    assert all(np.array_equal(a.position, b.position) for a, b in zip(shown.growth, recorded.growth, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(shown.growth_springs, recorded.growth_springs, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(shown.chambers, recorded.chambers, strict=True))


def test_a_run_without_a_life_is_shown_by_its_champion(tmp_path):
    said = []
    shown = shown_of(write(tmp_path / "run", lived=False), say=said.append)
    assert len(shown.life.time) == TASK.control_steps + 1 and "lives anew" in said[-1]


def test_targets_that_change_and_a_world_with_a_ceiling_are_packed_and_drawn(bag):
    recorded = life_of(read_recording(bag))
    target = np.full((len(recorded.time), 2), np.nan)
    target[10:20], target[20:] = (3.0, 1.0), (-4.0, 2.0)
    scene = with_world(default_task("walk"), "gap").scene
    made = replace(recorded, target=target, reach=9.0, scene=scene)
    packed = pack(made)["life"]
    assert packed["target"] == [[0, None, None], [10, 3.0, 1.0], [20, -4.0, 2.0]] and len(packed["surfaces"]) == 2
    plain, painter = Painter(recorded, 320, "safe"), Painter(made, 320, "safe")
    for step in (0, len(made.growth) + 5, painter.steps - 1):
        assert painter.draw(step).size == plain.draw(step).size == painter.size
    starred, bare = (np.asarray(one.draw(one.steps - 1)) == (132, 92, 196) for one in (painter, plain))
    assert starred.all(axis=-1).any() and not bare.all(axis=-1).any()


# --- in the browser --------------------------------------------------------------------------------------------------------

CENTRE = """(() => {  // of the pixels of the dot at the centre of mass, in the picture itself
  const canvas = document.querySelector('canvas'), ratio = canvas.width / canvas.clientWidth;
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0, x = 0, y = 0;
  for (let k = 0; k < data.length; k += 4) if (data[k] + data[k + 1] + data[k + 2] === 0) {
    count++; x += k / 4 % canvas.width + 0.5; y += Math.floor(k / 4 / canvas.width) + 0.5;
  }
  return [x / count / ratio, y / count / ratio, count, ...document.querySelector('figure').dataset.frame.split(' ').map(Number)];
})()"""


def step_is(number):
    return ["until", f"document.querySelector('figure').dataset.step === '{number}'"]


@needs_browser
def test_the_last_frame_is_the_last_state_within_a_pixel_at_both_widths(bag, page):
    recorded = life_of(read_recording(bag))
    last = len(recorded.growth) + len(recorded.time) - 1
    visited = visit(page, [
        ["until", READY], ["key", "End"], step_is(last), ["run", CENTRE], ["size", 390, 844], ["grab", str(page.with_suffix(".png"))],
        ["run", CENTRE], ["run", "document.documentElement.scrollWidth <= innerWidth"],
    ])
    for x, y, count, width, height, scale, middle_x, middle_y in (visited[3], visited[6]):
        there = recorded.centre[-1]
        assert count > 10
        assert abs(x - (width / 2 + (there[0] - middle_x) * scale)) <= 1 and abs(y - (height / 2 - (there[1] - middle_y) * scale)) <= 1
        assert width <= 1280 and scale > 10
    assert visited[7] is True and visited[-1] == ASIDE


@needs_browser
def test_keys_play_step_and_go_to_the_ends_and_a_reader_hears_it(bag, page):
    recorded = life_of(read_recording(bag))
    born, last = len(recorded.growth), len(recorded.growth) + len(recorded.time) - 1
    playing = "document.querySelector('figure').dataset.playing === '{}'".format
    visited = visit(page, [
        ["until", READY], ["until", playing("true")], ["key", "Space"], ["until", playing("false")],
        ["key", "Home"], step_is(0), ["key", "Right"], step_is(1), ["key", "Right", "Shift"], step_is(21), ["key", "Left"], step_is(20),
        ["key", "End"], step_is(last), ["key", "Period"], ["until", "document.querySelector('select').value === '2'"],
        ["key", "Space"], ["until", playing("true")], ["key", "Space"], ["until", playing("false")],
        ["run", "document.querySelector('[role=status]').textContent"],
        ["run", "document.querySelector('canvas').getAttribute('aria-label')"],
        ["run", "[...document.querySelectorAll('button,input,select')].every(e => e.textContent || e.ariaLabel || e.labels.length)"],
        ["run", "document.querySelector('input').value = 5; document.querySelector('input').dispatchEvent(new Event('input'))"], step_is(5),
        ["run", "document.querySelector('input').getAttribute('aria-valuetext')"],
    ])
    assert born > 40 and visited[20].startswith("paused at growth, step") and visited[21].startswith("Film of a bag: growth from 1 to 9")
    assert visited[22] is True and visited[25] == "growth, step 5" and visited[-1] == ASIDE


@needs_browser
def test_who_wants_less_motion_gets_a_film_that_waits(page):
    visited = visit(page, [["until", READY], ["run", "document.querySelector('figure').dataset.playing"]], "--force-prefers-reduced-motion")
    assert visited[1] == "false" and visited[-1] == ASIDE


# --- videos ----------------------------------------------------------------------------------------------------------------


def test_frames_of_a_video_are_at_the_pace_of_life(bag):
    recorded = life_of(read_recording(bag))
    clock, grown = clock_of(recorded), len(recorded.growth)
    assert (np.diff(clock) > 0).all() and clock[-1] - clock[grown] == pytest.approx(recorded.time[-1] - recorded.time[0])
    once, twice = frames_of(recorded, 30, 1.0), frames_of(recorded, 30, 2.0)
    assert once[0] == 0 and set(once[-30:]) == {len(clock) - 1} and len(once) - 30 == pytest.approx(2 * (len(twice) - 30), abs=2)


def test_the_last_frame_of_a_video_shows_the_last_state_within_a_pixel(bag):
    recorded = life_of(read_recording(bag))
    painter = Painter(recorded, 960, "safe")
    pixels = np.asarray(painter.draw(len(recorded.growth) + len(recorded.time) - 1))
    there = np.argwhere((pixels == 0).all(axis=-1)).mean(axis=0)[::-1] + 0.5
    pixels = np.asarray(painter.draw(len(recorded.growth)))
    before = np.argwhere((pixels == 0).all(axis=-1)).mean(axis=0)[::-1] + 0.5
    scale, camera = painter._scale / 2, smooth(smooth(recorded.centre, 30), 30)
    moved = (recorded.centre[-1] - camera[-1] - (recorded.centre[0] - camera[0])) * (scale, -scale)
    assert np.abs(there - before - moved).max() <= 1.0 and scale > 10


@pytest.mark.parametrize("ending", ["mp4", "gif"])
def test_videos_are_what_other_programs_read(bag, tmp_path, ending):
    out = tmp_path / f"film.{ending}"
    assert command.main([str(bag), "-o", str(out), "--width", "160", "--frames", "5"]) == 0
    count = len(frames_of(life_of(read_recording(bag)), 5, 1.0))
    if ending == "mp4":
        av = pytest.importorskip("av")
        with av.open(out) as file:
            stream = file.streams.video[0]
            assert sum(1 for _ in file.decode(stream)) == count and (stream.width, stream.height) == (160, 100)
            assert stream.codec_context.name in ("h264", "av1", "mpeg4", "libdav1d") and stream.average_rate == 5
    else:
        with Image.open(out) as file:
            length = 0
            for k in range(file.n_frames):
                file.seek(k)
                length += file.info["duration"]
            assert length == 200 * count and file.size == (160, 100) and file.info["loop"] == 0
    out.write_bytes(out.read_bytes()[:2000])
    assert command.main([str(bag), "-o", str(out), "--width", "64", "--frames", "2"]) == 0  # an older one is replaced


# --- bad input -------------------------------------------------------------------------------------------------------------


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as leaving:
        command.main([str(argument) for argument in arguments])
    said = capsys.readouterr().err.splitlines()[-1]
    assert leaving.value.code == 2 and len(said) <= 300
    return said


def test_bad_input_is_one_line_and_leaves_no_file(bag, tmp_path, capsys):
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.mcap").write_text("nothing of ours")
    (tmp_path / "cut").mkdir()
    whole = next(bag.glob("*.mcap")).read_bytes()
    (tmp_path / "cut" / "cut.mcap").write_bytes(whole[: len(whole) * 3 // 4])
    (tmp_path / "taken.html").write_text("a letter")
    out = tmp_path / "film.html"
    for source in ("empty.mcap", "text.mcap", "nowhere"):
        assert source in refused(capsys, tmp_path / source, "-o", out)
    assert "never overwritten" in refused(capsys, bag, "-o", tmp_path / "taken.html")
    assert ".html, .mp4 or .gif" in refused(capsys, bag, "-o", tmp_path / "film.avi")
    assert "--width" in refused(capsys, bag, "-o", out, "--width", "9")
    assert "--set is for a genome" in refused(capsys, bag, "-o", out, "--set", "control_steps=10")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut", "empty.mcap", "taken.html", "text.mcap"]
    code = command.main([str(tmp_path / "cut"), "-o", str(out)])
    assert code == 0 and document_of(out)["growth"] and "before it is read" in capsys.readouterr().err


def test_a_recording_without_states_says_what_can_be_drawn_instead(bag, tmp_path, capsys):
    from evodevo_sim.recording import Recorder
    from recordings import run_messages

    with Recorder(tmp_path / "run") as recorder:
        for topic, message, stamp in run_messages():
            if topic != "evolution/champion":
                recorder.write(topic, message, stamp)
    said = refused(capsys, tmp_path / "run", "-o", tmp_path / "film.html")
    assert "holds no states of a body" in said and "figure fitness" in said and not (tmp_path / "film.html").exists()


def test_a_genome_that_never_divides_is_shown_as_it_is(tmp_path, capsys):
    genome = random_genome(np.random.default_rng(0), 1)
    save_genome(tmp_path / "egg.yaml", genome)
    assert command.main([str(tmp_path / "egg.yaml"), "-o", str(tmp_path / "egg.html"), "--set", "development.steps=30"]) == 0
    made = document_of(tmp_path / "egg.html")
    assert made["life"] is None and made["growth"]["count"][-1] == 1 and "the animat fails" in capsys.readouterr().err


def test_a_palette_is_where_a_film_begins(bag):
    recorded = life_of(read_recording(bag))
    assert pack(recorded, "paper")["palette"] == "paper" and pack(replace(recorded, growth=[]))["growth"] is None
