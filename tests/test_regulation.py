"""The regulatory network against the laws of the model, and pruning against doing all the work."""

import numpy as np
import pytest
from evodevo_sim.genetics.elements import INPUTS, MORPHOGEN, OUTPUTS, TRANSCRIPTION_FACTOR
from evodevo_sim.genetics.regulation import activation, affinity, assign_units, exchange, express, make_spread, prune, regulate, share_out
from evodevo_sim.kernels.lanes import aligned
from genomes import hand_made, random_genomes, unit
from hypothesis import given, settings
from hypothesis import strategies as st

ALL_OUTPUTS, ALL_INPUTS = np.ones(OUTPUTS, bool), np.ones(INPUTS, bool)


@settings(deadline=None)  # the first example compiles
@given(st.floats(0, 20))
def test_affinity_is_the_law(distance):
    assert affinity(distance) == pytest.approx(2 * (5 - distance) / (10 * distance + 1) if distance <= 5 else 0.0, abs=1e-15)


@settings(deadline=None)
@given(st.floats(-1e6, 1e6))
def test_activation_is_half_a_hyperbolic_tangent(a):
    assert activation(a) == pytest.approx(np.tanh(max(a, 0.0) / 2), abs=7e-6)
    assert 0.0 <= activation(a) <= 1.0


def test_activation_never_falls():
    values = [activation(a) for a in np.linspace(-1, 30, 20001)]
    assert np.all(np.diff(values) >= -1e-15)


def test_units_are_a_run_of_regulators_then_a_run_of_genes():
    p, g = 1, 2
    kind = np.array([0] * 8 + [g, p, p, g, g, p, g, p], np.uint8)
    unit_of, units = assign_units(kind)
    assert units == 2
    assert unit_of[8:].tolist() == [-1, 0, 0, 0, 0, 1, 1, -1]


def test_weights_are_signed_sums_of_affinities():
    genome = hand_made(
        {"constant": (-1, 0.0, 1.0), "expansion": (1, 0.0, 0.0)},
        [unit([(1, 0.0, 0.0), (-1, 0.0, 3.0)], [(TRANSCRIPTION_FACTOR, -1, 0.0, 2.0), (MORPHOGEN, 1, 0.0, 4.0)])],
    )
    weights, units = express(*genome.arrays())
    a = affinity
    assert units == 1
    own, perceived, constant = 0, 1, 2 + 2
    assert weights[0, own] == pytest.approx(-a(2.0) + a(1.0))
    assert weights[0, perceived] == pytest.approx(a(4.0) - a(1.0))
    assert weights[0, constant] == pytest.approx(-a(1.0) + a(2.0))
    expansion = units + 2
    assert weights[expansion].tolist() == pytest.approx([-a(2.0), a(4.0), 0, 0, -a(1.0), 0])


def table_of(units, cells, rng):
    table = aligned(2 * units + OUTPUTS + INPUTS, cells)
    table[: units + OUTPUTS, :cells] = rng.random((units + OUTPUTS, cells))
    table[2 * units + OUTPUTS :, :cells] = rng.random((INPUTS, cells))
    return table


@settings(max_examples=30, deadline=None)
@given(random_genomes(), st.integers(1, 9), st.integers(0, 2**32))
def test_a_step_is_the_law_and_stays_in_range(genome, cells, seed):
    weights, units = express(*genome.arrays())
    network = prune(weights, units, ALL_OUTPUTS, ALL_INPUTS, cells)
    rng = np.random.default_rng(seed)
    table = table_of(units, cells, rng)
    table[units + OUTPUTS : 2 * units + OUTPUTS, :cells] = rng.random((units, cells))
    before = table.copy()
    regulate(network, table, aligned(network.nodes.size, cells), cells, 0.1)
    sources = np.delete(before, np.s_[units : units + OUTPUTS], axis=0)
    for node in range(units + OUTPUTS):
        expected = before[node] + 0.1 * (np.tanh(np.maximum(weights[node] @ sources, 0) / 2) - before[node])
        if node in network.nodes:
            assert table[node] == pytest.approx(expected, abs=1e-6)  # h = 0.1 of the activation's 7e-6
        else:
            assert np.array_equal(table[node], before[node])
    assert np.all((table[: units + OUTPUTS] >= 0) & (table[: units + OUTPUTS] <= 1))


@settings(max_examples=30, deadline=None)
@given(random_genomes(), st.integers(0, 2**32))
def test_pruning_changes_no_read_output_by_one_bit(genome, seed):
    weights, units = express(*genome.arrays())
    read = np.array([False, False, True, True])
    outputs = []
    for mask in (ALL_OUTPUTS, read):
        network = prune(weights, units, mask, ALL_INPUTS, 3)
        table = table_of(units, 3, np.random.default_rng(seed))
        start, spread = np.array([0, 1, 3, 4]), make_spread(network, 3)
        share_out(start, 3, spread)
        for _ in range(30):
            exchange(network, table, start, np.array([1, 0, 2, 1]), 3, spread)
            regulate(network, table, aligned(network.nodes.size, 3), 3, 0.1)
        outputs.append(table[units + 2 : units + 4, :3])
    assert np.array_equal(*outputs)


@settings(max_examples=30, deadline=None)
@given(st.integers(2, 12), st.integers(0, 2**32))
def test_exchange_conserves_every_morphogen(cells, seed):
    rng = np.random.default_rng(seed)
    genome = hand_made(
        {"expansion": (1, 0.0, 0.0)}, [unit([(1, 0.0, 0.0)], [(MORPHOGEN, 1, 0.0, 0.0)])],
    )
    network = prune(*express(*genome.arrays()), ALL_OUTPUTS, ALL_INPUTS, cells)
    ring = np.array([[(i - 1) % cells, (i + 1) % cells] for i in range(cells)])
    neighbours = [sorted(set(row)) for row in ring.tolist()]
    start = np.cumsum([0] + [len(n) for n in neighbours])
    table = table_of(1, cells, rng)
    spread = make_spread(network, cells)
    share_out(start, cells, spread)
    exchange(network, table, start, np.concatenate(neighbours), cells, spread)
    assert table[1 + OUTPUTS].sum() == pytest.approx(table[0].sum(), rel=1e-14)
