"""Kernels that are called by address: each is compiled once, not linked into its callers, where LLVM would optimise it again.

Numba links a callee's code into every caller and optimises all of it there, so that a program whose calls nest deeply takes many times as
long to compile as its functions take together.  Here a caller refers to such a callee by a symbol, which stands for the address of the
compiled code in this process.  The symbol is named by what tells the callee apart (`KernelCache`), so that a caller that comes from disk
finds it again, once the callee is loaded.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator
from copy import copy
from importlib import import_module
from typing import NamedTuple

import llvmlite.binding as llvm
from numba.core import types
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError

PREFIX = "evodevo."


class Missing(Exception):
    """A kernel that another one calls by address and that is not there, or not as it was."""


class Callee(NamedTuple):
    """How to find a kernel of one signature again."""

    symbol: str
    module: str
    name: str  # within the module
    arguments: tuple[types.Type, ...]


_placed: dict[str, tuple[Callee, CompileResult]] = {}  # holds the code, whose address others know


def call_by_address(compiled: Dispatcher) -> None:
    """Let other kernels call this one by address."""
    add, context, function = compiled.add_overload, compiled.targetctx, compiled.py_func

    def add_overload(result: CompileResult) -> None:
        add(result)
        described = copy(result.fndesc)
        described.mangled_name = f"{PREFIX}{compiled._cache.symbol(result.signature, context.codegen())}"
        callee = Callee(described.mangled_name, function.__module__, function.__qualname__, tuple(result.signature.args))
        _placed[callee.symbol] = callee, result
        llvm.add_symbol(callee.symbol, result.library.get_pointer_to_function(result.fndesc.llvm_func_name))
        context.remove_user_function(result.entry_point)
        context.insert_user_function(result.entry_point, described, ())

    compiled.add_overload = add_overload

def without_constants(compiled: Dispatcher) -> None:
    """Compile a kernel for the types of arguments alone: numba would compile another for each constant that it is called with."""
    template = compiled.get_call_template

    def get_call_template(arguments, keywords):
        return template(tuple(map(types.unliteral, arguments)), {name: types.unliteral(kind) for name, kind in keywords.items()})

    compiled.get_call_template = get_call_template


def callees(result: CompileResult) -> Iterator[Callee]:
    """What a compiled kernel calls by address."""
    for function in result.library._final_module.functions:
        if function.is_declaration and function.name.startswith(PREFIX):
            yield _placed[function.name][0]


def place(callee: Callee) -> None:
    """Load or compile a kernel, before one that calls it is loaded.  Raises: Missing."""
    if callee.symbol in _placed:
        return
    try:
        found = operator.attrgetter(callee.name)(import_module(callee.module))
        found.for_kernels.compile(callee.arguments)
    except (ImportError, AttributeError, TypeError, NumbaError) as error:
        raise Missing(f"{callee.module}.{callee.name} is not there as it was") from error
    if callee.symbol not in _placed:
        raise Missing(f"{callee.module}.{callee.name} is another by now")
