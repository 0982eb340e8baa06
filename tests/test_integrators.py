"""Integrators: closed forms to each method's order, what must stay the same stays, steps from bounds are stable."""

import numpy as np
import pytest
from bodies import ALONE, LAW, NO_LEDGER, STEP, accelerations_of, body_of, chain, go, rotation, slab, wave
from evodevo_sim.physics.bounds import bounds, drag_rate
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.integrators import State, carry, make_system, make_work, set_muscles
from evodevo_sim.physics.ladder import Ladder
from evodevo_sim.physics.replayed_motion import carry_soundly
from evodevo_sim.physics.soundness import INVERTED, SOUND, UNSTABLE
from evodevo_sim.physics.step_size import ADAPTIVE, EULER, INTEGRATORS, RK4, VERLET, choose_steps, longest_step
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

FIXED = pytest.mark.parametrize("method", [EULER, VERLET, RK4], ids=INTEGRATORS[:3])
EVERY = pytest.mark.parametrize("method, steps", [(EULER, 8), (VERLET, 8), (RK4, 4), (ADAPTIVE, 1e-7)], ids=INTEGRATORS)
ORDER = {EULER: 1, VERLET: 2, RK4: 4}


# --- closed forms -----------------------------------------------------------------------------------------------------


def damped(t, k=40.0, c=1.0, mass=2.0, stretch=0.3):
    """Length of a spring of rest length 1 between two masses, let go at 1 + stretch."""
    a, w = c / mass, np.sqrt(2 * k / mass - (c / mass) ** 2)
    return 1 + stretch * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))


def driven(t, k=40.0, c=1.0, mass=2.0, amplitude=0.5, frequency=0.6, phase=0.4):
    """The same from rest at length 1 with both muscles driven: L = 1 + 0.4 amplitude sin(2 pi frequency t + phase)."""
    # x = l - 1 obeys x'' + 2 a x' + w0^2 x = w0^2 s sin(f t + phase) + 2 a * 0: the damper sees l alone.
    a, w0, f, s = c / mass, np.sqrt(2 * k / mass), 2 * np.pi * frequency, 0.4 * amplitude
    particular = w0**2 * s * np.exp(1j * phase) / (w0**2 - f**2 + 2j * a * f)
    w = np.sqrt(w0**2 - a**2)
    x0, v0 = -particular.imag, -(1j * f * particular).imag
    free = np.exp(-a * t) * (x0 * np.cos(w * t) + (v0 + a * x0) / w * np.sin(w * t))
    return 1 + free + (particular * np.exp(1j * f * t)).imag


def length_after(method, steps, drive, intervals=90):
    law = Law(40.0, 1.0, 0.0, 0.0, 0.0, 0.2)
    drive = (np.full(2, 0.5), np.full(2, 0.6), np.full(2, 0.4)) if drive else None
    system, position, velocity = chain(1.0 if drive else 1.3, np.zeros((2, 2)), law, drive, mass=2.0)
    p, _ = go(system, method, steps, intervals, position, velocity)
    return p[0, 1] - p[0, 0]


@pytest.mark.parametrize("drive", [False, True], ids=["damped", "driven"])
@FIXED
def test_two_masses_on_a_spring_converge_to_the_closed_form_at_the_methods_order(method, drive):
    exact = (driven if drive else damped)(90 * STEP)
    coarse = {EULER: 16, VERLET: 8, RK4: 2}[method]
    errors = [abs(length_after(method, coarse << k, drive) - exact) for k in range(3)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx([ORDER[method]] * 2, abs=0.2)
    assert errors[-1] < {EULER: 2e-3, VERLET: 2e-5, RK4: 1e-7}[method]


@pytest.mark.parametrize("drive", [False, True], ids=["damped", "driven"])
def test_the_adaptive_pair_meets_the_closed_form_to_its_tolerance(drive):
    exact = (driven if drive else damped)(90 * STEP)
    for tolerance in (1e-6, 1e-9):
        assert abs(length_after(ADAPTIVE, tolerance, drive) - exact) < 20 * tolerance


@pytest.mark.parametrize("method, steps", [(EULER, 64), (VERLET, 16), (RK4, 4), (ADAPTIVE, 1e-10)], ids=INTEGRATORS)
def test_speed_across_a_bar_decays_as_drag_says(method, steps):
    # A rigid bar of 2 kg and length 1 that moves across itself: 2 v' = -d v^2, so v = v0 / (1 + d v0 t / 2).
    system, position, _ = chain(1.0, np.zeros((2, 2)), Law(400.0, 0.0, 0.0, 30.0, 0.5, 0.2))
    p, v = go(system, method, steps, 60, position, np.array([[0.0, 0.0], [2, 2]]))
    assert v[1] == pytest.approx(2 / (1 + 30.0), rel={EULER: 0.02, VERLET: 1e-3, RK4: 1e-4, ADAPTIVE: 1e-8}[method])
    assert p[0, 1] - p[0, 0] == pytest.approx(1.0, abs=1e-12)


@EVERY
def test_a_sinking_bar_reaches_its_terminal_speed(method, steps):
    body = body_of([(0, 0), (1, 0)])
    system = make_system(body, Law(400.0, 10.0, 0.0, 50.0, 0.5, 0.2), gravity=9.81)
    _, v = go(system, method, steps, 240)
    assert v[1] == pytest.approx(-np.sqrt(2 * 9.81 / 50.0), rel=1e-6)


@EVERY
def test_free_fall_is_exact(method, steps):
    body = slab(3, 2)
    body = body._replace(position=body.position + [0.0, 30.0])
    start = np.repeat([[1.5], [4.0]], 6, axis=1)
    # Euler's is exact above a ground alone; without one it is textbook Euler, ahead by half a step.
    system = make_system(body, ALONE, gravity=9.81, ground=method == EULER)
    p, v = go(system, method, steps, 120, velocity=start)
    assert p.T == pytest.approx(body.position + [3.0, 8.0 - 0.5 * 9.81 * 4], abs=1e-9)
    assert v.T == pytest.approx(start.T - [0, 2 * 9.81], abs=1e-9)


# --- order and reference on a whole body -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swimmer():
    body = slab()
    return make_system(body, LAW, drive=wave(body))


def by_dop853(system):
    """One second by DOP853 on the same right-hand side."""
    cells = len(system.body.position)

    def slope(t, y):
        position, velocity = y.reshape(2, 2, cells)
        set_muscles(system, t)
        out = accelerations_of(system.body, system.law, position, velocity, system.rest)
        return np.concatenate((velocity.ravel(), out.ravel()))

    start = np.concatenate((system.body.position.T.ravel(), np.zeros(2 * cells)))
    y = solve_ivp(slope, (0, 1), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return y[: 2 * cells].reshape(2, cells)


@FIXED
def test_order_on_a_body_is_that_of_theory(swimmer, method):
    # Without drag, whose v |v| is not smooth at 0.
    system = make_system(swimmer.body, LAW._replace(drag_normal=0.0, drag_tangential=0.0), drive=wave(swimmer.body))
    exact = by_dop853(system)
    coarse = {EULER: 32, VERLET: 16, RK4: 4}[method]
    error = [np.abs(go(system, method, coarse << k, 60)[0] - exact).max() for k in range(2)]
    assert np.log2(error[0] / error[1]) == pytest.approx(ORDER[method], abs=0.2)


def test_swimming_agrees_with_dop853(swimmer):
    exact = by_dop853(swimmer)
    for method, steps, close in ((EULER, 64, 1e-3), (VERLET, 32, 2e-5), (RK4, 8, 1e-6), (ADAPTIVE, 1e-11, 1e-9)):
        assert np.abs(go(swimmer, method, steps, 60)[0] - exact).max() < close


# --- what must not change ------------------------------------------------------------------------------------------------


@EVERY
def test_turned_and_shifted_bodies_swim_turned_and_shifted(swimmer, method, steps):
    turn, shift = rotation(0.7), np.array([3.0, -2.0])
    body = swimmer.body._replace(position=np.ascontiguousarray(swimmer.body.position @ turn.T + shift))
    there = make_system(body, LAW, drive=(swimmer.amplitude, swimmer.frequency, swimmer.phase))
    here, other = (go(system, method, steps, 60)[0].T for system in (swimmer, there))
    assert other == pytest.approx(here @ turn.T + shift, abs=1e-6 if method == ADAPTIVE else 1e-10)


def spin(p, v):
    return (p[0] * v[1] - p[1] * v[0]).sum()


@EVERY
def test_internal_forces_keep_momentum_over_2000_control_steps(method, steps):
    body = slab(6, 3)
    system = make_system(body, Law(400.0, 10.0, 400.0, 0.0, 0.0, 0.2), drive=wave(body))
    velocity = np.random.default_rng(1).normal(0, 0.5, body.position.T.shape)
    before = velocity.sum(1), spin(body.position.T, velocity)
    p, v = go(system, method, 1e-5 if method == ADAPTIVE else steps, 2000, velocity=velocity)
    assert np.abs(v.sum(1) - before[0]).max() < 1e-12 * max(1.0, np.abs(v).sum())
    if method in (EULER, VERLET):
        assert abs(spin(p, v) - before[1]) < 1e-11 * max(1.0, np.abs(before[1]))


# --- steps ---------------------------------------------------------------------------------------------------------------


def matrices(system):
    """Mass-scaled stiffness and damping matrices of a body at rest, by differences of its forces."""
    body, cells = system.body, len(system.body.position)
    x = body.position.T.copy()
    stiffness, damping = np.empty((2 * cells, 2 * cells)), np.empty((2 * cells, 2 * cells))
    for k in range(2 * cells):
        pair = []
        for which in range(2):
            sides = []
            for sign in (1, -1):
                state = [x.copy(), np.zeros_like(x)]
                state[which].flat[k] += sign * 1e-6
                sides.append(accelerations_of(body, system.law, *state, body.rest_length).ravel())
            pair.append((sides[0] - sides[1]) / 2e-6)
        stiffness[:, k], damping[:, k] = -pair[0], -pair[1]
    return stiffness, damping


def random_system(seed, cells, stiffness, damping, pressure):
    rng = np.random.default_rng(seed)
    body = body_of(rng.uniform(-0.6, 0.6, (cells, 2)) * np.sqrt(cells))
    body = body._replace(inverse_mass=1 / rng.uniform(0.5, 2.0, cells))
    return make_system(body, Law(stiffness, damping, pressure, 0.0, 0.0, 0.2))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(2, 16), st.floats(10, 1e4), st.floats(0, 300), st.floats(0, 1e4))
def test_bounds_lie_above_the_true_eigenvalues(seed, cells, stiffness, damping, pressure):
    system = random_system(seed, cells, stiffness, damping, pressure)
    k, d = matrices(system)
    frequency, strongest = bounds(system)
    assert frequency**2 * (1 + 1e-6) >= np.linalg.eigvals(k).real.max()
    assert strongest * (1 + 1e-6) + 1e-9 >= np.linalg.eigvals(d).real.max()


def propagator(method, h, stiffness, damping):
    """The matrix of a step of the linear problem, from the definition of each method."""
    n = len(stiffness)
    one, zero = np.eye(n), np.zeros((n, n))
    if method == EULER:
        v = np.hstack((-h * stiffness, one - h * damping))
        return np.vstack((np.hstack((one, zero)) + h * v, v))
    if method == VERLET:  # of (x, v, a)
        x = np.hstack((one, h * one, h * h / 2 * one))
        a = -stiffness @ x - damping @ np.hstack((zero, one, h * one))
        return np.vstack((x, np.hstack((zero, one, h / 2 * one)) + h / 2 * a, a))
    z = h * np.block([[zero, one], [-stiffness, -damping]])
    return np.eye(2 * n) + z @ (np.eye(2 * n) + z @ (np.eye(2 * n) + z @ (np.eye(2 * n) + z / 4) / 3) / 2)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(2, 10), st.floats(10, 1e4), st.floats(0, 300), st.sampled_from([EULER, VERLET, RK4]))
def test_the_longest_step_of_true_eigenvalues_is_stable_and_one_not_much_longer_is_not(seed, cells, stiffness, damping, method):
    k, d = matrices(random_system(seed, cells, stiffness, damping, stiffness))
    h = longest_step(method, np.sqrt(np.linalg.eigvals(k).real.max()), max(0.0, np.linalg.eigvals(d).real.max()))
    spectral_radius = lambda h: np.abs(np.linalg.eigvals(propagator(method, h, k, d))).max()
    assert spectral_radius(h * (1 - 1e-3)) < 1 + 1e-4  # whole-body motions have eigenvalue 1, twice: rounding shows as its root
    # Frequency and damping need not peak in one mode; RK4's limit is that of the worst angle.
    assert spectral_radius(h * (3.0 if damping else 1.1)) > 1 + 1e-3


@FIXED
def test_a_body_in_chosen_steps_comes_to_rest_whatever_its_damping(method):
    for damping in (5.0, 50.0, 300.0):
        system = make_system(slab(4, 3), Law(400.0, damping, 400.0, 0.0, 0.0, 0.2))
        position = system.body.position.T + np.random.default_rng(3).normal(0, 0.03, (2, 12))
        steps = choose_steps(system, method, bounds(system), position, np.zeros_like(position), STEP)
        _, v = go(system, method, steps, 1200, position)
        assert np.abs(v).max() < 0.02


@FIXED
def test_chosen_steps_do_not_overshoot_in_strong_drag(method):
    system, position, _ = chain(1.0, np.zeros((2, 2)), Law(400.0, 0.0, 0.0, 1e4, 0.5, 0.2))
    velocity = np.array([[0.0, 0.0], [5, 5]])
    steps = choose_steps(system, method, bounds(system), position, velocity, STEP)
    assert STEP / steps * drag_rate(system.body, system.law, position, velocity, np.empty(2)) <= 0.5
    _, v = go(system, method, steps, 1, position, velocity)
    assert v[1] == pytest.approx(5 / (1 + 1e4 * 5 * STEP / 2), rel=0.4)


# --- faults --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_a_step_too_long_is_redone_finer_and_named_where_that_does_not_help(seed):
    # For a second: an undamped body gains a little energy in every frame that is too coarse but passes.
    system = make_system(slab(4, 3), Law(4000.0, 0.0, 4000.0, 0.0, 0.0, 0.2))
    position = system.body.position.T + 0.01 * np.random.default_rng(seed).normal(size=(2, 12))
    work = make_work(system.body)

    def attempt(doublings):
        p, v = position.copy(), np.zeros((2, 12))
        for k in range(60):
            outcome, steps = carry_soundly(system, VERLET, k * STEP, STEP, 1, Ladder(doublings, 0), State(p, v, NO_LEDGER), work)
            if outcome != SOUND:
                break
        return outcome, steps

    assert attempt(0)[0] in (UNSTABLE, INVERTED)
    assert attempt(3)[0] == SOUND


@FIXED
def test_nan_is_unstable(method):
    system = make_system(slab(3, 2), LAW)
    velocity = np.zeros((2, 6))
    velocity[1, 2] = np.nan
    position, work = system.body.position.T.copy(), make_work(system.body)
    outcome, steps = carry_soundly(system, method, 0.0, STEP, 2, Ladder(1, 0), State(position, velocity, NO_LEDGER), work)
    assert (outcome, steps) == (UNSTABLE, 4)


def test_how_fast_a_body_travels_is_no_fault():
    system = make_system(slab(3, 2), ALONE)
    position, velocity, work = system.body.position.T.copy(), np.full((2, 6), 1e4), make_work(system.body)
    assert carry_soundly(system, RK4, 0.0, STEP, 2, Ladder(0, 0), State(position, velocity, NO_LEDGER), work)[0] == SOUND


def test_equal_arguments_give_equal_bits(swimmer):
    for method in (EULER, VERLET, RK4):
        runs = [go(swimmer, method, 4, 30) for _ in range(2)]
        assert np.array_equal(runs[0][0], runs[1][0]) and np.array_equal(runs[0][1], runs[1][1])


def test_an_interval_may_be_split(swimmer):
    # Euler and RK4 keep nothing from step to step.
    for method in (EULER, RK4):
        work, p = make_work(swimmer.body), swimmer.body.position.T.copy()
        v = np.zeros_like(p)
        for k in range(4):
            carry(swimmer, method, k * STEP / 4, STEP / 4, 2, State(p, v, NO_LEDGER), work)
        whole, _ = go(swimmer, method, 8, 1)
        assert p == pytest.approx(whole, abs=1e-14)
