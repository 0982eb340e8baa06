"""Contact with the ground: closed forms of sliding, sticking and bouncing, on cells and on edges; nothing sinks, nothing gains energy."""

import numpy as np
import pytest
from bodies import NO_LEDGER, STEP, body_of, random_body, slab, wave
from evodevo_sim.physics.bounds import bounds
from evodevo_sim.physics.contact import meet_tips
from evodevo_sim.physics.energy import stored_energy
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.integrators import euler, make_system, make_work
from evodevo_sim.physics.step_size import longest_step
from evodevo_sim.physics.terrain import FLAT, clearance, contacts, make_terrain, touching
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Scene

H = STEP / 4  # the default step of walking
LAW = Law(400.0, 10.0, 400.0, 0.0, 0.0, 0.2)
STIFF = Law(20_000.0, 100.0, 20_000.0, 0.0, 0.0, 0.2)  # nearly the rigid block of the closed form
G = 9.81
RADIUS = 0.5  # m, of a cell


def incline(angle):
    far = 1000.0
    return make_terrain(Scene(ground_x=(-far, far), ground_y=(-far * np.tan(angle), far * np.tan(angle))))


def march(system, steps, position, velocity, h=H, ledger=NO_LEDGER, look=lambda p, v: None):
    p, v, work = position.copy(), velocity.copy(), make_work(system.body)
    for _ in range(steps):
        euler(system, 0.0, h, p, v, work, ledger)
        look(p, v)
    return p, v


def block(angle, friction, body=None, law=LAW):
    """A block of 4 x 2 braced cells lying on an incline: (system, position, along, normal)."""
    body = body or body_of([(x + 0.5 * y, 0.87 * y) for y in range(2) for x in range(4)])
    along, normal = np.array((np.cos(angle), np.sin(angle))), np.array((-np.sin(angle), np.cos(angle)))
    position = along[:, None] * body.position[:, 0] + normal[:, None] * body.position[:, 1]
    return make_system(body, law, G, friction, True, terrain=incline(angle) if angle else FLAT), position, along, normal


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.3], ids=["level", "uphill", "downhill"])
def test_a_block_at_rest_stays(angle):
    system, position, *_ = block(angle, 0.5)
    p, v = march(system, 6000, position, np.zeros_like(position))  # its springs settle
    q, w = march(system, 8000, p, v)
    assert np.abs(q - p).max() < 1e-6 and np.abs(w).max() < 1e-6


@pytest.mark.parametrize("angle, friction", [(0.5, 0.2), (0.5, 0.0), (-0.3, 0.1)])
def test_a_block_slides_at_g_sin_minus_mu_cos(angle, friction):
    system, position, along, _ = block(angle, friction)
    p, v = march(system, 240, position, np.zeros_like(position))
    _q, w = march(system, 960, p, v)
    downhill = -along * np.sign(angle)
    gained = downhill @ (w - v).mean(axis=1) / (960 * H)
    assert gained == pytest.approx(G * (np.sin(abs(angle)) - friction * np.cos(angle)), rel=0.01)


@pytest.mark.parametrize("speed, friction", [(2.0, 0.3), (4.0, 0.8), (-1.0, 0.5)])
def test_a_sliding_block_stops_after_v_squared_over_two_mu_g(speed, friction):
    system, position, *_ = block(0.0, friction, law=STIFF)
    p, v = march(system, 4000, position, np.zeros_like(position), H / 8)
    v[0] += speed
    q, w = march(system, 4000, p, v, H / 8)
    assert abs((q - p)[0].mean()) == pytest.approx(speed**2 / (2 * friction * G), rel=0.01)
    assert np.abs(w).max() < 1e-3 and np.sign((q - p)[0].mean()) == np.sign(speed)


def test_a_cell_on_a_slope_sticks_below_the_friction_angle_and_not_above():
    for excess, moves in ((0.99, False), (1.01, True)):
        angle = np.arctan(0.6 * excess)
        pair = body_of([(0, 0), (1, 0)])
        system, position, along, _ = block(angle, 0.6, pair)
        p, _ = march(system, 2000, position, np.zeros_like(position))
        q, _ = march(system, 2000, p, np.zeros_like(position))
        assert (abs(along @ (q - p).mean(axis=1)) > 1e-3) == moves


@pytest.mark.parametrize("angle", [0.0, 0.35])
def test_a_bounce_never_gains_energy_and_no_cell_sinks(angle):
    body = slab(4, 3)
    system = make_system(body, LAW._replace(damping=0.0), G, 0.4, True, terrain=incline(angle) if angle else FLAT)
    position = body.position.T + [[0.0], [6.0]]
    energies, depth = [], []

    def look(p, v):
        energies.append(sum(stored_energy(body, system.law, system.rest, G, p, v)))
        depth.append((p[1] - np.tan(angle) * p[0]).min())

    march(system, 2400, position, np.zeros_like(position), look=look)
    start = sum(stored_energy(body, system.law, system.rest, G, position, np.zeros_like(position)))
    assert min(depth) > -1e-12 and min(depth) < 1e-9  # it lands, and stays out
    # Symplectic Euler's energy swings by order h about the true one while the undamped body rings.
    assert max(energies) < start * 1.005 and np.mean(energies[-600:]) < np.mean(energies[600:1200])


def test_the_ground_carries_just_the_weight_and_friction_just_stops_the_push():
    """Balance of impulse over two seconds: m dv = (normal - weight, friction) dt."""
    system, position, *_ = block(0.0, 0.3)
    p, v = march(system, 4000, position, np.zeros_like(position))
    v[0] += 3.0
    impulse, work, a = np.zeros(2), make_work(system.body), np.empty_like(p)
    begin = v.sum(axis=1)
    for _ in range(480):
        before = v.copy()
        euler(system, 0.0, H, p, v, work, NO_LEDGER)
        a[:] = work.slope_v[0]
        impulse += (v - before - H * a).sum(axis=1)  # what is not force is contact
    weight = 8 * G * 480 * H
    assert v.sum(axis=1) - begin == pytest.approx(impulse - [0, weight], abs=1e-9)
    assert impulse[1] == pytest.approx(weight, rel=1e-3)
    assert impulse[0] == pytest.approx(-3.0 * 8, rel=1e-3)  # it has stopped, and rings a little


ROUGH = make_terrain(Scene(
    ground_x=tuple(np.arange(-20.0, 21.0, 0.7)), ground_y=tuple(np.random.default_rng(3).uniform(0, 1.5, 59)),
    ceiling_x=(-30.0, -8.0, -7.9, 7.9, 8.0, 30.0), ceiling_y=(4.0, 4.0, 60.0, 60.0, 3.0, 3.0),
))


def stress(seed, terrain, friction, steps=400):
    """A random body that is dropped, kicked and driven at random: (finite, least height above ground, worst unexplained energy)."""
    rng = np.random.default_rng(seed)
    body = random_body(rng, int(rng.integers(2, 20)))
    drive = tuple(f * np.ones(len(body.position)) for f in (rng.uniform(0, 0.5), rng.uniform(0.2, 3.0))) + (
        rng.uniform(0, 6, len(body.position)),
    )
    system = make_system(body, LAW, rng.uniform(0, 10), friction, True, drive, terrain)
    frequency, damping = bounds(system)
    h = min(H, STEP / 1.6 / frequency, 0.8 * longest_step(0, frequency, damping))
    position = body.position.T + [[0.0], [-body.position[:, 1].min() + 1.6 + rng.uniform(0, 2)]]
    velocity = rng.normal(0, 3, position.shape)
    p, v, work, ledger = position.copy(), velocity.copy(), make_work(body), np.zeros(4)
    depth = np.inf
    for k in range(steps):
        euler(system, k * h, h, p, v, work, ledger)
        depth = min(depth, *clearance(terrain, body.outline, p[0], p[1]))
    return p, v, depth, ledger


def spikes(*tips, width=0.2):
    """Level ground at 0 with spikes (x, height)."""
    points = [(x + side * width / 2, y * (side == 0)) for x, y in tips for side in (-1, 0, 1)]
    return make_terrain(Scene(ground_x=tuple(x for x, _ in points), ground_y=tuple(y for _, y in points)))


SPIKES = spikes(*((x + 0.05 * x * x, 1.0 + x % 2) for x in range(-6, 7)))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.5, 2.0]), st.sampled_from([FLAT, ROUGH, SPIKES]))
def test_random_bodies_dropped_kicked_and_driven_stay_finite_and_above_ground(seed, friction, terrain):
    p, v, depth, ledger = stress(seed, terrain, friction)
    assert np.isfinite(p).all() and np.isfinite(v).all()
    assert depth > -1e-9 and depth > -0.01 * RADIUS
    assert ledger[3] <= 1e-3 * abs(ledger[1:3]).sum() + 1e-9  # the ground gives no energy, but for order h


def test_contacts_are_told_from_positions():
    scene = Scene(ground_x=(0.0, 2.0), ground_y=(0.0, 1.0), ceiling_x=(0.0, 2.0), ceiling_y=(5.0, 5.0))
    points = np.array([(1.0, 0.5), (1.0, 0.6), (1.0, 5.0), (-3.0, 0.0), (9.0, 1.0)])
    assert touching(scene, points).tolist() == [True, False, True, True, True]
    assert touching(Scene(), points).tolist() == [False, False, False, True, False]


def test_contacts_of_edges_are_told_from_positions():
    """A bar on a spike of the ground, then under one of the ceiling, then between them; a third cell touches nothing."""
    spiky = Scene(ground_x=(-0.5, 0.0, 0.5), ground_y=(0.0, 1.0, 0.0), ceiling_x=(-0.5, 0.2, 0.5), ceiling_y=(9.0, 6.0, 9.0))
    bar = np.array([(-1.0, 0.5), (1.0, 1.5), (0.0, 3.0)])
    position = np.array([bar, bar + (0.0, 4.9), bar + (0.0, 2.0)])
    outline = np.array([(0, 1), (1, 2), (2, 0)])
    assert contacts(spiky, outline[:1], position).tolist() == [[True, True, False], [True, True, False], [False, False, False]]
    assert not contacts(Scene(), outline, position).any() and not touching(spiky, position).any()


def test_level_ground_as_a_profile_is_level_ground():
    body = slab(4, 3)
    position = body.position.T + [[0.0], [2.0]]
    ends = []
    for terrain in (FLAT, make_terrain(Scene(ground_x=(-50.0, 0.3, 50.0), ground_y=(0.0, 0.0, 0.0)))):
        ends.append(march(make_system(body, LAW, G, 0.5, True, wave(body), terrain), 240, position, np.zeros_like(position))[0])
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.2, 0.0], ids=["middle", "fifth", "cell"])
@pytest.mark.parametrize("friction", [0.0, 0.3, 9.0], ids=["smooth", "slides", "sticks"])
def test_a_tip_pushes_the_two_cells_of_an_edge_by_how_near_it_is_to_each(share, friction):
    body = body_of([(0, 0), (1, 0)], mass=2.0)
    terrain = spikes((share + H, 1.0))  # where the edge would be after the step
    before = np.array([[0.0, 1.0], [1.01, 1.01]])
    speed = np.array([[1.0, 1.0], [-4.0, -4.0]])
    p, v = before + H * speed, speed.copy()
    meet_tips(terrain, friction, H, body, before, p, v)
    impulse = 2.0 * (v - speed)
    assert impulse[:, 1] * (1 - share) == pytest.approx(impulse[:, 0] * share, abs=1e-3)
    normal, along = impulse[1].sum(), impulse[0].sum()
    point = v @ (1 - share, share)
    assert point[1] == pytest.approx(-0.01 / H, rel=5e-3) and normal > 0  # it lands just on the tip
    assert clearance(terrain, body.outline, p[0], p[1])[0] == pytest.approx(0, abs=1e-9)
    if friction < 9:
        assert along == pytest.approx(-friction * normal, rel=1e-3) and point[0] > 0
    else:
        assert point[0] == pytest.approx(0, abs=0.05) and -along < friction * normal
    assert np.square(v).sum() < np.square(speed).sum()


def test_a_long_edge_comes_to_rest_on_tips_under_it():
    body = body_of([(0, 0), (4, 0), (2, 2.5)])
    terrain = spikes((1.0, 1.0), (3.2, 1.0))
    system = make_system(body, STIFF, G, 0.8, True, terrain=terrain)
    p, _ = march(system, 4000, body.position.T + [[0.0], [1.5]], np.zeros((2, 3)), H / 8)
    q, w = march(system, 4000, p, np.zeros_like(p), H / 8)
    assert np.abs(q - p).max() < 1e-6 and np.abs(w).max() < 1e-6
    assert q[1].min() > 0.9 and clearance(terrain, body.outline, q[0], q[1])[0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.77])
def test_a_body_dropped_on_a_spike_does_not_sink_through_it(shift):
    body, terrain = slab(6, 3), spikes((2.5, 3.0))
    system, depth = make_system(body, LAW, G, 0.5, True, terrain=terrain), []
    ledger, position = np.zeros(4), body.position.T + [[shift], [5.0]]
    start = sum(stored_energy(body, system.law, system.rest, G, position, np.zeros_like(position)))
    p, v = march(system, 4800, position, np.zeros_like(position), H / 4, ledger,
                 look=lambda p, v: depth.append(clearance(terrain, body.outline, p[0], p[1])[0]))
    assert -1e-8 < min(depth) < 1e-9
    end = sum(stored_energy(body, system.law, system.rest, G, p, v))
    assert ledger.sum() - 0.01 * start < end - start < ledger.sum() + 1e-3 * start and ledger[3] < 0.0


def test_a_ceiling_has_tips_too():
    ground = make_terrain(Scene(ceiling_x=(-9.0, 0.4, 0.5, 0.6, 9.0), ceiling_y=(6.0, 6.0, 4.0, 6.0, 6.0)))
    body = body_of([(0, 0), (1, 0)])
    system, depth = make_system(body, LAW, 0.0, 0.5, True, terrain=ground), []
    march(system, 400, body.position.T + [[0.0], [3.0]], np.array([[0.0, 0.0], [3.0, 3.0]]),
          look=lambda p, v: depth.append(clearance(ground, body.outline, p[0], p[1])[1]))
    assert -1e-9 < min(depth) < 1e-9
