"""Four doubles at a time, or two, in kernels: arithmetic that a compiler does not find by itself where indices are looked up.

A vector is a value like a number: load one, calculate with + - * /, store it.  Every operation is the IEEE one in each lane, in
the order written, so results have the bits of the same formula in single numbers, on every machine; a processor that lacks
registers as wide takes two steps.

    d = load4(state, 4 * j) - load4(state, 4 * i)
    store(edge, 2 * e, low(d))

Places count elements of arrays that are contiguous, which is asked of their type.  Nothing checks places: as little as in C.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.errors import TypingError
from numba.extending import intrinsic, overload, register_model

from .jit import inlined

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(32)
_ALIGNED = 8  # bytes: no more is promised


class Vector(types.Type):
    def __init__(self, width):
        self.width = width
        self.llvm = ir.VectorType(_DOUBLE, width)
        super().__init__(name=f"float64x{width}")


FOUR, TWO = Vector(4), Vector(2)


@register_model(Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, vector):
        super().__init__(manager, vector, vector.llvm)


def _contiguous(array, dtype=types.float64):
    if not isinstance(array, types.Array) or array.layout != "C" or array.dtype != dtype:
        raise TypingError(f"{array} in a vector operation: give a C-contiguous array of {dtype}")


def _pointer(context, builder, kind, array, place, width):
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), ir.VectorType(_DOUBLE, width).as_pointer())


def _loader(vector, meaning):
    @intrinsic
    def load(typing, array, place):
        _contiguous(array)

        def generate(context, builder, signature, values):
            return builder.load(_pointer(context, builder, signature.args[0], *values, vector.width), align=_ALIGNED)

        return vector(array, types.int64), generate

    load.__doc__ = meaning
    return load


load4 = _loader(FOUR, "array[place : place + 4]")
load2 = _loader(TWO, "array[place : place + 2]")


@intrinsic
def index(typing, array, place):
    """array[place], of unsigned 32-bit numbers, as a signed 64-bit one."""
    _contiguous(array, types.uint32)

    def generate(context, builder, signature, values):
        data = context.make_array(signature.args[0])(context, builder, values[0]).data
        return builder.zext(builder.load(builder.gep(data, [values[1]])), ir.IntType(64))

    return types.int64(array, types.int64), generate


@intrinsic
def number(typing, array, place):
    """array[place], of doubles."""
    _contiguous(array)

    def generate(context, builder, signature, values):
        return builder.load(builder.gep(context.make_array(signature.args[0])(context, builder, values[0]).data, [values[1]]))

    return types.float64(array, types.int64), generate


@intrinsic
def store(typing, array, place, vector):
    """array[place : place + width] = vector"""
    _contiguous(array)

    def generate(context, builder, signature, values):
        pointer = _pointer(context, builder, signature.args[0], *values[:2], vector.width)
        builder.store(values[2], pointer, align=_ALIGNED)
        return context.get_dummy_value()

    return types.void(array, types.int64, vector), generate


@intrinsic
def four(typing, *numbers):
    """four(a): (a, a, a, a); four(a, b, c, d)"""

    def generate(context, builder, signature, values):
        numbers = cgutils.unpack_tuple(builder, values[0])
        result = ir.Constant(FOUR.llvm, ir.Undefined)
        for k in range(FOUR.width):
            result = builder.insert_element(result, numbers[k % len(numbers)], ir.Constant(_INDEX, k))
        return result

    return FOUR(types.StarArgTuple(numbers)), generate


def _arithmetic(symbol, instruction):
    @intrinsic
    def calculate(typing, a, b):
        return a(a, b), lambda context, builder, signature, values: getattr(builder, instruction)(*values)

    @overload(symbol)
    def of_vectors(a, b):
        if isinstance(a, Vector) and a == b:
            return lambda a, b: calculate(a, b)


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")
_arithmetic(operator.truediv, "fdiv")


def _comparison(symbol, meaning):
    @intrinsic
    def compare(typing, a, b):
        def generate(context, builder, signature, values):
            lanes = builder.bitcast(builder.fcmp_ordered(symbol, *values), ir.IntType(signature.args[0].width))
            return builder.icmp_unsigned("==", lanes, ir.Constant(lanes.type, -1))

        return types.boolean(a, b), generate

    compare.__doc__ = meaning
    return compare


all_below = _comparison("<", "Whether a < b in every lane: never where there is a NaN.")
all_at_most = _comparison("<=", "Whether a <= b in every lane: never where there is a NaN.")


def _in_each_lane(name):
    @intrinsic
    def calculate(typing, a):
        def generate(context, builder, signature, values):
            kind = ir.FunctionType(a.llvm, [a.llvm])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{a.width}f64"), values)

        return a(a), generate

    calculate.__doc__ = f"{name} of each lane"
    return calculate


root, magnitude = _in_each_lane("sqrt"), _in_each_lane("fabs")


def _choice(symbol, meaning):
    @intrinsic
    def choose(typing, a, b, where, otherwise):
        def generate(context, builder, signature, values):
            return builder.select(builder.fcmp_ordered(symbol, *values[:2]), *values[2:])

        return where(a, b, where, otherwise), generate

    choose.__doc__ = meaning
    return choose


chosen = _choice(">", "where in the lanes where a > b, otherwise in the others: also where there is a NaN.")
chosen_at_least = _choice(">=", "where in the lanes where a >= b, otherwise in the others: also where there is a NaN.")


@intrinsic
def negative(typing, a):
    """-a"""
    return a(a), lambda context, builder, signature, values: builder.fneg(values[0])


def _shuffle(builder, a, b, *lanes):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, len(lanes)), list(lanes)))


def _of_one(vector, meaning, *lanes):
    @intrinsic
    def pick(typing, a):
        return vector(a), lambda context, builder, signature, values: _shuffle(builder, values[0], values[0], *lanes)

    pick.__doc__ = meaning
    return pick


def _of_two(meaning, *lanes):
    @intrinsic
    def pick(typing, a, b):
        return FOUR(a, b), lambda context, builder, signature, values: _shuffle(builder, *values, *lanes)

    pick.__doc__ = meaning
    return pick


low = _of_one(TWO, "(a0, a1) of four", 0, 1)
high = _of_one(TWO, "(a2, a3) of four", 2, 3)
join = _of_two("(a0, a1, b0, b1) of twos", 0, 1, 2, 3)
evens = _of_two("(a0, a2, b0, b2) of fours", 0, 2, 4, 6)
odds = _of_two("(a1, a3, b1, b3) of fours", 1, 3, 5, 7)
even_pairs = _of_two("(a0, b0, a2, b2) of fours", 0, 4, 2, 6)
odd_pairs = _of_two("(a1, b1, a3, b3) of fours", 1, 5, 3, 7)
halves = _of_two("(a0, a1, b2, b3) of fours", 0, 1, 6, 7)


@intrinsic
def transpose(typing, a, b, c, d):
    """Four rows of four, as four columns."""
    columns = types.UniTuple(FOUR, 4)

    def generate(context, builder, signature, values):
        a, b, c, d = values
        pairs = [_shuffle(builder, p, q, *lanes) for lanes in ((0, 4, 2, 6), (1, 5, 3, 7)) for p, q in ((a, b), (c, d))]
        halves = [(pairs[k], pairs[k + 1], lanes) for lanes in ((0, 1, 4, 5), (2, 3, 6, 7)) for k in (0, 2)]
        return context.make_tuple(builder, columns, [_shuffle(builder, p, q, *lanes) for p, q, lanes in halves])

    return columns(a, b, c, d), generate


@intrinsic
def lane(typing, vector, number):
    """One number of a vector.  Args: number: a literal."""
    if isinstance(number, types.IntegerLiteral):
        return types.float64(vector, number), lambda context, builder, signature, values: builder.extract_element(
            values[0], ir.Constant(_INDEX, number.literal_value)
        )


@inlined
def padded4(count):
    """The least multiple of four that holds so many."""
    return (count + 3) // 4 * 4


@inlined
def load4_within(array, place):
    """array[place : place + 4], with zeros beyond its end."""
    left = array.size - place
    if left >= 4:
        return load4(array, place)
    return four(number(array, place), number(array, place + 1) if left > 1 else 0.0, number(array, place + 2) if left > 2 else 0.0, 0.0)


@inlined
def store4_within(array, place, vector):
    """array[place : place + 4] = vector, as far as the array goes."""
    left = array.size - place
    if left >= 4:
        store(array, place, vector)
    else:
        array[place] = lane(vector, 0)
        if left > 1:
            array[place + 1] = lane(vector, 1)
        if left > 2:
            array[place + 2] = lane(vector, 2)
