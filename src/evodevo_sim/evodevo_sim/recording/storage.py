"""The files of a recording, and the messages in them, whatever storage they have."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from .compression import compression_of
from .definitions import HOW, RecordingError
from .mcap_file import McapFile
from .sqlite_file import sqlite_messages
from .stored import Damage, Stored

_ENDINGS = (".mcap", ".db3")
_KINDS = ((stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))


def is_recording(path: str | os.PathLike) -> bool:
    """Whether a name is that of a recording, and not of a genome: a directory, or a file of rosbag2, compressed or not."""
    path = Path(path)
    return path.is_dir() or any(suffix in _ENDINGS for suffix in path.suffixes[-2:])


def files_of(path: Path) -> list[Path]:
    """The files of a recording.  Raises RecordingError where there are none, or none that can be read."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        raise RecordingError(f"{path} does not exist: {HOW}") from None
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}: {HOW}") from None
    if stat.S_ISREG(mode):
        return [path]
    if not stat.S_ISDIR(mode):
        kind = next((name for test, name in _KINDS if test(mode)), "no file")
        raise RecordingError(f"{path} is {kind}, no recording: {HOW}")
    try:
        found = [file for file in path.iterdir() if file.is_file() and not file.name.startswith(".")]
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}: {HOW}") from None
    files = [file for file in found if file.suffix in _ENDINGS]
    files += [file for file in found if file.suffix not in _ENDINGS and is_recording(file)]  # compressed as a whole
    if not files:
        raise RecordingError(f"{path} holds no .mcap file: {HOW}")
    return sorted(files, key=lambda file: (len(file.name), file.name))  # run_2 before run_10


def messages_of(file: Path, damage: Damage, progress: bool = False) -> Iterator[Stored]:
    """The messages of one file, in its order; what is wrong with it goes to `damage`.  Raises RecordingError."""
    try:
        with open(file, "rb") as stream:
            begin = stream.read(16)
        if not begin:  # of a writer that was killed when it had just made it
            damage.cut = f"the end of {file} is missing"
            return
        compression = compression_of(begin)
        if compression:
            how = f"decompress it first, e.g. by `{compression} -d`"
            raise RecordingError(f"{file} is compressed by {compression} as a whole (`--compression-mode file`): {how}")
        if begin == b"SQLite format 3\0":
            yield from sqlite_messages(file, damage)
        elif begin[:8] and b"\x89MCAP0\r\n".startswith(begin[:8]):  # also one of a few bytes
            yield from McapFile(file, damage, progress).messages()
        else:
            raise RecordingError(f"{file} is not an MCAP file: {HOW}")
    except OSError as error:
        raise RecordingError(f"{file}: {error.strerror}: {HOW}") from None
