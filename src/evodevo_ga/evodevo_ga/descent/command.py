"""The command line of `ros2 run evodevo_ga descent`."""

from __future__ import annotations

from pathlib import Path

from evodevo_sim.ros.command_line import Parser, say_if_compiling, whole_number, without_remarks
from evodevo_sim.ros.environment import without_ros
from evodevo_sim.view import files

_EPILOG = """\
examples:
  ros2 run evodevo_ga descent bags/long -o descent.png
      the line of the champion: bodies on the way, fitness of all ancestors, what changed whom
  ros2 run evodevo_ga descent bags/long --number 4711 -o descent.pdf
      that of any individual, by its number in the history (docs/reference/run.md)
"""


def main(arguments: list[str]) -> int:
    parser = Parser("descent", "Draw the line of descent of a run's champion.", _EPILOG)
    parser.add_argument("run", type=Path, metavar="RUN", help="the directory of a run of evolve")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="the picture, as its ending .png, .svg or .pdf says")
    parser.add_argument("--number", type=whole_number, metavar="N", help="of another individual than the champion")
    given = parser.parse_args(without_ros(arguments))
    from ..keeping.errors import ResumeError

    try:
        files.check(given.out, *files.PICTURES)
        without_remarks()
        from .run import check, draw_descent

        check(given.run)
        say_if_compiling("kernel.swim")
        with files.whole(given.out, *files.PICTURES) as file:
            print(draw_descent(given.run, file, given.number))
    except (ResumeError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0
