"""Packages that import what they offer when it is first asked for (PEP 562), so that a command that prints its help starts at once."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType


def lazily(names: dict[str, object], load: Callable[[], ModuleType]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    Args: names: its `globals()`, with an `__all__`; load: imports and returns the module that has all of `__all__`.
    """

    def getattr_(name: str):
        if name not in names["__all__"]:
            raise AttributeError(f"module {names['__name__']!r} has no attribute {name!r}")
        module = load()
        names.update({offered: getattr(module, offered) for offered in names["__all__"]})
        return names[name]

    def dir_() -> list[str]:
        return sorted({*names, *names["__all__"]})

    return getattr_, dir_
