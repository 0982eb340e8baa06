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

from ._jit import kernel, lean

LANES = 16  # columns in a pass: arrays are as wide as the next multiple
WAYS = 4  # sums side by side, since each must wait for its last addition
_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, LANES)
_EIGHT = 8  # bytes of a double: no more alignment is promised


@lean
def padded(columns):
    """The least multiple of LANES that holds so many columns."""
    return (columns + LANES - 1) // LANES * LANES


@intrinsic
def fma(typing, a, b, c):
    """a b + c, rounded once."""
    return types.float64(types.float64, types.float64, types.float64), lambda context, builder, signature, values: builder.fma(*values)


def _splat(builder, number):
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(undefined, number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, undefined, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


def _lanes(builder, data, element):
    return builder.bitcast(builder.gep(data, [element]), _VECTOR.as_pointer())


def _sum(context, builder, table, row, weight, first, last, column, out, place):
    """Emit the loop of `sum_rows`, or, without weight, of `add_rows`."""
    ways = WAYS if weight is not None else 1
    width = cgutils.unpack_tuple(builder, table.shape)[1]
    fused = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_VECTOR, [_VECTOR] * 3), f"llvm.fma.v{LANES}f64")
    nothing = ir.Constant(_VECTOR, [0.0] * LANES)
    sums = [cgutils.alloca_once(builder, _VECTOR) for _ in range(ways)]
    for total in sums:
        builder.store(nothing, total)
    with cgutils.for_range_slice(builder, first, last, ir.Constant(first.type, ways), first.type, True) as (k, _):
        for way, total in enumerate(sums):
            this = builder.add(k, ir.Constant(k.type, way))
            index = builder.load(builder.gep(row.data, [this]))
            index = index if index.type == width.type else builder.zext(index, width.type)
            cells = builder.load(_lanes(builder, table.data, builder.add(builder.mul(index, width), column)), align=_EIGHT)
            if weight is None:
                after = builder.fadd(builder.load(total), cells)
            else:
                factor = _splat(builder, builder.load(builder.gep(weight.data, [this])))
                after = builder.call(fused, [factor, cells, builder.load(total)])
            builder.store(after, total)
    parts = [builder.load(total) for total in sums]
    while len(parts) > 1:
        parts = [builder.fadd(*parts[k : k + 2]) for k in range(0, len(parts), 2)]
    builder.store(parts[0], _lanes(builder, out.data, place), align=_EIGHT)
    return context.get_dummy_value()


@intrinsic
def sum_rows(typing, table, row, weight, first, last, column, out, place):
    """out[place : place + LANES] = sum over k in [first, last) of weight[k] table[row[k], column : column + LANES].

    Args: table (R, W) and out (any shape, indexed flat) float64, C-contiguous, W and column multiples of LANES; row (K,) int64;
    weight (K,) float64; last - first: a multiple of WAYS, of which each has a sum of its own.
    """
    signature = types.void(table, row, weight, first, last, column, out, place)

    def generate(context, builder, signature, values):
        table, row, weight, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 2, 6))
        return _sum(context, builder, table, row, weight, *values[3:6], out, values[7])

    return signature, generate


@intrinsic
def add_rows(typing, table, row, first, last, column, out, place):
    """The same without weights: out[place : place + LANES] = sum over k in [first, last) of table[row[k], column : column + LANES].

    Args: row (K,) uint32 or int64; first, last: int64.
    """
    signature = types.void(table, row, first, last, column, out, place)

    def generate(context, builder, signature, values):
        table, row, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 5))
        return _sum(context, builder, table, row, None, *values[2:5], out, values[6])

    return signature, generate


@kernel
def aligned(rows, columns):
    """Zeros (rows, padded columns) that start at a cache line, so that no pass reads across two lines."""
    width = padded(columns)
    memory = np.zeros(rows * width + LANES)
    first = -(memory.ctypes.data // 8) % LANES
    return memory[first : first + rows * width].reshape(rows, width)
