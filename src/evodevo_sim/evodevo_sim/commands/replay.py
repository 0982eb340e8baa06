"""`ros2 run evodevo_sim replay`: a recording in the Rerun viewer, as a Rerun file or as a picture."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ..command_process import if_ended
from ..ros.command_line import Parser, whole_number, without_remarks
from ..ros.environment import need_no_graph, without_ros
from ..view.palettes import add_palette

SHOWS = ("watch", "grow", "think", "evolve")
_EPILOG = """\
examples:
  ros2 run evodevo_sim replay
      the newest recording under bags/ in the Rerun viewer; without a display it saves a Rerun file and says where
  ros2 run evodevo_sim replay bags/long --save long.rrd
      keep the Rerun file; `rerun --bind 127.0.0.1 long.rrd` shows it again, here or on another computer
  ros2 run evodevo_sim replay bags/long --show think --cell 7
      the network of its cells, with the concentrations in cell 7; --show grow, evolve and watch are the others
  ros2 run evodevo_sim replay bags/sample-swim --no-viewer --picture swim.pdf
      a picture alone: growth, swim, muscles, fitness; it needs no Rerun

A recording is a directory that `evolve` or `ros2 bag record` made, or an .mcap or .db3 file of it; one that was cut off is shown
as far as it goes.  An older file of the same name and kind is replaced when the new one is complete; any other file is left alone.
The viewer that replay opens sends no statistics of its use to its makers; `rerun analytics disable` turns them off for others.
In the viewer: space plays and pauses, the timeline `generation` shows the curves of a run, dragging and scrolling move the view.
"""


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = Parser("replay", "Show a recording: how an animat grew and swims, and how a run evolved it.", _EPILOG)
    parser.add_argument("recording", nargs="?", type=Path, metavar="RECORDING", help="default: the newest one under bags/")
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="save a Rerun file")
    says = "save a picture, as its ending .png (1600 pixels wide), .svg or .pdf says"
    parser.add_argument("--picture", "--png", type=Path, metavar="FILE", help=says)
    parser.add_argument("--show", choices=SHOWS, help="what the viewer is for (default: watch, or evolve of a run without a life)")
    parser.add_argument("--cell", type=whole_number, metavar="N", help="with --show think: whose concentrations (default: the most active)")
    add_palette(parser)
    only = "only save: what is named, or else a Rerun file as without a display"
    parser.add_argument("--no-viewer", action="store_true", help=only)
    return parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit code: 0, 2 after an error that the user can mend, 130 after Ctrl-C."""
    try:
        options = _parse(arguments)
        need_no_graph()
        from ..recording import RecordingError
        from ..view.files import OutputError

        try:
            return _replay(options)
        except (RecordingError, OutputError) as error:
            print(f"replay: {error}", file=sys.stderr)
            return 2
    except KeyboardInterrupt:
        return 130


def _replay(options: argparse.Namespace) -> int:
    from ..analysis.stretches import words_of_holes
    from ..recording import RecordingError, read_recording
    from ..recording.life import life_of
    from ..view import files, purposes, viewer
    from ..view.summary import name_of

    for path, endings in ((options.save, (".rrd",)), (options.picture, files.PICTURES)):
        if path:
            files.check(path, *endings)
    source = options.recording or _newest(Path("bags"))
    recording = read_recording(source, progress=True)
    life = life_of(recording)
    if options.show or not options.picture:
        purposes.chosen(recording, life, options.show)
    missing = words_of_holes(life.time)
    for line in (*recording.notes, *([missing] if missing else [])):
        print(f"replay: {line}", file=sys.stderr)
    if options.picture and not (len(life.time) or any(len(pose.position) for pose in life.growth) or recording.statistics):
        raise RecordingError(f"{source} holds no life and no generations: there is nothing to draw")
    if options.picture:
        _picture(recording, life, options.picture, options.palette)
    opens = viewer.has_display() and viewer.is_installed() and not options.no_viewer
    if opens and not options.save:
        with tempfile.TemporaryDirectory(prefix="evodevo-") as directory, if_ended(lambda: shutil.rmtree(directory, ignore_errors=True)):
            file = os.path.join(directory, f"{name_of(source)}.rrd")
            with _bar("Preparing") as step:
                viewer.save(recording, life, file, step, options.palette, options.show, options.cell)
            return viewer.show(file)
    if options.no_viewer and options.picture and not options.save:
        return 0
    if options.picture and not options.save and not viewer.is_installed():
        print(f"replay: {viewer.NO_RERUN}", file=sys.stderr)
        return 0
    target = options.save or _beside(source)
    with files.whole(target, ".rrd") as whole, _bar("Saving") as step:
        viewer.save(recording, life, whole, step, options.palette, options.show, options.cell)
    print(f"Saved {target}.  See it:   {viewer.COMMAND} {shlex.quote(str(target))}", flush=True)
    return viewer.show(target) if opens else 0


def _newest(directory: Path) -> Path:
    """The recording whose files were written last."""
    from ..recording import RecordingError

    written: dict[Path, float] = {}
    for file in (*directory.glob("**/*.mcap"), *directory.glob("**/*.db3")):
        written[file.parent] = max(file.stat().st_mtime, written.get(file.parent, 0.0))
    if not written:
        raise RecordingError(f"{directory}/ holds no recording: make one by `ros2 run evodevo_ga evolve`, or name one")
    return max(written, key=written.__getitem__)


def _beside(source: Path) -> Path:
    """Where a Rerun file goes that the user gave no name: into the recording's directory, or else here."""
    from ..view.summary import name_of

    directory, name = source if source.is_dir() else source.parent, f"{name_of(source)}.rrd"
    return directory / name if os.access(directory, os.W_OK) else Path(name)


def _picture(recording, life, path: Path, palette: str) -> None:
    without_remarks()
    from ..view import files
    from ..view.picture import save_story

    with files.whole(path, *files.PICTURES) as file, _bar("Drawing") as step:
        save_story(recording, life, file, step, palette)
    print(f"Saved {path}")


@contextmanager
def _bar(what: str, parts: int = 4):
    """A bar on stderr once it has taken two seconds.  Yields what is to be called with the name of each part at its begin."""
    from tqdm import tqdm

    with tqdm(desc=what, total=parts, delay=2, unit="part", leave=False) as bar:
        yield lambda part: (bar.set_postfix_str(part, refresh=False), bar.update())


if __name__ == "__main__":
    from .entry import replay as entry

    sys.exit(entry())
