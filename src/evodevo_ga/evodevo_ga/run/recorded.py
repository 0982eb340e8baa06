"""What the recording of a run already holds, before it goes on: no generation is to be in it twice, and none is to be missing."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from evodevo_sim.recording.parts import files_of_recorder
from evodevo_sim.recording.storage import messages_of
from evodevo_sim.recording.stored import Damage
from evodevo_sim.ros.topics import AUDIT, CELL_STATES, CHAMPION, STATISTICS, role_of
from rclpy.serialization import deserialize_message


@dataclass
class Recorded:
    """statistics: ns, when each generation was recorded; champions: generations of those recorded; audits: messages by generation;
    lived: whether the life of a champion stands behind the last generation, whole."""

    statistics: dict[int, int] = field(default_factory=dict)
    champions: set[int] = field(default_factory=set)
    audits: dict[int, Any] = field(default_factory=dict)
    lived: bool = False


def recorded_in(directory: Path) -> Recorded:
    """What the recording in a directory holds, as far as it can be read.  Raises RecordingError."""
    found, damage = Recorded(), Damage()
    for file in files_of_recorder(directory):
        for one in messages_of(file, damage):
            entry = role_of(one.channel.topic)
            if entry == CELL_STATES:
                found.lived = True
            if entry not in (STATISTICS, CHAMPION, AUDIT):
                continue
            message = deserialize_message(one.data, entry.type)
            if entry == STATISTICS:
                found.statistics[message.generation] = one.log_time
                found.lived = False
            elif entry == CHAMPION:
                found.champions.add(message.generation)
            else:
                found.audits[message.generation] = message
    found.lived = found.lived and not (damage.cut or damage.holes)
    return found
