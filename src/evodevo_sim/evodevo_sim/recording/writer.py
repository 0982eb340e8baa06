"""Writes a rosbag2 recording in MCAP."""

from __future__ import annotations

import errno
import os
import shutil
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer
from rclpy.serialization import serialize_message

from ..whole_file import written_whole
from .definitions import RecordingError, definition, type_hash, type_name
from .drawn import Drawn
from .parts import Part, Plain, files_of_recorder, mended_part, metadata, next_name, quality_of

_CHUNK = 128 * 1024  # bytes of messages that share a compressed chunk
_LAST_MESSAGE = 2.0  # s for the message that is being written when the process is ended
_KEEP_WITHIN = 0.5  # s after which a message is in the file, come what may


class Recorder:
    """A recording that is being written, as a context.

    What is written is in the file within a second, even if nothing more is written and we are killed.  A thread sees to that, and
    asks the disk to keep it: a power cut takes what was written in the last second, and what a slow disk had not kept by then.
    Any thread may write.

    Args: directory: made anew, with its parents; go_on: it is there, and the recording that it holds goes on in another file, once its
        files are mended where they are damaged; drawn: whether to write beside cells what public tools draw.
    Raises RecordingError where it exists, or does not, or cannot be written.

    Attributes: hearers: called with each message that is written; companions: names of files beside the recording which are worth nothing
    without it.
    """

    def __init__(self, directory: str | os.PathLike, go_on: bool = False, drawn: bool = True):
        self.directory = Path(directory)
        self.mend = "make room and run again"  # what to do where the disk is full
        self.hearers: list[Callable[[Any], None]] = []
        self.companions: set[str] = set()
        self._channels: dict[str, int] = {}
        self._drawn = Drawn() if drawn else None
        try:
            if not go_on:
                self.directory.mkdir(parents=True)
            files = files_of_recorder(self.directory)
            self._before = [mended_part(file) for file in files]
            self._part = Part(next_name(self.directory, files))
            self._file = open(self.directory / self._part.name, "xb")  # noqa: SIM115  (closed by `close`)
            (self.directory / "metadata.yaml").unlink(missing_ok=True)  # it would hide this file, if we are killed
        except FileExistsError:
            raise RecordingError(f"{self.directory} exists already and is never overwritten: choose another directory") from None
        except OSError as error:
            raise RecordingError(f"{self.directory} cannot be written ({error.strerror}): choose another directory") from None
        self._writer = Writer(self._file, chunk_size=_CHUNK, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="evodevo")
        self._file.flush()  # a file of no bytes is no recording
        self._lock = threading.Lock()
        self._failed: RecordingError | None = None  # in the thread
        self._waiting, self._ending = threading.Event(), threading.Event()  # messages that are not in the file yet; the end
        self._keeper = threading.Thread(target=self._keep, name="recorder", daemon=True)
        self._keeper.start()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, topic: str, message: Any, stamp: int) -> None:
        """Append a message.

        Args: topic: absolute, or below `/`, of any name; one that ends as in `ros.topics` has the quality of service from there;
            message: of any ROS type; stamp: ns.
        """
        with self._lock, self._one_line_errors():
            if self._failed:
                raise self._failed
            for name, one in ((topic, message), *(self._drawn.of(topic, message) if self._drawn else ())):
                self._append(name, one, stamp)
        self._waiting.set()
        for hear in self.hearers:
            hear(message)

    def _append(self, topic: str, message: Any, stamp: int) -> None:
        data = serialize_message(message)
        topic, name = "/" + topic.lstrip("/"), type_name(type(message))
        channel = self._channels.get(topic) or self._add_channel(topic, name)
        self._part.take(topic, name, type_hash(name), stamp)
        self._writer.add_message(channel, stamp, data, stamp, self._part.counts[topic])

    def flush(self) -> None:
        """Put what was written into the file, where it survives the end of this process."""
        with self._lock, self._one_line_errors():
            self._writer.flush()
            self._file.flush()

    def _keep(self) -> None:
        """Flush what waits, again and again, and have the disk keep it."""
        while True:
            self._waiting.wait()
            self._waiting.clear()  # before looking at the end: who ends sets it after that, and it must not be lost
            if self._ending.wait(_KEEP_WITHIN):
                return
            try:
                self.flush()
                self._sync()
            except RecordingError as error:
                self._failed = error
                return

    def _sync(self) -> None:
        """Have the disk keep what is in the file; meanwhile others may write."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EROFS):  # of files that have no disk behind them
                with self._one_line_errors():
                    raise

    def close(self) -> None:
        """End the recording.  One in which nothing was written leaves no directory behind."""
        if self._file.closed:
            return
        self._ending.set()
        self._waiting.set()
        self._keeper.join()
        with self._lock:
            if not self._file.closed:
                self._finish()

    def close_for_good(self) -> None:
        """End the recording from any thread of a process that ends: nobody writes any more, since the lock is kept."""
        self._ending.set()
        self._waiting.set()
        if self._lock.acquire(timeout=_LAST_MESSAGE) and not self._file.closed:
            self._finish()

    def _finish(self) -> None:
        if not (self._channels or self._before):
            self._file.close()
            if {path.name for path in self.directory.iterdir()} <= {self._part.name, *self.companions}:
                shutil.rmtree(self.directory, ignore_errors=True)
            return
        with self._one_line_errors():
            try:
                self._writer.finish()
                self._file.flush()
                self._sync()
            finally:
                self._file.close()
            if not self._channels:
                (self.directory / self._part.name).unlink()
            text = yaml.dump(metadata([*self._before, *([self._part] if self._channels else [])]), Dumper=Plain, sort_keys=False)
            with written_whole(self.directory / "metadata.yaml", ".yaml") as name:
                Path(name).write_text(text, encoding="utf-8")

    def _add_channel(self, topic: str, name: str) -> int:
        schema = self._writer.register_schema(name, "ros2msg", definition(name).encode())
        about = {"offered_qos_profiles": yaml.dump(quality_of(topic), Dumper=Plain, sort_keys=False), "topic_type_hash": type_hash(name)}
        self._channels[topic] = self._writer.register_channel(topic, "cdr", schema, about)
        return self._channels[topic]

    def _one_line_errors(self):
        return _OneLine(self.directory, self.mend)


class _OneLine:
    """Turns an operating system's error into a RecordingError."""

    def __init__(self, directory: Path, mend: str):
        self._directory, self._mend = directory, mend

    def __enter__(self):
        pass

    def __exit__(self, _, error, __):
        if isinstance(error, OSError):
            raise RecordingError(
                f"{self._directory}: recording stopped ({error.strerror}): what came before is kept; {self._mend}"
            ) from None
