"""`ros2 run evodevo_sim gait BAG|GENOME`: names the gait of a champion and shows it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..parameters import ParameterError, Task, with_settings
from ..ros.command_line import Parser, pairs, say_if_compiling, without_remarks
from ..ros.environment import need_no_graph, without_ros
from ..view import files

if TYPE_CHECKING:
    from ..analysis.gait.track import Track

_EPILOG = """\
examples:
  ros2 run evodevo_sim gait bags/RUN --out gait.png
      the gait of the last champion, and a picture of muscles, phases and motion
  ros2 run evodevo_sim gait champion.yaml --set scene.drag_normal=100 --csv cells.csv
  ros2 run evodevo_sim gait bags/MINE --walk
      a motion that `simulate --scene walk` recorded

Swimmers are classed as protrusions, undulation, jellyfish or peristalsis; walkers as jump, run or mass shift; both, where no rule
fits, as unclear or still. docs/gaits.md tells the rules. All numbers are of the second half of the motion.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("gait", "Name and measure the gait of a swimmer or walker.", _EPILOG)
    parser.add_argument("source", metavar="BAG|GENOME", help="a recording, or a genome file")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    parser.add_argument("--walk", action="store_true", help="for a recording: it walks, on flat ground at y = 0")
    parser.add_argument("--out", type=Path, metavar="FILE.png", help="save a picture")
    parser.add_argument("--csv", type=Path, metavar="FILE.csv", help="save place, amplitude and phase of every cell")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from rich.console import Console

    from ..analysis.gait.analysis import analyse
    from ..analysis.gait.table import gait_table, write_cells
    from ..analysis.gait.track import GaitError
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError
    from ..view.summary import name_of

    try:
        for path, ending in ((given.out, ".png"), (given.csv, ".csv")):
            if path:
                files.check(path, ending)
        analysis = analyse(_track(given))
        gait, console = analysis.gait, Console(highlight=False)
        console.print(f"{gait.name}: {gait.why}", style="bold", soft_wrap=True)
        console.print(gait_table(gait))
        if given.csv:
            with files.whole(given.csv, ".csv") as file:
                write_cells(file, analysis)
        if given.out:
            without_remarks()
            from ..view.gait_picture import save_gait

            with files.whole(given.out, ".png") as file:
                save_gait(analysis, name_of(Path(given.source)), file)
    except (GaitError, GenomeError, ParameterError, RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


def _track(given) -> Track:
    from ..analysis.gait.sources import track_of_performance
    from ..genetics.genome_file import load_genome
    from ..recording import read_recording
    from ..recording.gait import track_of_recording
    from ..recording.life import life_of
    from ..tasks.evaluation import perform

    path = Path(given.source)
    if not path.is_dir() and path.suffix != ".mcap":
        if given.walk:
            raise ParameterError("--walk is for a recording: the task of a genome says whether it walks")
        genome, task = load_genome(path), with_settings(Task(), pairs(given.set))
        say_if_compiling("swim.swim")
        return track_of_performance(perform(genome, task), task)
    if given.set:
        raise ParameterError("--set is for a genome file: a recording names its own task")
    recording = read_recording(path)
    if recording.truncated:
        print(f"gait: the end of {path} is missing: this is of what was saved", file=sys.stderr)
    return track_of_recording(recording, life_of(recording), given.walk)


if __name__ == "__main__":
    from .entry import gait as entry

    sys.exit(entry())
