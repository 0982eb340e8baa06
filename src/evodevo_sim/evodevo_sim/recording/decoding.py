"""How the messages of a channel are read: as ours, by the recording's own schema, or not at all."""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable
from dataclasses import dataclass

from mcap.exceptions import McapError
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message

from .compression import compression_of
from .definitions import definition, type_hash, type_name
from .older import definition_before, lacking, message_of, words_of
from .schema import compare, short, types_of
from .stored import Channel

_CDR = (b"\0\0", b"\0\1")  # with which messages begin, big- and little-endian
_UNDECODABLE = (
    RuntimeError, ValueError, TypeError, AttributeError, KeyError, IndexError, OverflowError, EOFError, MemoryError, McapError,
    struct.error,
)


@dataclass(frozen=True)
class Reading:
    """decode: bytes to a message of ours, or None; refused: why there is none; other: whether that is another type of our name;
    notes: what another version has left out or added; trust: why the type is known all the same, where no schema tells it."""

    decode: Callable | None = None
    refused: str = ""
    other: bool = False
    notes: tuple[str, ...] = ()
    trust: str = ""


class Undecodable(ValueError):
    """A message that cannot be read; the text says why."""


def reading_of(channel: Channel, message_type: type) -> Reading | None:
    """How messages of a channel are read whose topic is one of ours; None for a channel of another type."""
    name = type_name(message_type)
    if channel.type and short(channel.type) != short(name):
        return None
    known, before = channel.type_hash == type_hash(name), definition_before(name, channel.type_hash)
    if channel.type_hash and not channel.type and not (known or before):
        return None
    if channel.encoding != "cdr":
        return Reading(refused=f"its messages are in the encoding {channel.encoding or 'of no name'!r}, not cdr")
    if before:
        return _by_schema(name, before.encode(), message_type)
    if channel.schema_encoding != "ros2msg" or not channel.schema.strip():
        language = channel.schema_encoding
        what = f"its schema is in {language}, not ros2msg" if language and channel.schema.strip() else "its schema is empty or absent"
        if known:
            return Reading(functools.partial(_ours, message_type), trust=f"{what}: read by its type's hash")
        return Reading(refused=f"{what}, and no hash of ours tells its type")
    return _by_schema(name, channel.schema, message_type)


@functools.lru_cache(maxsize=64)
def _by_schema(name: str, schema: bytes, message_type: type) -> Reading:
    text = schema.decode(errors="replace")
    difference = compare(name, types_of(name, text), types_of(name, definition(name)))
    why = lacking(difference)
    if why:
        return Reading(refused=f"it was recorded with other message types ({why}): replay it with the version that made it", other=True)
    if difference.same:
        return Reading(functools.partial(_ours, message_type))
    try:
        decode = DecoderFactory().decoder_for("cdr", Schema(id=1, name=name, encoding="ros2msg", data=text.encode()))
    except Exception as error:  # of the parser, which is not ours; its exceptions have no common class
        return Reading(refused=f"its schema cannot be read ({type(error).__name__})", other=True)
    if decode is None:
        return Reading(refused="its schema cannot be read", other=True)
    return Reading(functools.partial(_theirs, decode, message_type), notes=tuple(words_of(difference)))


def _ours(message_type: type, data: bytes):
    _check(data)
    try:
        return deserialize_message(data, message_type)
    except _UNDECODABLE:
        raise Undecodable("damaged") from None


def _theirs(decode: Callable, message_type: type, data: bytes):
    _check(data)
    try:
        return message_of(decode(data), message_type)
    except (*_UNDECODABLE, AssertionError):
        raise Undecodable("damaged") from None


def _check(data: bytes) -> None:
    """Raises Undecodable where data cannot be a serialized message."""
    if data[:2] not in _CDR:
        compression = compression_of(data)
        how = "each by itself (`--compression-mode message`): convert them by `ros2 bag convert` to mcap without compression"
        raise Undecodable(f"compressed by {compression}, {how}" if compression else "no serialized messages")
