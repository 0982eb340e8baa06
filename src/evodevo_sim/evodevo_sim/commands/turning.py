"""`ros2 run evodevo_sim turning GENOME|BAG ...`: how champions turn towards targets, a line each, and drawn as the paper's Fig. 6."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..parameters import ParameterError
from ..ros.command_line import Parser, add_plant, say_if_compiling, settings_of, warn, without_remarks
from ..ros.environment import need_no_graph, without_ros
from ..view.files import PICTURES, OutputError, check, whole
from ..view.palettes import add_palette

if TYPE_CHECKING:
    from ..analysis.turning import Turning

_EPILOG = """\
examples:
  ros2 run evodevo_sim turning bags/sample-chemotaxis
      the last champion of a run of chemotaxis
  ros2 run evodevo_sim turning bags/one bags/two champion.yaml --out turning.png
      three champions, and their turning maps: each cell's mean activation in a turn, minus that on the way without a target

A line says: to which sides it turns and how far, and the last distance from each target over the first; strategy, posture (mean
activation changes most) or stroke (its amplitude does); which side contracts; and control: reactive, where muscles depend on the
scent of the moment, or internal state, where its history counts (the share of the scent's effect that does).
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("turning", "Analyse how animats turn towards targets.", _EPILOG)
    parser.add_argument("sources", nargs="+", metavar="GENOME|BAG", help="genome files, or recordings of runs")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for genomes: a number of the task")
    add_plant(parser, "for genomes: ")
    parser.add_argument("--out", type=Path, metavar="FILE", help="save a picture, as its ending .png, .svg or .pdf says")
    add_palette(parser)
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..analysis.turning import turning
    from ..genetics.genome import GenomeError
    from ..recording import RecordingError
    from ..recording.champion import champion_of

    try:
        if given.out:
            check(given.out, *PICTURES)
        settings = settings_of(given, "chemotaxis", warn(parser.prog))
        champions = [champion_of(source, settings, "chemotaxis", warn(parser.prog)) for source in given.sources]
        say_if_compiling("kernel.trials")
        found = []
        for champion in champions:
            try:
                found.append((champion.name, turning(champion.genome, champion.task, champion.seed)))
            except ParameterError as error:
                raise ParameterError(f"{champion.name}: {error}") from None
            print(line(*found[-1]), flush=True)
        if given.out:
            without_remarks()
            from ..view.turning_picture import save_turning

            with whole(given.out, *PICTURES) as file:
                save_turning(found, file, given.palette)
            print(f"Saved {given.out}")
    except (GenomeError, OutputError, ParameterError, RecordingError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


def line(name: str, found: Turning) -> str:
    left, right = found.turn
    return (
        f"{name}: turns to {found.turns} (left {left:+.2f} rad, right {right:+.2f} rad), distance x {found.ratio[0]:.2f} and "
        f"x {found.ratio[1]:.2f}; strategy {found.strategy}, contracts the {found.side} side ({found.near[0]:+.3f}, "
        f"{found.near[1]:+.3f}); {found.control} ({found.memory:.2f})"
    )


if __name__ == "__main__":
    from .entry import turning as entry

    sys.exit(entry())
