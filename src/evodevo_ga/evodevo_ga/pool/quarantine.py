"""Genomes that end or hang whoever evaluates them, whole, so that somebody can look into it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from evodevo_sim import Genome, Task, save_genome

DIRECTORY = "quarantine"


def set_apart(run: Path | None, genome: Genome, task: Task, seed: int, cause: str) -> str:
    """Write a genome file that says why into the directory of a run, if there is one.

    Returns: where it is, to go on with a sentence.  A genome has one file.
    """
    if run is None:
        return ""
    path = run / DIRECTORY / f"{hashlib.sha256(genome.key()).hexdigest()[:12]}.yaml"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        about = {"task": task.name, "cells": task.development.max_cells, "seed": seed, "quarantined": cause}
        save_genome(path, genome, about, task.development)
    except OSError as error:
        return f"; it could not be kept: {error.strerror}"
    return f"; it is in {path}"
