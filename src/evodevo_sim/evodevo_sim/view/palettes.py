"""Palettes of cells as commands offer them."""

from __future__ import annotations

import argparse

from ..palettes import DEFAULT, PALETTES, Palette

__all__ = ["DEFAULT", "PALETTES", "Palette", "add_palette", "legend_of"]


def legend_of(palette: str) -> str:
    """The colours of a palette in words."""
    chosen = PALETTES[palette]
    return f"{chosen.contracting} contracting (−1), {chosen.rest} at rest (0), {chosen.expanding} expanding (+1)"


def add_palette(parser: argparse.ArgumentParser, default: str = DEFAULT) -> None:
    """Give a command line the option --palette."""
    says = "colours of cells: as in the paper, or safe for the colour-blind and for grey prints (default: %(default)s)"
    parser.add_argument("--palette", choices=tuple(PALETTES), default=default, help=says)
