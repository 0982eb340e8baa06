"""`ros2 run evodevo_sim conform NAMESPACE`: asks a node whether it is a plant as the contract has it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from ..parameters import ParameterError
from ..ros.command_line import Parser, real_number
from ..ros.environment import EnvironmentFault, check_environment, started, without_ros

_EPILOG = """\
examples:
  ros2 run evodevo_sim conform /
      the simulator node that runs there
  ros2 run evodevo_sim conform /eel --genome champion.yaml --json eel.json
      a driver, whose body is the one that this genome grows

The body moves: keep hands off it.
Exit code: 0 where all checks pass, 1 where one fails, 2 for bad input or where nobody is there.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("conform", "Ask a node whether it is a plant as the contract has it (docs/reference/plant.md).", _EPILOG)
    parser.add_argument("namespace", metavar="NAMESPACE", help="of the node, e.g. /sim_0")
    parser.add_argument("--genome", metavar="FILE", help="one that grows its body (default: the shipped undulator)")
    parser.add_argument("--only", nargs="+", metavar="CHECK", help="these checks alone")
    parser.add_argument("--json", metavar="FILE", help="write the findings there too")
    parser.add_argument("--patience", type=real_number, default=30.0, metavar="S", help="longest wait for an answer (default %(default)s)")
    parser.add_argument("--list", action="store_true", help="say which checks there are, and end")
    given = parser.parse_args(without_ros(arguments))
    try:
        check_environment()
    except EnvironmentFault as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    from ..genetics.champions import champions
    from ..genetics.genome import GenomeError
    from ..genetics.genome_file import read_genome
    from ..nodes.conformance import checks
    from ..nodes.conformance.session import CHECKS, Session, examine
    from ..ros.messages import genome_message, task_message
    from ..ros.process import stay_on_this_host
    from ..whole_file import written_whole

    if given.list:
        width = max(map(len, CHECKS))
        print("\n".join(f"{one.name:<{width}}  {one.what}" for one in CHECKS.values()))
        return 0
    assert checks
    try:
        for name in given.only or []:
            if name not in CHECKS:
                raise ParameterError(f"--only: there is no check {name!r}: see --list")
        animal = read_genome(Path(given.genome) if given.genome else champions()["undulator"])
        if not 0.1 <= given.patience <= 3600.0:
            raise ParameterError(f"--patience is {given.patience:g}: give 0.1 to 3600 seconds")
        stay_on_this_host()
        with started("conform", arguments):
            session = Session(given.namespace, genome_message(animal.genome), task_message(animal.task()), given.patience)
            try:
                if not session.until(lambda: session.has("load"), min(10.0, given.patience)):
                    raise ParameterError(f"nobody offers {session.at('load')}: start the node, or give another namespace")
                findings = examine(session, given.only, _say)
            finally:
                session.close()
        if given.json:
            with written_whole(given.json) as name, open(name, "w", encoding="utf-8") as file:
                json.dump({"namespace": given.namespace, "findings": [one.plain() for one in findings]}, file, indent=1)
    except (EnvironmentFault, GenomeError, ParameterError, OSError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    failed = [one for one in findings if one.outcome == "fail"]
    print(f"{len(findings)} checks: {sum(one.outcome == 'pass' for one in findings)} passed, {len(failed)} failed, "
          f"{sum(one.outcome == 'not asked' for one in findings)} not asked")
    return 1 if failed else 0


def _say(finding) -> None:
    print(f"{finding.outcome:>9}  {finding.name}" + (f": {finding.seen}" if finding.seen else ""), flush=True)


if __name__ == "__main__":
    from .entry import conform as entry

    sys.exit(entry())
