"""Genomes on disk: one YAML file, an element a line, exact to the last bit.

    evodevo_genome: 1
    about: {task: swim, fitness: '3.2'}
    development: {division_room: 0.6}               # the law by which it grows its body, where that is not the usual one
    elements:                                       # the first eight are the header, in this order
    - {special: maternal_x, sign: +1, x: 0.5, y: -1.25}
    - {kind: regulatory, sign: -1, x: 1.5, y: 0.0}

A genome grows another body by another law of growth, so a file says by which law it was bred.  `read_genome` tells all of it:

    file = read_genome("champion.yaml")
    evaluation = evaluate(file.genome, file.task("walk"))
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import yaml

from ..inputs import nearest, shown
from ..parameters import Development, ParameterError, Task, default_task, setting_of, with_settings
from ..text_file import parsed, read_text
from ..whole_file import written_whole
from .elements import HEADER, HEADER_NAMES, KINDS, SPECIAL
from .genome import Genome, GenomeError

VERSION = 1
# Settings of growth that hold where a file or a recording says nothing of them, whatever the defaults are: no cell waits to divide.
UNSAID: Mapping[str, Any] = MappingProxyType({"division_room": 0.0, "division_neighbours": 0, "waiting_turn": 0.0})
_USUAL = Development()
_KIND_NUMBER = {name: number for number, name in enumerate(KINDS)}


@dataclass(frozen=True)
class GenomeFile:
    """What a genome file holds.  Attributes: genome; growth: the settings of growth by which it was bred, as `with_settings` takes them,
    those that the file says and those of `UNSAID`; about: the file's own words."""

    genome: Genome
    growth: Mapping[str, object]
    about: Mapping[str, str]

    def task(self, name: str = "swim", settings: Mapping[str, object] | None = None) -> Task:
        """The task of a name with growth as the genome was bred with; `settings` go over all.  Raises ParameterError."""
        return with_settings(default_task(name), {**self.growth, **(settings or {})})

    def bred_otherwise(self, task: Task) -> str:
        """The settings of growth that a task has otherwise than the genome was bred with, as `--set` takes them; empty where none."""
        return " ".join(f"{name}={value}" for name, value in self.growth.items() if setting_of(task, name) != value)


def law_said(development: Development) -> dict[str, object]:
    """What a genome file has to say of a law of growth: the settings that differ from what holds where nothing is said."""
    unsaid = dataclasses.replace(_USUAL, **UNSAID)
    names = [field.name for field in dataclasses.fields(Development)]
    return {name: getattr(development, name) for name in names if getattr(development, name) != getattr(unsaid, name)}


def genome_text(genome: Genome, about: Mapping[str, object] | None = None, development: Development = _USUAL) -> str:
    """The text of a genome file.

    Args: about: free, what the genome is and where it comes from; development: the law by which it was bred.
    """
    lines = [f"evodevo_genome: {VERSION}"]
    if about:
        lines.append(yaml.safe_dump({"about": {k: str(v) for k, v in about.items()}}, sort_keys=False).rstrip())
    said = law_said(development)
    if said:
        law = (f"{name}: {_number(value) if isinstance(value, float) else value}" for name, value in said.items())
        lines.append(f"development: {{{', '.join(law)}}}")
    lines.append(f"elements:  # the first {HEADER} are the header, in this order")
    for i, (kind, sign, x, y) in enumerate(zip(*(a.tolist() for a in genome.arrays()))):
        name = f"{KINDS[kind]}: {HEADER_NAMES[i]}" if kind == SPECIAL else f"kind: {KINDS[kind]}"
        lines.append(f"- {{{name}, sign: {sign:+d}, x: {_number(x)}, y: {_number(y)}}}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """The shortest text of exactly this number that YAML 1.1 reads as one: it wants 1.0e-12, not 1e-12."""
    mantissa, e, exponent = repr(value).partition("e")
    return mantissa + (".0" if e and "." not in mantissa else "") + e + exponent


def save_genome(
    path: str | os.PathLike, genome: Genome, about: Mapping[str, object] | None = None, development: Development = _USUAL
) -> None:
    """Write a genome file, whole or not at all.  Args: as of `genome_text`."""
    with written_whole(path) as name:
        Path(name).write_text(genome_text(genome, about, development), encoding="utf-8")


def load_genome(path: str | os.PathLike) -> Genome:
    """The genome of a genome file alone.  Raises GenomeError that names file, element and mend."""
    return read_genome(path).genome


def read_genome(path: str | os.PathLike) -> GenomeFile:
    """A genome file, with the law of growth by which its genome was bred.  Raises GenomeError that names file, element and mend."""
    text = read_text(path, GenomeError, f"a genome file, YAML that begins with 'evodevo_genome: {VERSION}'")
    try:
        return parse_file(text)
    except GenomeError as error:
        raise GenomeError(f"{path}: {error}") from None


def parse_genome(text: str) -> Genome:
    """The genome of a genome file's text alone."""
    return parse_file(text).genome


def parse_file(text: str) -> GenomeFile:
    """What the text of a genome file says."""
    document = parsed(text, GenomeError)
    if not isinstance(document, dict) or "evodevo_genome" not in document:
        raise GenomeError(f"not a genome file: it must begin with 'evodevo_genome: {VERSION}'")
    version = document["evodevo_genome"]
    if type(version) is not int or version != VERSION:
        raise GenomeError(f"version {shown(version)} is unknown: this program reads version {VERSION}")
    unknown = sorted(set(document) - {"evodevo_genome", "about", "development", "elements"}, key=str)
    if unknown:
        raise GenomeError(f"unknown key {shown(unknown[0])}: use 'about', 'development' and 'elements'")
    about = document.get("about", {})
    if not isinstance(about, dict):
        raise GenomeError(f"about is {shown(about)}: give keys and values, or leave it out")
    growth = _law(document.get("development", {}))
    elements = document.get("elements")
    if not isinstance(elements, list):
        raise GenomeError("'elements' is missing or not a list: give one entry per genetic element")
    columns = [_element(i, entry) for i, entry in enumerate(elements)]
    rows: list[Any] = [[column[k] for column in columns] for k in range(4)]  # it makes arrays of them
    return GenomeFile(Genome(*rows), growth, {str(key): str(value) for key, value in about.items()})


def _law(given: Any) -> dict[str, object]:
    """The settings of growth of a file, checked, with those of `UNSAID` where it does not say them."""
    known = [field.name for field in dataclasses.fields(Development)]
    if not isinstance(given, dict):
        raise GenomeError(f"development is {shown(given)}: give settings and values, or leave it out")
    for name in given:
        if name not in known:
            raise GenomeError(f"development: setting {shown(name)} is unknown: did you mean {nearest(name, known)!r}?")
    try:
        law = Development(**{**UNSAID, **given})
    except ParameterError as error:
        raise GenomeError(str(error)) from None
    return {f"development.{name}": getattr(law, name) for name in {**UNSAID, **given}}


def _element(i, entry):
    special = i < HEADER
    names = {"special" if special else "kind", "sign", "x", "y"}
    if not isinstance(entry, dict) or set(entry) != names:
        raise GenomeError(f"element {i}: give exactly the keys {', '.join(sorted(names))}")
    if special:
        if entry["special"] != HEADER_NAMES[i]:
            raise GenomeError(f"element {i}: special is {shown(entry['special'])}: the header has {HEADER_NAMES[i]!r} here")
        kind = SPECIAL
    else:
        kind = _KIND_NUMBER.get(entry["kind"], SPECIAL) if isinstance(entry["kind"], str) else SPECIAL
        if kind == SPECIAL:
            raise GenomeError(f"element {i}: kind is {shown(entry['kind'])}: use one of {', '.join(KINDS[1:])}")
    for key in ("sign", "x", "y"):
        if isinstance(entry[key], bool) or not isinstance(entry[key], (int, float)):
            raise GenomeError(f"element {i}: {key} is {shown(entry[key])}: give a number")
    if entry["sign"] not in (1, -1):
        raise GenomeError(f"element {i}: sign is {shown(entry['sign'])}: give +1 or -1")
    return kind, int(entry["sign"]), float(entry["x"]), float(entry["y"])
