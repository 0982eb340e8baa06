"""The history of a run as Parquet: every individual, the statistics of every generation, and each new champion.

    RUN/history/*.parquet         a row for each individual: where it comes from, what it came to
    RUN/generations/*.parquet     a row for each generation
    RUN/hall_of_fame/*.parquet    a row for each new champion, with its genome

Each is one table in parts: `pandas.read_parquet("RUN/history")`.  A part is written anew, whole, every `EVERY` generations, with what
came since; until then that is kept in the checkpoint.  So a part that a crash left ahead of the checkpoint is written over by the same
rows, and no row is lost or comes twice.  What is written when follows from the number of the generation alone.
"""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from evodevo_sim.tasks.outcome import Steering

from evodevo_sim import Evaluation, Genome, Metrics, Status

from ..evolution import Evolution, Generation
from ..individual import Individual
from .errors import KeepingError, ResumeError
from .files import FILES, Files, replace_file
from .text import compact, listed

EVERY = 10  # generations, at whose ends the parts are written
MOST_ROWS = 5_000  # of a part, after which the next one begins
_REAL, _WHOLE, _TEXT, _TRUTH = pa.float64(), pa.int64(), pa.string(), pa.bool_()
_MAIN = ("cells", "springs", "chambers", "distance", "distance_second_half", "slowest_window", "activation_amplitude")


def _type_of(example: object) -> pa.DataType:
    return _WHOLE if isinstance(example, int) else _REAL


_ALL_METRICS = {
    **{f.name: _type_of(f.default) for f in dataclasses.fields(Metrics) if f.name != "steering"},
    **{f"steering_{f.name}": _REAL for f in dataclasses.fields(Metrics().steering)},
}
_CHILD = {
    "generation": _WHOLE, "number": _WHOLE, "parents": pa.list_(_WHOLE), "operators": pa.list_(_TEXT), "born": _WHOLE, "layer": _WHOLE,
    "group": _WHOLE, "elements": _WHOLE, "fitness": _REAL, "status": _TEXT,
}
_SCHEMAS = {
    "history": pa.schema({**_CHILD, "stays": _TRUTH, **{name: _ALL_METRICS[name] for name in _MAIN}}),
    "generations": pa.schema({
        "generation": _WHOLE, "best": _REAL, "median": _REAL, "worst": _REAL, "diversity": _REAL, "median_elements": _REAL,
        "evaluations": _WHOLE, "stagnation": _WHOLE, "improved": _TRUTH, "status_count": pa.list_(_WHOLE),
    }),
    "hall_of_fame": pa.schema({
        **_CHILD, "cause": _TEXT, **_ALL_METRICS, "kind": pa.list_(pa.uint8()), "sign": pa.list_(pa.int8()), "x": pa.list_(_REAL),
        "y": pa.list_(_REAL),
    }),
}
TABLES = tuple(_SCHEMAS)


class _Table:
    """One of the tables: its parts in a directory, and the rows that are in none yet."""

    def __init__(self, directory: Path, schema: pa.Schema, files: Files):
        self._directory, self._schema, self._files = directory, schema, files
        self.waiting: list[list[Any]] = []
        self.texts: list[str] = []  # of them, as JSON
        self._part: pa.Table = schema.empty_table()  # the newest one as it is on disk, with nothing of what waits
        self._name = ""

    def add(self, rows: Iterable[list[Any]]) -> None:
        for row in rows:
            self.waiting.append(row)
            self.texts.append(compact(row))

    def restore(self, rows: list[list[Any]], written: int) -> None:
        """Take up after the generation `written`, which is in the parts; `rows` are in none, whatever the parts hold beyond."""
        self.add(rows)
        starts = [path for path in self._parts() if int(path.stem) <= written]
        if starts:
            self._name = starts[-1].name
            try:
                table = pq.read_table(starts[-1], partitioning=None)
            except (OSError, pa.ArrowException):
                raise ResumeError(f"{starts[-1]} is damaged: restore it, or move it away, which loses those rows alone") from None
            kept = pc.less_equal(table["generation"], written)
            self._part = table.filter(kept).cast(self._schema).combine_chunks()

    def rows(self) -> Iterator[dict[str, Any]]:
        """All rows, from the parts and beyond, in order."""
        older = [path for path in self._parts() if path.name < self._name]
        for path in older:
            yield from pq.read_table(path, partitioning=None).cast(self._schema).to_pylist()
        yield from self._part.to_pylist()
        for row in self.waiting:
            yield dict(zip(self._schema.names, row))

    def _parts(self) -> list[Path]:
        return sorted(self._directory.glob("[0-9]*.parquet"))

    def write(self, first: int) -> None:
        """Have what waits in the newest part.  Args: first: generation of what waits, by which a new part is named.  Raises OSError."""
        if not self.waiting:
            return
        new, name = self._grown(first)
        if not self._directory.is_dir():
            self._files.make_directory(self._directory)
            self._files.sync_directory(self._directory.parent)
        buffer = io.BytesIO()
        pq.write_table(new, buffer, compression="zstd")
        replace_file(self._directory / name, buffer.getvalue(), self._files)

    def settle(self, first: int) -> None:
        """What waited is in the newest part, and its checkpoint will say so."""
        if self.waiting:
            self._part, self._name = self._grown(first)
            self.waiting, self.texts = [], []

    def _grown(self, first: int) -> tuple[pa.Table, str]:
        begun = self._part if self._name and len(self._part) < MOST_ROWS else self._schema.empty_table()
        name = self._name if len(begun) else f"{first:09d}.parquet"
        columns = [pa.array(list(column), field.type) for column, field in zip(zip(*self.waiting), self._schema)]
        return pa.concat_tables([begun, pa.table(columns, self._schema)]).combine_chunks(), name


class History:
    """The history of a run.

    Args: directory: of the run; files: the calls of the file system.
    """

    def __init__(self, directory: Path, files: Files = FILES):
        self._directory = directory
        self._tables = {name: _Table(directory / name, schema, files) for name, schema in _SCHEMAS.items()}
        self._written = -1  # generation, up to which everything is in the parts

    def restore(self, kept: dict[str, Any]) -> None:
        """Take up from what a checkpoint keeps.  Raises ResumeError."""
        try:
            self._written = int(kept["written"])
            for name, table in self._tables.items():
                table.restore(kept[name], self._written)
        except (KeyError, TypeError, ValueError, pa.ArrowException) as error:
            raise ResumeError(f"{self._directory}: its history cannot be taken up ({error}): restore the directory") from None

    def take(self, generation: Generation, evolution: Evolution) -> None:
        """Add a generation, the last one of an evolution."""
        stays = {one.number for one in evolution.population}
        now, group = generation.generation, getattr(evolution.search, "group", lambda one: one.layer)  # schemes without groups have none
        rows = [_child_row(one, now, group(one)) for one in evolution.children]
        for row, one in zip(rows, evolution.children):
            row += [one.number in stays, *(getattr(one.evaluation.metrics, name) for name in _MAIN)]
        self._tables["history"].add(rows)
        self._tables["generations"].add([_plain([getattr(generation, name) for name in _SCHEMAS["generations"].names])])
        if generation.improved:
            self._tables["hall_of_fame"].add([_fame_row(evolution.champion, now, group(evolution.champion))])

    def generations(self) -> Iterator[Generation]:
        """The statistics of all generations, in order."""
        for row in self._tables["generations"].rows():
            yield Generation(**row | {"status_count": tuple(row["status_count"])})

    def champions(self) -> Iterator[tuple[int, Individual]]:
        """Each new champion with its generation, in order."""
        for row in self._tables["hall_of_fame"].rows():
            yield row["generation"], champion_of_row(row)

    def kept(self) -> str:
        """What the checkpoint keeps for it, as text of JSON."""
        tables = ",\n".join(f'"{name}":{listed(table.texts)}' for name, table in self._tables.items())
        return f'{{"written":{self._written},\n{tables}}}'

    def write_if_due(self, generation: int) -> None:
        """Write what waits where the generation that ends is one of every `EVERY`.  Raises KeepingError."""
        if (generation + 1) % EVERY == 0:
            self.write()
            for table in self._tables.values():
                table.settle(self._written + 1)
            self._written = generation

    def write(self) -> None:
        """Write what waits, and keep it waiting: so a run that ends early changes nothing of how it goes on.  Raises KeepingError."""
        for name, table in self._tables.items():
            try:
                table.write(self._written + 1)
            except OSError as error:
                raise KeepingError.of(self._directory / name, error, self._directory) from None


def _child_row(one: Individual, generation: int, group: int) -> list[Any]:
    e = one.evaluation
    return [
        generation, one.number, list(one.parents), list(one.operators), one.born, one.layer, int(group), len(one.genome), float(e.fitness),
        e.status.name,
    ]


def _fame_row(one: Individual, generation: int, group: int) -> list[Any]:
    e, steering = one.evaluation, one.evaluation.metrics.steering
    metrics = [getattr(steering, n.removeprefix("steering_")) if n.startswith("steering_") else getattr(e.metrics, n) for n in _ALL_METRICS]
    return _plain([*_child_row(one, generation, group), e.cause, *metrics, *(values.tolist() for values in one.genome.arrays())])


def champion_of_row(row: dict[str, Any]) -> Individual:
    """A champion of a row of `hall_of_fame`."""
    steering = {field.name: row[f"steering_{field.name}"] for field in dataclasses.fields(Metrics().steering)}
    metrics = {field.name: row[field.name] for field in dataclasses.fields(Metrics) if field.name != "steering"}
    evaluation = Evaluation(row["fitness"], Status[row["status"]], row["cause"], Metrics(**metrics, steering=Steering(**steering)))
    genome = Genome(*(np.array(row[name]) for name in ("kind", "sign", "x", "y")))
    return Individual(
        genome, evaluation, row["born"], row["layer"], row["number"], tuple(row["parents"]), tuple(row["operators"])
    )


def _plain(row: list[Any]) -> list[Any]:
    return [list(value) if isinstance(value, tuple) else value for value in row]


def read_table(directory: Path, name: str) -> pa.Table:
    """A table of a run's history, in the order of generations.  Raises ResumeError where there is none."""
    parts = sorted((directory / name).glob("[0-9]*.parquet"))
    if not parts:
        raise ResumeError(f"{directory} holds no {name}/: give the directory of a run of evolve")
    try:
        return pa.concat_tables([pq.read_table(part, partitioning=None).cast(_SCHEMAS[name]) for part in parts])
    except (OSError, pa.ArrowException, ValueError) as error:
        raise ResumeError(f"{directory / name} cannot be read ({str(error).splitlines()[0][:100]}): restore it") from None

