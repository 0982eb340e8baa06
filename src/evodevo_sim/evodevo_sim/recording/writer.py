"""Writes a rosbag2 recording in MCAP."""

from __future__ import annotations

import errno
import os
import shutil
import threading
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer
from rclpy.serialization import serialize_message

from ..ros.topics import EVENTS, Quality, role_of
from .definitions import RecordingError, definition, type_hash, type_name
from .drawn import Drawn

_CHUNK = 128 * 1024  # bytes of messages that share a compressed chunk
_LAST_MESSAGE = 2.0  # s for the message that is being written when the process is ended
_KEEP_WITHIN = 0.5  # s after which a message is in the file, come what may
_INFINITE = {"sec": 9223372036, "nsec": 854775807}


class _Plain(yaml.SafeDumper):
    """Without anchors: each topic's entry can be read alone."""

    def ignore_aliases(self, _):
        return True


def _described(quality: Quality) -> dict:
    """A quality of service as rosbag2 tells it."""
    return {
        "history": "keep_last", "depth": quality.depth, "reliability": "reliable" if quality.reliable else "best_effort",
        "durability": "transient_local" if quality.latched else "volatile", "deadline": _INFINITE, "lifespan": _INFINITE,
        "liveliness": "automatic", "liveliness_lease_duration": _INFINITE, "avoid_ros_namespace_conventions": False,
    }


class Recorder:
    """A recording that is being written, as a context.

    What is written is in the file within a second, even if nothing more is written and we are killed.  A thread sees to that, and
    asks the disk to keep it: a power cut takes what was written in the last second, and what a slow disk had not kept by then.
    Any thread may write.

    Args: directory: made anew, with its parents; drawn: whether to write beside cells what public tools draw.
    Raises RecordingError where it exists or cannot be written.
    """

    def __init__(self, directory: str | os.PathLike, drawn: bool = True):
        self.directory = Path(directory)
        self._name = f"{self.directory.resolve().name}_0.mcap"
        self._channels: dict[str, dict] = {}
        self._drawn = Drawn() if drawn else None
        self._first, self._last = 2**63, 0
        try:
            self.directory.mkdir(parents=True)
            self._file = open(self.directory / self._name, "wb")  # noqa: SIM115  (closed by `close`)
        except FileExistsError:
            raise RecordingError(f"{self.directory} exists already and is never overwritten: choose another directory") from None
        except OSError as error:
            raise RecordingError(f"{self.directory} cannot be written ({error.strerror}): choose another directory") from None
        self._writer = Writer(self._file, chunk_size=_CHUNK, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="evodevo")
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

    def _append(self, topic: str, message: Any, stamp: int) -> None:
        data = serialize_message(message)
        channel = self._channels.get(topic) or self._add_channel(topic, type(message))
        self._first, self._last = min(self._first, stamp), max(self._last, stamp)
        channel["count"] += 1
        self._writer.add_message(channel["id"], stamp, data, stamp, channel["count"])

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
        if not self._channels:
            self._file.close()
            if [path.name for path in self.directory.iterdir()] == [self._name]:
                shutil.rmtree(self.directory, ignore_errors=True)
            return
        with self._one_line_errors():
            try:
                self._writer.finish()
                self._file.flush()
                self._sync()
            finally:
                self._file.close()
            text = yaml.dump(self._metadata(), Dumper=_Plain, sort_keys=False)
            (self.directory / "metadata.yaml").write_text(text, encoding="utf-8")

    def _add_channel(self, topic, message_type):
        entry = role_of(topic)
        name, quality = type_name(message_type), [_described(entry.service if entry else EVENTS)]
        schema = self._writer.register_schema(name, "ros2msg", definition(name).encode())
        described = {"offered_qos_profiles": yaml.dump(quality, Dumper=_Plain, sort_keys=False), "topic_type_hash": type_hash(name)}
        number = self._writer.register_channel("/" + topic.lstrip("/"), "cdr", schema, described)
        self._channels[topic] = {"id": number, "type": name, "quality": quality, "hash": described["topic_type_hash"], "count": 0}
        return self._channels[topic]

    def _metadata(self) -> dict:
        """The contents of metadata.yaml, version 9, as rosbag2 of Jazzy writes it."""
        count = sum(channel["count"] for channel in self._channels.values())
        span = {"starting_time": {"nanoseconds_since_epoch": self._first}, "duration": {"nanoseconds": self._last - self._first}}
        topics = [
            {
                "topic_metadata": {
                    "name": "/" + topic.lstrip("/"), "type": channel["type"], "serialization_format": "cdr",
                    "offered_qos_profiles": channel["quality"], "type_description_hash": channel["hash"],
                },
                "message_count": channel["count"],
            }
            for topic, channel in self._channels.items()
        ]
        return {
            "rosbag2_bagfile_information": {
                "version": 9, "storage_identifier": "mcap", "duration": span["duration"], "starting_time": span["starting_time"],
                "message_count": count, "topics_with_message_count": topics, "compression_format": "", "compression_mode": "",
                "relative_file_paths": [self._name], "files": [{"path": self._name, **span, "message_count": count}],
                "custom_data": None, "ros_distro": "jazzy",
            }
        }

    def _one_line_errors(self):
        return _OneLine(self.directory)


class _OneLine:
    """Turns an operating system's error into a RecordingError."""

    def __init__(self, directory):
        self._directory = directory

    def __enter__(self):
        pass

    def __exit__(self, _, error, __):
        if isinstance(error, OSError):
            raise RecordingError(
                f"{self._directory}: recording stopped ({error.strerror}): what came before is kept; make room and run again"
            ) from None
