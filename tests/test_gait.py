"""Gaits: each class is named on motions made by formula, in any frame, at any hour, in noise; numbers are those of formulas."""

import dataclasses
import functools

import gaits
import numpy as np
import pytest
from bodies import body_of, rotation
from evodevo_sim.analysis.gait import GaitError, Ground, Rules, Surroundings, Track, analyse, track_of_motion, track_of_performance
from evodevo_sim.analysis.gait.form import limbs
from evodevo_sim.analysis.gait.rhythm import common_rhythm
from evodevo_sim.analysis.gait.sources import parts_of_body
from evodevo_sim.analysis.gait.work import work_of
from evodevo_sim.parameters import ParameterError, with_settings
from evodevo_sim.tasks.audit import audit
from genomes import pulsing
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Task, make_own_body, perform, random_genome, simulate_body

SWIMMERS = {
    gaits.undulating: "undulation", gaits.pulsing_bell: "jellyfish", gaits.tailed: "protrusions", gaits.rowing: "protrusions",
    gaits.peristaltic: "peristalsis",
}
WALKERS = {gaits.hopping: "jump", gaits.running: "run", gaits.shifting: "mass shift"}
EVERY = SWIMMERS | WALKERS


@functools.cache
def made(make):
    return make()


def moved(track, angle=0.0, shift=(0.0, 0.0), skip=0, later=0.0, mirror=False):
    """The same motion turned, moved, looked at from another frame on, at another hour, and in a mirror."""
    sign = np.array([-1.0 if mirror else 1.0, 1.0])
    return dataclasses.replace(
        track, time=track.time[skip:] + later, position=(track.position[skip:] * sign) @ rotation(angle).T + shift,
        activation=track.activation[skip:], chambers=tuple(c[::-1] for c in track.chambers) if mirror else track.chambers,
    )


@pytest.mark.parametrize("make", EVERY, ids=lambda make: make.__name__)
def test_each_class_is_named(make):
    assert analyse(made(make)).gait.name == EVERY[make]


@settings(max_examples=15, deadline=None)
@given(
    st.sampled_from(list(SWIMMERS)), st.floats(-4, 4), st.tuples(st.floats(-50, 50), st.floats(-50, 50)), st.integers(0, 40),
    st.floats(0, 1e3), st.booleans(),
)
def test_a_swimmer_is_the_same_in_every_frame(make, angle, shift, skip, later, mirror):
    before = analyse(moved(made(make), skip=skip)).gait
    after = analyse(moved(made(make), angle, shift, skip, later, mirror)).gait
    assert after.name == before.name == SWIMMERS[make]
    same = ("frequency", "amplitude", "synchrony", "pulsation", "bending", "speed", "stroke", "gradient_along", "moving_share")
    for field in same:
        assert getattr(after, field) == pytest.approx(getattr(before, field), rel=1e-4, abs=1e-4), field
    assert after.lateral_shift == pytest.approx(before.lateral_shift, abs=1e-3)


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(list(EVERY)), st.integers(0, 47))
def test_a_gait_is_the_same_at_every_moment(make, skip):
    before, after = analyse(made(make)).gait, analyse(moved(made(make), skip=skip)).gait
    assert after.name == EVERY[make]
    assert after.frequency == pytest.approx(before.frequency, rel=1e-3)
    assert after.speed == pytest.approx(before.speed, rel=0.05)
    assert after.gradient_along == pytest.approx(before.gradient_along, abs=0.01)


@pytest.mark.parametrize("make", WALKERS, ids=lambda make: make.__name__)
def test_a_walker_is_the_same_to_the_left_and_to_the_right(make):
    before, after = analyse(made(make)).gait, analyse(moved(made(make), shift=(7.0, 0.0), mirror=True)).gait
    assert after.name == before.name
    for field in ("flight", "flights", "feet", "duty", "support", "mass_shift", "speed", "gradient_along"):
        assert getattr(after, field) == pytest.approx(getattr(before, field), rel=1e-4, abs=1e-4), field


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(list(SWIMMERS)), st.integers(0, 2**32))
def test_noise_does_not_change_a_swimmer(make, seed):
    rng, track = np.random.default_rng(seed), made(make)
    noisy = dataclasses.replace(
        track, position=track.position + 0.02 * rng.standard_normal(track.position.shape),
        activation=track.activation + 0.05 * rng.standard_normal(track.activation.shape),
    )
    assert analyse(noisy).gait.name == SWIMMERS[make]


def test_an_undulator_whose_cells_have_rhythms_of_their_own_too_is_one():
    track, rng = made(gaits.undulating), np.random.default_rng(1)
    own = 0.6 * np.sin(2 * np.pi * rng.uniform(0.4, 3.0, track.activation.shape[1]) * track.time[:, None])
    gait = analyse(dataclasses.replace(track, activation=track.activation + own)).gait
    assert gait.name == "undulation" and 0.25 < gait.coherence < 0.6


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(list(WALKERS)), st.integers(0, 2**32))
def test_noise_of_muscles_and_of_what_is_in_the_air_does_not_change_a_walker(make, seed):
    rng, track = np.random.default_rng(seed), made(make)
    high = track.position[..., 1:] > 0.05
    noisy = dataclasses.replace(
        track, position=track.position + 0.01 * high * rng.standard_normal(track.position.shape),
        activation=track.activation + 0.05 * rng.standard_normal(track.activation.shape),
    )
    assert analyse(noisy).gait.name == WALKERS[make]


def test_numbers_of_an_undulator_are_those_of_its_formula():
    gait = analyse(gaits.undulating(wavelength=7.0, speed=0.5)).gait
    assert gait.frequency == pytest.approx(gaits.FREQUENCY, rel=1e-4)
    assert gait.gradient_along == pytest.approx(2 * np.pi / 7.0, abs=1e-3)
    assert gait.lateral_shift == pytest.approx(np.pi, abs=0.01) and gait.lateral_agreement > 0.99
    assert abs(gait.gradient_across) == pytest.approx(np.pi / np.sqrt(3), abs=0.05)  # half a period over two rows
    assert gait.travel == pytest.approx(0.5 * gaits.SECONDS / 2, rel=1e-2)
    assert gait.stroke == pytest.approx(0.5 / gaits.FREQUENCY, rel=0.05)
    assert abs(gait.long_axis) < 0.02 and gait.coherence > 0.999 and gait.synchrony < 0.01


def test_a_swimmer_in_circles_has_a_heading_too():
    straight = made(gaits.rowing)
    rate, speed = 0.4, 0.3
    body = straight.position - straight.position.mean(axis=1, keepdims=True)
    angle = rate * gaits.TIME
    turned = np.stack([frame @ rotation(a).T for frame, a in zip(body, angle)])
    path = speed / rate * np.stack((np.sin(angle), 1 - np.cos(angle)), axis=-1)
    gait = analyse(dataclasses.replace(straight, position=turned + path[:, None])).gait
    assert gait.turning == pytest.approx(rate, rel=0.02) and gait.speed == pytest.approx(speed, rel=0.02)
    assert gait.travel < speed * gaits.SECONDS / 2 and gait.name == "protrusions"


@given(st.floats(0.4, 8.0), st.floats(0, 6.3), st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_frequency_and_phase_of_a_sine_in_noise(frequency, phase, seed):
    time = np.arange(1000) / 60
    signals = 0.5 * np.cos(2 * np.pi * frequency * time[:, None] + phase + np.array([0.0, 1.0, 2.5]))
    noise = 0.05 * np.random.default_rng(seed).standard_normal(signals.shape)
    rhythm = common_rhythm(time, signals + noise + 0.3 + 0.001 * time[:, None])
    assert rhythm.frequency == pytest.approx(frequency, abs=2e-3)
    assert np.abs(rhythm.wave) == pytest.approx(0.5, abs=0.02)
    assert np.angle(rhythm.wave[1:] / rhythm.wave[0]) == pytest.approx([1.0, 2.5], abs=0.03)


def test_limbs_are_what_is_thin_about_what_is_not():
    assert not limbs(gaits.lattice(10, 3), 2.4).any()  # stout all over
    assert not limbs(gaits.lattice(10, 2), 2.4).any()  # thin all over: a limb of nothing
    body = gaits.tailed()
    assert np.array_equal(np.flatnonzero(limbs(body.position[0], 2.4)), np.arange(25, 39))


def test_what_rests_is_still():
    track = made(gaits.rowing)
    silent = dataclasses.replace(track, activation=np.full_like(track.activation, 0.3))
    assert analyse(silent).gait.name == "still" and "muscles" in analyse(silent).gait.why
    fixed = dataclasses.replace(track, position=track.position - track.position.mean(axis=1, keepdims=True))
    assert analyse(fixed).gait.name == "still" and "m far" in analyse(fixed).gait.why
    chaos = np.random.default_rng(0).standard_normal(track.activation.shape)
    assert analyse(dataclasses.replace(track, activation=chaos)).gait.name == "unclear"


def test_contacts_of_those_that_jump_run_and_stand():
    jump, run, stand = (analyse(made(make)) for make in WALKERS)
    assert jump.gait.flight == pytest.approx(0.35, abs=0.02) and jump.gait.flights == pytest.approx(gaits.FREQUENCY, rel=0.2)
    assert run.gait.feet == 2 and run.gait.duty == pytest.approx(0.5, abs=0.02) and run.gait.support < -0.95
    rear, front = run.contact.feet
    x = made(gaits.running).position[0, :, 0]
    assert x[rear].max() < x[front].min()
    assert stand.gait.flight == 0.0 and stand.gait.duty == 1.0 and stand.gait.mass_shift > 0.1
    assert np.array_equal(stand.contact.duty == 1.0, made(gaits.shifting).position[0, :, 1] < 1e-9)


def test_contact_follows_the_ground():
    level = made(gaits.running)
    slope = level.position + 0.0
    slope[..., 1] += 0.2 * slope[..., 0]
    tilted = dataclasses.replace(level, position=slope, ground=Ground((-1e3, 1e3), (-200.0, 200.0)))
    assert np.array_equal(analyse(tilted).contact.touching, analyse(level).contact.touching)


def test_an_edge_on_a_tip_is_no_flight():
    """A body of three cells stands on a spike by an edge, its cells in the air, then hops off it."""
    lift = np.where(gaits.TIME % 1.0 < 0.5, 0.0, 0.3)
    position = np.array([(-1.0, 1.0), (1.0, 1.0), (0.0, 2.0)]) + np.stack((0.0 * lift, lift), axis=-1)[:, None]
    spike = Ground((-0.5, 0.0, 0.5), (0.0, 1.0, 0.0))
    muscle = np.cos(2 * np.pi * gaits.TIME)[:, None] * np.ones(3)
    track = Track(gaits.TIME, position, muscle, outline=np.array([(0, 1), (1, 2), (2, 0)]), ground=spike)
    found = spike.touching(track.outline, track.position, 1e-3)
    assert np.array_equal(found, (lift == 0.0)[:, None] & [True, True, False])
    assert Ground().touching(track.outline, track.position, 1e-3).sum() == 0
    assert analyse(track).gait.flight == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("muscle_range", [0.2, 0.25])
def test_work_is_that_of_the_ledger(muscle_range):
    task = with_settings(Task(), {"control_steps": 400, "material.muscle_range": muscle_range})
    genome = pulsing()
    work = work_of(track_of_performance(perform(genome, task), task))
    muscle, drag, damping, _ = audit(genome, task).runs[0].ledger
    assert work.muscle == pytest.approx(muscle, rel=2e-4)  # of lengths and speeds at frames
    assert work.drag == pytest.approx(drag, rel=0.05) and work.damping == pytest.approx(damping, rel=0.1)
    assert abs(work.rest) < 0.05 * muscle


def test_drag_of_a_bar_that_is_drawn_across():
    time = np.linspace(0, 2, 100)
    position = np.array([(0.0, 0.0), (1.5, 0.0)]) + np.stack((0 * time, 0.7 * time), axis=-1)[:, None]
    body = body_of([(0, 0), (1.5, 0)])
    world = Surroundings(1.0, 400.0, 10.0, 400.0, 40.0, 0.2, muscle_range=0.2)
    track = Track(time, position, np.zeros((100, 2)), world=world, **parts_of_body(body))
    work = work_of(track)
    assert work.drag == pytest.approx(-40.0 * 1.5 * 0.7**3 * 2, rel=1e-6)
    assert work.muscle == 0.0 and work.damping == pytest.approx(0.0, abs=1e-12) and work.gain == pytest.approx(0.0, abs=1e-9)


def waved(rest, amplitude, phase, frequency, scene):
    drive = {"amplitude": amplitude.tolist(), "frequency": frequency, "phase": phase.tolist()}
    own = make_own_body({"position": rest.tolist(), "activation": drive})
    return track_of_motion(own, simulate_body(own, scene, 8.0))


def test_hand_made_waves_that_swim_and_walk_are_named():
    rest = gaits.lattice()
    x, y = rest.T
    bending = analyse(waved(rest, 0.8 * y / y.max(), -2 * np.pi * x / 5, 2.0, "swim")).gait
    assert bending.name == "undulation" and bending.gradient_along == pytest.approx(2 * np.pi / 5, rel=0.1)
    assert abs(bending.muscle_work + bending.drag_work + bending.damping_work) < 0.05 * bending.muscle_work
    assert bending.cost_of_transport == pytest.approx(bending.muscle_work / (30 * bending.travel))
    rest = gaits.standing(gaits.lattice(8, 3))
    walking = analyse(waved(rest, np.full(24, 0.5), -2 * np.pi * rest[:, 0] / 8, 1.5, "walk")).gait
    assert walking.name == "mass shift" and walking.flight < 0.05
    assert -walking.muscle_work < walking.ground_work < 0  # friction takes, it never gives


def test_motions_that_have_no_gait_are_one_line():
    whole = made(gaits.rowing)
    hole = whole.position.copy()
    hole[100, 3] = np.nan
    late = whole.time.copy()
    late[50] = late[49]
    for change, says in (
        ({"position": hole}, "position holds no number in frame 100"), ({"time": late}, "time does not run on after frame 49"),
        ({"position": whole.position[:, :1], "activation": whole.activation[:, :1]}, "the body has 1 cell: "),
    ):
        with pytest.raises(GaitError, match=says):
            dataclasses.replace(whole, **change)
    with pytest.raises(GaitError, match="the motion has 20 frames"):
        analyse(dataclasses.replace(whole, time=whole.time[:20], position=whole.position[:20], activation=whole.activation[:20]))
    with pytest.raises(GaitError, match="nothing moved"):
        track_of_performance(perform(random_genome(np.random.default_rng(0), 1)))
    with pytest.raises(ParameterError, match=r"rules.antiphase is 4"):
        Rules(antiphase=4.0)


def test_uneven_frames_are_no_trouble():
    whole, rng = made(gaits.undulating), np.random.default_rng(3)
    kept = np.sort(rng.choice(len(whole.time), 500, replace=False))
    uneven = dataclasses.replace(whole, time=whole.time[kept], position=whole.position[kept], activation=whole.activation[kept])
    gait = analyse(uneven).gait
    assert gait.name == "undulation" and gait.frequency == pytest.approx(gaits.FREQUENCY, rel=1e-2)


@pytest.mark.parametrize("make", [gaits.undulating, gaits.peristaltic], ids=lambda make: make.__name__)
def test_a_gait_far_from_the_origin_is_the_gait_there(make):
    here, there = (analyse(moved(made(make), shift=shift)) for shift in ((0.0, 0.0), (-9e5, 9e5)))
    assert here.gait.name == there.gait.name
    for field in dataclasses.fields(here.gait):
        a, b = getattr(here.gait, field.name), getattr(there.gait, field.name)
        if isinstance(a, float) and np.isfinite(a):
            assert b == pytest.approx(a, rel=1e-3, abs=1e-5), field.name


def test_work_done_far_from_the_origin_is_the_work_there():
    at = np.array([(0, 0), (1, 0), (0.5, 0.9), (1.5, 0.9)])
    drive = {"activation": {"amplitude": 0.3, "frequency": 1.0, "phase": [0, 1, 2, 3]}}
    ledgers = []
    for shift in (0.0, 5e5):
        own = make_own_body({"position": (at + shift).tolist(), **drive})
        ledgers.append(dataclasses.astuple(work_of(track_of_motion(own, simulate_body(own, "swim", 1.0)))))
    assert ledgers[1] == pytest.approx(ledgers[0], rel=1e-4, abs=1e-4)
