"""The command line of `evolve`: flags into a Task, Settings and the rest, or one clear line and exit code 2."""

from __future__ import annotations

import dataclasses
import os
import re
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evodevo_sim.inputs import shown
from evodevo_sim.parameters import PRESETS, ParameterError, Task, default_task, known_kind, preset, with_settings
from evodevo_sim.ros.command_line import Parser, add_plant, real_number, settings_of, warn, whole_number
from evodevo_sim.ros.environment import without_ros
from evodevo_sim.task_kinds import names

from .keeping.limits import NONE, Limits
from .schemes import SCHEMES, default_scheme, scheme, search_of
from .settings import UNLIMITED, Settings

if TYPE_CHECKING:
    from evodevo_sim.genetics.genome import Genome

    from .keeping.resume import Resumed

_EPILOG = """\
examples:
  ros2 run evodevo_ga evolve
      a swimmer of up to 32 cells in one to three minutes on two cores
  ros2 run evodevo_ga evolve --generations 1000 --seed 7 --out bags/long
      a long run; Ctrl-C ends it at any time and keeps all that was done
  ros2 run evodevo_ga evolve --preset high_drag
      in a thick fluid
  ros2 run evodevo_ga evolve --scheme panmictic
      one population in which all compete, instead of an archive of unlike bodies
  ros2 run evodevo_ga evolve --task walk --world rough
      a walker on uneven ground (docs/guide/walk.md tells the worlds)
  ros2 run evodevo_ga evolve --plant plant.yaml
      for a rig with slow valves, as docs/guide/hardware.md describes it
  ros2 run evodevo_ga evolve --scheme paper --set task.fitness=distance
      the paper's search, until 500 generations bring nothing, for its plain distance (docs/reference/swimming.md tells what earns that)
  ros2 run evodevo_ga evolve --set scene.drag_normal=10 --set scene.drag_tangential=0.05
      any number of the model can be set so (docs/reference/parameters.md lists them)

  ros2 run evodevo_ga evolve --task chemotaxis --start bags/long
      begins from swimmers: half of the first population is the champion of a run and its mutants

  ros2 run evodevo_ga evolve --rig /eel --start champion.yaml --population 10 --generations 3
      on a body of rubber and air, that a driver has in the namespace /eel (docs/guide/hardware.md)

  ros2 run evodevo_ga evolve --resume bags/long --generations 2000
      goes on with a run, whatever ended it, to the same bits as if nothing had; --generations, --patience, --evaluations and --hours
      may be raised, nothing else changed

Simulator nodes found on the ROS graph do the work, e.g. those that you start yourself by
  ros2 run evodevo_sim simulator --ros-args -r __ns:=/sim_0
Any that come later are used too.  When there are none, evolve starts one of its own with a thread per core, or with --simulators N
and --threads N as many as these say, and ends them.  With --backend local threads of evolve itself evaluate, and with --backend dask
the workers of a Dask scheduler (docs/guide/cluster.md), to the same bits.

The run's directory holds a rosbag2 recording in MCAP, champion.yaml, a checkpoint of the last generation, and every individual
as Parquet (docs/reference/run.md). See it by
  ros2 run evodevo_sim replay DIR

Exit code: 0; 1 where nothing viable evolved, the best of all having failed; 2 for bad input, or where no simulator is left; 130
where Ctrl-C, SIGTERM or a terminal that closed ended it early. That ends in good order: the best animat is audited and recorded.
A second Ctrl-C ends at once, and keeps what was recorded.
A closed output, as of `evolve | head`, ends nothing.
"""
BACKENDS = ("ros", "local", "dask")
_ONE_BODY = "one-body"  # the scheme of who has a rig
_NAMESPACE = re.compile(r"/|(/[A-Za-z_]\w*)+")
_NUMBER = {int: whole_number, float: real_number}


@dataclasses.dataclass(frozen=True)
class Options:
    task: Task
    settings: Settings
    seed: int
    out: Path
    simulators: int | None  # None: those on the graph, or else one of our own
    look: float  # s to look for simulators on the graph
    quiet: bool
    start: tuple[Genome, ...] = ()
    scheme: str = "panmictic"
    threads: int | None = None  # of each simulator of our own; None: one a core in one, or 1 in each of `simulators`
    give_up_after: float = 3600.0  # s without a simulator
    limits: Limits = NONE
    sources: tuple[str, ...] = ()  # of the start genomes
    resumed: Resumed | None = None  # the run that goes on
    view: str | None = None  # the Rerun file of who watches, or nothing for the viewer; None: nobody does
    backend: str = "ros"  # one of BACKENDS
    scheduler: str = ""  # of Dask; empty: a cluster of our own
    rig: str = ""  # namespace of a driver of hardware, whose body evaluates; empty: nobody has one


def parse(arguments: list[str]) -> Options:
    """Options of a command line.  Leaves with exit code 2 and one line where something is wrong."""
    parser = Parser("evolve", "Evolve soft-bodied animats that grow from one cell and move without a central controller.", _EPILOG)
    what = f"what to evolve for: {', '.join(names())} (default %(default)s)"
    parser.add_argument("--task", default=names()[0], metavar="NAME", help=what)
    worlds = "walk: flat, slope, steps, rough, obstacles, gap, or a file of your own (default flat)"
    parser.add_argument("--world", metavar="NAME|FILE", help=worlds)
    add_plant(parser, "evolve for the ")
    starts = f"walk: orientations at birth, of which the worse half counts (default {default_task('walk').starts})"
    parser.add_argument("--starts", type=whole_number, metavar="N", help=starts)
    parser.add_argument("--cells", default=32, type=whole_number, metavar="N", help="most cells of a body (default %(default)s)")
    parser.add_argument(
        "--seed", default=1, type=whole_number, metavar="N", help="same seed, same champions, bit for bit (default %(default)s)"
    )
    parser.add_argument("--out", metavar="DIR", help="directory of the run, made anew (default bags/TASK-DATE-TIME)")
    parser.add_argument("--simulators", type=whole_number, metavar="N", help="start N simulator nodes of our own, whatever is on the graph")
    backends = "who evaluates: simulator nodes (ros), threads of this process (local), or workers of Dask (dask) (default %(default)s)"
    parser.add_argument("--backend", default=BACKENDS[0], metavar="NAME", help=backends)
    parser.add_argument(
        "--scheduler", default="", metavar="ADDRESS", help="dask: e.g. tcp://HOST:8786 (default: a worker of our own, a thread per core)"
    )
    rigs = "evaluate on the body of a driver of hardware, one life after the other, beginning from --start; its networks alone vary"
    parser.add_argument("--rig", metavar="NAMESPACE", help=rigs)
    threads = "threads of each simulator of our own (default: one a core in one simulator, or 1 where --simulators is given)"
    parser.add_argument("--threads", type=whole_number, metavar="N", help=threads)
    parser.add_argument(
        "--give-up-after", default=3600.0, type=real_number, metavar="S",
        help="seconds to wait for a simulator where the last one is gone (default %(default)s)",
    )
    parser.add_argument(
        "--look", default=1.5, type=real_number, metavar="S", help="seconds to look for simulators on the graph (default %(default)s)"
    )
    parser.add_argument("--start", nargs="+", default=[], metavar="FILE|DIR", help="genomes to begin from, or runs with a champion.yaml")
    parser.add_argument("--resume", metavar="DIR", help="go on with the run in a directory, after its last whole generation")
    parser.add_argument("--evaluations", type=whole_number, metavar="N", help="end at the generation that brings their number to N")
    hours = "end at the first generation that ends after so many hours of wall time, all sessions of the run together"
    parser.add_argument("--hours", type=real_number, metavar="H", help=hours)
    seen = "watch the run in the Rerun viewer, or without a display into a file for it"
    parser.add_argument("--view", nargs="?", const="", metavar="FILE.rrd", help=seen)
    parser.add_argument("--quiet", action="store_true", help="no progress bar, and no table of times")
    group = parser.add_argument_group("genetic algorithm")
    group.add_argument(
        "--scheme", metavar="NAME",
        help="a way to search and its set of the numbers below, which go over it (default: what suits the task); "
        f"{'; '.join(f'{one.name}: {one.what}' for one in SCHEMES.values())}".replace("%", "%%"),
    )
    named = {name: known_kind(name).search for name in names()} | {one.name: one.settings for one in SCHEMES.values()}
    for field in dataclasses.fields(Settings):
        group.add_argument(
            f"--{field.name.replace('_', '-')}", type=_NUMBER[type(field.default)], metavar="N" if isinstance(field.default, int) else "X",
            help=f"{field.metadata['meaning']} (default {_defaults(field, named)})",
        )
    parser.add_argument("--preset", metavar="NAME", help=f"a named set of numbers of the model: {', '.join(PRESETS)}")
    sets = "set a number of the model, e.g. material.stiffness=300"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=sets)
    given = parser.parse_args(without_ros(arguments))
    _check_numbers(parser, given)
    if given.resume is not None:
        return _resumed(parser, given, without_ros(arguments))
    from evodevo_sim.genetics.genome import GenomeError
    from evodevo_sim.genetics.genome_file import read_genome
    from evodevo_sim.worlds import with_world

    from .feasible import check, check_rig
    from .usual import law_of, usual_task

    try:
        task = usual_task(given.task, given.scheme or "")
        files = [read_genome(_genome_file(Path(place))) for place in given.start]
        task = with_settings(task, law_of(files))
        if given.world is not None:
            task = with_world(task, given.world)
        numbers: dict[str, object] = {"development.max_cells": given.cells}
        if given.starts is not None:
            numbers["starts"] = given.starts
        task = with_settings(task, numbers | (preset(given.preset) if given.preset else {}) | settings_of(given, task.name, warn("evolve")))
        chosen = {field.name: getattr(given, field.name) for field in dataclasses.fields(Settings)}
        chosen = {name: value for name, value in chosen.items() if value is not None}
        usual = _ONE_BODY if given.rig else default_scheme(task.name, chosen, task.development.max_cells, bool(files))
        name = usual if given.scheme is None else given.scheme
        settings = Settings(**scheme(name, task.name) | chosen)
        search_of(settings, name)
        start = tuple(file.genome for file in files)
        if len(start) > settings.population:
            raise ParameterError(f"--start gives {len(start)} genomes to a population of {settings.population}: give fewer")
        check(task, settings, start)
        if given.rig:
            check_rig(task, start)
        if given.evaluations is not None and given.evaluations < settings.population:
            raise ParameterError(f"--evaluations is {given.evaluations}: give {settings.population} or more, a batch of evaluations")
        bred = [file.bred_otherwise(task) for file in files]
    except (ParameterError, GenomeError) as error:
        parser.error(str(error))
    for place, other in zip(given.start, bred):
        if other:
            print(f"{parser.prog}: {place} was bred with {other}: give that by --set, or its body is another one", file=sys.stderr)
    out = Path(given.out or f"bags/{task.name}-{datetime.now():%Y%m%d-%H%M%S}")
    limits, sources, rig = Limits(given.evaluations, given.hours), tuple(given.start), given.rig or ""
    return Options(task, settings, given.seed, out, start=start, scheme=name, limits=limits, sources=sources, rig=rig, **_how(given))


def _how(given: Any) -> dict[str, Any]:
    """What decides how a run is worked on, and no bit of it."""
    names = ("simulators", "look", "quiet", "threads", "give_up_after", "view", "backend", "scheduler")
    return {name: getattr(given, name) for name in names}


def _check_numbers(parser: Parser, given: Any) -> None:
    if given.backend not in BACKENDS:
        parser.error(f"--backend is {shown(given.backend)}: choose one of {', '.join(BACKENDS)}")
    if given.scheduler and given.backend != "dask":
        parser.error(f"--scheduler is given where the backend is {given.backend}: add --backend dask, or leave it out")
    others = [f"--{name}" for name in ("simulators", "threads", "scheduler", "plant") if getattr(given, name)]
    if given.rig is not None and (others or given.backend != "ros"):
        one = (others or ["--backend"])[0]
        parser.error(f"{one} is given beside --rig: leave it out, the body of the rig alone evaluates, with actuators of its own")
    if given.rig is not None and not _NAMESPACE.fullmatch(given.rig):
        parser.error(f"--rig is {shown(given.rig)}: give the namespace of a driver, e.g. /eel")
    if given.simulators is not None and given.backend != "ros":
        parser.error(f"--simulators is given where the backend is {given.backend}: leave it out; --threads says how many threads work")
    if given.threads is not None and given.scheduler:
        parser.error("--threads is given beside --scheduler: leave it out, workers have the threads that they were started with")
    if not 0 <= given.seed < 2**63:
        parser.error(f"--seed is {given.seed}: give a whole number from 0 to 2^63 - 1")
    if given.simulators is not None and not 1 <= given.simulators <= 256:
        parser.error(f"--simulators is {given.simulators}: give 1 to 256")
    if given.threads is not None and not 1 <= given.threads <= 1024:
        parser.error(f"--threads is {given.threads}: give 1 to 1024")
    if not 0.0 <= given.give_up_after <= 1e9:
        parser.error(f"--give-up-after is {given.give_up_after}: give 0 to 1e9 seconds")
    if not 0.0 <= given.look <= 3600.0:
        parser.error(f"--look is {given.look}: give 0 to 3600 seconds")
    if given.evaluations is not None and not given.evaluations >= 1:
        parser.error(f"--evaluations is {given.evaluations}: give 1 or more")
    if given.hours is not None and not 0.0 < given.hours <= 1e6:
        parser.error(f"--hours is {given.hours:g}: give more than 0, up to 1e6")


def _resumed(parser: Parser, given: Any, arguments: list[str]) -> Options:
    """The options of a run that goes on."""
    from evodevo_sim.genetics.genome import GenomeError

    from .keeping.errors import ResumeError
    from .keeping.resume import explicit, resumed

    try:
        run = resumed(Path(given.resume), explicit(parser, arguments))
    except (ParameterError, GenomeError, ResumeError) as error:
        parser.error(str(error))
    e = run.evolution
    return Options(
        run.task, e.settings, e.seed, run.directory, start=e.start, scheme=e.scheme, limits=run.limits, sources=run.sources, resumed=run,
        rig=run.rig, **_how(given),
    )


def _defaults(field, named: dict[str, Any]) -> str:
    """The default of a setting, and where others have another.  Args: named: settings of tasks and schemes, by their names."""
    words: dict[Any, str] = {UNLIMITED: "without limit"}
    differ = [
        f"{words.get(settings[field.name], settings[field.name])} for {name}" for name, settings in named.items() if field.name in settings
    ]
    return ", ".join([str(field.default), *differ])


def _genome_file(path: Path) -> Path:
    return path / "champion.yaml" if os.path.isdir(path) else path


def cores() -> int:
    return len(os.sched_getaffinity(0))
