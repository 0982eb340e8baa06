"""Forces, integration and stability of the frozen body, each against its law (docs/reference/model.md)."""

import numpy as np
import pytest
from bodies import LAW, POLYGON_EDGES, POLYGONS, SQUARE, accelerations_of, body_of, random_body, state_of
from evodevo_sim.physics.bounds import frequency_bound
from evodevo_sim.physics.control_step import advance, relax
from evodevo_sim.physics.forces import Law, Ramp, accelerations, make_scratch
from evodevo_sim.physics.ladder import MOST_DOUBLINGS
from evodevo_sim.physics.soundness import INVERTED, SOUND, UNSTABLE
from evodevo_sim.physics.step_size import ACCURATE_REST, choose_substeps
from hypothesis import given, settings
from hypothesis import strategies as st

SEEDS = st.integers(0, 2**32)


def chambers_of(body):
    """(corners, area at rest) of every chamber."""
    polygons = [
        (body.polygon_cell[a:b].tolist(), s) for a, b, s in zip(body.polygon_start[:-1], body.polygon_start[1:], body.polygon_area)
    ]
    return [(t.tolist(), s) for t, s in zip(body.triangle, body.triangle_area)] + polygons


def area_of(corners):
    x, y = corners.T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


def forces_by_the_law(body, law, position, velocity, rest):
    """Section 4 of the model, edge by edge; everything here is (N, 2)."""
    p, v, force = position.T, velocity.T, np.zeros(body.position.shape)
    for i, j, length in zip(body.spring_a, body.spring_b, rest):
        d = p[j] - p[i]
        now = np.linalg.norm(d)
        u = d / now
        f = (law.stiffness * (now - length) + law.damping * (v[j] - v[i]) @ u) * u
        force[i] += f
        force[j] -= f
    for corners, area in chambers_of(body):
        excess = 1 - area_of(p[corners]) / area
        for i, j in zip(corners, np.roll(corners, -1)):
            d = p[j] - p[i]
            now = np.linalg.norm(d)
            outward = np.array([d[1], -d[0]]) / now  # to the right of a counter-clockwise walk
            force[[i, j]] += 0.5 * law.pressure * now * excess * outward
    for i, j in body.outline:
        d = p[j] - p[i]
        now = np.linalg.norm(d)
        along, across = d / now, np.array([-d[1], d[0]]) / now
        mean = 0.5 * (v[i] + v[j])
        t, n = mean @ along, mean @ across
        force[[i, j]] += 0.5 * now * (-law.drag_tangential * t * abs(t) * along - law.drag_normal * n * abs(n) * across)
    return force.T


def assert_same_forces(body, law, state):
    expected = forces_by_the_law(body, law, *state)
    found = accelerations_of(body, law, *state) / body.inverse_mass
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-10 * np.abs(expected).max())


@settings(max_examples=60, deadline=None)
@given(
    SEEDS, st.integers(2, 40),
    st.sampled_from([LAW, LAW._replace(damping=0.0), LAW._replace(pressure=0.0), Law(1.0, 2.0, 3.0, 0.0, 4.0, 0.2)]),
)
def test_forces_are_the_law(seed, cells, law):
    rng = np.random.default_rng(seed)
    body = random_body(rng, cells, mass=0.7)
    assert_same_forces(body, law, state_of(body, rng, 0.1, 2.0))


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_forces_of_polygon_chambers_and_tails_are_the_law(seed):
    body = body_of(POLYGONS, POLYGON_EDGES)
    assert len(body.polygon_area) == 2
    assert_same_forces(body, LAW, state_of(body, np.random.default_rng(seed), 0.1, 2.0))


@settings(max_examples=20, deadline=None)
@given(SEEDS, st.booleans())
def test_chambers_push_down_the_gradient_of_their_energy(seed, polygons):
    rng = np.random.default_rng(seed)
    body = body_of(POLYGONS, POLYGON_EDGES) if polygons else random_body(rng, 12)
    position, velocity, rest = state_of(body, rng, 0.1)
    law = Law(0.0, 0.0, 300.0, 0.0, 0.0, 0.2)

    def energy(p):
        return sum(law.pressure * (s - area_of(p.T[c])) ** 2 / (2 * s) for c, s in chambers_of(body))

    gradient, h = np.empty(position.shape), 1e-6
    for k in np.ndindex(position.shape):
        ahead, behind = position.copy(), position.copy()
        ahead[k] += h
        behind[k] -= h
        gradient[k] = (energy(ahead) - energy(behind)) / (2 * h)
    assert accelerations_of(body, law, position, velocity, rest) == pytest.approx(-gradient, abs=1e-5 * max(1, np.abs(gradient).max()))


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(2, 40))
def test_internal_forces_keep_momentum_and_angular_momentum(seed, cells):
    rng = np.random.default_rng(seed)
    body = random_body(rng, cells, mass=1.3)
    position, velocity, rest = state_of(body, rng, 0.1, 2.0)
    f = accelerations_of(body, LAW._replace(drag_normal=0.0, drag_tangential=0.0), position, velocity, rest) / body.inverse_mass
    scale = np.abs(f).sum() * (1 + np.abs(position).max())
    assert np.abs(f.sum(axis=1)).max() < 1e-13 * scale
    assert abs(np.sum(position[0] * f[1] - position[1] * f[0])) < 1e-13 * scale


def test_a_term_without_coefficient_is_not_computed():
    rng = np.random.default_rng(1)
    body = random_body(rng, 20)
    position, velocity, rest = state_of(body, rng, 0.1, 2.0)
    no_area = body._replace(triangle_area=np.zeros(len(body.triangle_area)))  # would make every chamber's force infinite
    bare = Law(400.0, 10.0, 0.0, 0.0, 0.0, 0.2)
    assert np.isfinite(accelerations_of(no_area, bare, position, velocity, rest)).all()
    no_drag = accelerations_of(body, LAW._replace(drag_normal=0.0, drag_tangential=0.0), position, velocity, rest)
    no_outline = body._replace(outline_spring=np.empty(0, np.uint32))
    assert np.array_equal(no_drag, accelerations_of(no_outline, LAW, position, velocity, rest))


def test_scratch_carries_nothing_from_one_law_to_the_next():
    rng = np.random.default_rng(2)
    body = random_body(rng, 20)
    position, velocity, rest = state_of(body, rng, 0.1, 2.0)
    scratch, out = make_scratch(body), np.empty(position.shape)
    for law in (LAW, LAW._replace(pressure=0.0), LAW):
        accelerations(body, law, rest, position, velocity, scratch, out)
        assert np.array_equal(out, accelerations_of(body, law, position, velocity, rest))


def run(body, law, state, seconds, steps, substeps=1):
    """Advance copies of a state; every control step must be sound."""
    position, velocity, rest = (a.copy() for a in state)
    scratch = make_scratch(body)
    for _ in range(steps):
        assert advance(body, law, Ramp(rest, rest, 0.0), position, velocity, seconds / steps, substeps, scratch) == SOUND
    return position, velocity


DUMBBELL = [(-0.5, 0.0), (0.5, 0.0)]


@pytest.mark.parametrize("damping, order", [(0.0, 6), (3.0, 5)])  # without damping the phase leads the error, of even order
def test_two_masses_on_a_spring_swing_as_in_closed_form(damping, order):
    body, law, mass = body_of(DUMBBELL, mass=2.0), Law(50.0, damping, 0.0, 0.0, 0.0, 0.2), 2.0
    position, velocity, rest = state_of(body)
    position[0] *= 1.1  # 0.1 too long
    decay, omega = damping / mass, np.sqrt(2 * law.stiffness / mass - (damping / mass) ** 2)
    seconds = 2.0
    exact = 0.1 * np.exp(-decay * seconds) * (np.cos(omega * seconds) + decay / omega * np.sin(omega * seconds))
    errors = []
    for steps in (50, 100, 200):
        p, _ = run(body, law, (position, velocity, rest), seconds, steps)
        errors.append(abs(p[0, 1] - p[0, 0] - 1.0 - exact))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-9 and orders == pytest.approx([order, order], abs=0.2)


def test_a_whole_body_is_integrated_to_fifth_order():
    rng = np.random.default_rng(3)
    body = random_body(rng, 16)
    state = state_of(body, rng, 0.03, 0.5)
    law = LAW._replace(drag_normal=0.0, drag_tangential=0.0)  # v |v| is not smooth at 0
    exact, _ = run(body, law, state, 0.2, 20, 64)
    errors = [np.abs(run(body, law, state, 0.2, 20, n)[0] - exact).max() for n in (2, 4, 8)]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([5.0, 5.0], abs=0.2)


@pytest.mark.parametrize("direction, name", [((1.0, 0.0), "drag_tangential"), ((0.0, 1.0), "drag_normal")])
def test_an_edge_glides_to_a_stop_as_in_closed_form(direction, name):
    body = body_of(DUMBBELL, mass=2.0)
    position, velocity, rest = state_of(body)
    velocity += 0.8 * np.array(direction)[:, None]
    seconds = 3.0
    _, after = run(body, LAW, (position, velocity, rest), seconds, 600)
    expected = 0.8 / (1 + 0.8 * seconds * getattr(LAW, name) * 1.0 / 4.0)  # v' = -d L v^2 / (total mass)
    assert after == pytest.approx(np.outer(direction, [expected, expected]), rel=1e-6, abs=1e-12)


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.floats(-3.1, 3.1))
def test_the_physics_is_the_same_in_every_frame(seed, angle):
    rng = np.random.default_rng(seed)
    body = random_body(rng, 20)
    position, velocity, rest = state_of(body, rng, 0.03, 0.5)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shift = np.array([[3.0], [-2.0]])
    p, v = run(body, LAW, (position, velocity, rest), 0.2, 12, 2)
    q, w = run(body, LAW, (turn @ position + shift, turn @ velocity, rest), 0.2, 12, 2)
    assert q == pytest.approx(turn @ p + shift, abs=1e-9)
    assert w == pytest.approx(turn @ v, abs=1e-9)


def highest_frequency(body, law):
    """From the eigenvalues of the differentiated forces of a body at rest."""
    conservative = Law(law.stiffness, 0.0, law.pressure, 0.0, 0.0, 0.2)
    position, velocity, rest = state_of(body)
    size, h = position.size, 1e-6
    jacobian = np.empty((size, size))
    for k in range(size):
        step = np.zeros(size)
        step[k] = h
        ahead, behind = (accelerations_of(body, conservative, position + s * step.reshape(2, -1), velocity, rest) for s in (1, -1))
        jacobian[:, k] = (ahead - behind).ravel() / (2 * h)
    return np.sqrt(-np.linalg.eigvals(jacobian).real.min())


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(2, 32), st.sampled_from([0.0, 100.0, 400.0]))
def test_the_frequency_bound_is_an_upper_and_a_close_one(seed, cells, pressure):
    body = random_body(np.random.default_rng(seed), cells, mass=1.7)
    law = LAW._replace(pressure=pressure)
    true, bound = highest_frequency(body, law), frequency_bound(body, law)
    assert true * (1 - 1e-6) <= bound <= 1.6 * true
    substeps = choose_substeps(body, law, 1 / 60)
    assert bound / 60 / substeps <= ACCURATE_REST < 3.18  # Lawson's method is stable up to there, where anything damps


def outcome_of(body, state, law=LAW, control_step=1 / 60, substeps=1):
    position, velocity, rest = (a.copy() for a in state)
    ramp = Ramp(rest, rest, 0.0)
    return advance(body, law, ramp, position, velocity, control_step, substeps, make_scratch(body)), position, velocity


@pytest.mark.parametrize("value", [1e6, 1e160, np.inf, np.nan])
@pytest.mark.parametrize("where", ["position", "velocity"])
def test_an_absurd_state_ends_with_a_name(value, where):
    body = random_body(np.random.default_rng(5), 12)
    position, velocity, rest = state_of(body)
    (velocity if where == "velocity" else position)[0, 3] = value
    outcome, *_ = outcome_of(body, (position, velocity, rest))
    assert outcome in (UNSTABLE, INVERTED)
    if where == "velocity" or not np.isfinite(value):
        assert outcome == UNSTABLE


def test_an_inverted_chamber_is_named():
    bare = Law(1e-6, 0.0, 0.0, 0.0, 0.0, 0.2)  # nothing pushes back
    for points, edges, mirrored in (([(0, 0), (1, 0), (0.5, 0.9)], None, 2), (SQUARE, [(0, 1), (0, 3), (1, 2), (2, 3)], None)):
        body = body_of(points, edges)
        position, velocity, rest = state_of(body)
        if mirrored is None:
            position[1] *= -1
        else:
            position[1, mirrored] *= -1
        assert outcome_of(body, (position, velocity, rest), bare)[0] == INVERTED


def test_a_collapsed_spring_is_named():
    body = body_of(DUMBBELL)
    position, velocity, rest = state_of(body)
    position *= 0.01
    assert outcome_of(body, (position, velocity, rest), Law(1e-6, 0.0, 0.0, 0.0, 0.0, 0.2))[0] == INVERTED


@given(SEEDS, st.floats(0.0, 0.49))
def test_muscles_change_rest_lengths_by_their_range(seed, muscle_range):
    from evodevo_sim.physics.forces import set_rest_lengths

    body = body_of(DUMBBELL)
    activation, rest = np.random.default_rng(seed).uniform(-1.0, 1.0, len(body.position)), np.empty_like(body.rest_length)
    set_rest_lengths(body, LAW._replace(muscle_range=muscle_range), activation, rest)
    both = activation[body.spring_a] + activation[body.spring_b]
    assert np.array_equal(rest, (1.0 + muscle_range * both) * body.rest_length) and (rest > 0.0).all()


def test_the_law_of_a_task_has_the_muscle_range_of_the_paper_and_that_which_is_set():
    from evodevo_sim.parameters import Material, Scene
    from evodevo_sim.physics.forces import make_law

    assert make_law(Material().arguments(), Scene().arguments()).muscle_range == 0.2
    assert make_law(Material(muscle_range=0.1).arguments(), Scene().arguments()).muscle_range == 0.1


def test_finer_substeps_are_taken_where_only_they_are_sound():
    body = random_body(np.random.default_rng(6), 12)
    stiff = LAW._replace(stiffness=LAW.stiffness * 120, pressure=LAW.pressure * 120)
    assert 1 < choose_substeps(body, stiff, 1 / 60) / 2 <= 8  # one is far from stable; eight are, at half the accurate step's rate
    position, velocity, _ = state_of(body, np.random.default_rng(7), 0.01, 0.1)
    state = position, velocity, body.rest_length
    outcome, p, v = outcome_of(body, state, stiff, substeps=1)
    assert outcome == SOUND
    finer = [outcome_of(body, state, stiff, substeps=1 << k) for k in range(1, MOST_DOUBLINGS + 1)]
    assert any(np.array_equal(p, q) and np.array_equal(v, w) for _, q, w in finer)
    hopeless = stiff._replace(stiffness=stiff.stiffness * 1e6)
    assert outcome_of(body, state, hopeless)[0] != SOUND


def test_a_sound_step_is_not_refined():
    rng = np.random.default_rng(8)
    body = random_body(rng, 12)
    state = state_of(body, rng, 0.01, 0.1)
    thin = LAW._replace(drag_normal=1.0, drag_tangential=0.1)
    _, p, _ = outcome_of(body, state, thin)
    q, _ = run(body, thin, state, 1 / 60, 1)
    assert np.array_equal(p, q)
    assert not np.array_equal(p, outcome_of(body, state, thin, substeps=2)[1])


def test_a_step_in_which_drag_might_overshoot_is_refined():
    body = body_of(DUMBBELL)
    position, velocity, rest = state_of(body)
    kicked = LAW._replace(drag_normal=4000.0, stiffness=0.0, damping=0.0)
    velocity[1] = 0.5  # m/s across: 4,000 x 0.5 / 60 is 33, which one step would turn round and blow up
    outcome, _, v = outcome_of(body, (position, velocity, rest), kicked, substeps=8)
    assert outcome == SOUND and np.all((0 < v[1]) & (v[1] < 0.5))


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(2, 40))
def test_settling_ends_at_rest_where_the_centre_of_mass_was(seed, cells):
    rng = np.random.default_rng(seed)
    body = random_body(rng, cells)
    position, velocity, _ = state_of(body)
    rest = body.rest_length * rng.uniform(0.8, 1.2, body.rest_length.size)
    before = position.mean(axis=1)
    steps = relax(body, LAW, rest, position, velocity, 1e-3, 2000, make_scratch(body))
    assert position.mean(axis=1) == pytest.approx(before, abs=1e-10)
    assert not velocity.any()
    left = np.abs(accelerations_of(body, LAW, position, velocity, rest)).max()
    assert left <= 1e-3 if steps < 2000 else np.isfinite(left)


@pytest.mark.parametrize("drag", [1e3, 4e4, 1e6])
def test_a_body_at_rest_that_is_driven_against_drag_ends_where_fine_steps_take_it(drag):
    body = random_body(np.random.default_rng(3), 12)
    position, velocity, rest = state_of(body)
    state = position, velocity, rest * np.random.default_rng(4).uniform(0.9, 1.1, rest.shape)
    thick = LAW._replace(drag_normal=drag, drag_tangential=drag / 200)
    assert choose_substeps(body, thick, 1 / 60) == 1  # at rest there is no drag to choose steps by
    outcome, p, _ = outcome_of(body, state, thick, substeps=1)
    fine, q, _ = outcome_of(body, state, thick, substeps=2000)
    assert outcome == fine == SOUND
    assert np.abs(p - q).max() < 0.02 * np.abs(q - position).max()
