"""What driver and firmware say to each other on a serial line (docs/reference/protocol.md).

A frame is a message and the CRC-32 of it, stuffed by COBS, between two zero bytes, so that what was garbage before it harms it not;
numbers are little-endian.  A message is a byte
that tells its kind, and fields as the classes below have them.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from enum import IntEnum, IntFlag

import numpy as np
from cobs import cobs

VERSION = 1
MOST_CHANNELS = 255
MOST_FRAME = 4096  # bytes between two zeros; a state of 255 channels and markers has 3,100
_CHECK = struct.Struct("<I")
_UINT8, _UINT16, _UINT32 = 0xFF, 0xFFFF, 0xFFFFFFFF


class FrameError(ValueError):
    """Bytes that are no frame, or a frame that is no message; the message says in one line why."""


class Mode(IntEnum):
    """What the valves do."""

    VENTED = 0  # all open; commands are refused until the firmware is armed
    ARMED = 1
    STOPPED = 2  # vented by an emergency stop or by too much pressure; arming again is up to a person


class Fault(IntFlag):
    """Why the firmware vented, or what it noticed; a bit stays until the next arming."""

    NONE = 0
    SILENCE = 1  # no command came within the watchdog's time
    PRESSURE = 2  # a channel was above its limit
    STOP = 4  # an emergency stop was asked for, by the host or by a button
    COMMAND = 8  # a command with another number of channels, or a level that is not finite
    RESTART = 16  # the firmware has begun anew


@dataclass(frozen=True)
class Hello:
    """Host: asks who is there.  version: of the protocol that the host speaks, from 0 to 255."""

    version: int = VERSION


@dataclass(frozen=True)
class Welcome:
    """Firmware: who it is.  boot: number of this start; watchdog: ms of silence after which it vents; name: up to 32 bytes of UTF-8."""

    version: int
    channels: int
    markers: int
    boot: int
    watchdog: int
    name: str


@dataclass(frozen=True)
class Arm:
    """Host: close the valves and take commands, or vent and take none."""

    on: bool
    person: bool = False  # whether a person asked for it, which STOPPED needs


@dataclass(frozen=True)
class Stop:
    """Host: emergency stop.  The firmware vents, and stays so until a person arms it."""


@dataclass(frozen=True, eq=False)
class Command:
    """Host: a level for every channel, in the unit of the calibration.  sequence: 0 to 65535, one more each time, then from 0."""

    sequence: int
    levels: np.ndarray = field(repr=False)  # (channels,) float32


@dataclass(frozen=True, eq=False)
class State:
    """Firmware: the body at one instant.

    Attributes: sequence: 0 to 65535; time: us of the firmware's clock at which markers and pressures were measured, modulo 2^32; executed:
    sequence of the last command that was carried out; pressure (channels,) float32, in the unit of the calibration; marker (markers, 2)
    float32, in the unit of the calibration, NaN where it is lost.
    """

    sequence: int
    time: int
    executed: int
    mode: Mode
    fault: Fault
    pressure: np.ndarray = field(repr=False)
    marker: np.ndarray = field(repr=False)


def alike(one: Message, other: Message) -> bool:
    """Whether two messages say the same, NaN counting as equal to NaN."""
    if type(one) is not type(other):
        return False
    pairs = ((getattr(one, item.name), getattr(other, item.name)) for item in fields(one))
    return all(np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b for a, b in pairs)


Message = Hello | Welcome | Arm | Stop | Command | State
_HELLO, _ARM, _COMMAND, _STOP, _WELCOME, _STATE = 0x01, 0x02, 0x03, 0x04, 0x81, 0x82
_WELCOME_FIELDS, _STATE_FIELDS = struct.Struct("<BBBIH"), struct.Struct("<HIHBBBB")
MOST_NAME = 32  # bytes


def encode(message: Message) -> bytes:
    """The frame of a message.  Raises FrameError where a field is out of its range."""
    try:
        plain = _plain(message)
    except (struct.error, OverflowError) as error:
        raise FrameError(f"{type(message).__name__} with a field out of range: {error}") from None
    return b"\0" + cobs.encode(plain + _CHECK.pack(zlib.crc32(plain))) + b"\0"


def _plain(message: Message) -> bytes:
    match message:
        case Hello(version):
            return struct.pack("<BB", _HELLO, version)
        case Arm(on, person):
            return struct.pack("<BBB", _ARM, on, person)
        case Stop():
            return struct.pack("<B", _STOP)
        case Command(sequence, levels):
            values = np.ascontiguousarray(levels, "<f4")
            return struct.pack("<BHB", _COMMAND, sequence, values.size) + values.tobytes()
        case Welcome(version, channels, markers, boot, watchdog, name):
            text = name.encode()[:MOST_NAME]
            return struct.pack("<B", _WELCOME) + _WELCOME_FIELDS.pack(version, channels, markers, boot, watchdog) + text
        case State():
            pressure, marker = np.ascontiguousarray(message.pressure, "<f4"), np.ascontiguousarray(message.marker, "<f4")
            head = _STATE_FIELDS.pack(
                message.sequence, message.time & _UINT32, message.executed, message.mode, message.fault, pressure.size, len(marker)
            )
            return struct.pack("<B", _STATE) + head + pressure.tobytes() + marker.tobytes()
    raise FrameError(f"{type(message).__name__} is no message")


def decode(frame: bytes) -> Message:
    """The message of a frame without its zero byte.  Raises FrameError: nothing that is not whole is taken for a message."""
    try:
        stuffed = cobs.decode(frame)
    except cobs.DecodeError:
        raise FrameError("no COBS") from None
    plain, check = stuffed[: -_CHECK.size], stuffed[-_CHECK.size :]
    if len(check) < _CHECK.size or not plain:
        raise FrameError(f"{len(stuffed)} bytes, too few")
    if _CHECK.unpack(check)[0] != zlib.crc32(plain):
        raise FrameError("wrong checksum")
    try:
        return _message(plain[0], plain[1:])
    except struct.error as error:
        raise FrameError(f"kind {plain[0]:#x} with {len(plain) - 1} bytes: {error}") from None


def _message(kind: int, rest: bytes) -> Message:
    if kind == _HELLO:
        return Hello(*struct.unpack("<B", rest))
    if kind == _ARM:
        on, person = struct.unpack("<BB", rest)
        return Arm(bool(on), bool(person))
    if kind == _STOP:
        struct.unpack("", rest)
        return Stop()
    if kind == _COMMAND:
        sequence, channels = struct.unpack_from("<HB", rest)
        return Command(sequence, _floats(rest[3:], channels))
    if kind == _WELCOME:
        version, channels, markers, boot, watchdog = _WELCOME_FIELDS.unpack_from(rest)
        return Welcome(version, channels, markers, boot, watchdog, rest[_WELCOME_FIELDS.size :][:MOST_NAME].decode(errors="replace"))
    if kind == _STATE:
        sequence, time, executed, mode, fault, channels, markers = _STATE_FIELDS.unpack_from(rest)
        if mode not in Mode.__members__.values():
            raise FrameError(f"a state in mode {mode}")
        values = _floats(rest[_STATE_FIELDS.size :], channels + 2 * markers)
        return State(sequence, time, executed, Mode(mode), Fault(fault & 31), values[:channels], values[channels:].reshape(-1, 2))
    raise FrameError(f"kind {kind:#x}")


def _floats(rest: bytes, count: int) -> np.ndarray:
    if len(rest) != 4 * count:
        raise struct.error(f"{len(rest)} bytes in place of {count} floats")
    return np.frombuffer(rest, "<f4").astype(np.float32)


class Parser:
    """Finds messages in a stream of bytes, however it is cut, and begins anew after whatever is none.

    Attributes: damaged: frames that were none; why: of the last one.
    """

    def __init__(self) -> None:
        self.damaged, self.why = 0, ""
        self._rest = bytearray()
        self._skips = False  # until the next zero: what came was too long for a frame

    def feed(self, data: bytes) -> Iterator[Message]:
        """Take bytes as they come.  Yields: the messages that are whole by then."""
        self._rest += data
        *frames, rest = self._rest.split(b"\0")
        self._rest = bytearray(rest)
        for frame in frames:
            if self._skips or len(frame) > MOST_FRAME:
                self._skips = False
                self._count("a frame too long")
            elif frame:
                try:
                    yield decode(bytes(frame))
                except FrameError as error:
                    self._count(str(error))
        if len(self._rest) > MOST_FRAME:
            self._rest.clear()
            self._skips = True

    def _count(self, why: str) -> None:
        self.damaged, self.why = self.damaged + 1, why


def after(sequence: int) -> int:
    """The sequence number that follows."""
    return (sequence + 1) & _UINT16


def lost_between(last: int, this: int) -> int:
    """How many numbers are missing between two that came one after the other; 0 where this one is late."""
    gap = (this - last - 1) & _UINT16
    return gap if gap < 0x8000 else 0
