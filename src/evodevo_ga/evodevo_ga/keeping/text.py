"""Individuals as JSON, fast: a generation differs from the one before in few individuals, and those in few numbers.

The text is that of `json.dumps(plain_individual(one))` but for its spaces.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

import numpy as np

from evodevo_sim import Genome

from ..individual import Individual

_ZERO = np.uint8(ord("0"))
_NUMBERS = 10_000  # whose texts are remembered, or twice as many as individuals have

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
        self._genomes: dict[int, tuple[Genome, str]] = {}

    def expect(self, genomes: Iterable[Genome]) -> None:
        """Make the texts of genomes ahead of the next call of `of`, in whatever thread."""
        self._genomes = {id(genome): (genome, self._genome(genome)) for genome in genomes}

    def of(self, individuals: Iterable[Individual]) -> list[str]:
        """The text of each."""
        known, texts, numbers = {}, [], 0
        for one in individuals:
            numbers += 2 * len(one.genome)
            found = self._known.get(id(one))  # the individual beside it lives, so that nobody else has its id
            known[id(one)] = found if found is not None else (one, self._text(one))
            texts.append(known[id(one)][1])
        self._known, self._genomes = known, {}
        if len(self._numbers) > max(_NUMBERS, 2 * numbers):
            self._numbers.clear()
        return texts

    def _text(self, one: Individual) -> str:
        e, ahead = one.evaluation, self._genomes.get(id(one.genome))
        genome = ahead[1] if ahead else self._genome(one.genome)
        evaluation = compact({
            "fitness": float(e.fitness), "status": e.status.name, "cause": e.cause,
            "metrics": {**vars(e.metrics), "steering": vars(e.metrics.steering)},
        })
        about = compact({
            "born": one.born, "layer": one.layer, "number": one.number, "parents": one.parents, "operators": one.operators,
        })[1:]
        return f'{{"genome":{genome},"evaluation":{evaluation},{about}'

    def _genome(self, genome: Genome) -> str:
        kind = ",".join((genome.kind + _ZERO).tobytes().decode())  # digits of one place
        sign = ",".join((genome.sign > 0).tobytes().decode()).replace("\0", "-1").replace("\1", "1")
        return f'{{"kind":[{kind}],"sign":[{sign}],"x":{self._real(genome.x)},"y":{self._real(genome.y)}}}'

    def _real(self, values: np.ndarray) -> str:
        numbers, plain = self._numbers, values.tolist()
        if 0.0 in plain:
            return f"[{','.join(map(repr, plain))}]"
        return f"[{','.join(map(numbers.__getitem__, plain))}]"


def listed(texts: Sequence[str]) -> str:
    """A list of texts of JSON, one a line."""
    return "[\n" + ",\n".join(texts) + "\n]" if texts else "[]"
