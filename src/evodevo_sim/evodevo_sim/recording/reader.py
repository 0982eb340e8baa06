"""Reads recordings, whole ones and those whose writer was killed or whose end is damaged."""

from __future__ import annotations

import os
import re
import struct
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from geometry_msgs.msg import PoseStamped
from mcap.exceptions import InvalidMagic, McapError
from mcap.reader import NonSeekingReader
from rclpy.serialization import deserialize_message
from zstandard import ZstdError

from evodevo_msgs import msg

from .definitions import RecordingError, definition, type_name

# What a missing end, or damage, can set off in the MCAP reader, decompression and ROS's deserialisation.
_DAMAGE = (McapError, ZstdError, struct.error, RuntimeError, ValueError, KeyError, EOFError, MemoryError)
_HOW = "give a directory that `evolve` or `ros2 bag record -s mcap` made"


@dataclass
class Recording:
    """The messages of a recording, in the order in which they were written; what it does not hold is None or empty.

    Attributes: settings: Evolution; statistics: GenerationStatistics; champions: Champion; audits: Audit, of those champions
    that the run got to; growth and states: CellStates; growth_bodies: Body, where the embryo's graph changed; body: Body;
    gait: Gait of the states; scene: Scene, of a walk by simulate; targets: PoseStamped; targets_from: for each of them, how many
    states came before it; truncated: whether the end is missing, or damaged.
    """

    path: Path
    settings: msg.Evolution | None = None
    statistics: list[msg.GenerationStatistics] = field(default_factory=list)
    champions: list[msg.Champion] = field(default_factory=list)
    audits: list[msg.Audit] = field(default_factory=list)
    growth: list[msg.CellStates] = field(default_factory=list)
    growth_bodies: list[msg.Body] = field(default_factory=list)
    body: msg.Body | None = None
    states: list[msg.CellStates] = field(default_factory=list)
    targets: list[PoseStamped] = field(default_factory=list)
    targets_from: list[int] = field(default_factory=list)
    gait: msg.Gait | None = None
    scene: msg.Scene | None = None
    truncated: bool = False


_LISTS = {
    "/evolution/statistics": ("statistics", msg.GenerationStatistics),
    "/evolution/champion": ("champions", msg.Champion),
    "/evolution/audit": ("audits", msg.Audit),
    "/growth/cell_states": ("growth", msg.CellStates),
    "/growth/body": ("growth_bodies", msg.Body),
    "/cell_states": ("states", msg.CellStates),
    "/target_pose": ("targets", PoseStamped),
}
_SINGLE = {
    "/evolution/settings": ("settings", msg.Evolution), "/body": ("body", msg.Body), "/gait": ("gait", msg.Gait),
    "/scene": ("scene", msg.Scene),
}


def read_recording(path: str | os.PathLike, progress: bool = False) -> Recording:
    """Read a recording, as far as it goes.

    Topics count whatever namespace they are in; of several animats the first one is read.

    Args: path: a directory with MCAP files, or one such file; progress: whether to show a bar on stderr when it takes long.
    Raises RecordingError.
    """
    recording = Recording(Path(path))
    wanted: dict[str, tuple[str, type, bool] | None] = {}
    for file in _files(recording.path):
        try:
            with open(file, "rb") as opened, _watched(opened, file, progress) as stream:
                for schema, channel, message in NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False):
                    if channel.topic not in wanted:
                        wanted[channel.topic] = _choose(channel.topic, schema, file, wanted)
                    if wanted[channel.topic]:
                        _keep(recording, message.data, *wanted[channel.topic])
        except RecordingError:
            raise
        except OSError as error:
            raise RecordingError(f"{file}: {error.strerror}: {_HOW}") from None
        except InvalidMagic:
            if not wanted and not _begins_as_mcap(file):
                raise RecordingError(f"{file} is not an MCAP file: {_HOW}") from None
            recording.truncated = True
        except _DAMAGE:
            recording.truncated = True
    if not any(wanted.values()):
        what = "is cut or damaged before its first message" if recording.truncated else "holds nothing of evodevo's"
        raise RecordingError(f"{recording.path} {what}: {_HOW}")
    return recording


def _watched(stream, file: Path, progress: bool):
    """A context: the stream, with a bar once reading has taken two seconds."""
    if not progress:
        return nullcontext(stream)
    from tqdm import tqdm

    return tqdm.wrapattr(stream, "read", total=file.stat().st_size, desc=f"Reading {file.name}", delay=2, leave=False)


def _files(path: Path) -> list[Path]:
    if os.path.isfile(path):
        return [path]
    if not os.path.isdir(path):
        raise RecordingError(f"{path} does not exist: {_HOW}")
    files = sorted(path.glob("*.mcap"), key=lambda file: (len(file.name), file.name))  # run_2 before run_10
    if not files:
        raise RecordingError(f"{path} holds no .mcap file: {_HOW}")
    return files


def _begins_as_mcap(file: Path) -> bool:
    with open(file, "rb") as stream:
        return stream.read(5) == b"\x89MCAP"


def _choose(topic, schema, file, wanted):
    """Where the messages of a topic go: (attribute, type, whether it is a list), or None."""
    for table, many in ((_LISTS, True), (_SINGLE, False)):
        ending = next((e for e in sorted(table, key=len, reverse=True) if topic.endswith(e)), None)
        if ending is None:
            continue
        attribute, message_type = table[ending]
        if any(choice and choice[0] == attribute for choice in wanted.values()):
            return None
        ours = definition(type_name(message_type))
        if schema is None or _words(schema.data.decode(errors="replace")) != _words(ours):
            how = "replay it with the version that made it"
            raise RecordingError(f"{file}: {topic} was recorded with other message types: {how}")
        return attribute, message_type, many
    return None


def _words(text: str) -> list[str]:
    """A message type's definition without its comments."""
    return re.sub(r"#.*", "", text).split()


def _keep(recording, data, attribute, message_type, many):
    message = deserialize_message(data, message_type)
    if many:
        getattr(recording, attribute).append(message)
        if attribute == "targets":
            recording.targets_from.append(len(recording.states))
    else:
        setattr(recording, attribute, message)
