"""What a report tells of a run, read from its directory."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from evodevo_sim.analysis.gait.analysis import Gait
from evodevo_sim.parameters import ParameterError, Task
from evodevo_sim.recording import Recording, RecordingError, read_recording
from evodevo_sim.recording.gait import gait_of_recording
from evodevo_sim.recording.life import Life, life_of
from evodevo_sim.ros.messages import task_from_message
from evodevo_sim.view.summary import name_of

from ..settings import Settings
from .descent import Ancestor, descent_of


@dataclass(frozen=True, eq=False)
class Run:
    """name; path; recording; life of the champion; task, settings: None where this version cannot take them; gait, or None;
    ancestors of the champion, newest first, where there is a history; notes: what must be known, a line each."""

    name: str
    path: Path
    recording: Recording
    life: Life
    task: Task | None
    settings: Settings | None
    gait: Gait | None
    ancestors: list[Ancestor] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def told(self) -> Any:
        """The message Evolution: what the run was."""
        return self.recording.settings

    @property
    def champion(self) -> Any:
        """The last message Champion, or None."""
        return self.recording.champions[-1] if self.recording.champions else None

    def audit_of(self, generation: int) -> Any:
        """The last message Audit of the champion of a generation, or None."""
        return next((audit for audit in reversed(self.recording.audits) if audit.generation == generation), None)


def read_run(path: Path) -> Run:
    """Read a run as far as it goes.  Raises RecordingError."""
    recording = read_recording(path)
    for attribute in ("settings", "statistics"):
        if attribute in recording.unread and not getattr(recording, attribute):
            raise RecordingError(f"{path}: {recording.unread[attribute]}")
    told = recording.settings
    if told is None or not recording.statistics:
        missing = "settings" if told is None else "generations"
        film = f"`film {path}` shows what moves in it" if recording.states or recording.growth else "there is nothing in it to draw"
        raise RecordingError(f"{path} holds no {missing} of a run: give a directory that evolve made; {film}")
    notes = list(recording.notes)
    task = settings = None
    try:
        task, settings = task_from_message(told.task), settings_of(told)
    except ParameterError as error:
        notes.append(f"its settings are not of this version: {error}")
    life = life_of(recording)
    ancestors, said = descent_of(path)
    return Run(name_of(path), path, recording, life, task, settings, gait_of_recording(recording, life), ancestors, notes + said)


def settings_of(told: Any) -> Settings:
    """The numbers of the search of a message Evolution.  Raises ParameterError."""
    return Settings(**{name: getattr(told, name) for name in Settings.__dataclass_fields__})
