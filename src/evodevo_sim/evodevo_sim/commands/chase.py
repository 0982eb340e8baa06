"""The command line of `ros2 run evodevo_sim chase`."""

from __future__ import annotations

import sys
from pathlib import Path

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, real_number, whole_number
from ..ros.environment import EnvironmentFault, check_environment, without_ros
from ..view.files import OutputError
from ..view.palettes import add_palette

_EPILOG = """\
examples:
  ros2 run evodevo_sim chase bags/sample-chemotaxis
      ten random targets around the champion of a run, on a simulator of its own
  ros2 run evodevo_sim chase champion.yaml --targets path.csv --out bags/chase
      the targets that a file draws, a line `x,y` each; the recording is made anew, and replays as any other
  ros2 run evodevo_sim chase champion.yaml --targets bags/chase --real-time-factor 4
      the targets of a recording, four times as fast
  ros2 run evodevo_sim chase champion.yaml --simulator /sim_0 --view
      on a simulator node of the graph; in the Rerun viewer while it swims

A target counts as captured when the centre of mass is within --capture metres of it; then, or after --each simulated seconds, the
next one comes.
Exit code: 0; 1 where the animat failed or the simulator was lost; 2 for bad input; 130 after Ctrl-C, 143 after SIGTERM.
What was recorded is kept.
"""


def _parse(arguments: list[str]):
    parser = Parser("chase", "Let an animat follow targets, live.", _EPILOG)
    parser.add_argument("source", metavar="GENOME|BAG", help="a genome file, or the recording of a run")
    parser.add_argument("--targets", default="random", metavar="random|FILE|BAG", help="where targets come from (default %(default)s)")
    parser.add_argument("--count", type=whole_number, metavar="N", help="targets (default: 10 random ones, or all)")
    distance = "of random targets, from and to (default 4 12)"
    parser.add_argument("--distance", type=real_number, nargs=2, default=(4.0, 12.0), metavar="M", help=distance)
    parser.add_argument("--seed", type=whole_number, default=1, metavar="N", help="of random targets (default %(default)s)")
    each = "simulated seconds for each target (default %(default)s)"
    parser.add_argument("--each", type=real_number, default=60.0, metavar="S", help=each)
    capture = "distance that counts as captured (default %(default)s)"
    parser.add_argument("--capture", type=real_number, default=3.0, metavar="M", help=capture)
    pace = "simulated s per s; beyond about 5, cell states are missed and targets come late (default %(default)s)"
    parser.add_argument("--real-time-factor", type=real_number, default=1.0, metavar="X", help=pace)
    parser.add_argument("--simulator", metavar="NAMESPACE", help="of a simulator node on the graph (default: one of our own)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    add_plant(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="directory of a recording, made anew")
    parser.add_argument("--view", action="store_true", help="show it in the Rerun viewer")
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="save a Rerun file while it runs")
    add_palette(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    given = parser.parse_args(without_ros(arguments))
    for name, value, least, most in (
        ("--each", given.each, 1e-3, 1e6), ("--capture", given.capture, 1e-3, 1e6),
        ("--count", 1 if given.count is None else given.count, 1, 10**9),
        ("--real-time-factor", given.real_time_factor, 0.01, 100.0), ("--seed", given.seed, 0, 2**63),
    ):
        if not least <= value <= most:
            parser.error(f"{name} is {value}: give {least:g} to {most:g}")
    return given


def main(arguments: list[str]) -> int:
    given = _parse(arguments)
    try:
        check_environment()
    except EnvironmentFault as error:
        return _refuse(error, 2)
    from ..genetics.genome import GenomeError
    from ..nodes.chase import ChaseError, chase
    from ..recording import RecordingError

    try:
        return chase(given, arguments)
    except (EnvironmentFault, GenomeError, OutputError, ParameterError, RecordingError) as error:
        return _refuse(error, 2)
    except ChaseError as error:
        return _refuse(error, 1)


def _refuse(error: Exception, code: int) -> int:
    print(f"chase: {error}", file=sys.stderr)
    return code


if __name__ == "__main__":
    from .entry import chase as entry

    sys.exit(entry())
