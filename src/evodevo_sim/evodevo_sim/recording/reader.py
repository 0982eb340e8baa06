"""Reads recordings, of any writer, whole ones and damaged ones, in the order of time."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from geometry_msgs.msg import PoseStamped

from evodevo_msgs import msg

from ..ros.topics import CELL_STATES, SETTINGS, Topic, namespace_of, role_of
from .decoding import Reading, Undecodable, reading_of
from .definitions import HOW, RecordingError
from .older import named
from .ordering import lives
from .storage import files_of, messages_of
from .stored import Channel, Damage, Stored

_LONGEST = 290  # characters of a note
_TRIES = 3  # messages of a topic that are tried where none can be read


@dataclass
class Recording:
    """The messages of a recording, in the order of time; what it does not hold is None or empty.

    Attributes: settings: Evolution; statistics: GenerationStatistics; champions: Champion; audits: Audit, of those champions
    that the run got to; growth and states: CellStates, actuation: Actuation, of each life by their stamps; growth_bodies: Body, where
    the embryo's graph changed; body: Body; gait: Gait of the states; scene: Scene, of a walk by simulate; targets: PoseStamped;
    worker: Worker, of a simulator, where somebody recorded it;
    state_times and target_times: ns, when each was recorded; truncated: whether the end is missing, or damaged; notes: what else must
    be known of what was read, a line each; unread: why messages of ours were not, by attribute.
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
    state_times: list[int] = field(default_factory=list)
    actuation: list[msg.Actuation] = field(default_factory=list)
    targets: list[PoseStamped] = field(default_factory=list)
    target_times: list[int] = field(default_factory=list)
    gait: msg.Gait | None = None
    scene: msg.Scene | None = None
    worker: msg.Worker | None = None
    truncated: bool = False
    notes: list[str] = field(default_factory=list)
    unread: dict[str, str] = field(default_factory=dict)


def read_recording(path: str | os.PathLike, progress: bool = False) -> Recording:
    """Read a recording, as far as it goes.

    What a message is, its type and the end of its topic's name say, in whatever namespace; of several animats the first one is
    read, of several runs the last.

    Args: path: a directory with MCAP or SQLite files, or one such file; progress: whether to show a bar on stderr when it takes long.
    Raises RecordingError.
    """
    recording, damage = Recording(Path(path)), Damage()
    collected = _Collected(recording)
    for file in files_of(recording.path):
        collected.take(file, messages_of(file, damage, progress))
    recording.truncated = bool(damage.cut)
    if damage.cut:
        _note(recording, f"{damage.cut}: what was saved before it is read")
    if damage.holes:
        more = f" and {len(damage.holes) - 1} more places" if len(damage.holes) > 1 else ""
        _note(recording, f"{damage.holes[0]}{more} cannot be read: there is a hole in the middle, the rest is read")
    collected.give()
    return recording


def _note(recording: Recording, text: str) -> None:
    recording.notes.append(text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "...")


_Bad = Counter[tuple[str, str]]  # messages that cannot be read, by topic and why


class _Collected:
    """What the files hold of ours: the messages of each channel, as bytes."""

    def __init__(self, recording: Recording):
        self._recording = recording
        self._roles: dict[Channel, tuple[Topic, Reading] | None] = {}
        self._decoders: dict[Channel, Callable] = {}  # of the channels that have a role
        self._messages: dict[Topic, dict[str, list[tuple[int, Stored]]]] = {}  # by namespace, with their places in the files
        self._seen: set = set()
        self._count = 0

    def take(self, file: Path, messages) -> None:
        repeated = own = 0
        for one in messages:
            channel = one.channel
            if channel not in self._roles:
                self._roles[channel] = self._role(channel)
            role = self._roles[channel]
            if role is None:
                continue
            key = (channel.topic, one.log_time, one.data)
            own, size = own + 1, len(self._seen)
            self._seen.add(key)
            if len(self._seen) == size:
                repeated += 1
                continue
            place = self._messages.setdefault(role[0], {}).setdefault(namespace_of(channel.topic, role[0]), [])
            place.append((self._count, one))
            self._count += 1
        if repeated:
            what = "repeats messages of another file" if repeated == own else f"holds {repeated} messages a second time"
            _note(self._recording, f"{file} {what}: each is read once")

    def _role(self, channel: Channel) -> tuple[Topic, Reading] | None:
        entry = role_of(channel.topic)
        if entry is None:
            return None
        reading = reading_of(channel, entry.type)
        if reading is None:
            return None
        if reading.decode is None:
            self._recording.unread.setdefault(entry.attribute, f"{channel.topic}: {reading.refused}")
            return None
        self._decoders[channel] = reading.decode
        return entry, reading

    def give(self) -> None:
        """Decode what is to be read, into the recording.  Raises RecordingError where there is nothing."""
        recording, self._seen = self._recording, set()
        chosen = self._chosen()
        begin, bad = self._begin_of_run(chosen), _Bad()
        for entry, messages in chosen.items():
            kept = self._decoded(entry, (one for one in messages if one[1].log_time >= begin), bad)
            if not kept:
                continue
            if not entry.many:
                setattr(recording, entry.attribute, kept[-1][1])
                continue
            if entry.lives:
                kept = [kept[k] for life in lives([_stamp(m) for _, m in kept], [t for t, _ in kept]) for k in life]
            setattr(recording, entry.attribute, [message for _, message in kept])
            if entry.attribute in ("states", "targets"):
                setattr(recording, entry.attribute[:-1] + "_times", [time for time, _ in kept])
        task = "" if recording.settings is None else recording.settings.task.name
        for audit in recording.audits:
            named(audit, task)
        self._tell(bad)

    def _chosen(self) -> dict[Topic, list[tuple[int, Stored]]]:
        """Of each role the messages of one namespace: those of the animat whose states come first, or else those that come first."""
        begins = {
            entry: {namespace: min((one.log_time, namespace) for _, one in messages) for namespace, messages in found.items()}
            for entry, found in self._messages.items()
        }
        animats = begins.get(CELL_STATES, {})
        first = min(animats, key=animats.__getitem__, default=None)
        if len(animats) > 1:
            _note(self._recording, f"{self._recording.path} holds {len(animats)} animats: {first or '/'}, the first one, is read")
        chosen = {}
        for entry, found in self._messages.items():
            free = [name for name in found if not entry.animat or name == first or name not in animats]
            best = first if entry.animat and first in found else min(free, key=begins[entry].__getitem__, default=None)
            if best is not None:
                chosen[entry] = sorted(found[best], key=lambda one: (one[1].log_time, one[0]))
        return chosen

    def _begin_of_run(self, chosen) -> int:
        """ns, when the last of several runs in one directory began."""
        settings = chosen.get(SETTINGS, [])
        if len({self._without_limits(one) for _, one in settings}) < 2:
            return -(2**63)
        _note(self._recording, f"{self._recording.path} holds {len(settings)} runs: the last one is read")
        return settings[-1][1].log_time

    def _without_limits(self, one: Stored) -> bytes | str:
        """The settings of a run but for its limits, which may be raised when it is resumed: that begins no other run."""
        try:
            settings = self._decoders[one.channel](one.data)
        except Undecodable:
            return one.data
        settings.generations = settings.patience = 0
        return repr(settings)

    def _decoded(self, entry: Topic, messages, bad: _Bad) -> list[tuple[int, object]]:
        kept: list[tuple[int, object]] = []
        failed: tuple[str, str] | None = None
        for _, one in messages:
            if failed and not kept and bad[failed] >= _TRIES:
                bad[failed] += 1
                continue
            try:
                kept.append((one.log_time, self._decoders[one.channel](one.data)))
            except Undecodable as error:
                failed = (one.channel.topic, str(error))
                bad[failed] += 1
                self._recording.unread.setdefault(entry.attribute, f"the messages of {one.channel.topic} are {error}")
        if kept:
            self._recording.unread.pop(entry.attribute, None)
        return kept

    def _tell(self, bad: _Bad) -> None:
        """Notes on how messages were read, and on those that were not.  Raises RecordingError where none were."""
        recording = self._recording
        readings = [(channel, role[1]) for channel, role in self._roles.items() if role]
        whole = any(getattr(recording, entry.attribute) for entry in self._messages)
        if not whole:
            if recording.unread:
                raise RecordingError(f"{recording.path}: {next(iter(recording.unread.values()))}"[:_LONGEST])
            what = "is cut or damaged before its first message" if recording.notes else "holds nothing of evodevo's"
            raise RecordingError(f"{recording.path} {what}: {HOW}")
        for (topic, why), count in bad.items():
            if (entry := role_of(topic)) and entry.attribute not in recording.unread:
                _note(recording, f"{count} messages of {topic} are left out: {why}")
        versions = list(dict.fromkeys(note for _, reading in readings for note in reading.notes))
        if versions:
            _note(recording, f"{recording.path} was recorded by another version: {', '.join(versions)}")
        trust = list(dict.fromkeys(reading.trust for _, reading in readings if reading.trust))
        for why in trust:
            topics = [channel.topic for channel, reading in readings if reading.trust == why]
            more = f" and {len(topics) - 1} more" if len(topics) > 1 else ""
            _note(recording, f"{topics[0]}{more}: {why}")
        for attribute, why in recording.unread.items():
            if not getattr(recording, attribute):
                _note(recording, f"left out: {why}")


def _stamp(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
