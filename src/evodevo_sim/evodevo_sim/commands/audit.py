"""`ros2 run evodevo_sim audit GENOME|BAG`: says whether a champion's fitness stands."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, real_number, say_if_compiling, settings_of, warn
from ..ros.environment import need_no_graph, without_ros
from ..task_kinds import names

if TYPE_CHECKING:
    from ..tasks.audit import Audit

_EPILOG = """\
examples:
  ros2 run evodevo_sim audit bags/sample-swim
      the last champion of a run, in the task that it was evolved for
  ros2 run evodevo_sim audit champion.yaml --set development.max_cells=64

Three runs of a swimmer: as evolved; in steps 8 times as fine; by an adaptive method of order 5 with the same muscles. The fitness stands if
neither it nor the sustained distance, which is its part without the bonus for active muscles, changes by more than --within, and
if the energy that muscles put in is found again: in drag, damping and what is stored.
Of a seeker: the same of all its swims, and where each ends.
Of a walker: as evolved; from 16 other starts; from those in finer steps, and what must agree are means. In the median of
the 16 it must walk half as far as from its own starts.
Exit code: 0 it stands, 1 it does not, 2 bad input.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("audit", "Repeat a champion in finer steps and by a better method.", _EPILOG)
    parser.add_argument("source", metavar="GENOME|BAG", help="a genome file, or the recording of a run")
    parser.add_argument("--task", default=names()[0], metavar="NAME", help=f"for a genome: {', '.join(names())} (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    add_plant(parser)
    within = "change that still stands, relative (default 0.01, of walkers 0.25)"
    parser.add_argument("--within", type=real_number, metavar="X", help=within)
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError
    from ..recording.champion import champion_of
    from ..tasks.audit import audit

    try:
        if given.within is not None and not 0.0 < given.within <= 1.0:
            raise ParameterError(f"--within is {given.within!r}: give a number above 0, up to 1")
        champion = champion_of(given.source, settings_of(given, given.task, warn(parser.prog)), given.task, warn(parser.prog))
        if champion.hardware:
            raise ParameterError(
                f"{given.source} lived on the body {champion.hardware[:40]!r}, which no audit repeats: give its champion.yaml to audit the "
                "genome in simulation, or see compare"
            )
        say_if_compiling("replayed_motion.repeat")
        result = audit(champion.genome, champion.task, champion.seed, given.within)
    except (GenomeError, ParameterError, RecordingError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    faults = list(result.faults)
    recorded = champion.fitness
    if recorded is not None and recorded != result.evaluation.fitness:
        now = result.evaluation.fitness
        faults.insert(0, f"recorded was {recorded:.6g}, here it is {now:.6g}: another version or machine made it")
    print("\n".join(filter(None, (table(result), result.says))))
    print("The fitness stands." if not faults else "The fitness does not stand:\n" + "\n".join(f"  {fault}" for fault in faults))
    return 1 if faults else 0


def table(result: Audit) -> str:
    """The runs of an audit, a line each."""
    from ..physics.energy import LEDGER

    last = ["targets m"] if any(run.near for run in result.runs) else []
    rows = [("", "fitness m", "change", "sustained m", *(f"{name} J" for name in LEDGER[:3]), "unexplained", "least S/S0", *last)]
    for run in result.runs:
        work = (f"{value:.4g}" for value in run.ledger[:3])
        row = (run.name, f"{run.fitness:.6g}", f"{run.change:+.2e}", f"{run.sustained:.6g}", *work, f"{run.gap:.1e}", f"{run.chamber:.3f}")
        rows.append((*row, " ".join(f"{distance:.2f}" for distance in run.near)) if last else row)
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join("  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths)) for row in rows)


if __name__ == "__main__":
    from .entry import audit as entry

    sys.exit(entry())
