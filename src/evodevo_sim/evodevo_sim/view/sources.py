"""What commands that draw take for GENOME|BAG: the life of a recording, or the one that a genome lives."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..analysis.gait.sources import parts_of_body, track_of_performance
from ..analysis.gait.track import Track
from ..genetics.genome_file import read_genome
from ..parameters import ParameterError, Task
from ..recording import Recording, RecordingError, is_recording, read_recording
from ..recording.life import Life, Pose, life_of
from ..ros.messages import genome_from_message, task_from_message
from ..tasks.evaluation import Performance, perform
from .summary import BETWEEN, headline, name_of

_NONE = np.empty((0, 2), int)


@dataclass(frozen=True, eq=False)
class Shown:
    """name; about: it, in a line; life; recording: where it is from, or None of a genome; track: of a life that was lived anew."""

    name: str
    about: str
    life: Life
    recording: Recording | None = None
    track: Track | None = None


def shown_of(
    source: str | os.PathLike, settings: Mapping[str, object] | None = None, task_name: str = "swim",
    say: Callable[[str], None] = lambda line: None,
) -> Shown:
    """What there is to draw of a genome file or a recording.

    A run that was ended before its champion was recorded alive is shown by its last champion, which lives anew.

    Args: settings, task_name: of a genome file, as for `champion_of`; say: called with each line that must be known.
    Raises GenomeError, ParameterError or RecordingError.
    """
    path = Path(source)
    if not is_recording(path):
        file = read_genome(path)
        task = file.task(task_name, settings)
        performance = perform(file.genome, task)
        return _lived(path.stem, performance, task, say)
    if settings:
        raise ParameterError("--set is for a genome file, as --plant is: a recording names its own task")
    recording = read_recording(path)
    for line in recording.notes:
        say(line)
    life = life_of(recording)
    if not len(life.time) and recording.champions and recording.settings is not None:
        say(f"{path} holds no life: its last champion lives anew")
        task = task_from_message(recording.settings.task)
        performance = perform(genome_from_message(recording.champions[-1].genome), task, recording.settings.seed)
        return _lived(name_of(path), performance, task, say, recording)
    name, about = headline(recording, life)
    return Shown(name, about, life, recording)


def _lived(name: str, performance: Performance, task: Task, say: Callable[[str], None], recording: Recording | None = None) -> Shown:
    failed = performance.body is None or performance.evaluation.cause
    track = None if failed else track_of_performance(performance, task)
    return Shown(name, _about(performance, task, say), life_of_performance(performance, task), recording, track)


def need_life(shown: Shown, source: str | os.PathLike, what: str, growth: bool = True) -> None:
    """Raise RecordingError where there is nothing that moves, or with `growth` grows, to draw.  Args: what: is to be drawn."""
    life = shown.life
    if len(life.time) or (growth and any(len(pose.position) for pose in life.growth)):
        return
    others = [name for name, there in (("growth", bool(life.growth)), ("fitness", _has_generations(shown))) if there]
    instead = f"draw `figure {' or '.join(others)}` of it instead" if others else "there is nothing else in it to draw either"
    raise RecordingError(f"{source} holds no states of a body, which {what} needs: {instead}")


def _has_generations(shown: Shown) -> bool:
    return shown.recording is not None and bool(shown.recording.statistics)


def _about(performance: Performance, task: Task, say: Callable[[str], None]) -> str:
    found = performance.evaluation
    if found.cause:
        say(f"the animat fails: {found.cause}; what came before is shown")
    facts = [task.name, f"fitness {found.fitness:.3f}", f"{found.metrics.cells} cells, {found.metrics.chambers} chambers"]
    return BETWEEN.join([*facts, f"failed: {found.cause}" if found.cause else f"{found.metrics.distance:.2f} cell diameters"])


def life_of_performance(performance: Performance, task: Task) -> Life:
    """The life of `perform`, as `life_of` has that of its recording."""
    alive = [np.isfinite(position[:, 0]) for position in performance.growth]
    step = float(performance.time[1])
    growth = [
        Pose(position[there], activation[there]) for position, activation, there
        in zip(performance.growth, performance.growth_activation, alive)
    ]
    sound = np.zeros(len(performance.time), bool)
    parts = {}
    if performance.body is not None:
        sound, parts = np.isfinite(performance.position[:, 0, 0]), parts_of_body(performance.body)
    target = performance.target
    cells = performance.position.shape[1]
    return Life(
        growth_time=step * np.arange(len(growth)), growth=growth,
        growth_springs=[np.asarray(edges, int).reshape(-1, 2) for edges in performance.growth_edges],
        time=performance.time[sound] + len(growth) * step, position=performance.position[sound],
        activation=performance.activation[sound], velocity=performance.velocity[sound],
        springs=parts.get("springs", _NONE), outline=parts.get("outline", _NONE), chambers=list(parts.get("chambers", ())),
        target=np.empty((0, 2)) if target is None or not cells else np.tile(np.asarray(target, float), (int(sound.sum()), 1)),
        reach=task.chemotaxis.scent_reach if task.has_target else 0.0, scene=task.scene if task.has_ground else None,
    )
