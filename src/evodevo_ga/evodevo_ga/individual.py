"""Individuals of a search and where they come from, frozen; and the same as plain data, of which a run goes on with the same bits."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from operator import index
from typing import Any

import numpy as np

from evodevo_sim import Evaluation, Genome, Metrics, Status


@dataclass(frozen=True)
class Child:
    """A genome that was bred and has no evaluation yet.

    Attributes: born: generation of the random genome from which its oldest line comes; layer: of ages, 0 the youngest; parents: numbers
    of those it comes from; operators: names of what made it of them, in their order; bar: m, a fitness of which it has to have more, or
    nothing comes of it, so its life may stop where it cannot; growths: of bodies alone that it took to find it.
    """

    genome: Genome
    born: int = 0
    layer: int = 0
    parents: tuple[int, ...] = ()
    operators: tuple[str, ...] = ()
    bar: float = -math.inf
    growths: int = 0


@dataclass(frozen=True)
class Individual:
    """A child that has its evaluation.  Attributes: as of Child; number: its place among all that the run has bred, from 0."""

    genome: Genome
    evaluation: Evaluation
    born: int = 0
    layer: int = 0
    number: int = 0
    parents: tuple[int, ...] = ()
    operators: tuple[str, ...] = ()


def plain_genome(genome: Genome) -> dict[str, list]:
    return {name: values.tolist() for name, values in zip(("kind", "sign", "x", "y"), genome.arrays())}


def genome_of_plain(plain: dict[str, Any]) -> Genome:
    return Genome(*(np.asarray(plain[name]) for name in ("kind", "sign", "x", "y")))


def plain_individual(one: Individual) -> dict[str, Any]:
    """It as dicts, lists, numbers and texts, which JSON carries without the loss of a bit."""
    evaluation = {
        "fitness": float(one.evaluation.fitness), "status": one.evaluation.status.name, "cause": one.evaluation.cause,
        "metrics": dataclasses.asdict(one.evaluation.metrics),
    }
    about = {"born": one.born, "layer": one.layer, "number": one.number, "parents": list(one.parents), "operators": list(one.operators)}
    return {"genome": plain_genome(one.genome), "evaluation": evaluation, **about}


def individual_of_plain(plain: dict[str, Any]) -> Individual:
    """Raises KeyError, TypeError or ValueError where the data are not what `plain_individual` made."""
    given = plain["evaluation"]
    metrics = _made_like(Metrics(), given["metrics"])
    evaluation = Evaluation(float(given["fitness"]), Status[given["status"]], _text(given["cause"]), metrics)
    born, layer, number = (index(plain[name]) for name in ("born", "layer", "number"))
    parents, operators = tuple(map(index, plain["parents"])), tuple(map(_text, _list(plain["operators"])))
    return Individual(genome_of_plain(plain["genome"]), evaluation, born, layer, number, parents, operators)


def _made_like(example: Any, plain: Any) -> Any:
    """The plain value in the type of the example: a number, or a dataclass of such, whole."""
    if not dataclasses.is_dataclass(example):
        return index(plain) if isinstance(example, int) else float(plain)
    cls: Any = type(example)
    names = [field.name for field in dataclasses.fields(cls)]
    return cls(**{name: _made_like(getattr(example, name), plain[name]) for name in names})


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} in place of a text")
    return value


def _list(value: Any) -> list:
    if not isinstance(value, list):
        raise TypeError(f"{value!r} in place of a list")
    return value
