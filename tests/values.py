"""Equality of values that may hold NaN, which equals nothing, itself included.

Up to Python 3.12 the == of a dataclass compares tuples of fields, and tuples take the same object for equal: there two values that
share one NaN object are equal.  From 3.13 on it compares field by field, and they are not.  `same` means one thing on all.
"""

import dataclasses
import functools
import math
import sys

import numpy as np

PACKAGES = ("evodevo_sim", "evodevo_ga")


def same(a, b) -> bool:
    """Whether two values are of one type and equal in all that they hold, where NaN is the same as NaN."""
    if type(a) is not type(b):
        return False
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    return bool(a == b) or (isinstance(a, float) and math.isnan(a) and math.isnan(b))


def field_by_field(a, b) -> bool:
    """The == that Python generates for a dataclass from 3.13 on."""
    return type(a) is type(b) and all(getattr(a, f.name) == getattr(b, f.name) for f in dataclasses.fields(a) if f.compare)


def holds_nan(value) -> bool:
    if dataclasses.is_dataclass(value):
        return any(holds_nan(getattr(value, f.name)) for f in dataclasses.fields(value))
    if isinstance(value, (tuple, list)):
        return any(map(holds_nan, value))
    return isinstance(value, float) and math.isnan(value)


def value_classes() -> list[type]:
    """Dataclasses of the packages, in the modules loaded so far, whose == compares fields."""
    loaded = [module for name, module in list(sys.modules.items()) if name.partition(".")[0] in PACKAGES]
    found = {c for module in loaded for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__}
    return [c for c in found if dataclasses.is_dataclass(c) and c.__dataclass_params__.eq and "__eq__" in vars(c)]


def guard(cls: type) -> None:
    """Make the == of a dataclass fail loudly where either side holds NaN, on every Python."""
    generated = cls.__eq__

    @functools.wraps(generated)
    def equal(self, other):
        if other.__class__ is self.__class__ and (holds_nan(self) or holds_nan(other)):
            raise AssertionError(f"a {cls.__name__} that holds NaN is compared by ==, which Pythons answer differently: use values.same")
        return generated(self, other)

    if not hasattr(generated, "__wrapped__"):
        cls.__eq__ = equal
