"""Colours as numbers: of cells by their activation e - c in a palette, and those of everything else."""

from __future__ import annotations

from collections.abc import Sequence

from ..palettes import activation_colours

__all__ = ["ACCENT", "INK", "PAPER", "QUIET", "SECOND", "THIRD", "activation_colours", "unit_rgb"]

INK, QUIET, ACCENT, SECOND, THIRD = (38, 43, 54), (138, 145, 158), (222, 116, 24), (132, 92, 196), (34, 150, 160)
PAPER = (250, 250, 248)
# Of curves in one figure: told apart by the colour-blind, and in grey by their lightness.
SERIES = ((0, 92, 170), (220, 105, 20), (26, 30, 42), (120, 190, 225))


def unit_rgb(colour: Sequence[int]) -> tuple[float, ...]:
    """A colour of 0..255 as matplotlib takes it."""
    return tuple(channel / 255 for channel in colour)
