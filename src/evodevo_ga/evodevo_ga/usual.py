"""The task of a run of which no more is said than its name, and the law by which its bodies grow."""

from __future__ import annotations

from collections.abc import Sequence

from evodevo_sim.genetics.genome_file import UNSAID, GenomeFile
from evodevo_sim.parameters import Task, default_task, preset, with_settings

from .schemes import scheme_of

GROWTH = "contact_inhibition"  # the preset by which bodies of runs grow where nobody says; empty: the default law of the model


def usual_task(name: str, scheme: str = "") -> Task:
    """The task that runs of a name are about, by a scheme where one is named.  Raises ParameterError where there is none of either."""
    own = scheme_of(scheme).growth if scheme else None
    growth = GROWTH if own is None else own
    return with_settings(default_task(name), dict(preset(growth)) if growth else {})


def law_of(files: Sequence[GenomeFile]) -> dict[str, object]:
    """Those settings of `UNSAID` that genomes to begin from were bred with; none where they do not agree."""
    names = [f"development.{name}" for name in UNSAID]
    laws = [{name: file.growth[name] for name in names} for file in files]
    return laws[0] if laws and all(law == laws[0] for law in laws) else {}
