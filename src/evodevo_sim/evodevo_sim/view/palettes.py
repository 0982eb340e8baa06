"""Palettes of cells by their activation e - c, as commands offer them.

    paper   blue contracting, green at rest, red expanding, as in the paper's Figs. 3 to 5
    safe    blue contracting, grey at rest, yellow expanding: lighter all the way, so that the colour-blind and a grey print show it
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass


@dataclass(frozen=True)
class Palette:
    """stops: sRGB, 0..255, from contracting to expanding, evenly spaced along the stretched activation; contracting, rest, expanding:
    the words for its colours; change: the matplotlib colour map of changes of activation, or empty for the one of the stops."""

    stops: tuple[tuple[int, int, int], ...]
    contracting: str
    rest: str
    expanding: str
    change: str = ""


PALETTES = {
    "paper": Palette(((36, 92, 220), (64, 160, 190), (92, 184, 92), (222, 168, 60), (224, 48, 44)), "blue", "green", "red", "RdBu_r"),
    "safe": Palette(((20, 78, 165), (86, 116, 160), (150, 150, 150), (204, 186, 96), (252, 218, 36)), "blue", "grey", "yellow"),
}
DEFAULT = "paper"


def legend_of(palette: str) -> str:
    """The colours of a palette in words."""
    chosen = PALETTES[palette]
    return f"{chosen.contracting} contracting (−1), {chosen.rest} at rest (0), {chosen.expanding} expanding (+1)"


def add_palette(parser: argparse.ArgumentParser, default: str = DEFAULT) -> None:
    """Give a command line the option --palette."""
    says = "colours of cells: as in the paper, or safe for the colour-blind and for grey prints (default: %(default)s)"
    parser.add_argument("--palette", choices=tuple(PALETTES), default=default, help=says)
