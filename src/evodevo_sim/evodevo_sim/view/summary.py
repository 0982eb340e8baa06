"""Settings and champion of a recording in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from evodevo_msgs import msg

from ..analysis.gait.table import headline as gait_headline
from ..analysis.stretches import holes, words_of_holes
from ..recording import Recording
from ..recording.gait import gait_of_recording
from ..recording.life import Life
from ..tasks.outcome import Status
from .palettes import DEFAULT, legend_of

BETWEEN = "  ·  "  # facts in a line


def headline(recording: Recording, life: Life) -> tuple[str, str]:
    """Name, and one line of what the recording is."""
    facts, settings = [], recording.settings
    if settings is not None:
        facts.append(f"{settings.task.name}, seed {settings.seed}")
    if recording.statistics:
        facts.append(f"{len(recording.statistics)} generations" + (f" of {settings.population}" if settings is not None else ""))
    if recording.champions:
        found = _audit(recording)
        mark = "" if found is None or found.stands else ", which fails its audit"
        facts.append(f"fitness {recording.champions[-1].evaluation.fitness:.3f}{mark}")
        if found is not None and found.stands and len(found.runs) > 1:
            facts.append("audit: " + ", ".join(f"{run.fitness:.3f} {run.name}" for run in found.runs[1:]))
    if len(life.time):
        facts.append(f"{life.position.shape[1]} cells, {len(life.chambers)} chambers")
        seconds = life.time[-1] - life.time[0]
        away: np.ndarray = life.target_distance[np.isfinite(life.target).all(axis=1)] if len(life.target) else np.empty(0)
        if len(away):
            facts.append(f"{away[0]:.1f}, then {away[-1]:.1f} m from the target in {seconds:.1f} s")
        else:
            facts.append(f"{life.distance[-1]:.2f} cell diameters in {seconds:.1f} s")
    gait = gait_of_recording(recording, life)
    if gait is not None:
        facts.append(f"gait: {gait.name}")
    if recording.truncated:
        facts.append("the end of the recording is missing")
    if len(holes(life.time)):
        facts.append("states are missing in the middle")
    return name_of(recording.path), BETWEEN.join(facts)


def name_of(path: Path) -> str:
    """A recording's name: its directory's, or its file's without the ending."""
    path = path.resolve()
    return path.stem if path.suffix in (".mcap", ".db3") else path.name


def markdown(recording: Recording, life: Life, palette: str = DEFAULT) -> str:
    """All of it, as Markdown.  Args: palette: of the cells.

    Tables hold short values alone, since the viewer cuts their rows at the panel's edge; paragraphs it wraps.
    """
    parts = [f"# {name_of(recording.path)}"]
    missing = words_of_holes(life.time)
    parts += [f"*{line}.*" for line in (*recording.notes, *([missing] if missing else []))]
    if len(life.time) or life.growth:
        parts.append(f"**Colours**, by e - c: {legend_of(palette)}.")
    if recording.champions:
        parts.append(_champion(recording.champions[-1], _audit(recording)))
    if len(life.time):
        cells, seconds = life.position.shape[1], life.time[-1] - life.time[0]
        parts.append(f"**Shown:** {cells} cells, {seconds:.1f} s, {life.distance[-1]:.3g} cell diameters from birth.")
    gait = gait_of_recording(recording, life)
    if gait is not None:
        parts.append(f"**Gait:** {gait_headline(gait)}; {gait.why}.")
    if recording.statistics:
        last = recording.statistics[-1]
        parts.append(
            f"**Evolution:** {len(recording.statistics)} generations, {last.evaluations} evaluations, "
            f"best {last.best:.3f}, median {last.median:.3f}, diversity {last.diversity:.2f}."
        )
    if recording.audits:
        failed = [str(audit.generation) for audit in recording.audits if not audit.stands]
        which = f"failed: those of generations {', '.join(failed)}." if failed else "failed."
        parts.append(f"**Audits:** {len(recording.audits)} champions, {len(failed) or 'none'} {which}")
    if recording.settings:
        rows = _numbers(recording.settings)
        parts.append("## Settings\n\n" + _table({"scheme": "", **rows} | {"scheme": rows["scheme"] or "not recorded"}))
    return "\n\n".join(parts) + "\n"


def _audit(recording: Recording) -> msg.Audit | None:
    """The audit of the last champion, if there is one."""
    generation = recording.champions[-1].generation
    return next((audit for audit in reversed(recording.audits) if audit.generation == generation), None)


def _champion(champion: msg.Champion, audit: msg.Audit | None) -> str:
    evaluation, metrics = champion.evaluation, champion.evaluation.metrics
    status = Status(evaluation.status).name if evaluation.status in list(Status) else str(evaluation.status)
    rows = {
        "fitness": f"{evaluation.fitness:.4g}", "generation": champion.generation, "status": status,
        "genetic elements": len(champion.genome.kind), "cells": metrics.cells, "springs": metrics.springs,
        "chambers": metrics.chambers, "distance, m": f"{metrics.distance:.4g}",
        "in the second half, m": f"{metrics.distance_second_half:.4g}",
        "activation amplitude": f"{metrics.activation_amplitude:.3g}",
        **_runs(audit),
    }
    steering = metrics.steering
    if steering.distance:
        for side in ("left", "right"):
            rows[f"target on the {side}, m"] = f"{steering.distance:.3g} at birth, {getattr(steering, side + '_distance'):.3g} at the end"
    said = [f"**Audit:** {_verdict(audit)}."]
    if evaluation.cause:
        said.insert(0, f"**Failed:** {evaluation.cause}.")
    return "\n\n".join(["## Champion", _table(rows), *said])


def _verdict(audit: msg.Audit | None) -> str:
    if audit is None:
        return "none"
    return "the fitness stands" if audit.stands else "**failed:** " + "; ".join(audit.faults)


def _runs(audit: msg.Audit | None) -> dict:
    """A row for each way in which the life was repeated, by its name."""
    runs = audit.runs[1:] if audit is not None else ()
    return {f"audit, {run.name}": f"{run.fitness:.6g}" for run in runs if not run.cause}


def _numbers(message, prefix: str = "") -> dict:
    """The fields of a message and of those in it, by dotted name."""
    rows: dict[str, Any] = {}
    for name in message.get_fields_and_field_types():
        value = getattr(message, name)
        if isinstance(value, list):  # of genomes to begin from
            value = len(value)
        nested = hasattr(value, "get_fields_and_field_types")
        rows |= _numbers(value, f"{prefix}{name}.") if nested else {prefix + name: value}
    return {name: f"{value:g}" if isinstance(value, float) else value for name, value in rows.items()}


def _table(rows: dict) -> str:
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows.items())])
