#!/usr/bin/env python
"""This checkout beside another commit, in turns within one run: seconds to compile, milliseconds of evaluations, errors, and bits.

    python benchmarks/baseline.py COMMIT [--rounds N] [--compile N] [--only NAME ...] [--history]

The commit is laid out in a directory of its own, with caches of its own.  Each turn is a process for each side, one after the
other, in an order that changes.  What is timed: the processor time from empty caches to the first evaluated swimmer (--compile
times), and the fastest of a few evaluations of each animal in each turn.  Printed: the median over the turns of the ratio of ours
to theirs.
The error of a swimmer: root mean square over cells of the distance, in cell diameters, from the same life in 32 times the substeps, after
1,000 control steps.  --history appends the rows to benchmarks/history.csv.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import statistics
import subprocess
import sys
import tarfile
import tempfile
from datetime import date
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
HISTORY = Path(__file__).with_name("history.csv")
COLUMNS = ("date", "commit", "baseline", "what", "ratio", "ours", "theirs", "unit", "error", "force_evaluations", "bits")
FIRST = "empty caches to the first swimmer"
ANIMALS = {  # file of the genome, task, settings
    "64 cells": ("swimmer.yaml", "swim", {"development.max_cells": 64}),
    "32 cells": ("swimmer.yaml", "swim", {"development.max_cells": 32}),
    "undulator": ("champions/undulator.yaml", "swim", {}),
    "ribbon": ("champions/ribbon.yaml", "swim", {}),
    "peristalsis": ("champions/peristalsis.yaml", "swim", {}),
    "jellyfish": ("champions/jellyfish.yaml", "swim", {}),
    "seeker, 2 pairs": ("champions/seeker.yaml", "chemotaxis", {"chemotaxis.pairs": 2}),
    "walker": ("champions/walker.yaml", "walk", {}),
}

# What runs on either side: it knows the names that every version has.
SIDE = '''
import hashlib, json, sys, time
from pathlib import Path
import numpy as np
from evodevo_sim import evaluate, load_genome, perform, random_genome
from evodevo_sim.parameters import default_task, with_settings

root, asked = sys.argv[1], json.loads(sys.argv[2])
if not asked:
    evaluate(random_genome(np.random.default_rng(0)), default_task("swim"))
    print(json.dumps(time.process_time()))
    sys.exit()
found = {}
for name, (file, task_name, settings, calls, accurate) in asked.items():
    path = next(path for path in sorted(Path(root, "src").rglob(file)) + [Path(root, "benchmarks", file)] if path.is_file())
    genome, task = load_genome(path), with_settings(default_task(task_name), settings)
    evaluation, took = evaluate(genome, task), []
    for _ in range(calls):
        began = time.perf_counter()
        evaluate(genome, task)
        took.append(time.perf_counter() - began)
    error = None
    if accurate:
        step = min(1000, task.control_steps)
        apart = perform(genome, task).position[step] - perform(genome, task, 0, 32.0).position[step]
        error = float(np.sqrt((apart**2).sum(axis=1).mean()))
    steps = evaluation.metrics.substeps * 4 * task.control_steps if task_name == "swim" else None
    bits = hashlib.sha256(repr(evaluation.fitness).encode()).hexdigest()[:8]
    found[name] = {"ms": 1e3 * min(took), "error": error, "force_evaluations": steps, "bits": bits}
print(json.dumps(found))
'''


def laid_out(commit: str, directory: Path) -> Path:
    """The files of a commit."""
    command = ["git", "-C", str(ROOT), "archive", commit, "src", "benchmarks"]
    with tarfile.open(fileobj=io.BytesIO(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)) as files:
        files.extractall(directory, filter="data")
    return directory


def answer(root: Path, caches: Path, asked: dict) -> dict:
    """What a process of one side finds."""
    environment = os.environ | {"PYTHONPATH": f"{root}/src/evodevo_sim", "NUMBA_CACHE_DIR": str(caches)}
    command = [sys.executable, "-c", SIDE, str(root), json.dumps(asked)]
    return json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True, text=True).stdout.splitlines()[-1])


def named(commit: str) -> str:
    return subprocess.run(
        ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude=*"] if commit == "" else
        ["git", "-C", str(ROOT), "rev-parse", "--short", commit], stdout=subprocess.PIPE, check=True, text=True,
    ).stdout.strip()


def compare(commit: str, rounds: int, compilations: int, only: list[str]) -> list[dict]:
    """Rows of COLUMNS."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        theirs = laid_out(commit, Path(place, "theirs"))
        caches = {root: Path(place, f"caches-{k}") for k, root in enumerate((ROOT, theirs))}
        about = {"date": date.today().isoformat(), "commit": named(""), "baseline": named(commit)}
        pairs = []
        for k in range(compilations):
            took = {root: answer(root, Path(place, f"empty-{root.name}-{k}"), {}) for root in (ROOT, theirs)[:: 1 - 2 * (k % 2)]}
            pairs.append((took[ROOT], took[theirs]))
        if pairs:
            rows.append(about | {"what": FIRST, "unit": "s"} | _median(pairs))
        calls = {name: (*animal, 5, animal[1] == "swim") for name, animal in ANIMALS.items() if not only or name in only}
        found = {root: answer(root, caches[root], calls) for root in (ROOT, theirs)}  # compiles, and is not counted
        quick = {name: (*animal[:-1], False) for name, animal in calls.items()}
        turns: dict[str, list[tuple[float, float]]] = {name: [] for name in calls}
        for k in range(rounds):
            took = {root: answer(root, caches[root], quick) for root in (ROOT, theirs)[:: 1 - 2 * (k % 2)]}
            for name in calls:
                turns[name].append((took[ROOT][name]["ms"], took[theirs][name]["ms"]))
        for name, pairs in turns.items():
            ours = found[ROOT][name]
            more = {"error": ours["error"], "force_evaluations": ours["force_evaluations"], "bits": ours["bits"]}
            rows.append(about | {"what": name, "unit": "ms"} | _median(pairs) | more)
    return rows


def _median(pairs: list[tuple[float, float]]) -> dict[str, float]:
    return {
        "ratio": round(statistics.median(one / other for one, other in pairs), 3),
        "ours": round(statistics.median(one for one, _ in pairs), 2), "theirs": round(statistics.median(other for _, other in pairs), 2),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("baseline", metavar="COMMIT", help="that is measured beside this checkout")
    parser.add_argument("--rounds", type=int, default=7, help="turns (default 7)")
    parser.add_argument("--compile", type=int, default=1, dest="compilations", metavar="N", help="compilations of each side (default 1)")
    parser.add_argument("--only", nargs="+", choices=list(ANIMALS), default=[], metavar="NAME", help=f"of {', '.join(ANIMALS)}")
    parser.add_argument("--history", action="store_true", help=f"append the rows to {HISTORY.name}")
    given = parser.parse_args()
    rows = compare(given.baseline, given.rounds, given.compilations, given.only)
    table = Table("what", "ratio", "ours", "theirs", "error", "force evaluations", "bits", title=f"beside {given.baseline}")
    for row in rows:
        error = "" if row.get("error") is None else f"{row['error']:.1e}"
        values = (f"{row['ratio']:.3f}", f"{row['ours']:g} {row['unit']}", f"{row['theirs']:g} {row['unit']}", error)
        table.add_row(row["what"], *values, str(row.get("force_evaluations") or ""), row.get("bits", ""))
    Console().print(table)
    if given.history:
        new = not HISTORY.exists()
        with HISTORY.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
