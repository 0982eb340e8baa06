"""What a recording says of its messages: the text and hash of their types, as rosbag2 writes them."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

from ament_index_python.packages import get_package_share_directory

from ..inputs import InputError

HOW = "give a directory that `evolve` or `ros2 bag record -s mcap` made"  # the mend of what is no recording

_SEPARATOR = "=" * 80
_BUILT_IN = r"(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string)\b"
_FIELD = re.compile(r"^([A-Za-z][\w/]*)(<=\d+)?(\[[^\]]*\])?\s+[a-z]\w*")


class RecordingError(InputError, RuntimeError):
    """A recording that cannot be written or read; the message says which, why, and what to do."""


def type_name(message_type: type) -> str:
    """The name of a message class, e.g. `evodevo_msgs/msg/Body`."""
    package, _, _ = message_type.__module__.partition(".")
    return f"{package}/msg/{message_type.__name__}"


@functools.cache
def definition(name: str) -> str:
    """The text of a message type, then of those that it is made of, breadth-first (MCAP's `ros2msg`)."""
    texts, queue = {}, [name]
    while queue:
        current = queue.pop(0)
        if current not in texts:
            texts[current] = _share(current, "msg").read_text(encoding="utf-8").rstrip("\n")
            queue += _parts(current, texts[current])
    first, *others = texts.items()
    return "".join([first[1] + "\n", *(f"{_SEPARATOR}\nMSG: {n.replace('/msg/', '/')}\n{text}\n" for n, text in others)])


@functools.cache
def type_hash(name: str) -> str:
    """The RIHS01 hash of a message type."""
    described = json.loads(_share(name, "json").read_text(encoding="utf-8"))
    return next(entry["hash_string"] for entry in described["type_hashes"] if entry["type_name"] == name)


def _share(name: str, suffix: str) -> Path:
    package, _, stem = name.partition("/msg/")
    return Path(get_package_share_directory(package), "msg", f"{stem}.{suffix}")


def _parts(name: str, text: str) -> list[str]:
    """Names of the message types that the fields of a message have."""
    package = name.partition("/")[0]
    kinds = [match[1] for line in text.splitlines() if (match := _FIELD.match(line)) and not re.match(_BUILT_IN, match[1])]
    return [f"{owner or package}/msg/{stem}" for owner, _, stem in (kind.replace("/msg/", "/").rpartition("/") for kind in kinds)]
