"""Files that a power cut leaves whole: each call of the file system that matters is one method, so that tests crash between any two."""

from __future__ import annotations

import errno
import os
from pathlib import Path

_NO_DISK = (errno.EINVAL, errno.ENOTSUP, errno.EROFS)  # of fsync, where no disk is behind the file


class Files:
    """The calls of the file system by which a run keeps what it must not lose.  All raise OSError."""

    def create(self, path: Path) -> int:
        """A new, empty file.  Returns: its descriptor."""
        return os.open(path, os.O_CREAT | os.O_TRUNC | os.O_WRONLY | os.O_CLOEXEC, 0o666)

    def write(self, descriptor: int, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(descriptor, rest) :]

    def sync(self, descriptor: int) -> None:
        """Have the disk keep what was written."""
        try:
            os.fsync(descriptor)
        except OSError as error:
            if error.errno not in _NO_DISK:
                raise

    def close(self, descriptor: int) -> None:
        os.close(descriptor)

    def make_directory(self, path: Path) -> None:
        path.mkdir(exist_ok=True)

    def rename(self, path: Path, to: Path) -> None:
        """Give a file another name, in place of whatever has it."""
        os.replace(path, to)

    def remove(self, path: Path) -> None:
        path.unlink(missing_ok=True)

    def sync_directory(self, path: Path) -> None:
        """Have the disk keep which names a directory has."""
        descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            self.sync(descriptor)
        finally:
            os.close(descriptor)


FILES = Files()


def aside(path: Path) -> Path:
    """Where a file is written before it takes the place of `path`; hidden, so that readers of a directory leave it out."""
    return path.with_name(f".{path.name}.new")


def replace_file(path: Path, data: bytes, files: Files = FILES, before: Path | None = None) -> None:
    """Put `data` in the place of a file, so that after a crash at any moment either the old or the new one is there, whole.

    Args: before: the name that the old one then gets.
    Raises OSError, and leaves the old one where it was, where the new one cannot be written.
    """
    new = aside(path)
    try:
        descriptor = files.create(new)
        try:
            files.write(descriptor, data)
            files.sync(descriptor)
        finally:
            files.close(descriptor)
        if before is not None and path.exists():
            files.rename(path, before)
        files.rename(new, path)
    except (OSError, KeyboardInterrupt):  # it may be what fills the disk, or a person ends the run at once
        files.remove(new)
        raise
    files.sync_directory(path.parent)
