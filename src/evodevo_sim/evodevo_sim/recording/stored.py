"""What every storage gives a reader: messages as bytes, with what the file says of their types; and what is wrong with the file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class Channel(NamedTuple):
    """topic; type: e.g. `evodevo_msgs/msg/Body`, or nothing; encoding: of the messages, e.g. `cdr`; schema_encoding, schema: the
    type's definition and its language, or nothing; type_hash: RIHS01, or nothing."""

    topic: str
    type: str
    encoding: str
    schema_encoding: str
    schema: bytes
    type_hash: str


class Stored(NamedTuple):
    """A message.  log_time: ns, when it was recorded."""

    channel: Channel
    log_time: int
    data: bytes


@dataclass
class Damage:
    """Of the files of a recording.  cut: why the end is missing, or nothing; holes: damaged places with sound ones behind them."""

    cut: str = ""
    holes: list[str] = field(default_factory=list)
