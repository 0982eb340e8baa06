"""Output files: whole or not at all, and nothing else is ever overwritten."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..inputs import InputError
from ..whole_file import written_whole

_BEGINS_WITH = {
    ".rrd": (b"RRF",), ".png": (b"\x89PNG",), ".svg": (b"<?xml", b"<svg"), ".pdf": (b"%PDF",), ".csv": (b"cell", b"time"),
    ".html": (b"<!DOCTYPE html",), ".gif": (b"GIF8",),
}
_HEAD = 1024  # bytes
PICTURES = (".png", ".svg", ".pdf")


class OutputError(InputError, RuntimeError):
    """A file that cannot be written; the message says which, why, and what to do."""


def check(path: Path, *endings: str) -> None:
    """Raise OutputError where `path` cannot be written, has none of the endings, or holds anything but an older file of its kind."""
    ending = path.suffix.lower()
    if ending not in endings:
        raise OutputError(f"{path}: give a name that ends in {' or '.join(', '.join(endings).rsplit(', ', 1))}")
    if os.path.isdir(path):
        raise OutputError(f"{path} is a directory: give a file name in it")
    if not os.path.isdir(path.parent):
        raise OutputError(f"{path} cannot be written: make the directory {path.parent} first")
    try:
        begin = path.open("rb").read(_HEAD) if path.exists() else b""
    except OSError as error:
        raise OutputError(f"{path} cannot be replaced ({error.strerror}): choose another name") from None
    if begin and not _is_of_kind(begin, ending):
        raise OutputError(f"{path} holds something else and is never overwritten: choose another name")
    if not os.access(path.parent, os.W_OK):
        raise OutputError(f"{path} cannot be written: choose another directory")


def _is_of_kind(begin: bytes, ending: str) -> bool:
    if ending == ".mp4":
        return begin[4:8] == b"ftyp"
    return begin.startswith(_BEGINS_WITH[ending]) and (ending != ".svg" or b"<svg" in begin)


@contextmanager
def whole(path: Path, *endings: str) -> Iterator[str]:
    """`written_whole`, after `check`, by a name of the same ending.  Raises OutputError."""
    check(path, *endings)
    try:
        with written_whole(path, path.suffix.lower()) as name:
            yield name
    except OSError as error:
        raise OutputError(f"{path} cannot be written ({error.strerror or error}): choose another place") from None
