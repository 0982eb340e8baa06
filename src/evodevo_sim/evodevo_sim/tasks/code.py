"""A hash of the sources that decide the bits of an evaluation, by which programs on several hosts find out whether they are alike."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_DECIDE = ("task_kinds.py", "parameters.py", "profiles.py", "kernels", "genetics", "development", "physics", "brain", "plant", "tasks")


@cache
def code_hash() -> str:
    """Sixteen hexadecimal digits: equal where all files are that evaluations come from."""
    digest = hashlib.sha256()
    for name in _DECIDE:
        place = _PACKAGE / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(f"{file.relative_to(_PACKAGE).as_posix()}\0".encode() + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
