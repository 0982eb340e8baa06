"""Genomes on disk: one YAML file, an element a line, exact to the last bit.

    evodevo_genome: 1
    about: {task: swim, fitness: '3.2'}
    elements:                                       # the first eight are the header, in this order
    - {special: maternal_x, sign: +1, x: 0.5, y: -1.25}
    - {kind: regulatory, sign: -1, x: 1.5, y: 0.0}
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ..inputs import shown
from ..text_file import parsed, read_text
from ..whole_file import written_whole
from .elements import HEADER, HEADER_NAMES, KINDS, SPECIAL
from .genome import Genome, GenomeError

VERSION = 1
_KIND_NUMBER = {name: number for number, name in enumerate(KINDS)}


def genome_text(genome: Genome, about: Mapping[str, object] | None = None) -> str:
    """The text of a genome file; `about` is free: what the genome is and where it comes from."""
    lines = [f"evodevo_genome: {VERSION}"]
    if about:
        lines.append(yaml.safe_dump({"about": {k: str(v) for k, v in about.items()}}, sort_keys=False).rstrip())
    lines.append(f"elements:  # the first {HEADER} are the header, in this order")
    for i, (kind, sign, x, y) in enumerate(zip(*(a.tolist() for a in genome.arrays()))):
        name = f"{KINDS[kind]}: {HEADER_NAMES[i]}" if kind == SPECIAL else f"kind: {KINDS[kind]}"
        lines.append(f"- {{{name}, sign: {sign:+d}, x: {_number(x)}, y: {_number(y)}}}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """The shortest text of exactly this number that YAML 1.1 reads as one: it wants 1.0e-12, not 1e-12."""
    mantissa, e, exponent = repr(value).partition("e")
    return mantissa + (".0" if e and "." not in mantissa else "") + e + exponent


def save_genome(path: str | os.PathLike, genome: Genome, about: Mapping[str, object] | None = None) -> None:
    """Write a genome file, whole or not at all."""
    with written_whole(path) as name:
        Path(name).write_text(genome_text(genome, about), encoding="utf-8")


def load_genome(path: str | os.PathLike) -> Genome:
    """Read a genome file.  Raises GenomeError that names file, element and mend."""
    text = read_text(path, GenomeError, f"a genome file, YAML that begins with 'evodevo_genome: {VERSION}'")
    try:
        return parse_genome(text)
    except GenomeError as error:
        raise GenomeError(f"{path}: {error}") from None


def parse_genome(text: str) -> Genome:
    """The genome of a genome file's text."""
    document = parsed(text, GenomeError)
    if not isinstance(document, dict) or "evodevo_genome" not in document:
        raise GenomeError(f"not a genome file: it must begin with 'evodevo_genome: {VERSION}'")
    version = document["evodevo_genome"]
    if type(version) is not int or version != VERSION:
        raise GenomeError(f"version {shown(version)} is unknown: this program reads version {VERSION}")
    unknown = sorted(set(document) - {"evodevo_genome", "about", "elements"})
    if unknown:
        raise GenomeError(f"unknown key {shown(unknown[0])}: use 'about' and 'elements'")
    if not isinstance(document.get("about", {}), dict):
        raise GenomeError(f"about is {shown(document['about'])}: give keys and values, or leave it out")
    elements = document.get("elements")
    if not isinstance(elements, list):
        raise GenomeError("'elements' is missing or not a list: give one entry per genetic element")
    columns = [_element(i, entry) for i, entry in enumerate(elements)]
    rows: list[Any] = [[column[k] for column in columns] for k in range(4)]  # it makes arrays of them
    return Genome(*rows)


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
