"""Messages of an MCAP file, also of one whose writer was killed, and of one with damaged places."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

from mcap.exceptions import EndOfFile, InvalidMagic, McapError, UnsupportedCompressionError
from mcap.reader import make_reader
from mcap.records import Channel as McapChannel
from mcap.records import Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary
from zstandard import ZstdError

from .definitions import HOW, RecordingError
from .stored import Channel, Damage, Stored

# What a missing end, or damage, can set off in the MCAP reader and decompression.
DAMAGE = (McapError, ZstdError, struct.error, RuntimeError, ValueError, KeyError, EOFError, MemoryError)


class McapFile:
    """One file.  What is damaged is left out and told to `damage`, and reading goes on behind it where the file says where that is."""

    def __init__(self, path: Path, damage: Damage, progress: bool = False):
        self._path, self._damage, self._progress = path, damage, progress
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, McapChannel] = {}
        self._known: dict[int, Channel] = {}
        self._summary: Summary | None = None
        self._looked = False

    def messages(self) -> Iterator[Stored]:
        """The messages in the order of the file.  Raises RecordingError where it is no MCAP file."""
        size = self._path.stat().st_size
        with open(self._path, "rb") as opened, _watched(opened, self._path, self._progress) as stream:
            records = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size).records
            while True:
                begin = opened.tell()
                try:
                    record = next(records)
                except StopIteration:
                    return
                except DAMAGE as error:
                    if begin == 0 and isinstance(error, InvalidMagic):
                        raise RecordingError(f"{self._path} is not an MCAP file: {HOW}") from None
                    behind = self._next_chunk(begin)
                    if behind is None:
                        ends = opened.tell() >= size or isinstance(error, EndOfFile)
                        broken = f"{self._path} is damaged from byte {begin} on"
                        self._damage.cut = f"the end of {self._path} is missing" if ends else broken
                        return
                    self._damage.holes.append(f"{self._path} from byte {begin} to {behind}")
                    opened.seek(behind)
                    records = StreamReader(stream, skip_magic=True, emit_chunks=True, record_size_limit=size).records
                    continue
                if isinstance(record, Chunk):
                    yield from self._of_chunk(record, begin, opened.tell())
                else:
                    yield from self._take(record)

    def _of_chunk(self, chunk: Chunk, begin: int, end: int) -> Iterator[Stored]:
        try:
            records = breakup_chunk(chunk, validate_crc=True)
        except UnsupportedCompressionError:
            raise RecordingError(f"{self._path}: its chunks are compressed by {chunk.compression}, which cannot be read here") from None
        except DAMAGE:
            self._damage.holes.append(f"{self._path} from byte {begin} to {end}")
            return
        for record in records:
            yield from self._take(record)

    def _take(self, record) -> Iterator[Stored]:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, McapChannel):
            self._channels[record.id] = record
            self._known.pop(record.id, None)
        elif isinstance(record, Message):
            channel = self._known.get(record.channel_id) or self._channel(record.channel_id)
            if channel is not None:
                yield Stored(channel, record.log_time, record.data)

    def _channel(self, number: int) -> Channel | None:
        """A channel by its number; one that stood in a damaged place, from the summary at the end of the file."""
        channel = self._channels.get(number) or self._at_end("channels").get(number)
        if channel is None:
            return None
        schema = self._schemas.get(channel.schema_id) or self._at_end("schemas").get(channel.schema_id)
        known = Channel(
            channel.topic, schema.name if schema else "", channel.message_encoding, schema.encoding if schema else "",
            bytes(schema.data) if schema else b"", channel.metadata.get("topic_type_hash", ""),
        )
        self._known[number] = known
        return known

    def _at_end(self, what: str) -> dict:
        return getattr(self._read_summary(), what, {})

    def _next_chunk(self, after: int) -> int | None:
        """Where the first chunk behind a place begins, if the file says."""
        starts = [chunk.chunk_start_offset for chunk in getattr(self._read_summary(), "chunk_indexes", ())]
        return min((start for start in starts if start > after), default=None)

    def _read_summary(self):
        if not self._looked:
            self._looked = True
            try:
                with open(self._path, "rb") as stream:
                    self._summary = make_reader(stream).get_summary()
            except (*DAMAGE, OSError):
                pass
        return self._summary


def _watched(stream, file: Path, progress: bool):
    """A context: the stream, with a bar once reading has taken two seconds."""
    if not progress:
        return nullcontext(stream)
    from tqdm import tqdm

    return tqdm.wrapattr(stream, "read", total=file.stat().st_size, desc=f"Reading {file.name}", delay=2, leave=False)
