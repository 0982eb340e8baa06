"""`ros2 run evodevo_sim info BAG|GENOME ...`: what a recording or a genome is, how it ended, and what can be drawn from it."""

from __future__ import annotations

import shlex
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..ros.command_line import Parser, warn
from ..ros.environment import need_no_graph, without_ros

_EPILOG = """\
examples:
  ros2 run evodevo_sim info bags/sample-swim
      what it is, versions, how it ended, topics, and what can be drawn from it
  ros2 run evodevo_sim info bags/sample-swim/champion.yaml
      a genome: its elements and network, and what its file tells about it
  ros2 run evodevo_sim info bags/sample-swim --json
      the same for programs, a JSON object a line

How a recording ended: complete; cut, without its end; torn, damaged in the middle; unfinished, where the run did not get to its champion's
life. What is no recording and no genome is said in a line, with exit code 2, after the others.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("info", "Tell what recordings and genomes are.", _EPILOG)
    parser.add_argument("sources", nargs="+", type=Path, metavar="BAG|GENOME", help="recordings, or genome files")
    parser.add_argument("--json", action="store_true", help="a JSON object a line, in the order of the arguments")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError, is_recording

    code = 0
    for place, source in enumerate(given.sources):
        try:
            told = recording_told(source) if is_recording(source) else genome_told(source)
        except (GenomeError, RecordingError) as error:
            warn(parser.prog)(str(error))
            code = 2
            continue
        if given.json:
            import json

            print(json.dumps(told, ensure_ascii=False), flush=True)
        else:
            if place:
                print()
            _show(told)
    return code


def recording_told(path: Path) -> dict[str, Any]:
    """The facts of a recording, as plain data.  Raises RecordingError."""
    from ..recording.facts import facts_of, moment, numbers, writer_of

    facts = facts_of(path)
    recording, life = facts.recording, facts.life
    settings = recording.settings
    told: dict[str, Any] = {"source": str(path), "is": "recording"}
    word, words = facts.ending
    told |= {"what": _what(recording, life), "ended": word, "ended_in_words": words, "notes": recording.notes}
    told |= {
        "files": [str(file) for file in facts.files], "bytes": facts.bytes, "writer": writer_of(path),
        "from": moment(facts.began), "seconds": (facts.ended - facts.began) * 1e-9, "messages": numbers(recording),
        "topics": [dict(zip(("topic", "type", "messages", "read"), row)) for row in facts.topics],
    }
    if settings is not None:
        told["run"] = {
            "version": settings.version, "task": settings.task.name, "seed": settings.seed, "scheme": settings.scheme or "not recorded",
            "population": settings.population, "generations": len(recording.statistics),
            "evaluations": recording.statistics[-1].evaluations if recording.statistics else 0,
        }
    if recording.champions:
        last = recording.champions[-1]
        audit = next((one for one in reversed(recording.audits) if one.generation == last.generation), None)
        verdict = "none" if audit is None else "the fitness stands" if audit.stands else "failed: " + "; ".join(audit.faults)
        told["champion"] = {
            "fitness": last.evaluation.fitness, "generation": last.generation, "elements": len(last.genome.kind), "audit": verdict,
        }
    if recording.gait is not None:
        told["gait"] = recording.gait.name
    if len(life.time) or life.growth:
        cells = life.position.shape[1] if len(life.time) else len(life.growth[-1].position)
        told["life"] = {
            "cells": cells, "springs": len(life.springs), "chambers": len(life.chambers), "growth_steps": len(life.growth),
            "states": len(life.time), "seconds": float(life.time[-1] - life.time[0]) if len(life.time) else 0.0,
            "ground": life.scene is not None,
        }
    told["drawn"] = _drawn(recording, life, path)
    return told


def _what(recording, life) -> str:
    parts = []
    if recording.settings is not None or recording.statistics:
        parts.append("a run of evolve")
    if len(life.time):
        parts.append("the life of its champion" if parts else "the life of one body, with its growth" if life.growth else "a motion")
    elif life.growth:
        parts.append("growth")
    if len(recording.targets) > 1:
        parts.append("targets that it followed")
    if recording.actuation:
        parts.append("what its muscles were told")
    return ", ".join(parts) or "messages of evodevo's, without a run or a life"


def _drawn(recording, life, path: Path) -> list[dict[str, str]]:
    """What can be drawn: each command that is installed, and what is missing where it cannot."""
    from ..recording.facts import purposes

    named = shlex.quote(str(path))

    def row(command: str, missing: str, package: str = "evodevo_sim") -> dict[str, str]:
        return {"package": package, "command": command, "missing": missing}

    lives = "" if len(life.time) else "no motion of a body"
    task = recording.settings.task.name if recording.settings is not None else ""
    network = "" if recording.champions and task else "no run with a champion"
    rows = [row(f"replay {named} --show {name}", missing) for name, missing in purposes(recording, life).items()]
    anything = "" if not lives or life.growth or recording.statistics else "no life and no generations"
    rows += [row(f"replay {named} --picture FILE", anything), row(f"gait {named} --out FILE", lives)]
    seeks = "" if task == "chemotaxis" else f"a run of {task}, not of chemotaxis"
    rows.append(row(f"turning {named} --out FILE", network or seeks))
    if find_spec("evodevo_sim.commands.film"):
        rows.append(row(f"film {named} -o FILE", "" if life.growth or not network else lives))  # a champion lives anew for it
    if find_spec("evodevo_sim.commands.figure"):
        needs = {
            "growth": "" if len(life.growth) > 1 else "no growth", "gait": lives, "traces": lives, "turning": network or seeks,
            "fitness": "" if recording.statistics else "no generations of a run",
            "work-precision": network or ("a run on ground, where contacts are chaotic" if life.scene is not None else ""),
        }
        rows += [row(f"figure {kind} {named} -o FILE", missing) for kind, missing in needs.items()]
    if find_spec("evodevo_ga"):
        run = "" if recording.settings is not None and recording.statistics else "no generations of a run"
        scheme = recording.settings.scheme if recording.settings is not None else ""
        beside = path if path.is_dir() else path.parent
        kept = "" if (beside / "hall_of_fame").is_dir() else "no history beside it"
        archive = "" if scheme == "archive" else f"a run of scheme {scheme}, not of an archive" if scheme else "no archive"
        rows += [
            row(f"report {named} -o FILE.html", run, "evodevo_ga"),
            row(f"descent {shlex.quote(str(beside))} -o FILE", run or kept, "evodevo_ga"),
            row(f"gallery {shlex.quote(str(beside))} -o FILE", run or archive, "evodevo_ga"),
        ]
    return rows


def genome_told(path: Path) -> dict[str, Any]:
    """The facts of a genome file, as plain data.  Raises GenomeError."""
    import numpy as np

    from ..genetics.elements import HEADER, KINDS
    from ..genetics.genome_file import read_genome
    from ..genetics.regulation import express

    file = read_genome(path)
    genome = file.genome
    weights, units = express(*genome.arrays())
    counts = np.bincount(genome.kind[HEADER:], minlength=len(KINDS))
    return {
        "source": str(path), "is": "genome", "what": "a genome", "about": dict(file.about), "growth": dict(file.growth),
        "elements": len(genome), **{name: int(counts[k]) for k, name in enumerate(KINDS) if k},
        "units": int(units), "connections": int(np.count_nonzero(weights)), "bytes": path.stat().st_size,
    }


def _show(told: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    console.print(f"{told['source']}: {told['what']}", style="bold", soft_wrap=True, markup=False)
    table = Table.grid(padding=(0, 2))
    for name, value in _rows(told):
        table.add_row(name, value)
    console.print(table)
    if told["is"] == "genome":
        return
    topics = Table("topic", "type", "messages", "read", box=None, padding=(0, 2, 0, 0))
    for column in topics.columns:
        column.no_wrap = True
    for one in told["topics"]:
        topics.add_row(one["topic"], one["type"].replace("/msg/", "/"), f"{one['messages']:,}", "here" if one["read"] else "by others")
    console.print("\nTopics", style="bold")
    console.print(topics)
    console.print("\nWhat can be drawn from it", style="bold")
    for one in told["drawn"]:
        if not one["missing"]:
            console.print(f"  ros2 run {one['package']} {one['command']}", soft_wrap=True, markup=False)
    for one in told["drawn"]:
        if one["missing"]:
            console.print(f"  not {one['command']}: {one['missing']}", style="dim", soft_wrap=True, markup=False)


def _rows(told: dict[str, Any]):
    if told["is"] == "genome":
        yield from told["about"].items()
        kinds = ", ".join(f"{told[name]} {name.replace('_', ' ')}" for name in ("regulatory", "transcription_factor", "morphogen"))
        yield "elements", f"{told['elements']}, of which {kinds}"
        yield "network", f"{told['units']} units, {told['connections']} connections"
        yield "bred with", " ".join(f"{name}={value}" for name, value in told["growth"].items())
        return
    yield "ended", told["ended_in_words"]
    for note in told["notes"]:
        yield "note", note
    if "run" in told:
        run = told["run"]
        yield "version", f"evodevo {run['version']}"
        yield "task", f"{run['task']}, seed {run['seed']}"
        yield "search", f"{run['scheme']}, {run['generations']} generations of {run['population']}, {run['evaluations']:,} evaluations"
    if "champion" in told:
        best = told["champion"]
        yield "champion", f"fitness {best['fitness']:.4g}, of generation {best['generation']}, {best['elements']} elements"
        yield "audit", best["audit"]
    if "gait" in told:
        yield "gait", told["gait"]
    if "life" in told:
        life = told["life"]
        yield "body", f"{life['cells']} cells, {life['springs']} springs, {life['chambers']} chambers"
        ground = ", with ground" if life["ground"] else ""
        yield "life", f"{life['growth_steps']:,} steps of growth, {life['states']:,} states in {life['seconds']:.1f} s{ground}"
    yield "recorded", f"from {told['from']}, {told['seconds']:.1f} s" + (f", {told['writer']}" if told["writer"] else "")
    files = f"{len(told['files'])} files" if len(told["files"]) > 1 else "1 file"
    yield "size", f"{told['bytes'] / 1e6:.2f} MB in {files}"


if __name__ == "__main__":
    from .entry import info as entry

    sys.exit(entry())
