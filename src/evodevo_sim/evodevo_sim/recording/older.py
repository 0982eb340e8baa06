"""Messages of other versions of evodevo as messages of ours, field by field by name, as far as that is true."""

from __future__ import annotations

import re
from array import array
from pathlib import Path
from typing import Any

from evodevo_msgs import msg

from ..genetics.genome_file import UNSAID
from ..parameters import Task, default_task, with_settings
from ..ros.messages import task_message
from ..task_kinds import kind_of
from .schema import Difference

# Fields without which a message of ours says nothing; of messages of other packages all are.
_NEEDED = {
    "Actuation": {"header", "step", "activation"},
    "Audit": {"generation", "stands"},
    "AuditRun": {"name", "fitness"},
    "Body": {"cells", "spring_a", "spring_b", "chamber_start", "chamber_cell", "outline_a", "outline_b"},
    "CellStates": {"header", "position_x", "position_y", "velocity_x", "velocity_y", "activation"},
    "Champion": {"generation", "genome", "evaluation"},
    "Evaluation": {"fitness", "status"},
    "Evolution": {"task", "seed"},
    "Gait": {"name"},
    "GenerationStatistics": {"generation", "best", "median"},
    "Genome": {"kind", "sign", "x", "y"},
    "Metrics": set(),
    "Scene": {"gravity", "ground"},
    "Task": {"name"},
    "Vertex": {"x", "y"},
}
_HASH = re.compile(r"RIHS01_[0-9a-f]{64}")
_SETTINGS = {"Task", "Development", "Material", "Scene", "Noise", "Rig", "Chemotaxis"}  # what is missing there has its default
_ABSENT = {"Steering"}  # all 0 where there was none
# What is not there holds none the less: all were so before the field came, or its empty value says that nobody knows.
_TRUE = {
    ("Task", "fitness"), ("Task", "rig"), ("Material", "muscle_range"), ("Evolution", "scheme"), ("Development", "division_room"),
    ("Development", "division_neighbours"), ("Development", "waiting_turn"), ("Evolution", "elongations"), ("Evolution", "fillings"),
    ("Evolution", "redraws"), ("Evolution", "apart"),
}
# Fields that other versions have, and `_upgraded` makes use of; and those that it fills by them.
_USED = {("Audit", "fitness_finer"), ("Audit", "fitness_higher_order"), ("Audit", "unexplained")}
_FILLED = {("Audit", "runs")}


def definition_before(name: str, type_hash: str) -> str | None:
    """The definition that a type of ours had under an older hash: a channel with it holds such messages, whatever its schema says.

    They stand in files of `before/`, named by the type and the hash, without comments.
    """
    package, _, stem = name.partition("/msg/")
    if package != "evodevo_msgs" or not stem.isidentifier() or not _HASH.fullmatch(type_hash or ""):
        return None
    file = Path(__file__).with_name("before") / f"{stem}.{type_hash}.msg"
    return file.read_text(encoding="utf-8") if file.is_file() else None


def lacking(difference: Difference) -> str:
    """Why a type that differs cannot be read truthfully, or nothing."""
    if difference.other:
        return difference.other
    for name, field in difference.missing:
        package, _, stem = name.partition("/")
        if package != "evodevo_msgs" or field in _NEEDED.get(stem, ()):
            return f"{name}.{field} is missing"
    return ""


def words_of(difference: Difference) -> list[str]:
    """What is missing and what is ignored, where that matters to a reader."""
    used = {pair for pair in ((name.rpartition("/")[2], field) for name, field in difference.ignored) if pair in _USED}
    found = []
    for name, field in difference.missing:
        stem = name.rpartition("/")[2]
        if (stem, field) not in _TRUE and not (used and (stem, field) in _FILLED):
            found.append(f"{stem}.{field} is missing ({'its default is taken' if stem in _SETTINGS else 'not known'})")
    found += [f"{name.rpartition('/')[2]}.{field} is ignored" for name, field in difference.ignored
              if (name.rpartition("/")[2], field) not in used]
    return found


def message_of(decoded: Any, message_type: type) -> Any:
    """A message of ours from one that was decoded by its own schema."""
    return _filled(message_type(), decoded)


def _filled(message, decoded):
    stem = type(message).__name__
    if stem == "Task":
        task = default_task(decoded.name) if kind_of(decoded.name) is not None else Task()
        message = task_message(with_settings(task, {f"development.{name}": value for name, value in UNSAID.items()}))
    for name, kind in message.get_fields_and_field_types().items():
        before = getattr(message, name)
        if not hasattr(decoded, name):
            if kind == "double" and stem not in _SETTINGS | _ABSENT:
                setattr(message, name, float("nan"))
            continue
        value = getattr(decoded, name)
        if isinstance(before, array):
            value = array(before.typecode, value)
        elif hasattr(before, "get_fields_and_field_types"):
            value = _filled(before, value)
        elif kind.startswith("sequence<evodevo_msgs/"):
            part = getattr(msg, kind.removesuffix(">").rpartition("/")[2])
            value = [_filled(part(), one) for one in value]
        elif isinstance(before, float):
            value = float(value)
        setattr(message, name, value)
    if stem == "Audit" and not hasattr(decoded, "runs"):
        message.runs = _unnamed_runs(decoded)
    return message


def _unnamed_runs(decoded) -> list[msg.AuditRun]:
    """The runs of an audit that told them by position, under names that say no more than that (see `named`)."""
    nan = float("nan")
    first = getattr(decoded, "fitness", nan)
    runs = [msg.AuditRun(name="as evolved", fitness=first, sustained=nan, unexplained=getattr(decoded, "unexplained", nan))]
    for name in ("fitness_finer", "fitness_higher_order"):
        if hasattr(decoded, name):
            runs.append(msg.AuditRun(name=name, fitness=getattr(decoded, name), change=nan, sustained=nan, unexplained=nan))
    return runs


def named(audit: msg.Audit, task: str) -> None:
    """Give the runs of an audit that told them by position the names that they had in that task."""
    names = {"fitness_finer": "finer steps", "fitness_higher_order": "order 5, adaptive"}
    if task == "walk":  # what stood there were means over other starts
        names = {"fitness_finer": "mean of other starts", "fitness_higher_order": "mean of those in finer steps"}
    elif not task:
        names = {"fitness_finer": "second run, name not recorded", "fitness_higher_order": "third run, name not recorded"}
    for run in audit.runs:
        run.name = names.get(run.name, run.name)
