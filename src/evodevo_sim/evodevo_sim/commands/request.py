"""`ros2 run evodevo_sim request GENOME|BAG`: prints a request for a simulator, as `ros2 service call` takes it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from ..parameters import ParameterError, default_task
from ..ros.command_line import Parser, add_plant, real_number, settings_of, warn
from ..ros.environment import need_no_graph, without_ros
from ..task_kinds import names

if TYPE_CHECKING:
    from ..recording.champion import Champion

SERVICES = ("load", "evaluate")
_EPILOG = """\
examples:
  ros2 run evodevo_sim request bags/sample-swim
  ros2 service call /load evodevo_msgs/srv/Load "$(ros2 run evodevo_sim request bags/RUN)"
      lets the last champion of a run live on the simulator in the namespace /
  ros2 service call /sim_0/evaluate evodevo_msgs/srv/Evaluate "$(ros2 run evodevo_sim request champion.yaml --service evaluate)"

A task with default numbers is written by its name alone, which a simulator takes as that.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("request", "Print a request for a simulator's service.", _EPILOG)
    parser.add_argument("source", metavar="GENOME|BAG", help="a genome file, or the recording of a run")
    parser.add_argument("--service", default="load", metavar="NAME", help=f"{', '.join(SERVICES)} (default %(default)s)")
    parser.add_argument("--task", default=names()[0], metavar="NAME", help=f"for a genome: {', '.join(names())} (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    add_plant(parser)
    pace = "load: simulated s per s; 0 is as fast as it goes (default %(default)s)"
    parser.add_argument("--real-time-factor", type=real_number, default=1.0, metavar="X", help=pace)
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError
    from ..recording.champion import champion_of

    try:
        if given.service not in SERVICES:
            raise ParameterError(f"--service is {given.service}: choose one of {', '.join(SERVICES)}")
        if not 0.0 <= given.real_time_factor <= 1e6:
            raise ParameterError(f"--real-time-factor is {given.real_time_factor}: give a number up to 1e6, or 0 for as fast as it goes")
        champion = champion_of(given.source, settings_of(given, given.task, warn(parser.prog)), given.task)
    except (GenomeError, ParameterError, RecordingError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(request_text(champion, given.service, given.real_time_factor), end="")
    return 0


def request_text(champion: Champion, service: str, real_time_factor: float = 1.0) -> str:
    """The YAML of a request.  Args: service: "load" or "evaluate"; real_time_factor: of load alone."""
    import yaml

    from ..ros.messages import genome_message, task_message

    task, genome = champion.task, _plain(genome_message(champion.genome))
    asked = {"task": {"name": task.name} if task == default_task(task.name) else _plain(task_message(task)), "seed": champion.seed}
    asked |= {"genome": genome, "real_time_factor": real_time_factor} if service == "load" else {"genomes": [genome]}
    return yaml.safe_dump(asked, default_flow_style=None, sort_keys=False, width=10**9)


def _plain(value):
    """A message as dicts, lists, numbers and text."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: _plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    return value if isinstance(value, (str, bool, int, float)) else [_plain(item) for item in value]


if __name__ == "__main__":
    from .entry import request as entry

    sys.exit(entry())
