"""Nothing rests on NaN compared by identity: Python 3.13 changed what == of a dataclass does with it."""

import dataclasses
import importlib
import pkgutil

import numpy as np
import pytest
from evodevo_sim.analysis.gait import Gait
from evodevo_sim.ros.messages import gait_from_message, gait_message
from hypothesis import given
from hypothesis import strategies as st
from values import field_by_field, guard, holds_nan, same, value_classes

import evodevo_ga
import evodevo_sim

NAN = float("nan")
NUMBERS = st.floats() | st.just(NAN)
TREES = st.recursive(NUMBERS, lambda inner: st.lists(inner, max_size=3) | st.tuples(inner, inner), max_leaves=6)


def copied(value):
    """Equal to a value, of other objects throughout, NaN too."""
    return type(value)(map(copied, value)) if isinstance(value, (list, tuple)) else float(np.float64(value))


@given(TREES)
def test_same_does_not_look_at_identity(value):
    assert same(value, value) and same(value, copied(value)) and not same([value], [value, value])


@given(st.floats(allow_nan=False), NUMBERS)
def test_same_tells_numbers_apart(a, b):
    assert same((a, NAN), (b, NAN)) == (a == b) and same(np.array([a, NAN]), np.array([b, NAN])) == (a == b)


def test_a_gait_that_passed_through_its_message_is_the_same_and_never_equal():
    gait = Gait("jump", "because", frequency=1.5)
    again = gait_from_message(gait_message(gait))
    assert holds_nan(gait) and same(gait, again) and not same(gait, dataclasses.replace(again, frequency=1.25))
    assert gait != again and not field_by_field(gait, gait)  # so that == on one is a mistake on every Python


def everything_of(package):
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        yield importlib.import_module(found.name)


def test_classes_whose_fields_may_be_nan_have_no_equality_of_fields():
    assert len([*everything_of(evodevo_sim), *everything_of(evodevo_ga)]) > 60
    classes = value_classes()
    assert len(classes) > 10
    for cls in classes:
        for field in dataclasses.fields(cls):
            assert not holds_nan(field.default), f"{cls.__name__}.{field.name} is NaN by default: give the class eq=False"
            assert "ndarray" not in str(field.type), f"{cls.__name__}.{field.name}: arrays have no single =="


def test_the_guard_of_all_tests_tells_of_nan():
    @dataclasses.dataclass(frozen=True)
    class Number:
        value: float
        parts: tuple = ()

    guard(Number)
    assert Number(1.0) == Number(1.0) != Number(2.0)
    for bad in (Number(NAN), Number(1.0, (0.0, (NAN,)))):
        with pytest.raises(AssertionError, match="Number that holds NaN"):
            bad == Number(1.0)  # noqa: B015  (comparing is what raises)
