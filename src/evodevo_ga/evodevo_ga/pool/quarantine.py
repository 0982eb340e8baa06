"""Genomes that end or hang whoever evaluates them, whole, so that somebody can look into it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from evodevo_sim import Genome, Task, save_genome

DIRECTORY = "quarantine"


def set_apart(directory: Path, genome: Genome, task: Task, seed: int, cause: str) -> Path:
    """Write a genome file that says why.  Returns: its path, which is the same for the same genome.  Raises OSError."""
    directory.mkdir(exist_ok=True)
    path = directory / f"{hashlib.sha256(genome.key()).hexdigest()[:12]}.yaml"
    save_genome(path, genome, {"task": task.name, "cells": task.development.max_cells, "seed": seed, "quarantined": cause})
    return path
