"""The section of a report about the archive of a run, from the table that `gallery` leaves in its directory."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from pathlib import Path

from .runs import Run
from .tables import number, paragraph, table

_SCHEMES = ("archive", "gaits")
_STANDS = "the fitness stands"  # how the verdict of such an audit begins


def archive_section(run: Run) -> str:
    """The gaits of its elites, with their audits; nothing where the run kept no archive, and a line where nobody has looked at it."""
    path = run.path / "archive" / "archive.csv"
    found: dict[str, list[tuple[float, str]]] = defaultdict(list)
    try:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                found[row["gait"] or "none"].append((float(row["fitness_m"]), row["audit"]))
    except FileNotFoundError:
        pass
    except (OSError, KeyError, TypeError, ValueError) as error:
        return paragraph(f"{_shown(path)} cannot be read ({error}): run gallery again.", "note")
    if not found:
        return _hint(run) if run.told.scheme in _SCHEMES else ""
    rows = []
    for gait, elites in sorted(found.items(), key=lambda of: -max(of[1])[0]):
        stand = [fitness for fitness, verdict in elites if verdict.startswith(_STANDS)]
        audited = sum(verdict != "not audited" for _, verdict in elites)
        rows.append((
            gait, len(elites), number(max(elites)[0]), f"{len(stand)} of {audited}" if audited else "not audited",
            number(max(stand, default=math.nan)),
        ))
    head = ["gait", "animals", "best, m", "audits that stand", "best of those, m"]
    return table("Unlike animals that the run kept, by gait", head, rows) + paragraph(
        "Their genomes are in the folder archive of the run, as gallery left them.", "about")


def _hint(run: Run) -> str:
    return paragraph(f"Its animals are not drawn yet: ros2 run evodevo_ga gallery {run.path} -o gallery.png", "about")


def _shown(path: Path) -> str:
    return "/".join(path.parts[-3:])
