"""Vectors: every operation gives, lane by lane, the bits of the same arithmetic in single numbers."""

import numpy as np
import pytest
from evodevo_sim.kernels.jit import kernel
from evodevo_sim.kernels.vectors import (
    all_at_most,
    all_below,
    chosen,
    chosen_at_least,
    even_pairs,
    evens,
    four,
    halves,
    high,
    index,
    join,
    lane,
    load2,
    load4,
    load4_within,
    low,
    magnitude,
    negative,
    number,
    odd_pairs,
    odds,
    padded4,
    root,
    store,
    store4_within,
    transpose,
)
from numba.core.errors import TypingError

A, B = np.random.default_rng(1).uniform(0.1, 2.0, (2, 4)) * np.array([1.0, -1e3, 1e-3, 1.0])


@kernel
def _arithmetic(a, b, out):
    x, y = load4(a, 0), load4(b, 0)
    store(out, 0, x + y)
    store(out, 4, x - y)
    store(out, 8, x * y)
    store(out, 12, x / y)
    store(out, 16, root(magnitude(x)))
    store(out, 20, negative(x - x))


def test_arithmetic_is_that_of_single_numbers():
    out = np.empty(24)
    _arithmetic(A, B, out)
    assert out.tobytes() == np.concatenate((A + B, A - B, A * B, A / B, np.sqrt(np.abs(A)), np.full(4, -0.0))).tobytes()


@kernel
def _lanes(a, b, out):
    x, y = load4(a, 0), load4(b, 0)
    store(out, 0, evens(x, y))
    store(out, 4, odds(x, y))
    store(out, 8, even_pairs(x, y))
    store(out, 12, odd_pairs(x, y))
    store(out, 16, join(low(x), load2(b, 1)))
    store(out, 20, four(lane(x, 3), lane(y, 2), 5.0, 6.0))
    store(out, 24, join(high(x), low(y)))
    store(out, 28, halves(x, y))
    columns = transpose(x, y, four(1.0), four(2.0))
    for k in range(4):
        store(out, 32 + 4 * k, columns[k])


def test_lanes_go_where_their_names_say():
    out, (a, b) = np.empty(48), (np.arange(4.0), np.arange(10.0, 14.0))
    _lanes(a, b, out)
    assert out[:32].reshape(8, 4).tolist() == [
        [0, 2, 10, 12], [1, 3, 11, 13], [0, 10, 2, 12], [1, 11, 3, 13], [0, 1, 11, 12], [3, 12, 5, 6], [2, 3, 10, 11], [0, 1, 12, 13],
    ]
    assert np.array_equal(out[32:].reshape(4, 4).T, [a, b, [1] * 4, [2] * 4])


@kernel
def _within(a, place, out):
    store4_within(out, place, load4_within(a, place) + four(1.0))


@pytest.mark.parametrize("size", range(1, 9))
def test_nothing_beyond_the_end_is_read_or_written(size):
    memory, out = np.full(12, np.nan), np.full(12, -1.0)
    memory[:size] = np.arange(size)
    for place in range(0, size, 4):
        _within(memory[:size], place, out[:size])
    assert out[:size].tolist() == [k + 1.0 for k in range(size)] and (out[size:] == -1.0).all()


@kernel
def _compare(a, b, out):
    x, y = load4(a, 0), load4(b, 0)
    store(out, 0, chosen(y, x, y, four(-1.0)))
    store(out, 4, chosen_at_least(y, x, y, four(-1.0)))
    return all_below(x, y), all_at_most(x, y)


@pytest.mark.parametrize("b, below, at_most, above", [
    ([2, 3, 4, 5], True, True, [2, 3, 4, 5]), ([2, 2, 4, 5], False, True, [2, -1, 4, 5]), ([2, 1, 4, 5], False, False, [2, -1, 4, 5]),
    ([2, np.nan, 4, 5], False, False, [2, -1, 4, 5]),
])
def test_lanes_are_compared_and_a_nan_is_neither_above_nor_below(b, below, at_most, above):
    out = np.empty(8)
    assert _compare(np.array([1.0, 2.0, 3.0, 4.0]), np.array(b, float), out) == (below, at_most)
    assert out[:4].tolist() == above
    assert out[4:].tolist() == [2, b[1] if b[1] >= 2 else -1, 4, 5]


def test_an_array_with_gaps_is_refused():
    with pytest.raises(TypingError, match="C-contiguous"):
        _within(np.zeros(8)[::2], 0, np.zeros(4))


@kernel
def _look_up(places, numbers):
    return index(places, 1), number(numbers, index(places, 0)), padded4(5)


def test_places_are_unsigned():
    assert _look_up(np.array([2, 2**32 - 1], np.uint32), np.array([1.0, 2.0, 3.0])) == (2**32 - 1, 3.0, 8)
