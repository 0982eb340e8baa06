"""The files of a recording that are already there when another one is added: what is in each, and a damaged one mended."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from mcap.reader import make_reader
from mcap.records import Header
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from ..ros.topics import EVENTS, Quality, role_of
from ..whole_file import written_whole
from .definitions import RecordingError
from .mcap_file import DAMAGE, McapFile
from .stored import Channel, Damage

_INFINITE = {"sec": 9223372036, "nsec": 854775807}
_NUMBERED = re.compile(r"(.+)_(\d+)\.mcap")


class Plain(yaml.SafeDumper):
    """Without anchors: each topic's entry can be read alone."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def described(quality: Quality) -> dict:
    """A quality of service as rosbag2 tells it."""
    return {
        "history": "keep_last", "depth": quality.depth, "reliability": "reliable" if quality.reliable else "best_effort",
        "durability": "transient_local" if quality.latched else "volatile", "deadline": _INFINITE, "lifespan": _INFINITE,
        "liveliness": "automatic", "liveliness_lease_duration": _INFINITE, "avoid_ros_namespace_conventions": False,
    }


def quality_of(topic: str) -> list[dict]:
    """The qualities of service of a topic: those of `ros.topics`, or of events."""
    entry = role_of(topic)
    return [described(entry.service if entry else EVENTS)]


@dataclass
class Part:
    """What metadata.yaml tells of a file.

    Attributes: name; first, last: ns, when its messages were recorded; counts: of messages, by topic; types: names and hashes by topic.
    """

    name: str
    first: int = 2**63
    last: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    types: dict[str, tuple[str, str]] = field(default_factory=dict)

    def take(self, topic: str, name: str, type_hash: str, stamp: int) -> None:
        """Count a message."""
        self.first, self.last = min(self.first, stamp), max(self.last, stamp)
        self.counts[topic] = self.counts.get(topic, 0) + 1
        self.types[topic] = (name, type_hash)

    @property
    def count(self) -> int:
        return sum(self.counts.values())

    @property
    def span(self) -> dict:
        first, last = (self.first, self.last) if self.count else (0, 0)
        return {"starting_time": {"nanoseconds_since_epoch": first}, "duration": {"nanoseconds": last - first}}


def metadata(parts: list[Part]) -> dict:
    """The contents of metadata.yaml, version 9, as rosbag2 of Jazzy writes it."""
    whole = Part("")
    for part in parts:
        if part.count:
            whole.first, whole.last = min(whole.first, part.first), max(whole.last, part.last)
        for topic, count in part.counts.items():
            whole.counts[topic] = whole.counts.get(topic, 0) + count
            whole.types[topic] = part.types[topic]
    topics = [
        {
            "topic_metadata": {
                "name": topic, "type": whole.types[topic][0], "serialization_format": "cdr", "offered_qos_profiles": quality_of(topic),
                "type_description_hash": whole.types[topic][1],
            },
            "message_count": count,
        }
        for topic, count in whole.counts.items()
    ]
    files = [{"path": part.name, **part.span, "message_count": part.count} for part in parts]
    return {
        "rosbag2_bagfile_information": {
            "version": 9, "storage_identifier": "mcap", "duration": whole.span["duration"], "starting_time": whole.span["starting_time"],
            "message_count": whole.count, "topics_with_message_count": topics, "compression_format": "", "compression_mode": "",
            "relative_file_paths": [part.name for part in parts], "files": files, "custom_data": None, "ros_distro": "jazzy",
        }
    }


def files_of_recorder(directory: Path) -> list[Path]:
    """The MCAP files of a directory that a Recorder wrote, in order."""
    found = [path for path in directory.glob("*.mcap") if _NUMBERED.fullmatch(path.name) and not path.name.startswith(".")]
    return sorted(found, key=lambda path: (len(path.name), path.name))


def next_name(directory: Path, files: list[Path]) -> str:
    """The name of the file that is added behind these."""
    last = _NUMBERED.fullmatch(files[-1].name) if files else None
    return f"{last[1]}_{int(last[2]) + 1}.mcap" if last else f"{directory.resolve().name}_0.mcap"


def mended_part(file: Path) -> Part:
    """What is in a file.  One that is damaged, or has no end, is written anew with all that can be read.  Raises RecordingError."""
    damage, part, empty = Damage(), Part(file.name), file.stat().st_size == 0
    for one in () if empty else McapFile(file, damage).messages():
        part.take(one.channel.topic, one.channel.type, one.channel.type_hash, one.log_time)
    if empty or damage.cut or damage.holes or not _is_closed(file, part.count):
        _rewrite(file)
    return part


def _is_closed(file: Path, count: int) -> bool:
    """Whether a file begins with a header, and ends with a summary that tells of as many messages."""
    try:
        with open(file, "rb") as stream:
            begins = isinstance(next(StreamReader(stream).records), Header)
            stream.seek(0)
            summary = make_reader(stream, validate_crcs=True).get_summary()
    except (*DAMAGE, StopIteration):
        return False
    return begins and summary is not None and summary.statistics is not None and summary.statistics.message_count == count


def _rewrite(file: Path) -> None:
    try:
        with written_whole(file, ".part") as name, open(name, "wb") as stream:
            writer = Writer(stream, compression=CompressionType.ZSTD)
            writer.start(profile="ros2", library="evodevo")
            channels: dict[Channel, int] = {}
            counts: dict[int, int] = {}
            for one in McapFile(file, Damage()).messages() if file.stat().st_size else ():
                number = channels.get(one.channel) or channels.setdefault(one.channel, _register(writer, one.channel))
                counts[number] = counts.get(number, 0) + 1
                writer.add_message(number, one.log_time, one.data, one.log_time, counts[number])
            writer.finish()
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as error:
        raise RecordingError(f"{file} cannot be mended ({error.strerror}): make room and run again") from None


def _register(writer: Writer, channel: Channel) -> int:
    schema = writer.register_schema(channel.type, channel.schema_encoding, channel.schema) if channel.type else 0
    about = {"offered_qos_profiles": yaml.dump(quality_of(channel.topic), Dumper=Plain, sort_keys=False)}
    return writer.register_channel(channel.topic, channel.encoding, schema, about | {"topic_type_hash": channel.type_hash})
