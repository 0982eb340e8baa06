"""Crashes between any two calls of the file system, as a power cut and a killed process leave them."""

import itertools
from pathlib import Path

from evodevo_ga.keeping.files import Files


class Crash(BaseException):
    """The process is gone: no handler of errors runs."""


class Crashing(Files):
    """Ends the process at the call number `at`, from 0; of a write, after half of it.  What was called before stays."""

    def __init__(self, at=None):
        self.at, self.calls = at, 0

    def _count(self):
        self.calls += 1
        if self.at is not None and self.calls > self.at:
            raise Crash

    def sync(self, descriptor):
        """The disk is not waited for: nobody cuts its power."""
        self._count()

    def sync_directory(self, path):
        self._count()

    def write(self, descriptor, data):
        try:
            self._count()
        except Crash:
            super().write(descriptor, data[: len(data) // 2])
            raise
        super().write(descriptor, data)


class Failing(Crashing):
    """The call number `at` fails as those of the operating system do."""

    def __init__(self, at=None, error=None):
        super().__init__(at)
        self.error = error

    def _count(self):
        self.calls += 1
        if self.calls - 1 == self.at:
            raise self.error

    def write(self, descriptor, data):
        try:
            self._count()
        except OSError:
            Files.write(self, descriptor, data[: len(data) // 2])
            raise
        Files.write(self, descriptor, data)


def _counted(name):
    def call(self, *arguments):
        self._count()
        return getattr(Files, name)(self, *arguments)

    return call


for _name in ("create", "close", "rename", "make_directory"):
    setattr(Crashing, _name, _counted(_name))


class Disk(Crashing):
    """Knows besides what a disk holds for certain, and what it may hold, if the power is cut at the call number `at`.

    Names that a directory has are certain once it was synced; from then on any of what was done to them may have come to the disk, in
    order or not.  Bytes of a file are certain once it was synced; else there may be old ones, some, none, or zeros.
    """

    def __init__(self, root, at=None):
        super().__init__(at)
        self.root, self._open = Path(root), {}
        self._contents = {}  # by file, a number: (certain bytes, bytes)
        self._now, self._certain, self._pending = {}, {}, {}  # names: file; the same for certain; what was done, by directory

    def _do(self, path, *change):
        self._pending.setdefault(path.parent, []).append(change)
        _apply(self._now, change)

    def create(self, path):
        descriptor = super().create(path)
        if path not in self._now:
            self._contents[len(self._contents)] = (b"", b"")
            self._do(path, "link", path, len(self._contents) - 1)
        self._open[descriptor] = number = self._now[path]
        self._contents[number] = (self._contents[number][0], b"")
        return descriptor

    def write(self, descriptor, data):
        number = self._open[descriptor]
        certain, before = self._contents[number]
        self._contents[number] = (certain, before + data)
        super().write(descriptor, data)

    def sync(self, descriptor):
        super().sync(descriptor)
        data = self._contents[self._open[descriptor]][1]
        self._contents[self._open[descriptor]] = (data, data)

    def close(self, descriptor):
        super().close(descriptor)
        del self._open[descriptor]

    def make_directory(self, path):
        super().make_directory(path)
        self._do(path, "link", path, "directory")

    def rename(self, path, to):
        super().rename(path, to)
        self._do(path, "rename", path, to)

    def sync_directory(self, path):
        super().sync_directory(path)
        for change in self._pending.pop(path, []):
            _apply(self._certain, change)

    def left(self):
        """What may be on the disk after the power cut: dicts of bytes by path."""
        changes = [[list(some) for some in _subsets(done)] for done in self._pending.values()]
        for chosen in itertools.product(*changes):
            names = dict(self._certain)
            for change in itertools.chain(*chosen):
                _apply(names, change)
            for what in range(4):
                yield {
                    path: self._bytes(number, what) for path, number in names.items()
                    if number != "directory" and (path.parent == self.root or path.parent in names)
                }

    def _bytes(self, number, what):
        certain, now = self._contents[number]
        return (certain, now, now[: len(now) // 2], bytes(len(now)))[what] if certain != now else certain


def _subsets(done):
    return (some for count in range(len(done) + 1) for some in itertools.combinations(done, count))


def _apply(names, change):
    kind, path, to = change
    if kind == "link":
        names[path] = to
    elif path in names:
        names[to] = names.pop(path)
