"""Steps that move four cells at a time have the bits of `euler`, which moves any cell anywhere."""

import numpy as np
import pytest
from bodies import NO_LEDGER, body_of, random_body, slab, wave
from evodevo_sim.kernels.jit import lean
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.grounded_steps import alike_in, are_alike, go_alike, go_soundly_alike
from evodevo_sim.physics.integrators import State, carry, euler, make_system, make_work
from evodevo_sim.physics.soundness import SOUND, judge
from evodevo_sim.physics.step_size import EULER
from evodevo_sim.physics.terrain import make_terrain
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Scene

H, G = 1 / 240, 9.81
LAWS = {
    "walker": Law(400.0, 10.0, 400.0, 0.0, 0.0, 0.2), "springs": Law(400.0, 10.0, 0.0, 0.0, 0.0, 0.2),
    "in a fluid": Law(400.0, 10.0, 400.0, 100.0, 0.5, 0.2),
}
LOOSE = Law(0.0, 0.0, 0.0, 0.0, 0.0, 0.2)  # nothing holds the cells together


@lean
def _go(system, h, steps, position, velocity, scratch, soundly):
    if soundly:
        return go_soundly_alike(alike_in(system, scratch), h, steps, position, velocity)
    go_alike(alike_in(system, scratch), h, steps, position, velocity)
    return True


@lean
def _asked(system, ledger):
    return are_alike(system, ledger)


def by_euler(system, steps, position, velocity, h=H):
    """(position, velocity, which cells are on the ground after each step)."""
    p, v, work, down = position.copy(), velocity.copy(), make_work(system.body), []
    for _ in range(steps):
        euler(system, 0.0, h, p, v, work, NO_LEDGER)
        down.append(p[1] == 0.0)
    return p, v, np.array(down)


def in_fours(system, steps, position, velocity, h=H, soundly=False):
    """(position, velocity, what comes back)."""
    p, v = position.copy(), velocity.copy()
    result = _go(system, h, steps, p, v, make_work(system.body).scratch, soundly)
    return p, v, result


def bits(array):
    """Zeros keep their signs; a NaN is like any other."""
    return np.where(np.isnan(array), np.nan, array).tobytes()


def same(one, other):
    return all(bits(a) == bits(b) for a, b in zip(one[:2], other[:2], strict=True))


def standing(body, height=0.0):
    """Position (2, N) with the lowest cell so high."""
    position = body.position.T.copy()
    position[1] += height - position[1].min()
    return position


@given(
    st.integers(0, 2**32 - 1), st.integers(2, 23), st.sampled_from(list(LAWS)), st.sampled_from([0.0, 0.8]), st.sampled_from([0.0, G]),
    st.booleans(), st.sampled_from([0.0, 1e-3, 100.0]), st.sampled_from([(0.0, 0.0), (3.0, 0.0), (-1.0, -4.0), (0.0, 2.0)]),
)
@settings(deadline=None, max_examples=200)
def test_random_bodies_move_to_the_same_bits(seed, cells, law, friction, gravity, ground, height, start):
    rng = np.random.default_rng(seed)
    body = random_body(rng, cells)
    system = make_system(body, LAWS[law], gravity, friction, ground)
    position = standing(body, height)
    velocity = np.array(start)[:, None] + 0.3 * rng.standard_normal(position.shape)
    for steps in (1, 30):
        assert same(in_fours(system, steps, position, velocity), by_euler(system, steps, position, velocity))


@pytest.mark.parametrize("friction", [0.0, 0.8])
@pytest.mark.parametrize("columns", [4, 5, 6, 7])
@pytest.mark.parametrize(
    "way, start, height", [("stays", (0, 0), 0.0), ("slides", (4, 0), 0.0), ("bounces", (0, -6), 0.5), ("flies", (1, 1), 50.0)]
)
def test_a_slab_does_what_it_is_to_do_and_to_the_same_bits(way, start, height, columns, friction):
    body = slab(columns, 3)
    system, steps = make_system(body, LAWS["walker"], G, friction, True), 120
    position = standing(body, height)
    velocity = np.repeat(np.array(start, float)[:, None], position.shape[1], axis=1)
    p, v, down = by_euler(system, steps, position, velocity)
    assert same(in_fours(system, steps, position, velocity), (p, v))
    if way == "flies":
        assert not down.any()
    elif way == "bounces":
        assert not down[0].any() and (down[:-1] & ~down[1:]).any()
    else:
        assert down.any(axis=0).sum() > 2 and not down.all(axis=1).any()
        if way == "slides":
            assert (v[0].mean() > 1.0) == (friction == 0.0)


@pytest.mark.parametrize("friction", [0.0, 0.8])
@pytest.mark.parametrize("cells", [2, 4, 7, 8])
@pytest.mark.parametrize("speed", [0.0, 0.01, -3.0])
def test_all_cells_on_the_ground_stick_and_slide_to_the_same_bits(cells, speed, friction):
    body = body_of([(k, 0.0) for k in range(cells)])
    system, position = make_system(body, LAWS["walker"], G, friction, True), body.position.T.copy()
    velocity = np.zeros_like(position)
    velocity[0] = speed
    p, v, down = by_euler(system, 40, position, velocity)
    assert down.all() and (v[0] == 0.0).all() == (speed == 0.0 or (friction > 0.0 and speed == 0.01))
    assert same(in_fours(system, 40, position, velocity), (p, v))


NUMBERS = [0.0, -0.0, 1e-320, -1e-320, 1e-9, -1e-9, 0.7, -0.7, -3.0, 1e200, -1e200, np.inf, -np.inf, np.nan]


@given(
    st.lists(st.tuples(*[st.sampled_from(NUMBERS)] * 2), min_size=6, max_size=6),
    st.lists(st.sampled_from([0.0, 1e-320, 1e-9, 0.02]), min_size=6, max_size=6),
    st.sampled_from([0.0, 0.8]), st.sampled_from([0.0, G]),
)
@settings(deadline=None, max_examples=300)
def test_loose_cells_meet_the_ground_by_any_number_alike(speeds, heights, friction, gravity):
    body = body_of([(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)])
    system = make_system(body, LOOSE, gravity, friction, True)
    position = np.array([body.position[:, 0], heights])
    velocity = np.array(speeds).T.copy()
    assert same(in_fours(system, 1, position, velocity), by_euler(system, 1, position, velocity))


def test_what_is_not_sound_has_not_moved():
    body = slab(5, 3)
    system, position = make_system(body, LAWS["walker"], G, 0.8, True), standing(body)
    velocity = np.zeros_like(position)
    p, v, sound = in_fours(system, 4, position, velocity, soundly=True)
    assert sound and same((p, v), by_euler(system, 4, position, velocity))
    assert judge(body, p, v, H, make_work(body).scratch) == SOUND
    velocity[0, 3] = 1e4
    p, v, sound = in_fours(system, 4, position, velocity, soundly=True)
    assert not sound and same((p, v), (position, velocity))
    assert judge(body, *by_euler(system, 4, position, velocity)[:2], H, make_work(body).scratch) != SOUND


@pytest.mark.parametrize("watched", [False, True])
@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("ground", [False, True])
def test_a_body_of_ones_own_is_carried_to_the_bits_that_it_has_with_a_ledger(ground, driven, watched):
    body = slab(6, 3)
    system = make_system(body, LAWS["walker"], G, 0.8, ground, wave(body) if driven else None)
    ends = []
    for ledger in (NO_LEDGER, np.zeros(4)):
        state = State(standing(body, 0.05), np.zeros((2, 18)), ledger)
        for k in range(5):
            assert carry(system, EULER, 0.1 * k, 0.1, 40, state, make_work(body), watched) == SOUND
        ends.append(state)
    assert same(*ends)


def test_bumps_and_ledgers_are_none_of_its_business():
    body = slab(4, 3)
    bumps = make_terrain(Scene(ground_x=(-1.0, 0.0, 1.0), ground_y=(0.0, 0.2, 0.0)))
    asked = [make_system(body, LAWS["walker"], G, 0.8, ground, terrain=bumps) for ground in (True, False)]
    assert [_asked(system, NO_LEDGER) for system in asked] == [False, True]
    flat = make_system(body, LAWS["walker"], G, 0.8, True)
    assert _asked(flat, NO_LEDGER) and not _asked(flat, np.zeros(4))
