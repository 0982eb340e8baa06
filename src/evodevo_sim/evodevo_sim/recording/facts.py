"""What a recording is, in facts: who made it, of what, how it ended, what it holds."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..analysis.stretches import holes
from ..ros.topics import Topic, role_of
from . import Recording, RecordingError, read_recording
from .decoding import reading_of
from .life import Life, life_of
from .storage import files_of, messages_of
from .stored import Channel, Damage


@dataclass(frozen=True)
class Facts:
    """Of one recording.

    Attributes:
        recording; life; files: their paths; bytes: of all of them.
        topics: (topic, type, messages, whether it is read here) of each channel, in the order of the file.
        began, ended: ns of the first and last message.
        metadata: whether its directory has a `metadata.yaml`, which is written last.
        holes: damaged places in the middle.
    """

    recording: Recording
    life: Life
    files: list[Path]
    bytes: int
    topics: list[tuple[str, str, int, bool]]
    began: int
    ended: int
    metadata: bool
    holes: list[str] = field(default_factory=list)

    @property
    def ending(self) -> tuple[str, str]:
        """(one word, in words): `complete`; `cut`, without its end; `torn`, damaged in the middle; `unfinished`, where its writer was."""
        recording = self.recording
        if self.holes:
            more = f" and {len(self.holes) - 1} more" if len(self.holes) > 1 else ""
            return "torn", f"torn: {self.holes[0]}{more} cannot be read, what lies around it can"
        if recording.truncated:
            return "cut", "cut: its end is missing, e.g. because its writer was killed; what was saved before can be read"
        if not self.metadata:
            return "unfinished", "unfinished: metadata.yaml is missing, which is written last; the file itself is whole"
        if recording.settings is not None and not recording.states:
            return "unfinished", "unfinished: the run was ended before its champion's life was recorded"
        if len(holes(self.life.time)):
            return "torn", "complete, but states are missing in the middle of the life"
        return "complete", "complete"


def facts_of(path: str | os.PathLike) -> Facts:
    """The facts of a recording.  Raises RecordingError where it is none, holds nothing of evodevo's, or cannot be read."""
    place = Path(path)
    recording = read_recording(place, progress=True)
    files, damage = files_of(place), Damage()
    counts: Counter[Channel] = Counter()
    began, ended = 2**63, 0
    for file in files:
        for one in messages_of(file, damage):
            counts[one.channel] += 1
            began, ended = min(began, one.log_time), max(ended, one.log_time)
    topics = [(channel.topic, channel.type, count, _is_read(channel)) for channel, count in counts.items()]
    metadata = not place.is_dir() or (place / "metadata.yaml").is_file()
    try:
        life = life_of(recording)
    except RecordingError as error:
        recording.notes.append(str(error))
        life = Life(np.empty(0), [], [], np.empty(0), np.empty((0, 0, 2)), np.empty((0, 0)))
    return Facts(recording, life, files, sum(file.stat().st_size for file in files), topics, began, ended, metadata, damage.holes)


def _is_read(channel: Channel) -> bool:
    entry: Topic | None = role_of(channel.topic)
    if entry is None or not entry.attribute:
        return False
    reading = reading_of(channel, entry.type)
    return reading is not None and reading.decode is not None


def writer_of(path: Path) -> str:
    """Who wrote it, by its metadata: the distribution of ROS and the version of the form; nothing where it does not say."""
    try:
        about = yaml.safe_load((path / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        return f"ROS 2 {about['ros_distro']}, rosbag2 metadata {about['version']}"
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError):
        return ""


def moment(nanoseconds: int) -> str:
    """A time in words, or as seconds where it is no date, as of a recording in simulated time."""
    if nanoseconds < 10**17:
        return f"{nanoseconds * 1e-9:.3f} s"
    return datetime.fromtimestamp(nanoseconds * 1e-9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def purposes(recording: Recording, life: Life) -> dict[str, str]:
    """Of each purpose of `replay --show`: nothing where the recording serves it, or else what is missing."""
    lives, grew = len(life.time) > 0, len(life.growth) > 1
    network = bool(recording.champions) and recording.settings is not None
    thinks = "no motion of a body" if network else "no run with a champion, whose genome would tell the network"
    return {
        "watch": "" if lives or life.growth else "no growth and no motion of a body",
        "grow": "" if grew else "no growth",
        "think": "" if lives and network else thinks,
        "evolve": "" if recording.statistics else "no generations of a run",
    }


def numbers(recording: Recording) -> dict[str, Any]:
    """How many of each kind of message it holds."""
    kinds = ("statistics", "champions", "audits", "growth", "states", "actuation", "targets")
    return {kind: len(getattr(recording, kind)) for kind in kinds}
