"""What commands take for GENOME|BAG: a genome file with a task of its own, or the last champion of a run in the task of the run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ..genetics.genome import Genome
from ..genetics.genome_file import read_genome
from ..parameters import ParameterError, Task
from ..ros.messages import genome_from_message, task_from_message
from . import RecordingError, is_recording, read_recording


@dataclass(frozen=True)
class Champion:
    """name; genome; task; seed; fitness as recorded, or None; hardware: name of the body on which it was recorded, if that is one."""

    name: str
    genome: Genome
    task: Task
    seed: int = 0
    fitness: float | None = None
    hardware: str = ""


def champion_of(
    source: str | os.PathLike, settings: Mapping[str, object], task_name: str = "swim", say: Callable[[str], None] = lambda line: None
) -> Champion:
    """The champion of a genome file or a recording.

    Args: settings: of the task of a genome file, which is the default one of `task_name` with growth as the file says; say: called with
        each line that must be known of a recording, e.g. that its end is missing.
    Raises GenomeError, ParameterError or RecordingError.
    """
    path = Path(source)
    name = Path(os.path.realpath(path)).name
    if not is_recording(path):
        file = read_genome(path)
        return Champion(path.stem, file.genome, file.task(task_name, settings))
    if settings:
        raise ParameterError("--set is for a genome file, as --plant is: a recording names its own task")
    recording = read_recording(path)
    for attribute in ("settings", "champions"):
        if attribute in recording.unread and not getattr(recording, attribute):
            raise RecordingError(f"{path}: {recording.unread[attribute]}")
    if recording.settings is None or not recording.champions:
        raise RecordingError(f"{path} holds no champion: give a run of evolve, or a genome file")
    for line in recording.notes:
        say(line)
    champion, run = recording.champions[-1], recording.settings
    genome, task = genome_from_message(champion.genome), task_from_message(run.task)
    hardware = recording.channels.name or "body" if recording.channels is not None else ""
    return Champion(name, genome, task, run.seed, champion.evaluation.fitness, hardware)
