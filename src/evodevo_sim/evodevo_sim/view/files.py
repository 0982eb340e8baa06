"""Output files: whole or not at all, and nothing else is ever overwritten."""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path

from ..inputs import InputError
from ..whole_file import written_whole

BEGINS_WITH = {".rrd": b"RRF", ".png": b"\x89PNG", ".csv": b"cell"}


class OutputError(InputError, RuntimeError):
    """A file that cannot be written; the message says which, why, and what to do."""


def check(path: Path, ending: str) -> None:
    """Raise OutputError where `path` cannot be written, or holds anything but an older file of the same kind."""
    if path.suffix.lower() != ending:
        raise OutputError(f"{path}: give a name that ends in {ending}")
    if os.path.isdir(path):
        raise OutputError(f"{path} is a directory: give a file name in it")
    if not os.path.isdir(path.parent):
        raise OutputError(f"{path} cannot be written: make the directory {path.parent} first")
    try:
        begin = path.open("rb").read(4) if path.exists() else b""
    except OSError as error:
        raise OutputError(f"{path} cannot be replaced ({error.strerror}): choose another name") from None
    if begin and not begin.startswith(BEGINS_WITH[ending]):
        raise OutputError(f"{path} holds something else and is never overwritten: choose another name")
    if not os.access(path.parent, os.W_OK):
        raise OutputError(f"{path} cannot be written: choose another directory")


@contextmanager
def whole(path: Path, ending: str):
    """`written_whole`, after `check`.  Raises OutputError."""
    check(path, ending)
    try:
        with written_whole(path, ending) as name:
            yield name
    except OSError as error:
        raise OutputError(f"{path} cannot be written ({error.strerror or error}): choose another place") from None
