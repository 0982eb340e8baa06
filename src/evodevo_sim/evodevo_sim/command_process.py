"""The life of a command's process: signals, standard streams and the exit code, before anything heavy is imported.

    @command
    def gait():
        from .gait import main
        return main

`gait()` hears signals first, then imports and runs `main` in a second thread.  The first thread does nothing but wait: Python
hears a signal between two of its own instructions, and the compiler of kernels takes seconds for one.  It waits for a pipe, into
which signals write, since one that came just before it waited for a lock would not wake it.

SIGINT, SIGTERM and SIGHUP end a command at once with exit code 128 + their number, after what `if_ended` was given.  Within `heeded`
the first of them only asks, and a second one ends, but for SIGHUP, of which a closed terminal may send several.

A reader of the output who leaves, or a terminal that is closed, ends nothing: what is printed from then on is dropped, and the exit
code stays that of the work.
"""

from __future__ import annotations

import errno
import functools
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

Main = Callable[[list[str]], int]  # a command: its arguments in, its exit code out
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_GONE = (errno.EPIPE, errno.EIO)  # the reader of a pipe left; a terminal was closed

_ending: list[Callable[[], None]] = []  # what is to be done before the process ends early, the last first
_asked: list[Callable[[int], None]] = []  # told of the first signal within `heeded`
_heard: list[int] = []  # number of the first signal within `heeded`, if one came


_rule: list[Callable[[int], int]] = [lambda number: 128 + number]  # the last one tells the exit code after a signal


@contextmanager
def if_ended(undo: Callable[[], None]) -> Iterator[None]:
    """Where a signal ends the process in this context, `undo` is called before, in another thread than this one."""
    _ending.append(undo)
    try:
        yield
    finally:
        _ending.remove(undo)


@contextmanager
def heeded(ask: Callable[[int], None]) -> Iterator[None]:
    """In this context the first signal does nothing but call `ask` with its number: the work goes on to a good end."""
    _asked.append(ask)
    try:
        yield
    finally:
        _asked.remove(ask)


def exit_code(otherwise: int = 0) -> int:
    """128 + the number of the signal that was heeded, or else `otherwise`."""
    return _rule[-1](_heard[0]) if _heard else otherwise


def end_now(code: int) -> None:
    """End the process, whatever its other threads do, after what `if_ended` was given.  They say nothing more."""
    sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115  (as long as the process lives)
    for undo in _ending[::-1]:  # as it is: the other thread may leave its contexts meanwhile
        with suppress(Exception):  # the next one must have its turn
            undo()
    os._exit(code)


def command(load: Callable[[], Main] | None = None, *, code_of: Callable[[int], int] | None = None) -> Any:
    """Make an entry point, without arguments, of a function that imports and returns a `main`.

    Args: code_of: the exit code after a signal, by its number.
    """
    if load is None:
        return functools.partial(command, code_of=code_of)

    @functools.wraps(load)
    def entry() -> int | str:
        _rule.append(code_of or _rule[0])
        _open_descriptors()
        reader, writer = _hear()
        _wrap_streams()
        came = _in_a_thread(load, reader, writer)
        for number in (signal.SIGINT, signal.SIGHUP):  # the work is done; while Python shuts down they would count as crashes
            signal.signal(number, signal.SIG_IGN)
        return _finish(load.__name__, came)

    return entry


def _hear() -> tuple[int, int]:
    """Take the signals, also where a shell in the background ignores Ctrl-C for its children; `nohup` is respected.

    Returns: reader and writer of a pipe into which each signal writes."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    for number in _SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _take)
    return reader, writer


def _take(number: int, _frame) -> None:
    if _asked and not _heard:
        _heard.append(number)
        _asked[-1](number)
    elif not (_asked and number == signal.SIGHUP):
        end_now(_rule[-1](number))


def _in_a_thread(load, reader: int, writer: int) -> int | str | BaseException:
    """What `main` returned or raised; of SystemExit its code."""
    came: list = []

    def work():
        try:
            if not _asks_for_help() and _is_nowhere():
                print(f"{load.__name__}: the working directory does not exist any more: cd to another one", file=sys.stderr)
                came.append(2)
            else:
                came.append(load()(sys.argv[1:]))
        except SystemExit as error:
            came.append(0 if error.code is None else error.code)
        except ModuleNotFoundError as error:
            from .extras import lacking

            told = lacking(error)
            if told is error:
                came.append(error)
            else:
                print(f"{load.__name__}: {told}", file=sys.stderr)
                came.append(2)
        except BaseException as error:
            came.append(error)
        os.write(writer, b"\0")

    threading.Thread(target=work, name="command", daemon=True).start()
    while not came:
        os.read(reader, 1)
    return came[0]


def _finish(name: str, came) -> int | str:
    """Put on the streams what is left for them.  Returns the exit code; raises what `main` raised."""
    if isinstance(came, BaseException):
        raise came
    sys.stdout.flush()
    failure = getattr(sys.stdout, "failure", None)
    if failure is not None:
        print(f"{name}: the output cannot be written ({failure.strerror}): make room, or send it elsewhere", file=sys.stderr)
        came = came or 1
    return came


def _asks_for_help() -> bool:
    return not {"-h", "--help"}.isdisjoint(sys.argv[1:])


def _is_nowhere() -> bool:
    try:
        os.getcwd()
    except OSError:
        return True
    return False


class _Outlet(io.FileIO):
    """A file descriptor whose reader may leave.  Attributes: failure: the error that stopped it for another reason, or None."""

    failure: OSError | None = None
    _dead = False

    def write(self, data: Any) -> int:
        if not self._dead:
            try:
                return super().write(data)
            except OSError as error:
                self._dead = True
                if error.errno not in _GONE:
                    self.failure = error
        return memoryview(data).nbytes


class _Stream(io.TextIOWrapper):
    """A standard stream of text on an `_Outlet`."""

    def __init__(self, outlet: _Outlet, encoding: str, errors: str | None, lines: bool, at_once: bool):
        self.outlet = outlet
        super().__init__(io.BufferedWriter(outlet), encoding, errors, line_buffering=lines, write_through=at_once)

    @property
    def failure(self) -> OSError | None:
        return self.outlet.failure


def _open_descriptors() -> None:
    """Open the standard streams that are closed, so that no other file gets their numbers."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # it gets the lowest number that is free, which is this one


def _wrap_streams() -> None:
    """Let the readers of standard output and error leave."""
    sys.stdin = sys.stdin or open(0, closefd=False)  # noqa: SIM115  (as long as the process lives)
    for name, number in (("stdout", 1), ("stderr", 2)):
        before = getattr(sys, name)
        encoding, errors = (before.encoding, before.errors) if before else ("utf-8", "backslashreplace")
        outlet = _Outlet(number, "w", closefd=False)
        lines, at_once = number == 2 or outlet.isatty(), bool(before and before.write_through)
        setattr(sys, name, _Stream(outlet, encoding, errors, lines, at_once))
