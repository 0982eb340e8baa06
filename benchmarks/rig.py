#!/usr/bin/env python
"""Bred with the rig and bred without: what a champion keeps of its simulated distance on an emulated rig with slow actuators.

    python benchmarks/rig.py --seeds 5 --generations 40
    python benchmarks/rig.py --seeds 1 --first 3 --lag 0.3 --rate 2 --csv rig.csv --genomes out

Each seed breeds two swimmers, one with the rig in the task and one without.  Both then swim on the emulated body: firmware, protocol,
limits, calibration, actuators and camera, from its shape at birth, by the driver's evaluation (`hardware.trial`) at the body's own clock.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from pathlib import Path

import numpy as np
from evodevo_sim.hardware.calibration import calibration_of
from evodevo_sim.hardware.emulator import EmulatedBody
from evodevo_sim.hardware.rig import Rig, rig_of
from evodevo_sim.hardware.stepped import SteppedBody
from evodevo_sim.hardware.trial import trial
from evodevo_sim.live.animat import Animat
from evodevo_sim.parameters import default_task, with_settings
from rich.console import Console
from rich.table import Table
from tqdm import trange

from evodevo_ga import Evolution, Settings, default_scheme, scheme
from evodevo_sim import Genome, Task, evaluate, save_genome

COLUMNS = ("seed", "bred", "generations", "evaluations", "simulated", "emulated", "share", "frequency", "cells", "seconds")


def bred(task: Task, seed: int, generations: int, population: int) -> tuple[Genome, int]:
    """(the champion of a run of that seed, evaluations that it took)."""
    name = default_scheme(task.name)
    numbers = {**scheme(name, task.name), "generations": generations} | ({"population": population} if population else {})
    evolution = Evolution(Settings(**numbers), seed, (), name, task)
    for _ in trange(generations, desc=f"seed {seed}, lag {task.rig.lag:g} s", leave=False, mininterval=10.0):
        if evolution.finished:
            break
        genomes = evolution.ask()
        bars = evolution.bars or [-np.inf] * len(genomes)
        evolution.tell([evaluate(genome, task, seed, bar) for genome, bar in zip(genomes, bars)])
    return evolution.champion.genome, evolution.evaluations


def emulated(genome: Genome, task: Task, rig: Rig, seed: int) -> float:
    """m that a swimmer goes on the emulated rig, in the time of its task."""
    plain = with_settings(default_task(task.name), {"development.max_cells": task.development.max_cells})
    animat = Animat(genome, plain, seed)
    calibration = calibration_of(animat.body.position)
    body = SteppedBody(EmulatedBody(animat.plant, calibration, rig, plain.control_step), calibration, plain.control_step)
    found = trial(genome, plain, seed, body)
    assert not found.cause, found.cause
    return found.metrics.distance


def frequency(genome: Genome, task: Task, seed: int) -> float:
    """Hz, of the strongest component of what its muscles are asked for."""
    from evodevo_sim import perform

    activation = perform(genome, task, seed).activation[task.control_steps // 2 :]
    power = (np.abs(np.fft.rfft(activation - activation.mean(0), axis=0)) ** 2).sum(1)
    return float(np.fft.rfftfreq(len(activation), task.control_step)[power.argmax()])


def row_of(seed: int, how: str, task: Task, rig: Rig, given: argparse.Namespace) -> dict[str, object]:
    began = time.monotonic()
    genome, evaluations = bred(task, seed, given.generations, given.population)
    found = evaluate(genome, task, seed)
    far = emulated(genome, task, rig, seed)
    if given.genomes:
        Path(given.genomes).mkdir(parents=True, exist_ok=True)
        save_genome(Path(given.genomes) / f"{how}-{seed}.yaml", genome, {"task": task.name, "seed": seed, "rig.lag": task.rig.lag})
    return {
        "seed": seed, "bred": how, "generations": given.generations, "evaluations": evaluations, "simulated": found.metrics.distance,
        "emulated": far, "share": far / max(found.metrics.distance, 1e-12), "frequency": frequency(genome, task, seed),
        "cells": found.metrics.cells, "seconds": round(time.monotonic() - began),
    }


def show(rows: list[dict[str, object]]) -> None:
    table = Table("seed", "bred", "simulated m", "emulated m", "share", "Hz", "cells")
    for row in rows:
        numbers = (f"{row['simulated']:.2f}", f"{row['emulated']:.2f}", f"{row['share']:.0%}", f"{row['frequency']:.2f}")
        table.add_row(str(row["seed"]), str(row["bred"]), *numbers, str(row["cells"]))
    Console().print(table)
    for how in ("with", "without"):
        of = [row for row in rows if row["bred"] == how]
        if of:
            far, share = (np.median([row[name] for row in of]) for name in ("emulated", "share"))
            print(f"bred {how} the rig: median {far:.2f} m on it, {share:.0%} of the simulated distance")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5, help="runs, of seeds FIRST, FIRST + 1, ... (default %(default)s)")
    parser.add_argument("--first", type=int, default=1, help="first seed (default %(default)s)")
    parser.add_argument("--generations", type=int, default=40, help="of each run (default %(default)s)")
    parser.add_argument("--population", type=int, default=0, help="of each run (default that of the task's scheme)")
    parser.add_argument("--lag", type=float, default=0.15, help="s, of the rig's actuators (default %(default)s)")
    parser.add_argument("--rate", type=float, default=4.0, help="1/s, likewise (default %(default)s)")
    parser.add_argument("--only", choices=("with", "without"), help="breed with the rig, or without it, alone")
    parser.add_argument("--csv", metavar="FILE", help="append the rows to a file as well")
    parser.add_argument("--genomes", metavar="DIR", help="keep champions there, as YAML")
    given = parser.parse_args()
    plain = with_settings(default_task("swim"), {"development.max_cells": 32})
    slow = with_settings(plain, {"rig.lag": given.lag, "rig.rate": given.rate})
    rows = []
    for seed in range(given.first, given.first + given.seeds):
        for how, task in (("with", slow), ("without", plain)):
            if given.only in (None, how):
                rows.append(row_of(seed, how, task, rig_of(slow.rig), given))
                if given.csv:
                    append(given.csv, rows[-1])
    show(rows)


def append(path: str, row: dict[str, object]) -> None:
    new = not os.path.exists(path)
    with open(path, "a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if new:
            writer.writeheader()
        writer.writerow(row)


if __name__ == "__main__":
    main()
