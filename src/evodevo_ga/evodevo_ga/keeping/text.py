"""Individuals as JSON, fast: a generation differs from the one before in few individuals, and those in few numbers.

The text is that of `json.dumps(plain_individual(one))` but for its spaces.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

import numpy as np

from ..individual import Individual

_ZERO = np.uint8(ord("0"))
_MOST_NUMBERS = 400_000  # whose texts are remembered

compact = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode


class _Numbers(dict[float, str]):
    """The texts of numbers that were asked for; never of 0, since -0.0 is equal to it."""

    def __missing__(self, number: float) -> str:
        text = self[number] = repr(number)
        return text


class Texts:
    """Texts of individuals; those of the last call are remembered."""

    def __init__(self) -> None:
        self._numbers = _Numbers()
        self._known: dict[int, tuple[Individual, str]] = {}

    def of(self, individuals: Iterable[Individual]) -> list[str]:
        """The text of each."""
        if len(self._numbers) > _MOST_NUMBERS:
            self._numbers.clear()
        known, texts = {}, []
        for one in individuals:
            found = self._known.get(id(one))  # the individual beside it lives, so that nobody else has its id
            known[id(one)] = found if found is not None else (one, self._text(one))
            texts.append(known[id(one)][1])
        self._known = known
        return texts

    def _text(self, one: Individual) -> str:
        genome, e = one.genome, one.evaluation
        evaluation = compact({
            "fitness": float(e.fitness), "status": e.status.name, "cause": e.cause,
            "metrics": {**vars(e.metrics), "steering": vars(e.metrics.steering)},
        })
        about = compact({
            "born": one.born, "layer": one.layer, "number": one.number, "parents": one.parents, "operators": one.operators,
        })[1:]
        kind = ",".join((genome.kind + _ZERO).tobytes().decode())  # digits of one place
        sign = ",".join((genome.sign > 0).tobytes().decode()).replace("\0", "-1").replace("\1", "1")
        return (
            f'{{"genome":{{"kind":[{kind}],"sign":[{sign}],"x":{self._real(genome.x)},"y":{self._real(genome.y)}}},'
            f'"evaluation":{evaluation},{about}'
        )

    def _real(self, values: np.ndarray) -> str:
        numbers = self._numbers
        return f"[{','.join([numbers[value] if value else repr(value) for value in values.tolist()])}]"


def listed(texts: Sequence[str]) -> str:
    """A list of texts of JSON, one a line."""
    return "[\n" + ",\n".join(texts) + "\n]" if texts else "[]"
