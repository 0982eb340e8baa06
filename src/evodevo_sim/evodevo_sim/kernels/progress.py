"""What a terminal shows while kernels are compiled: which, and how many are left."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.dispatcher import Dispatcher

from .cache import tell_once

_DELAY = 2.0  # s before anything is shown: kernels that are kept on disk are loaded in less
_lock = threading.Lock()
_bars: list[Any] = []  # the one that is shown, while a kernel is compiled that Python called
_met: set[Any] = set()  # functions of kernels that are done or left
_left: set[Any] = set()  # those that were met and are not done


def callees(kernel: Dispatcher) -> set[Any]:
    """The functions of a kernel and of all that it may call, found by their names."""
    found, left = set(), [kernel.py_func]
    while left:
        function = left.pop()
        if function in found:
            continue
        found.add(function)
        names = {name: function.__globals__.get(name) for name in function.__code__.co_names}
        inner = [*names.values(), *(cell.cell_contents for cell in function.__closure__ or ())]
        left += [item.py_func for item in inner if isinstance(item, Dispatcher) and hasattr(item, "for_kernels")]
    return found


@contextmanager
def _shown(kernel: Dispatcher) -> Iterator[None]:
    """In this context a kernel that Python calls is compiled or loaded; a terminal shows how far that is, if it takes long."""
    with _lock:
        new = callees(kernel) - _met
        _met.update(new)
        _left.update(new)
        if _bars:  # another thread compiles
            _bars[0].total += len(new)
            bar = None
        else:
            bar = _bar(len(new))
            _bars.extend([bar] if bar is not None else [])
    try:
        yield
    finally:
        if bar is not None:
            with _lock:
                _bars.remove(bar)
            bar.close()


def attend(compiled: Dispatcher, from_python: bool) -> None:
    """Count the compilations of a kernel, and collect no garbage meanwhile: that would take a twelfth of the time."""
    compile_ = compiled.compile

    def counted(signature):
        result = compile_(signature)
        _done(compiled)
        return result

    def attended(signature):
        _say_if_slow(compiled.targetctx.codegen().magic_tuple()[-1])
        collects = gc.isenabled()
        gc.disable()
        try:
            with _shown(compiled):
                return counted(signature)
        finally:
            if collects:
                gc.enable()

    compiled.compile = attended if from_python else counted


def _say_if_slow(features: str) -> None:
    """Args: features: of the processor that is compiled for, as LLVM names them."""
    if not {"+avx2", "+fma"} <= set(features.split(",")):
        tell_once("processor", "This processor lacks AVX2 or FMA: the same results take some eight times as long.")


def _done(compiled: Dispatcher) -> None:
    """Count a kernel as compiled or loaded."""
    if compiled.py_func not in _left:
        return
    _left.discard(compiled.py_func)
    for bar in _bars[:1]:
        module = compiled.py_func.__module__.rpartition(".")[2]
        bar.set_postfix_str(f"{module}.{compiled.py_func.__name__}", refresh=False)
        bar.update()


def _bar(total: int) -> Any:
    try:
        from tqdm import tqdm
    except ImportError:  # the library alone does without
        return None
    return tqdm(total=total, desc="Compiling", unit="kernel", delay=_DELAY, leave=False, disable=None)  # shown on terminals alone
