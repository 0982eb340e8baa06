"""Parameters of nodes that are set at the start only."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor

from ..parameters import ParameterError
from .barrier import brief


def fixed(meaning: str, low: int | None = None, high: int | None = None) -> ParameterDescriptor:
    """The descriptor of a parameter that is set at the start only."""
    limits = [] if low is None else [IntegerRange(from_value=low, to_value=high, step=1)]
    return ParameterDescriptor(description=meaning, read_only=True, integer_range=limits)


def seconds(node: Any, name: str, default: float, meaning: str) -> float:
    """A parameter in seconds, whole numbers too, set at the start only.  Raises ParameterError unless it is 0 to 1e9."""
    descriptor = ParameterDescriptor(description=meaning, read_only=True, dynamic_typing=True)
    value = node.declare_parameter(name, default, descriptor).value
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= 1e9:  # a range of ROS's lets NaN pass
        raise ParameterError(f"{name} is {brief(repr(value), 60)}: give seconds from 0 to 1e9")
    return float(value)
