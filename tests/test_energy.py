"""Energy: forces are slopes of what is stored, and the ledger closes to each method's order."""

import numpy as np
import pytest
from bodies import ALONE, LAW, STEP, accelerations_of, body_of, go, slab, wave
from evodevo_sim.physics.energy import LEDGER, least_chamber, stored_energy
from evodevo_sim.physics.forces import Law, set_rest_lengths
from evodevo_sim.physics.integrators import make_system
from evodevo_sim.physics.step_size import ADAPTIVE, EULER, INTEGRATORS, RK4, VERLET
from plain import grid


def total(system, t, position, velocity):
    muscle = np.zeros(position.shape[1])
    if system.amplitude.size:
        muscle = system.amplitude * np.sin(2 * np.pi * system.frequency * t + system.phase)
    rest = np.empty_like(system.body.rest_length)
    set_rest_lengths(system.body, system.law, muscle, rest)
    return sum(stored_energy(system.body, system.law, rest, system.gravity, position, velocity))


def test_forces_are_the_slopes_of_stored_energy():
    from evodevo_sim import make_own_body

    body = make_own_body(grid()[0]).body  # triangles and a polygon, unequal masses
    position = body.position.T + np.random.default_rng(0).normal(0, 0.03, body.position.T.shape)
    still = np.zeros_like(position)
    out = accelerations_of(body, ALONE, position, still, body.rest_length)
    for x in range(2):
        for i in range(position.shape[1]):
            sides = []
            for sign in (1, -1):
                moved = position.copy()
                moved[x, i] += sign * 1e-5
                sides.append(sum(stored_energy(body, ALONE, body.rest_length, 0.0, moved, still)))
            assert out[x, i] / body.inverse_mass[i] == pytest.approx(-(sides[0] - sides[1]) / 2e-5, abs=1e-5)


def gap(system, method, steps, intervals=60):
    """(energy that the ledger does not explain, the ledger), J."""
    ledger, start = np.zeros(4), system.body.position.T.copy()
    p, v = go(system, method, steps, intervals, ledger=ledger)
    return abs(total(system, intervals * STEP, p, v) - total(system, 0.0, start, np.zeros_like(start)) - ledger.sum()), ledger


@pytest.mark.parametrize("method, steps, close", [
    (EULER, 64, 2e-2), (VERLET, 64, 3e-4), (RK4, 8, 3e-6), (ADAPTIVE, 1e-9, 1e-7),
], ids=INTEGRATORS)
def test_the_ledger_of_a_swimmer_closes(method, steps, close):
    body = slab()
    missing, ledger = gap(make_system(body, LAW, drive=wave(body)), method, steps)
    work = dict(zip(LEDGER, ledger))
    assert work["muscle"] > 0 > work["drag"] and work["damping"] < 0 and work["ground"] == 0
    assert missing < close * work["muscle"]


def test_the_ledger_closes_for_muscles_of_any_range():
    body = slab()
    missing, ledger = gap(make_system(body, LAW._replace(muscle_range=0.35), drive=wave(body)), RK4, 8)
    weaker = gap(make_system(body, LAW, drive=wave(body)), RK4, 8)[1]
    assert ledger[0] > 2 * weaker[0] and missing < 3e-6 * ledger[0]


@pytest.mark.parametrize("method, coarse, order", [(EULER, 32, 1), (VERLET, 16, 2), (RK4, 4, 4)], ids=INTEGRATORS[:3])
def test_the_gap_shrinks_at_the_methods_order(method, coarse, order):
    body = slab()
    system = make_system(body, LAW._replace(drag_normal=0.0, drag_tangential=0.0), drive=wave(body))
    gaps = [gap(system, method, coarse << k)[0] for k in range(2)]
    assert np.log2(gaps[0] / gaps[1]) > order - 0.3


def test_a_fall_onto_the_ground_loses_what_the_ground_takes():
    body = slab(4, 3)
    body = body._replace(position=body.position - [0, body.position[:, 1].min() - 0.5])
    system = make_system(body, Law(400.0, 10.0, 400.0, 0.0, 0.0, 0.2), gravity=9.81, friction=0.6, ground=True)
    missing = []
    for steps in (32, 512):
        gone, ledger = gap(system, EULER, steps, 90)
        work = dict(zip(LEDGER, ledger))
        assert work["ground"] < 0 and work["damping"] < 0 and work["muscle"] == work["drag"] == 0
        missing.append(gone / -(work["ground"] + work["damping"]))
    assert missing[1] < 0.01 and missing[1] < missing[0] / 4


def test_the_ledger_changes_no_bit_of_the_motion():
    body = slab(4, 3)
    for method, steps in ((EULER, 4), (VERLET, 4), (RK4, 2)):
        system = make_system(body, LAW, drive=wave(body))
        plain, kept = go(system, method, steps, 30), go(system, method, steps, 30, ledger=np.zeros(4))
        assert np.array_equal(plain[0], kept[0]) and np.array_equal(plain[1], kept[1])


def test_the_least_chamber_is_found():
    body = body_of([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0.5)])
    position = body.position.T.copy()
    assert least_chamber(body, position) == (1.0, 0)
    folded = position.copy()
    folded[0, 4] = 0.5
    share, where = least_chamber(body, folded)
    assert (share, where) == (-0.5, 0) or share < 0
    assert least_chamber(body_of([(0, 0), (1, 0)]), np.zeros((2, 2))) == (1.0, -1)
