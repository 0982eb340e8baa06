"""The command line of `ros2 run evodevo_ga gallery`."""

from __future__ import annotations

import sys
from pathlib import Path

from evodevo_sim.ros.command_line import Parser, say_if_compiling, without_remarks
from evodevo_sim.ros.environment import without_ros
from evodevo_sim.view import files

_EPILOG = """\
examples:
  ros2 run evodevo_ga evolve --out bags/unlike
      a run whose search is an archive, as that of swimmers is by default
  ros2 run evodevo_ga gallery bags/unlike -o gallery.png
      the map of its archive: each animal in the cell of its body's measures, on a colour that tells its fitness, its gait named; the
      best is framed
  ros2 run evodevo_ga gallery bags/unlike -o gallery.pdf --save gallery.rrd
      the same moving, in the Rerun viewer: `rerun --bind 127.0.0.1 gallery.rrd`

Each animal's genome is left in RUN/archive, named by column and row of its cell, with what its audit said; RUN/archive/archive.csv is the
table of all. Audits repeat each life in finer steps: a few times as long as a generation takes; --no-audit leaves them out.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("gallery", "Draw the archive of a run as a map of unlike animals.", _EPILOG)
    parser.add_argument("run", type=Path, metavar="RUN", help="the directory of a run of evolve")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="the picture, as its ending .png, .svg or .pdf says")
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="save a Rerun file of the map, in which all move")
    parser.add_argument("--no-audit", action="store_true", help="leave out the audits")
    given = parser.parse_args(without_ros(arguments))
    from ..keeping.errors import ResumeError
    from .content import GalleryError

    try:
        files.check(given.out, *files.PICTURES)
        if given.save:
            files.check(given.save, ".rrd")
        without_remarks()
        _draw(given)
    except (ResumeError, GalleryError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    except OSError as error:
        what = error.filename or given.run
        parser.exit(2, f"{parser.prog}: {what} cannot be written ({error.strerror}): make room, or give another place\n")
    return 0


def _draw(given) -> None:
    from evodevo_sim.view.body_map import save_map
    from evodevo_sim.view.viewer import NO_RERUN, is_installed
    from tqdm import tqdm

    from ..arguments import cores
    from .content import read_content
    from .draw import map_of
    from .lives import folder_of, keep, live

    if given.save and not is_installed():
        raise files.OutputError(NO_RERUN)
    content, notes = read_content(given.run)
    for line in notes:
        print(f"gallery: {line}", file=sys.stderr)
    folder = folder_of(given.run)  # before lives are lived for it
    say_if_compiling(content.task.kind.kernel)
    with tqdm(total=len(content.animals), unit="animal", leave=False, disable=not sys.stderr.isatty()) as bar:
        lives = live(content, not given.no_audit, cores(), bar.update)
    keep(lives, content, folder)
    found = map_of(content, lives)
    with files.whole(given.out, *files.PICTURES) as file:
        save_map(found, file)
    if given.save:
        from evodevo_sim.view.map_log import save_map_log

        with files.whole(given.save, ".rrd") as file:
            save_map_log(found, file)
    print(f"{found.facts.replace('  ·  ', ', ')}; genomes in {folder}")
