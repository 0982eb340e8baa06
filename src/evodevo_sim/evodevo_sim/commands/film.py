"""`ros2 run evodevo_sim film BAG|GENOME -o FILE`: a life as a film, in a page that plays it or as a video."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, real_number, say_if_compiling, settings_of, warn, whole_number
from ..ros.environment import need_no_graph, without_ros
from ..task_kinds import names
from ..view import files
from ..view.palettes import add_palette

ENDINGS = (".html", ".mp4", ".gif")
_EPILOG = """\
examples:
  ros2 run evodevo_sim film bags/sample-swim -o swim.html
      one page of at most 1 MB, which any browser plays without a network: growth, then the swim
  ros2 run evodevo_sim film champion.yaml --task walk -o walk.mp4
      the life of a genome as a video (H.264), at the pace at which it lives
  ros2 run evodevo_sim film bags/sample-walk -o walk.gif --width 480 --frames 12 --no-growth

In the page: space plays and pauses, arrow keys step, Home and End go to the ends, and a choice of speed, view and colours.
A recording that was cut off is shown as far as it goes; a run without a recorded life by its last champion, which lives anew.
An older film of the same name and kind is replaced when the new one is complete; any other file is left alone.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("film", "Film a life: a page that plays it, or a video.", _EPILOG)
    parser.add_argument("source", metavar="BAG|GENOME", help="a recording, or a genome file")
    ending = "the film, as its ending .html, .mp4 or .gif says"
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help=ending)
    parser.add_argument("--task", default=names()[0], metavar="NAME", help=f"for a genome: {', '.join(names())} (default %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    add_plant(parser)
    parser.add_argument("--no-growth", action="store_true", help="begin at birth")
    parser.add_argument("--width", type=whole_number, default=None, metavar="PX", help="of a video (default 800, of a GIF 480)")
    frames = "of a second of a video (default 30, of a GIF 15)"
    parser.add_argument("--frames", type=whole_number, default=None, metavar="N", help=frames)
    parser.add_argument("--speed", type=real_number, default=1.0, metavar="X", help="of a video: simulated s per s (default %(default)s)")
    add_palette(parser, "safe")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError
    from ..view.sources import need_life, shown_of

    try:
        files.check(given.out, *ENDINGS)
        _check(given)
        say_if_compiling("kernel.swim")
        shown = shown_of(given.source, settings_of(given, given.task, warn(parser.prog)), given.task, warn(parser.prog))
        need_life(shown, given.source, "a film")
        with files.whole(given.out, *ENDINGS) as file:
            _write(shown, given, file)
    except (GenomeError, ParameterError, RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(f"Saved {given.out}")
    return 0


def _check(given: Any) -> None:
    numbers = (("--width", given.width, 64, 4096), ("--frames", given.frames, 1, 120), ("--speed", given.speed, 0.01, 100.0))
    for name, value, least, most in numbers:
        if value is not None and not least <= value <= most:
            raise ParameterError(f"{name} is {value}: give {least:g} to {most:g}")


def _write(shown: Any, given: Any, file: str) -> None:
    import dataclasses

    life = dataclasses.replace(shown.life, growth=[], growth_springs=[], growth_time=shown.life.growth_time[:0]) if (
        given.no_growth and len(shown.life.time)) else shown.life
    if given.out.suffix.lower() == ".html":
        from ..view.film.packing import pack
        from ..view.film.page import film_page

        Path(file).write_text(film_page(pack(life, given.palette), shown.name, shown.about), encoding="utf-8")
        return
    from ..view.film.video import save_video

    small = given.out.suffix.lower() == ".gif"
    save_video(
        life, file, width=given.width or (480 if small else 800), rate=given.frames or (15 if small else 30),
        speed=given.speed, palette=given.palette,
    )


if __name__ == "__main__":
    from .entry import film as entry

    sys.exit(entry())
