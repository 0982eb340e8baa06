"""Sums over table rows, many columns at a time, in vector registers.

Numba vectorises a loop only along its innermost index.  A sum of rows then loads and stores its result once for every few rows,
and each such loop begins with tests of what overlaps; at the size of an animat these take longer than the arithmetic.  Here
`LANES` columns stay in registers while the loop runs over rows.  Multiply-adds are fused (IEEE fusedMultiplyAdd), which gives the
same bits on every machine, by the processor or without it.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .jit import kernel, lean

LANES = 16  # columns in a pass: arrays are as wide as the next multiple
WAYS = 4  # sums side by side, since each must wait for its last addition
# Doubles in a vector.  Wider ones make processors clock down, which costs the rest of a life more than they save here.
_WIDTH = 4
_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, _WIDTH)
_ALIGNED = 8  # bytes: no more is promised


@lean
def padded(columns):
    """The least multiple of LANES that holds so many columns."""
    return (columns + LANES - 1) // LANES * LANES


@intrinsic
def fma(typing, a, b, c):
    """a b + c, rounded once."""
    return types.float64(types.float64, types.float64, types.float64), lambda context, builder, signature, values: builder.fma(*values)


def _splat(builder, number):
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(ir.IntType(32), _WIDTH), [0] * _WIDTH))


def _vectors(builder, data, first):
    """Pointers to the vectors of a pass whose first column is element `first` of data."""
    elements = (builder.add(first, ir.Constant(first.type, k)) for k in range(0, LANES, _WIDTH))
    return [builder.bitcast(builder.gep(data, [element]), _VECTOR.as_pointer()) for element in elements]


def _sums(builder, table, row, weights, first, last, column, ways):
    """Emit a loop that sums rows of a table, for each list of weights, in some of the ways, or, without any, all in one.

    Args: weights: pointers, to be indexed as `row` is.  Returns: sums [list][way][vector].
    """
    width = cgutils.unpack_tuple(builder, table.shape)[1]
    fused = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_VECTOR, [_VECTOR] * 3), f"llvm.fma.v{_WIDTH}f64")
    sums = [[[cgutils.alloca_once(builder, _VECTOR) for _ in range(0, LANES, _WIDTH)] for _ in ways] for _ in weights or [None]]
    for total in sum(sum(sums, []), []):
        builder.store(ir.Constant(_VECTOR, [0.0] * _WIDTH), total)
    with cgutils.for_range_slice(builder, first, last, ir.Constant(first.type, WAYS if weights else 1), first.type, True) as (k, _):
        for n, way in enumerate(ways):
            this = builder.add(k, ir.Constant(k.type, way))
            place = builder.load(builder.gep(row.data, [this]))
            if not weights:
                place = builder.mul(place if place.type == width.type else builder.zext(place, width.type), width)
            cells = _vectors(builder, table.data, builder.add(place, column))
            cells = [builder.load(vector, align=_ALIGNED) for vector in cells]
            factors = [_splat(builder, builder.load(builder.gep(weight, [this]))) for weight in weights]
            for totals, factor in zip(sums, factors or [None]):
                for vector, total in zip(cells, totals[n]):
                    before = builder.load(total)
                    after = builder.fadd(before, vector) if factor is None else builder.call(fused, [factor, vector, before])
                    builder.store(after, total)
    return [[[builder.load(total) for total in totals] for totals in of_list] for of_list in sums]


def _store(builder, out, place, *ways):
    """Store sums [way][vector], added in pairs."""
    for target, *parts in zip(_vectors(builder, out.data, place), *ways):
        while len(parts) > 1:
            parts = [builder.fadd(*parts[k : k + 2]) for k in range(0, len(parts), 2)]
        builder.store(parts[0], target, align=_ALIGNED)


@intrinsic
def sum_rows(typing, table, row, weight, first, last, column, out, place):
    """out[place : place + LANES] = sum over k in [first, last) of weight[k] table[row[k] + column : row[k] + column + LANES].

    Args: table and out (any shape, indexed flat) float64, C-contiguous; row (K,) int64: where rows of the table begin; column: a
    multiple of LANES; weight (K,) float64; last - first: a multiple of WAYS, of which each has a sum of its own.
    """
    signature = types.void(table, row, weight, first, last, column, out, place)

    def generate(context, builder, signature, values):
        table, row, weight, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 2, 6))
        (ways,) = _sums(builder, table, row, [weight.data], *values[3:6], range(WAYS))
        _store(builder, out, values[7], *ways)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def sum_rows_twice(typing, table, row, weight, first, last, column, out, places):
    """`sum_rows` with the weights from `first` on to the first of two places, and with as many more from `last` on to the second.

    The same bits in two thirds of the time: each number of the table is loaded once for both, so the ways go two by two, for
    want of registers.
    """
    signature = types.void(table, row, weight, first, last, column, out, places)

    def generate(context, builder, signature, values):
        table, row, weight, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 2, 6))
        first, last, column = values[3:6]
        weights = [weight.data, builder.gep(weight.data, [builder.sub(last, first)])]
        halves = [_sums(builder, table, row, weights, first, last, column, range(n, n + WAYS // 2)) for n in (0, WAYS // 2)]
        for place, *ways in zip(cgutils.unpack_tuple(builder, values[7], 2), *halves):
            _store(builder, out, place, *sum(ways, []))
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def add_rows(typing, table, row, first, last, column, out, place):
    """Without weights: out[place : place + LANES] = sum over k in [first, last) of table[row[k], column : column + LANES].

    Args: table (R, W), W a multiple of LANES; row (K,) uint32 or int64; first, last: int64.
    """
    signature = types.void(table, row, first, last, column, out, place)

    def generate(context, builder, signature, values):
        table, row, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 5))
        (ways,) = _sums(builder, table, row, [], *values[2:5], [0])
        _store(builder, out, values[6], *ways)
        return context.get_dummy_value()

    return signature, generate


@kernel
def aligned(rows, columns):
    """Zeros (rows, padded columns) that start at a cache line, so that no pass reads across two lines."""
    width = padded(columns)
    memory = np.zeros(rows * width + LANES)
    first = -(memory.ctypes.data // 8) % LANES
    return memory[first : first + rows * width].reshape(rows, width)
