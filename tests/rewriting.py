"""Recordings as other programs write them: the same messages, otherwise ordered, described, stored or wrapped."""

from typing import NamedTuple

import zstandard
from evodevo_sim.recording.definitions import definition
from evodevo_sim.recording.schema import short, types_of
from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType, Writer


class Row(NamedTuple):
    """A message as a file holds it."""

    topic: str
    type: str
    schema: str
    hash: str
    time: int
    data: bytes


STRING = Row("/leg/gait", "std_msgs/msg/String", "string data\n", "", 0, b"\0\1\0\0\3\0\0\0hi\0")


def rows_of(path):
    """The messages of an MCAP file, in its order."""
    with open(path, "rb") as stream:
        return [
            Row(c.topic, s.name, s.data.decode(), c.metadata.get("topic_type_hash", ""), m.log_time, bytes(m.data))
            for s, c, m in NonSeekingReader(stream).iter_messages(log_time_order=False)
        ]


def write(path, rows, encoding="ros2msg", chunk=1 << 20, hashes=False, message_encoding="cdr"):
    """An MCAP file of these messages by the `mcap` library."""
    with open(path, "wb") as stream:
        writer, channels = Writer(stream, chunk_size=chunk, compression=CompressionType.ZSTD), {}
        writer.start(profile="ros2", library="another")
        for k, row in enumerate(rows):
            key = (row.topic, row.type, row.schema)
            if key not in channels:
                schema = writer.register_schema(row.type, encoding, row.schema.encode()) if row.type else 0
                about = {"topic_type_hash": row.hash} if hashes else {}
                channels[key] = writer.register_channel(row.topic, message_encoding, schema, about)
            writer.add_message(channels[key], row.time, row.data, row.time, k)
        writer.finish()
    return path


def depth_first(name, text):
    """A schema's text as rosbag2 orders it: the types that a type is made of depth first, by name; without comments."""
    types, seen = types_of(name, text), set()

    def told(current):
        lines = [f"{kind} {field}" for field, kind in types[current]]
        for part in sorted({kind.partition("[")[0] for _, kind in types[current] if "/" in kind} - seen):
            seen.add(part)
            lines += ["=" * 80, f"MSG: {part}", told(part)]
        return "\n".join(lines)

    return told(short(name)) + "\n"


def by_rosbag2(rows):
    return [row._replace(schema=depth_first(row.type, row.schema)) for row in rows]


def compressed(rows):
    squeeze = zstandard.ZstdCompressor()
    return [row._replace(data=squeeze.compress(row.data)) for row in rows]


def our_schema(name):
    return definition(f"evodevo_msgs/msg/{name}")
