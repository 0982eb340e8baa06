"""The line to a body of rubber and air, without ROS: protocol, limits, calibration, rig, firmware, and all of them on a pseudo-terminal."""

import io
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from evodevo_sim.hardware.calibration import CalibrationError, calibration_of, make_calibration, save_calibration
from evodevo_sim.hardware.chain import ActuatorChain, SensorChain
from evodevo_sim.hardware.emulator import EmulatedBody, Emulator, Noisy
from evodevo_sim.hardware.firmware import WATCHDOG, Firmware
from evodevo_sim.hardware.limits import Limiter
from evodevo_sim.hardware.protocol import (
    MOST_FRAME,
    Arm,
    Command,
    Fault,
    FrameError,
    Hello,
    Mode,
    Parser,
    State,
    Stop,
    Welcome,
    alike,
    decode,
    encode,
    lost_between,
)
from evodevo_sim.hardware.rig import Line, Rig, RigError, event_of_line, make_rig
from evodevo_sim.hardware.serial_body import Health, SerialBody
from evodevo_sim.hardware.serial_line import LineError
from evodevo_sim.plant import Outcome
from evodevo_sim.text_file import parsed
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
CELLS = 5
STEP = 1 / 60
IDEAL = Rig()
PLACES = np.stack([np.arange(CELLS), np.zeros(CELLS)], 1) * 1.0

floats = st.floats(width=32)
uint16 = st.integers(0, 65535)
messages = st.one_of(
    st.builds(Hello, st.integers(0, 255)),
    st.builds(Arm, st.booleans(), st.booleans()),
    st.just(Stop()),
    st.builds(lambda n, values: Command(n, np.array(values, np.float32)), uint16, st.lists(floats, max_size=255)),
    st.builds(
        Welcome, *[st.integers(0, 255)] * 3, st.integers(0, 2**32 - 1), uint16, st.text(max_size=8),
    ),
    st.builds(
        lambda n, t, e, mode, fault, p, m: State(
            n, t, e, mode, Fault(fault), np.array(p, np.float32), np.array(m, np.float32).reshape(-1, 2)
        ),
        uint16, st.integers(0, 2**32 - 1), uint16, st.sampled_from(Mode), st.integers(0, 31), st.lists(floats, max_size=255),
        st.lists(st.tuples(floats, floats), max_size=255),
    ),
)


@given(st.lists(messages, max_size=5), st.lists(st.integers(1, 300), max_size=40), st.binary(max_size=50))
def test_messages_arrive_as_they_were_sent_however_the_stream_is_cut_and_whatever_came_before(sent, cuts, garbage):
    parser, found = Parser(), []
    stream = garbage + b"".join(map(encode, sent))
    for cut in cuts:
        found += parser.feed(stream[:cut])
        stream = stream[cut:]
    found += parser.feed(stream)
    assert len(found) == len(sent) and all(map(alike, found, sent))


@given(messages, st.integers(0), st.integers(1, 255))
def test_a_damaged_frame_is_no_message(message, place, change):
    frame = bytearray(encode(message).strip(b"\0"))
    frame[place % len(frame)] ^= change
    for part in bytes(frame).split(b"\0"):
        with pytest.raises(FrameError):
            decode(part)


@settings(max_examples=300)
@given(st.binary(max_size=2000))
def test_a_parser_takes_whatever_comes(data):
    parser = Parser()
    assert not list(parser.feed(data))  # 32 bits of checksum: none of these is a message
    assert list(parser.feed(encode(Stop()))) == [Stop()]


def test_fuzzed_frames_invent_nothing_and_harm_none_that_comes_after():
    from fuzz_frames import KINDS, fuzz

    told, wrong = fuzz(3000, 7)
    assert not wrong and all(told[kind.__name__] > 100 for kind in KINDS) and told["frames that were none"] > 1000


def test_what_never_ends_does_not_fill_the_memory():
    parser = Parser()
    for _ in range(1000):
        assert not list(parser.feed(b"x" * 1000))
    assert list(parser.feed(encode(Hello()))) == [Hello()] and parser.damaged == 1
    assert len(parser._rest) <= MOST_FRAME


def test_numbers_that_do_not_fit_are_refused():
    with pytest.raises(FrameError):
        encode(Command(65536, np.zeros(1)))
    with pytest.raises(FrameError):
        encode(Command(0, np.zeros(256)))


@given(uint16, st.integers(1, 1000))
def test_lost_states_are_counted_across_the_overflow(last, ahead):
    assert lost_between(last, (last + ahead) % 65536) == ahead - 1
    assert lost_between(last, last) == 0


# --- limits -----------------------------------------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.lists(st.floats(), min_size=CELLS, max_size=CELLS), st.floats(0, 0.1)), max_size=30))
def test_levels_stay_within_magnitude_and_rate_whatever_is_asked(asked):
    least, most, rate = np.full(CELLS, 10.0), np.full(CELLS, 50.0), np.full(CELLS, 100.0)
    limiter = Limiter(least, most, rate, np.full(CELLS, 10.0))
    before = limiter.level.copy()
    for levels, seconds in asked:
        level = limiter.towards(np.array(levels), seconds)
        assert ((least <= level) & (level <= most)).all()
        assert (np.abs(level - before) <= rate * seconds + 1e-9).all()
        before = level.copy()


def test_limits_say_what_they_did():
    limiter = Limiter(np.zeros(2), np.ones(2), np.full(2, 1.0), np.zeros(2))
    limiter.towards(np.array([np.nan, 2.0]), 0.5)
    assert (limiter.report.refused, limiter.report.magnitude, limiter.report.rate) == (1, 1, 1)
    assert limiter.level.tolist() == [0.0, 0.5]


# --- calibration and rig ------------------------------------------------------------------------------------------------------


def document(**changes):
    file = io.StringIO()
    save_calibration(calibration_of(PLACES, "eel"), file)
    return parsed(file.getvalue(), CalibrationError) | changes


def test_a_calibration_is_read_as_it_was_written():
    made = make_calibration(document())
    expected = calibration_of(PLACES, "eel")
    for name in ("position", "channel", "marker", "vent", "rest", "span", "least", "most", "rate"):
        assert np.array_equal(getattr(made, name), getattr(expected, name))


@given(st.permutations(range(CELLS)), st.permutations(range(CELLS)), st.floats(0.01, 100), st.floats(-4, 4), st.floats(-9, 9))
def test_wiring_and_frames_lead_there_and_back(channel, marker, scale, angle, x):
    frame = {"scale": scale, "angle": angle, "x": x, "y": -x}
    c = make_calibration(document(channel=list(channel), marker=list(marker), frame=frame))
    place = np.random.default_rng(0).normal(size=(CELLS, 2))
    assert np.allclose(c.seen(c.marks(place)), place)
    levels = c.levels_of(np.linspace(-1, 1, CELLS))
    assert np.allclose(c.by_cell(c.by_channel(levels)), levels) and np.allclose(c.activation_of(levels), np.linspace(-1, 1, CELLS))


LEVELS = {"vent": 0, "rest": 30, "span": 20, "least": 5, "most": 55, "rate": 400}


@pytest.mark.parametrize("changes, says", [
    ({"channel": [0, 1, 2, 3, 3]}, "channel[4] is 3, as channel[3] is, and no cell has 4"),
    ({"channel": [0, 1, 2, 3, 9]}, "channel[4] is 9: give a whole number from 0 to 4"),
    ({"channel": [0, 1, 2, 3]}, "marker has 5 entries, and channel has 4"),
    ({"marker": [0, 0, 1, 2, 3]}, "marker[1] is 0, as marker[0] is"),
    ({"channel": None}, "channel is missing"),
    ({"position": [[0, 0]] * 4}, "position has 4 entries"),
    ({"position": [[0, 0]] * 4 + [[0, float("nan")]]}, "position[4]"),
    ({"levels": LEVELS | {"rest": 60}}, "rest 60 is not within least 5 and most 55"),
    ({"levels": LEVELS | {"span": 0}}, "span is 0"),
    ({"levels": LEVELS | {"rate": -1}}, "levels.rate is -1"),
    ({"levels": LEVELS | {"rest": [1, 2]}}, "levels.rest has 2 entries"),
    ({"levels": LEVELS, "pressure": {"most": 50}}, "above pressure.most 50"),
    ({"levles": {}}, "did you mean 'levels'"),
    ({"patience": {"command": 0}}, "patience.command is 0"),
])
def test_bad_calibrations_name_the_place_and_the_mend(changes, says):
    with pytest.raises(CalibrationError) as error:
        make_calibration(document(**changes))
    assert says in str(error.value) and "\n" not in str(error.value) and len(str(error.value)) <= 300


@pytest.mark.parametrize("document, says", [
    ({"actuators": {"lag": -1}}, "actuators.lag is -1"),
    ({"actuators": {"lga": 1}}, "did you mean 'lag'"),
    ({"actuators": {"dead": [1, 1]}}, "actuators.dead[1] is 1 again"),
    ({"actuators": {"dead": [5]}}, "0 to 4"),
    ({"sensors": {"noise": "much"}}, "sensors.noise"),
    ({"line": {"lost": 2}}, "line.lost is 2"),
    ({"events": [{"at": 1, "what": "explode"}]}, "events[0].what is 'explode'"),
    ({"events": [{"what": "unplug"}]}, "events[0].at is None"),
    ({"seed": -1}, "seed is -1"),
    ([], "give the keys"),
])
def test_bad_rigs_name_the_place_and_the_mend(document, says):
    with pytest.raises(RigError) as error:
        make_rig(document, CELLS)
    assert says in str(error.value) and "\n" not in str(error.value)


# --- actuators and sensors as laws ------------------------------------------------------------------------------------------


def test_an_ideal_rig_changes_no_bit():
    rig, asked = make_rig({}), np.random.default_rng(1).uniform(-1, 1, (20, CELLS))
    chain, sensors = ActuatorChain(rig.actuators, CELLS, STEP), SensorChain(rig.sensors, PLACES, STEP, 0)
    assert rig.ideal
    for row in asked:
        assert np.array_equal(chain.step(row), row) and np.array_equal(sensors.see(PLACES + row[:, None]), PLACES + row[:, None])


def test_a_lag_and_a_dead_time_answer_a_step_by_their_closed_form():
    lag, steps = 0.15, 30
    chain = ActuatorChain(make_rig({"actuators": {"lag": lag, "dead_time": 3 * STEP}}).actuators, 1, STEP)
    found = [chain.step(np.ones(1))[0] for _ in range(steps)]
    time_since = STEP * np.maximum(np.arange(1, steps + 1) - 3, 0)
    assert np.allclose(found, 1 - np.exp(-time_since / lag), atol=1e-12)


@given(st.floats(0.1, 50), st.floats(0, 0.5), st.floats(0, 0.3))
def test_rate_resolution_and_dead_cells_hold(rate, resolution, lag):
    law = make_rig({"actuators": {"rate": rate, "resolution": resolution, "lag": lag, "dead": [2]}}).actuators
    chain, rng, before = ActuatorChain(law, CELLS, STEP), np.random.default_rng(0), np.zeros(CELLS)
    for _ in range(50):
        now = chain.step(rng.uniform(-1, 1, CELLS)).copy()
        assert (np.abs(now - before) <= rate * STEP + 1e-12).all() and now[2] == 0.0 and (np.abs(now) <= 1.0).all()
        before = now


def test_sensors_are_late_noisy_and_lose_markers_as_they_say():
    law = make_rig({"sensors": {"noise": 0.1, "delay": 2 * STEP, "lost": 0.25}}).sensors
    sensors = SensorChain(law, PLACES, STEP, 3)
    seen = np.array([sensors.see(PLACES + k) for k in range(4000)])
    there = seen[2:] - (PLACES + np.arange(3998)[:, None, None])
    lost = np.isnan(there)
    assert np.array_equal(lost[..., 0], lost[..., 1]) and abs(lost.mean() - 0.25) < 0.02
    assert abs(np.nanstd(there) - 0.1) < 0.005 and abs(np.nanmean(there)) < 0.005


@given(st.integers(0, 2**32))
def test_a_bad_line_loses_and_damages_frames_and_invents_none(seed):
    noisy, parser = Noisy(Line(0.2, 0.2), seed, 0), Parser()
    sent = [encode(Command(k, np.full(3, k, np.float32))) for k in range(200)]
    found = [message for frame in sent for message in parser.feed(noisy(frame))]
    assert all(message.levels[0] == message.sequence for message in found)
    assert 70 < len(found) < 180 and parser.damaged > 5


# --- firmware, by its own clock ---------------------------------------------------------------------------------------------


def armed():
    firmware = Firmware(np.full(CELLS, 10.0), 60.0)
    firmware.receive(encode(Arm(True)), 0.0)
    firmware.receive(encode(Command(1, np.full(CELLS, 30.0))), 0.0)
    assert firmware.mode == Mode.ARMED and (firmware.levels == 30.0).all()
    return firmware


def test_silence_vents_within_two_frames():
    firmware = armed()
    firmware.watch(firmware.levels, WATCHDOG - 0.001)
    assert firmware.mode == Mode.ARMED
    firmware.watch(firmware.levels, WATCHDOG + 0.001)
    assert firmware.mode == Mode.VENTED and (firmware.levels == 10.0).all() and firmware.fault == Fault.SILENCE
    firmware.receive(encode(Command(2, np.full(CELLS, 30.0))), 0.05)
    assert (firmware.levels == 10.0).all()  # not before it is armed
    firmware.receive(encode(Arm(True)) + encode(Command(3, np.full(CELLS, 30.0))), 0.05)
    assert (firmware.levels == 30.0).all() and firmware.fault == Fault.NONE and firmware.executed == 3


@pytest.mark.parametrize("pressure", [61.0, np.nan, np.inf])
def test_too_much_pressure_stops_until_a_person_arms_it(pressure):
    firmware = armed()
    firmware.watch(np.array([30.0, 30, pressure, 30, 30]), 0.01)
    assert firmware.mode == Mode.STOPPED and (firmware.levels == 10.0).all() and Fault.PRESSURE in firmware.fault
    firmware.receive(encode(Arm(True)), 0.02)
    assert firmware.mode == Mode.STOPPED
    firmware.receive(encode(Arm(True, person=True)), 0.03)
    assert firmware.mode == Mode.ARMED


@pytest.mark.parametrize("levels", [np.full(CELLS + 1, 30.0), np.full(CELLS, np.nan), np.zeros(0)])
def test_a_command_that_does_not_fit_is_not_carried_out(levels):
    firmware = armed()
    firmware.receive(encode(Command(2, levels)), 0.01)
    assert (firmware.levels == 30.0).all() and firmware.executed == 1 and Fault.COMMAND in firmware.fault


# --- the whole on a pseudo-terminal -----------------------------------------------------------------------------------------


class Masses:
    """A plant whose cells stand where their activation puts them."""

    def __init__(self):
        self.position, self.velocity = PLACES.copy(), np.zeros((CELLS, 2))

    def move(self, activation, seconds):
        self.position[:, 1] = activation
        return Outcome.SOUND


class Bench:
    """An emulated body on a pseudo-terminal, in a thread."""

    def __init__(self, directory, rig=IDEAL, calibration=None, version=1, step=STEP):
        self.calibration = calibration or calibration_of(PLACES, "eel")
        c, self.link = self.calibration, directory / "eel"
        self.firmware = Firmware(c.by_channel(c.vent), c.most_pressure, version=version)
        self.plant = Masses()
        self.emulator = Emulator(EmulatedBody(self.plant, c, rig, step), self.firmware, rig, step, self.link)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self.emulator.run, args=(self._stop.is_set,))

    def __enter__(self):
        self._thread.start()
        wait(self.link.exists)
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()


def wait(ready, seconds=30.0):
    deadline = time.monotonic() + seconds
    while not ready():
        assert time.monotonic() < deadline
        time.sleep(0.002)


def drive(body, activation, done, seconds=30.0):
    """Command the activation at every state until `done(sight)`."""
    deadline, number = time.monotonic() + seconds, -1
    while time.monotonic() < deadline:
        sight = body.look(number, 1.0)
        if sight is not None:
            number = sight.number
            if done(sight):
                return sight
        body.command(activation, number)
    raise AssertionError(f"not within {seconds} s: {body.health} {body.why}")


@pytest.fixture
def at(tmp_path):
    """(bench, body) of a rig."""
    opened = []

    def made(rig=IDEAL, **others):
        bench = Bench(tmp_path, rig, **others).__enter__()
        opened.append(bench)
        body = SerialBody(str(bench.link), bench.calibration, report=lambda health, why: heard.append(health))
        opened.append(body)
        return bench, body

    heard = []
    made.heard = heard
    yield made
    for one in reversed(opened):
        one.close() if isinstance(one, SerialBody) else one.__exit__()


ASKED = np.linspace(-0.9, 0.9, CELLS)


def test_a_body_goes_where_it_is_told(at):
    bench, body = at()
    sight = drive(body, ASKED, lambda sight: np.allclose(sight.position[:, 1], ASKED, atol=1e-5))
    assert np.allclose(sight.position[:, 0], PLACES[:, 0], atol=1e-6) and body.health == Health.FINE
    body.release()
    wait(lambda: bench.firmware.mode == Mode.VENTED)
    body.close()


def test_wiring_does_not_matter(at):
    c = make_calibration(document(channel=[4, 2, 0, 1, 3], marker=[1, 0, 3, 2, 4], frame={"scale": 0.01, "angle": 0.7, "x": 3, "y": -2}))
    _, body = at(calibration=c)
    drive(body, ASKED, lambda sight: np.allclose(sight.position[:, 1], ASKED, atol=1e-3))


def test_who_ceases_to_command_vents_the_body(at):
    bench, body = at()
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.ARMED and sight.state.executed > 3)
    wait(lambda: bench.firmware.mode == Mode.VENTED)  # nobody commands any more
    wait(lambda: Health.STALE in at.heard)
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.ARMED and np.allclose(sight.position[:, 1], ASKED, atol=1e-5))


def test_a_stop_holds_until_a_person_arms_the_body(at):
    bench, body = at()
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.ARMED)
    body.stop()
    wait(lambda: bench.firmware.mode == Mode.STOPPED)
    number = body.look().number
    drive(body, ASKED, lambda sight: sight.number > number + 30)
    assert bench.firmware.mode == Mode.STOPPED and body.health == Health.STOPPED
    body.rearm()
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.ARMED)


@pytest.mark.parametrize("what", ["unplug", "restart", "silence", "garbage"])
def test_a_fault_has_a_name_and_the_body_comes_back(at, what):
    named = {"unplug": Health.UNPLUGGED, "restart": Health.VENTED, "silence": Health.SILENT, "garbage": Health.FINE}
    _, body = at(make_rig({"events": [{"at": 0.5, "what": what, "for": 0.4}]}))
    there = lambda sight: sight.state.mode == Mode.ARMED and np.allclose(sight.position[:, 1], ASKED, atol=1e-5)
    drive(body, ASKED, lambda sight: sight.time > 1.2 and there(sight))
    assert named[what] in at.heard
    if what == "garbage":
        assert body.damaged > 5


def test_too_much_pressure_stops_the_body(at):
    _, body = at(make_rig({"events": [{"at": 0.3, "what": "pressure", "for": 0.05}]}))
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.STOPPED)
    assert Health.STOPPED in at.heard and "pressure" in body.why


def test_a_person_arms_once_and_a_stop_outlives_a_restart_of_the_firmware(at):
    bench, body = at(make_rig({"events": [{"at": 0.3, "what": "pressure", "for": 1e6}]}))
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.STOPPED)
    armings = []
    bench.firmware._log = lambda line: armings.append(line) if line.endswith("-> armed") else None
    body.rearm()
    number = body.look().number
    drive(body, ASKED, lambda sight: sight.number > number + 60)  # the pressure stays, and nobody arms it again
    assert len(armings) == 1 and bench.firmware.mode == Mode.STOPPED
    bench.emulator.happen(event_of_line("pressure 0"))
    bench.emulator.happen(event_of_line("restart"))
    number = body.look().number
    drive(body, ASKED, lambda sight: sight.number > number + 60)
    assert len(armings) == 1 and bench.firmware.boot == 2 and bench.firmware.mode == Mode.STOPPED
    body.rearm()
    drive(body, ASKED, lambda sight: sight.state.mode == Mode.ARMED)


def test_a_line_that_loses_a_tenth_goes_on(at):
    _, body = at(make_rig({"line": {"lost": 0.1, "damaged": 0.1}}))
    sight = drive(body, ASKED, lambda sight: sight.number > 60 and np.allclose(sight.position[:, 1], ASKED, atol=1e-5))
    assert body.counts.lost + body.damaged > 0 and sight.number > 60


def test_a_lost_marker_is_nan_and_never_the_last_value(at):
    _, body = at(make_rig({"sensors": {"lost": 0.5}}))
    seen = []
    drive(body, ASKED, lambda sight: seen.append(sight.position) or len(seen) > 40)
    lost = np.isnan(np.array(seen)[..., 0]).mean()
    assert 0.3 < lost < 0.7


def test_what_is_no_body_of_ours_is_refused_before_anything_moves(tmp_path):
    other = calibration_of(np.zeros((CELLS + 1, 2)), "other")
    with Bench(tmp_path) as bench:
        with pytest.raises(LineError, match=r"has 5 channels and 5 markers, the calibration 'other' 6"):
            SerialBody(str(bench.link), other)
        body = SerialBody(str(bench.link), bench.calibration)
        with pytest.raises(LineError, match="another program has it open"):
            SerialBody(str(bench.link), bench.calibration)
        body.close()
        assert bench.firmware.executed == 0
    with pytest.raises(LineError, match="there is no such port"):
        SerialBody(str(bench.link), bench.calibration)
    with Bench(tmp_path, version=7) as bench, pytest.raises(LineError, match="speaks version 7 of the protocol, this driver 1"):
        SerialBody(str(bench.link), bench.calibration)
