"""Which code the bits of a run follow from."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from evodevo_sim.tasks.code import code_hash

_PACKAGE = Path(__file__).resolve().parents[1]
# Folders and files in which no bit of a run is decided: who evaluates, what is told and kept.
_BESIDE = {"backends", "descent", "keeping", "pool", "run"}
_ALSO_BESIDE = {
    "__init__", "answers", "arguments", "auditor", "commands", "evolve", "evolve_command", "feasible", "in_process", "library", "messages",
    "status", "times",
}


@cache
def search_hash() -> str:
    """Sixteen hexadecimal digits: equal where the code is that evaluates, and that which searches."""
    digest = hashlib.sha256(code_hash().encode())
    for file in sorted(_PACKAGE.rglob("*.py")):
        place = file.relative_to(_PACKAGE)
        if place.parts[0] not in _BESIDE and place.stem not in _ALSO_BESIDE:
            digest.update(f"{place.as_posix()}\0".encode() + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
