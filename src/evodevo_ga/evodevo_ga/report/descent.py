"""The descent of a champion, from the history of its run, where there is one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

_COLUMNS = ("number", "generation", "parents", "operators", "fitness")


@dataclass(frozen=True)
class Ancestor:
    """number; generation in which it was born; fitness, m; operators that made it; parents: their numbers, the one that
    the line goes on with first."""

    number: int
    generation: int
    fitness: float
    operators: tuple[str, ...]
    parents: tuple[int, ...]


def descent_of(run: Path, asked: bool = True) -> tuple[list[Ancestor], list[str]]:
    """The line of the best individual of a run, through first parents, newest first; and what must be known, a line each.

    A run without RUN/history has none, and nothing is said of that.
    """
    parts = sorted((run / "history").glob("*.parquet")) if run.is_dir() else []
    if not parts or not asked:
        return [], []
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq

        table = pa.concat_tables([pq.read_table(part, columns=list(_COLUMNS), partitioning=None) for part in parts])
        rows = dict(zip(_COLUMNS, (table[name].to_pylist() for name in _COLUMNS)))
    except ModuleNotFoundError:
        return [], ["its history cannot be read: pip install pyarrow"]
    except Exception as error:  # of a reader that is not ours, whose exceptions have no common class
        return [], [f"its history cannot be read ({type(error).__name__}): the descent of the champion is left out"]
    return line_of(rows), []


def line_of(rows: dict[str, list[Any]]) -> list[Ancestor]:
    """The line of the best of all rows.  Args: rows: columns as in the history of a run."""
    if not rows["number"]:
        return []
    place = {number: k for k, number in enumerate(rows["number"])}
    best = max(range(len(rows["number"])), key=lambda k: (rows["fitness"][k], -rows["number"][k]))
    line: list[Ancestor] = []
    k: int | None = best
    while k is not None and len(line) < len(place):
        parents = tuple(rows["parents"][k] or ())
        line.append(Ancestor(rows["number"][k], rows["generation"][k], rows["fitness"][k], tuple(rows["operators"][k] or ()), parents))
        known = [place[parent] for parent in parents if parent in place and parent < rows["number"][k]]
        k = known[0] if known else None
    return line
