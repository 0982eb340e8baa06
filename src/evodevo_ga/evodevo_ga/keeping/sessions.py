"""Who worked on a run when, in `sessions.json`: of use to people, and to the budget of hours.  No bit of a run follows from it."""

from __future__ import annotations

import json
import os
import socket
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from .errors import KeepingError
from .files import aside

NAME = "sessions.json"


class Sessions:
    """The sessions of a run, of which this process's own begins.  Args: after: the last generation before it, -1 for none."""

    def __init__(self, directory: Path, after: int = -1):
        self._path, self._began = directory / NAME, time.monotonic()
        self._earlier = _read(self._path)
        self._own: dict[str, Any] = {
            "host": socket.gethostname(), "pid": os.getpid(), "began": datetime.now(UTC).isoformat(timespec="seconds"),
            "after_generation": after,
        }

    @property
    def seconds(self) -> float:
        """Wall time of all sessions, s."""
        return sum(one["seconds"] for one in self._earlier) + time.monotonic() - self._began

    def write(self, generation: int) -> None:
        """Keep what is known, after a generation.  Raises KeepingError."""
        own = self._own | {"to_generation": generation, "seconds": round(time.monotonic() - self._began, 3)}
        text = "[\n" + ",\n".join(json.dumps(one) for one in [*self._earlier, own]) + "\n]\n"
        try:
            aside(self._path).write_text(text, encoding="utf-8")
            os.replace(aside(self._path), self._path)
        except OSError as error:
            raise KeepingError.of(self._path, error, self._path.parent) from None


def _read(path: Path) -> list[dict[str, Any]]:
    """The sessions of a file; none where it is missing or damaged, as a power cut may leave it."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return [one | {"seconds": max(0.0, float(one["seconds"]))} for one in found]
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return []
