"""What it costs that no generation is lost: the search's own work, history and checkpoint of a generation, beside its evaluations.

    python benchmarks/keeping.py [--population N] [--generations N] [--units N] [--out DIR]

Evaluations are a stand-in that takes no time.  Prints, for each part, ms of processor time and of wall time in a generation: median and
most.  What is prepared while a generation is evaluated stands apart.  Wall time waits for the disk: give --out where runs are kept.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from evodevo_ga.keeping.checkpoint import NAME, Checkpoints
from evodevo_ga.keeping.history import History
from evodevo_ga.keeping.limits import Limits
from evodevo_ga.keeping.sessions import Sessions
from rich.console import Console
from rich.table import Table

from evodevo_ga import Evolution, Settings
from evodevo_sim import Evaluation, Genome, Metrics, Status, Task


def stand_in(genome: Genome) -> Evaluation:
    """Points near the origin are good."""
    distance = 2.0 - float(abs(genome.x).mean() + abs(genome.y).mean())
    return Evaluation(distance, Status.OK, "", Metrics(cells=32, springs=61, chambers=30, distance=distance))


class Watch:
    """Times of parts: [(s of processor time, s of wall time)] by part."""

    def __init__(self) -> None:
        self.took: dict[str, list[tuple[float, float]]] = {}

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        processor, wall = time.thread_time(), time.perf_counter()
        yield
        self.took.setdefault(part, []).append((time.thread_time() - processor, time.perf_counter() - wall))


def keep(directory: Path, settings: Settings, watch: Watch) -> int:
    """A run that keeps what `evolve` keeps.  Returns: bytes of its last checkpoint."""
    evolution = Evolution(settings, 1)
    checkpoints, history = Checkpoints(directory, evolution, Task(), Limits(), ()), History(directory)
    sessions = Sessions(directory)
    while not evolution.finished:
        with watch("breeding: ask"):
            asked = evolution.ask()
        with watch("beside evaluations: texts of genomes"):
            checkpoints.expect(asked)
        evaluations = [stand_in(genome) for genome in asked]
        with watch("breeding: tell"):
            generation = evolution.tell(evaluations)
        with watch("history"):
            history.take(generation, evolution)
            history.write_if_due(generation.generation)
        with watch("checkpoint"):
            checkpoints.write(evolution.champion, generation.generation, history.kept())
        with watch("sessions"):
            sessions.write(generation.generation)
    return (directory / NAME).stat().st_size


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--population", type=int, default=100, metavar="N")
    parser.add_argument("--generations", type=int, default=100, metavar="N")
    parser.add_argument("--units", type=int, default=45, metavar="N", help="regulatory units of a genome: 45 make 150 elements")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default: the directory of temporary files)")
    given = parser.parse_args()
    watch = Watch()
    with tempfile.TemporaryDirectory(dir=given.out) as directory:
        size = keep(Path(directory), Settings(population=given.population, generations=given.generations, units=given.units), watch)
    shown = Table("ms in a generation", title=f"{given.population} individuals, a checkpoint of {size / 1e6:.2f} MB")
    for name in ("processor, median", "mean", "most", "wall, median", "mean", "most"):
        shown.add_column(name, justify="right")
    for part, took in watch.took.items():
        numbers = [1e3 * number(column) for column in zip(*took) for number in (statistics.median, statistics.mean, max)]
        shown.add_row(part, *(f"{number:.2f}" for number in numbers))
    Console().print(shown)


if __name__ == "__main__":
    main()
