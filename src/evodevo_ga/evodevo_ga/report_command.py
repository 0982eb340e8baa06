"""`ros2 run evodevo_ga report RUN... -o FILE.html`: runs as one page that stands alone."""

from __future__ import annotations

import sys
from pathlib import Path

from evodevo_sim.ros.command_line import Parser, warn
from evodevo_sim.ros.environment import need_no_graph, without_ros
from evodevo_sim.view import files
from evodevo_sim.view.palettes import add_palette

_EPILOG = """\
examples:
  ros2 run evodevo_ga report bags/sample-swim -o report.html
      what was run, curves, champions as films, gait, energy, audits, descent, and the commands to repeat it
  ros2 run evodevo_ga report bags/sample-swim bags/sample-walk -o both.html
      two runs beside each other, a film of each champion

The page is one file, which any browser shows without a network. Runs that were cut off are told as far as they go; what a run does not
hold is said in its place. An older page of the same name is replaced when the new one is complete; any other file is left alone.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("report", "Report runs on one page that stands alone.", _EPILOG)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="directories that evolve made")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.html", help="the page")
    add_palette(parser, "safe")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from evodevo_sim.recording import RecordingError
    from evodevo_sim.ros.command_line import say_if_compiling

    from .report.page import report_page
    from .report.runs import read_run

    try:
        files.check(given.out, ".html")
        runs = [read_run(path) for path in given.runs]
        for run in runs:
            for note in run.notes:
                warn(parser.prog)(f"{run.path}: {note}" if str(run.path) not in note else note)
        page = report_page(runs, given.palette, lambda line: say_if_compiling("kernel.swim"))
        with files.whole(given.out, ".html") as file:
            Path(file).write_text(page, encoding="utf-8")
    except (RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(f"Saved {given.out}")
    return 0


if __name__ == "__main__":
    from .commands import report as entry

    sys.exit(entry())
