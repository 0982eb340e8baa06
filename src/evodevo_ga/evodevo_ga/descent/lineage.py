"""The ancestors of an individual, from the history of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from ..keeping.errors import ResumeError


@dataclass(frozen=True, eq=False)
class Lineage:
    """An individual and all its ancestors.

    Attributes:
        number (A,): of each, ascending: the individual is the last one; generation, fitness, cells, elements (A,): of each.
        operators: names of what made each, in order.
        links (L, 2): places of parent and child in these arrays.
        line (M,): places of the individual's own line, the first one first: from child to its fitter parent, of equals the first, again
            and again.
    """

    number: np.ndarray
    generation: np.ndarray
    fitness: np.ndarray
    cells: np.ndarray
    elements: np.ndarray
    operators: list[tuple[str, ...]]
    links: np.ndarray
    line: np.ndarray

    def counts(self) -> dict[str, int]:
        """How many times each operator was at work in the line, the most frequent first."""
        found: dict[str, int] = {}
        for place in self.line:
            for name in self.operators[place]:
                found[name] = found.get(name, 0) + 1
        return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))


def lineage(individuals: pa.Table, number: int) -> Lineage:
    """The ancestors of the individual of a number.

    Args: individuals: the table `history`, in which each stands behind its parents.
    Raises ResumeError where parents are missing.
    """
    numbers = individuals["number"].to_numpy()
    lists = individuals["parents"].combine_chunks()
    offsets, parents = lists.offsets.to_numpy(), lists.values.to_numpy()
    if not np.all(numbers[1:] > numbers[:-1]):
        raise ResumeError("the history has individuals that are not in order: restore its files")
    rows, ahead = {_row(numbers, number)}, [_row(numbers, number)]
    links = []
    while ahead:
        row = ahead.pop()
        for parent in parents[offsets[row] : offsets[row + 1]].tolist():
            above = _row(numbers, parent)
            if above >= row:
                raise ResumeError(f"the history has individual {numbers[row]} before its parent {parent}: restore its files")
            links.append((above, row))
            if above not in rows:
                rows.add(above)
                ahead.append(above)
    chosen = np.array(sorted(rows))
    fitness, line = individuals["fitness"].to_numpy(), [_row(numbers, number)]
    while both := [_row(numbers, parent) for parent in parents[offsets[line[-1]] : offsets[line[-1] + 1]].tolist()]:
        line.append(max(both, key=lambda row: fitness[row]))
    columns = {name: individuals[name].take(chosen) for name in ("generation", "fitness", "cells", "elements", "operators")}
    made = [tuple(names) for names in columns.pop("operators").to_pylist()]
    found = {name: column.to_numpy() for name, column in columns.items()}
    places = np.searchsorted(chosen, np.array(sorted(links), np.int64).reshape(-1, 2))
    return Lineage(numbers[chosen], operators=made, links=places, line=np.searchsorted(chosen, line[::-1]), **found)


def _row(numbers: np.ndarray, number: int) -> int:
    row = int(np.searchsorted(numbers, number))
    if row == len(numbers) or numbers[row] != number:
        raise ResumeError(f"the history has no individual {number}: restore its files")
    return row
