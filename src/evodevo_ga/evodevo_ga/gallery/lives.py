"""The lives of an archive's animals: their motion, gait and audit, and what of them is kept in the run's directory."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from evodevo_sim.analysis.gait import GaitError, analyse, track_of_performance
from evodevo_sim.development.shape import principal
from evodevo_sim.tasks.audit import audit, verdict_of
from evodevo_sim.view.body_map import Shown
from evodevo_sim.whole_file import written_whole

from evodevo_sim import Task, perform, save_genome

from .content import Animal, Content

FOLDER, TABLE = "archive", "archive.csv"  # in the directory of a run
_EVERY = 10  # control steps between frames of motions
_NAMED = re.compile(r"\d{2,}-\d{2,}\.yaml")
_COLUMNS = (
    "file", "column", "row", "cells", "chambers", "elongation", "share_of_chambers", "fitness_m", "distance_m", "gait", "frequency_hz",
    "speed_m_per_s", "audit", "number", "born", "operators",
)


@dataclass(frozen=True, eq=False)
class Life:
    """animal; gait: its name; frequency, Hz, and speed, m/s, or NaN; stands: whether its audit does, None: there is none; verdict: on it;
    shown: as the map has it."""

    animal: Animal
    gait: str
    frequency: float
    speed: float
    stands: bool | None
    verdict: str
    shown: Shown

    @property
    def file(self) -> str:
        return f"{self.animal.column:02d}-{self.animal.row:02d}.yaml"


def frame_time(task: Task) -> float:
    """s between frames of motions."""
    return _EVERY * task.control_step


def live(content: Content, audits: bool = True, workers: int = 1, done: Callable[[], object] = lambda: None) -> list[Life]:
    """The lives of all animals, side by side.  Args: done: called after each."""

    def one(animal: Animal) -> Life:
        found = _life(animal, content.task, content.seed, audits)
        done()
        return found

    with ThreadPoolExecutor(workers) as pool:
        under_way = [pool.submit(one, animal) for animal in content.animals]
        try:
            return [future.result() for future in under_way]
        except BaseException:  # Ctrl-C among them: it does not wait for those that have not begun
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _life(animal: Animal, task: Task, seed: int, audits: bool) -> Life:
    genome, recorded = animal.individual.genome, animal.individual.evaluation.fitness
    performance = perform(genome, task, seed)
    gait, frequency, speed, shape = "", np.nan, np.nan, principal(animal.grown.position)[1]
    try:
        analysis = analyse(track_of_performance(performance, task))
        gait, frequency, speed, shape = analysis.gait.name, analysis.gait.frequency, analysis.gait.speed, analysis.frame.shape
    except GaitError:
        pass
    stands, verdict = None, "not audited"
    own = performance.evaluation.fitness
    if audits and task.kind.audit is not None:
        found = audit(genome, task, seed, quick=True)
        stands, verdict = found.stands, verdict_of(found)
    if own != recorded:
        stands, verdict = False, f"FAILED: the recorded fitness of {recorded:.6g} differs from that of its own evaluation, {own:.6g}"
    motion = performance.position[::_EVERY]
    shown = Shown(animal.column, animal.row, recorded, shape, animal.grown.edges, gait, stands, motion)
    return Life(animal, gait, float(frequency), float(speed), stands, verdict, shown)


def folder_of(directory: Path) -> Path:
    """The folder for the animals of a run, made where it is not there.  Raises OSError."""
    folder = directory / FOLDER
    folder.mkdir(exist_ok=True)
    return folder


def keep(lives: Sequence[Life], content: Content, folder: Path) -> None:
    """Write each animal's genome, and the table of all; those of cells that are empty go.  Raises OSError."""
    for life in lives:
        save_genome(folder / life.file, life.animal.individual.genome, _about(life, content), content.task.development)
    known = {life.file for life in lives}
    for name in os.listdir(folder):
        if _NAMED.fullmatch(name) and name not in known:
            (folder / name).unlink()
    with written_whole(folder / TABLE, ".csv") as name, open(name, "w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(_COLUMNS)
        lines.writerows(_rows(lives))


def _about(life: Life, content: Content) -> dict[str, object]:
    e = life.animal.individual.evaluation
    return {
        "task": content.task.name, "cells": content.task.development.max_cells, "seed": content.seed,
        "number": life.animal.individual.number, "fitness": repr(e.fitness), "distance": repr(e.metrics.distance),
        "gait": life.gait or "none", "audit": life.verdict,
    }


def _rows(lives: Sequence[Life]) -> Iterator[list[object]]:
    for life in lives:
        one, grown = life.animal.individual, life.animal.grown
        e = one.evaluation
        yield [
            life.file, life.animal.column, life.animal.row, grown.cells, grown.chambers, f"{grown.elongation:.6g}",
            f"{grown.share_of_chambers:.6g}", repr(e.fitness), repr(e.metrics.distance), life.gait, f"{life.frequency:.6g}",
            f"{life.speed:.6g}", life.verdict, one.number, one.born, " ".join(one.operators),
        ]
