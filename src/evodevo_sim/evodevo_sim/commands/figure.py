"""`ros2 run evodevo_sim figure KIND BAG|GENOME... -o FILE`: a figure for a paper, from recordings alone."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, real_number, say_if_compiling, settings_of, warn, without_remarks
from ..ros.environment import need_no_graph, without_ros
from ..task_kinds import names
from ..view import files
from ..view.figures import KINDS
from ..view.palettes import add_palette

_LEAST, _MOST = 60.0, 400.0  # mm
_EPILOG = f"""\
kinds:
{chr(10).join(f"  {name:15} {kind.what}" for name, kind in KINDS.items())}

examples:
  ros2 run evodevo_sim figure fitness bags/sample-swim -o fitness.pdf
      one column wide (86 mm), fonts inside
  ros2 run evodevo_sim figure traces bags/sample-swim bags/sample-chemotaxis -o traces.svg
      two animats beside each other, lettered
  ros2 run evodevo_sim figure turning bags/sample-chemotaxis -o turning.png --width 86

All but the pictures of turning and work-precision, for which champions live anew, show what was recorded. PNG files have 300 dots an inch.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("figure", "Draw a figure for a paper.", _EPILOG)
    parser.add_argument("kind", metavar="KIND", choices=tuple(KINDS), help=", ".join(KINDS))
    parser.add_argument("sources", nargs="+", metavar="BAG|GENOME", help="recordings, or genome files")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="the figure, as its ending .png, .svg or .pdf says")
    widths = ", ".join(f"{kind.width:g} for {name}" for name, kind in KINDS.items() if kind.width != 178.0)
    parser.add_argument("--width", type=real_number, metavar="MM", help=f"of the figure (default 178; {widths})")
    parser.add_argument("--task", default=names()[0], metavar="NAME", help=f"for genomes: {', '.join(names())} (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for genomes: a number of the task")
    add_plant(parser, "for genomes: ")
    add_palette(parser, "safe")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError

    try:
        files.check(given.out, *files.PICTURES)
        if given.width is not None and not _LEAST <= given.width <= _MOST:
            raise ParameterError(f"--width is {given.width:g}: give {_LEAST:g} to {_MOST:g} mm")
        _draw(given, parser.prog)
    except (GenomeError, ParameterError, RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(f"Saved {given.out}")
    return 0


def _draw(given: Any, prog: str) -> None:
    without_remarks()
    import matplotlib

    from ..recording.champion import champion_of
    from ..view.figure_file import save_figure
    from ..view.figures.sheet import PRINT, Sheet
    from ..view.sources import shown_of

    kind = KINDS[given.kind]
    say_if_compiling("kernel.trials" if given.kind == "turning" else "kernel.swim")
    task = "chemotaxis" if given.kind == "turning" else given.task
    settings = settings_of(given, task, warn(prog))
    if kind.champions:
        sources: list[Any] = [champion_of(source, settings, task, warn(prog)) for source in given.sources]
    else:
        sources = [shown_of(source, settings, given.task, warn(prog)) for source in given.sources]
    draw = importlib.import_module(f"..view.figures.{kind.module}", __package__).draw
    with matplotlib.rc_context(PRINT):
        sheet = Sheet(given.width or kind.width, given.palette, warn(prog))
        draw(sources, sheet)
        with files.whole(given.out, *files.PICTURES) as file:
            save_figure(sheet.figure, file)


if __name__ == "__main__":
    from .entry import figure as entry

    sys.exit(entry())
