"""The champions that come with the package: genomes of long runs, to begin from."""

from __future__ import annotations

from pathlib import Path

from .genome import Genome, GenomeError
from .genome_file import load_genome

_FOLDER = Path(__file__).resolve().parents[1] / "champions"


def champions() -> dict[str, Path]:
    """The genome file of each champion, by name."""
    return {file.stem: file for file in sorted(_FOLDER.glob("*.yaml"))}


def load_champion(name: str) -> Genome:
    """The genome of a champion.  Raises GenomeError with the names that exist."""
    files = champions()
    if name not in files:
        raise GenomeError(f"no champion is called {str(name)[:40]!r}: take one of {', '.join(files)}")
    return load_genome(files[name])
