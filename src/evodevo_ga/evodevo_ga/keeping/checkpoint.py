"""Checkpoints: all that a run is after a generation, in a file of JSON that goes on with the same bits.

    {"evodevo_checkpoint":1,"program":"0.4.0","code":"…","sha256":"…",
    "run":{"settings_hash":…,"task":…,"limits":…,"sources":…,"rig":…,"champion":…,"history":…,"evolution":…}}

The hash is that of everything behind the first line: `tail -n +2 checkpoint.json | sha256sum`.  What the file holds follows from the
run alone, without times and names of computers, so that two runs are equal where their files are.

docs/reference/run.md tells every key.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from evodevo_sim.inputs import shown
from evodevo_sim.parameters import Checked, ParameterError

from evodevo_sim import Genome, Task, __version__

from ..evolution import Evolution
from ..individual import Individual, plain_genome
from .code import search_hash
from .errors import KeepingError, ResumeError
from .files import FILES, Files, replace_file
from .limits import RAISED, Limits
from .text import Texts, compact, listed

VERSION = 1
NAME, BEFORE = "checkpoint.json", "checkpoint-before.json"
_A_RUN = "give the directory of a run of evolve"


def settings_hash(evolution: Evolution, task: Task) -> str:
    """A hash of all that a run's bits follow from, and that no resuming may change: task, search, seed, start, version."""
    settings = {name: value for name, value in dataclasses.asdict(evolution.settings).items() if name not in RAISED}
    start = [plain_genome(genome) for genome in evolution.start]
    told = [__version__, dataclasses.asdict(task), evolution.scheme, settings, evolution.seed, start]
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


class Checkpoints:
    """Writes the checkpoints of a run.

    Args: sources: names of the files that the start genomes came from; files: the calls of the file system; rig:
        namespace of the driver whose body evaluates, if it is one.
    """

    def __init__(
        self, directory: Path, evolution: Evolution, task: Task, limits: Limits, sources: tuple[str, ...], files: Files = FILES,
        rig: str = "",
    ):
        self._path, self._files, self._evolution, self._texts = directory / NAME, files, evolution, Texts()
        about = {
            "settings_hash": settings_hash(evolution, task), "task": dataclasses.asdict(task), "limits": dataclasses.asdict(limits),
            "sources": sources, "rig": rig,
        }
        self._head = ",\n".join(f'"{name}":{compact(value)}' for name, value in about.items())
        self._start = listed([compact(plain_genome(genome)) for genome in evolution.start])

    def expect(self, genomes: Iterable[Genome]) -> None:
        """Prepare for the checkpoint of a generation whose genomes are these, while they are evaluated."""
        self._texts.expect(genomes)

    def write(self, champion: Individual | None, generation: int, history: str) -> None:
        """Keep what the run is.  Raises KeepingError; the checkpoint before is kept then.

        Args: champion: recorded last, in which generation; history: text of JSON, what history has not written yet.
        """
        evolution = self._evolution
        *population, last = self._texts.of([*evolution.population, *([champion] if champion else [])]) or ["null"]
        if champion is None:
            last = "null"
        progress = ",\n".join(f'"{name}":{compact(value)}' for name, value in evolution.progress().items())
        text = (
            f'"run":{{{self._head},\n"champion":{{"generation":{generation if champion else -1},"individual":{last}}},\n'
            f'"history":{history},\n"evolution":{{\n{progress},\n"start":{self._start},\n"population":{listed(population)}}}}}}}\n'
        )
        data = text.encode()
        first = {"evodevo_checkpoint": VERSION, "program": __version__, "code": search_hash(), "sha256": hashlib.sha256(data).hexdigest()}
        try:
            replace_file(self._path, compact(first)[:-1].encode() + b",\n" + data, self._files, self._path.with_name(BEFORE))
        except OSError as error:
            raise KeepingError.of(self._path, error, self._path.parent) from None


def read_checkpoint(directory: Path, instead: str = "") -> tuple[dict[str, Any], list[str]]:
    """The newest checkpoint of a run that is whole.

    Args: instead: of who draws the run and does not go on with it: what can be drawn of a recording that has none.  Then those of other
        code are read too, since no bit rests on it, and a note says so.
    Returns: its `run`; what must be known of it, a line each.  Raises ResumeError.
    """
    if not directory.is_dir():
        raise ResumeError(f"{directory} {'is no directory' if directory.exists() else 'does not exist'}: {_A_RUN}")
    whole: list[dict[str, Any]] = []
    damaged: list[str] = []
    notes: list[str] = []
    for path in (directory / NAME, directory / BEFORE):
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            continue
        except OSError as error:
            raise ResumeError(f"{path} cannot be read ({error.strerror}): {_A_RUN}") from None
        run = _read(data, path, notes if instead else None)
        if run is not None:
            whole.append(run)
        else:
            damaged.append(path.name)
    if not whole:
        raise ResumeError(_why_none(directory, damaged, instead or f"begin anew from its champion by --start {directory}"))
    run = max(whole, key=_generation)  # of equals the first
    notes = notes[:1] + [f"{directory / name} is damaged: going on after generation {_generation(run)}" for name in damaged if name == NAME]
    return run, notes


def _generation(run: dict[str, Any]) -> int:
    return run["evolution"]["generation"]


def _read(data: bytes, path: Path, notes: list[str] | None) -> dict[str, Any] | None:
    """The `run` of a checkpoint; None where it is damaged.  Raises ResumeError where it is whole, and of another version.

    Args: notes: where it is to be drawn alone: takes that it is of other code; None where it is to be gone on with.
    """
    line, _, rest = data.partition(b"\n")
    try:
        first = json.loads(line.rstrip(b", \r") + b"}")
        version, program, code, sha256 = (first[name] for name in ("evodevo_checkpoint", "program", "code", "sha256"))
    except (ValueError, RecursionError, KeyError, TypeError):
        return None
    if hashlib.sha256(rest).hexdigest() != sha256:
        return None
    other = program != __version__ or code != search_hash()
    if other and notes is not None and version == VERSION:
        notes.append(f"{path} is of other code ({shown(program, 20)}, {shown(code, 20)}): what lives anew may live otherwise")
    elif version != VERSION or program != __version__:
        what = f"format {version!r}"[:40] + f" of version {program!r}"[:40]
        this = f"format {VERSION} of version {__version__!r}"
        raise ResumeError(f"{path} is {what}, and this program reads {this}: resume it with the version that it was begun with")
    elif other:
        what = f"{path} is of code {shown(code, 20)} of version {program}, and this is {search_hash()}, whose bits may differ"
        raise ResumeError(f"{what}: resume it with the code that it was begun with")
    try:
        run = json.loads(b"{" + rest)["run"]
        return run if isinstance(run["evolution"]["generation"], int) else None
    except (ValueError, RecursionError, KeyError, TypeError):
        return None


def _why_none(directory: Path, damaged: list[str], instead: str) -> str:
    if damaged:
        are = "are damaged" if len(damaged) > 1 else "is damaged"
        return f"{directory}: {' and '.join(damaged)} {are}: {instead}"
    names = [path.name for path in directory.iterdir()]
    if not names:
        return f"{directory} is empty: {_A_RUN}"
    if any(name.endswith(".mcap") for name in names):
        return f"{directory} holds a recording without a checkpoint: {instead}"
    return f"{directory} holds no {NAME}: {_A_RUN}"


def task_of_plain(plain: dict[str, Any]) -> Task:
    """The task of a checkpoint.  Raises ParameterError."""
    try:
        made: dict[str, Any] = {}
        for field in dataclasses.fields(Task):
            value, default = plain[field.name], field.default
            made[field.name] = type(default)(**value) if isinstance(default, Checked) else value
        return Task(**made)
    except (KeyError, TypeError) as error:
        raise ParameterError(f"task that is not whole ({error}): resume the run with the version that it was begun with") from None
