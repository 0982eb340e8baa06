"""`ros2 run evodevo_sim gait BAG|GENOME`: names the gait of a champion and shows it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, say_if_compiling, settings_of, warn, without_remarks
from ..ros.environment import need_no_graph, without_ros
from ..view import files
from ..view.palettes import add_palette

if TYPE_CHECKING:
    from ..analysis.gait.track import Track

_EPILOG = """\
examples:
  ros2 run evodevo_sim gait bags/sample-swim --out gait.png
      the gait of the last champion, and a picture of muscles, phases and motion
  ros2 run evodevo_sim gait champion.yaml --set scene.drag_normal=100 --csv cells.csv
  ros2 run evodevo_sim gait bags/MINE
      a motion that simulate recorded; of another's recording of a walk, add --walk

Swimmers are classed as protrusions, undulation, jellyfish or peristalsis; walkers as jump, run or mass shift; both, where no rule
fits, as unclear or still. docs/reference/gaits.md tells the rules. All numbers are of the second half of the motion.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("gait", "Name and measure the gait of a swimmer or walker.", _EPILOG)
    parser.add_argument("source", metavar="BAG|GENOME", help="a recording, or a genome file")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    add_plant(parser)
    parser.add_argument("--walk", action="store_true", help="for a recording: it walks, on the ground in it, or else flat at y = 0")
    parser.add_argument("--out", type=Path, metavar="FILE", help="save a picture, as its ending .png, .svg or .pdf says")
    parser.add_argument("--csv", type=Path, metavar="FILE.csv", help="save place, amplitude and phase of every cell")
    add_palette(parser)
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
        for path, endings in ((given.out, files.PICTURES), (given.csv, (".csv",))):
            if path:
                files.check(path, *endings)
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

            with files.whole(given.out, *files.PICTURES) as file:
                save_gait(analysis, name_of(Path(given.source)), file, given.palette)
    except (GaitError, GenomeError, ParameterError, RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


def _track(given) -> Track:
    from ..analysis.gait.sources import track_of_performance
    from ..genetics.genome_file import read_genome
    from ..recording import is_recording, read_recording
    from ..recording.gait import track_of_recording, words_of_stretch
    from ..recording.life import life_of
    from ..tasks.evaluation import perform

    path = Path(given.source)
    if not is_recording(path):
        if given.walk:
            raise ParameterError("--walk is for a recording: the task of a genome says whether it walks")
        file = read_genome(path)
        task = file.task(settings=settings_of(given, "swim", warn("gait")))
        say_if_compiling("kernel.swim")
        return track_of_performance(perform(file.genome, task), task)
    if given.set or given.plant is not None:
        raise ParameterError("--set is for a genome file, as --plant is: a recording names its own task")
    recording = read_recording(path)
    life = life_of(recording)
    for line in filter(None, (*recording.notes, words_of_stretch(life) if len(life.time) else "")):
        print(f"gait: {line}", file=sys.stderr)
    if recording.settings is None and life.scene is None and not given.walk:
        print(f"gait: {path} does not say in what scene it is: read as a swimmer's; give --walk if it walks", file=sys.stderr)
    return track_of_recording(recording, life, given.walk)


if __name__ == "__main__":
    from .entry import gait as entry

    sys.exit(entry())
