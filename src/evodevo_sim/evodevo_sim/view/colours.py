"""Colours as numbers: of cells by their activation e - c in a palette, and those of everything else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .palettes import DEFAULT, PALETTES

_STRETCH = 0.7  # power of |e - c|: weak muscles show, too
INK, QUIET, ACCENT, SECOND, THIRD = (38, 43, 54), (138, 145, 158), (222, 116, 24), (132, 92, 196), (34, 150, 160)
PAPER = (250, 250, 248)
# Of curves in one figure: told apart by the colour-blind, and in grey by their lightness.
SERIES = ((0, 92, 170), (220, 105, 20), (26, 30, 42), (120, 190, 225))


def activation_colours(activation: Any, palette: str = DEFAULT) -> np.ndarray:
    """The colour of e - c, in full at -1 and 1, and stretched about 0.

    Args: activation: any shape (...); outside [-1, 1] it is clipped, NaN is at rest.
    Returns: (..., 3) uint8, sRGB.
    """
    a = np.nan_to_num(np.clip(np.asarray(activation, float), -1.0, 1.0))
    stretched = np.sign(a) * np.abs(a) ** _STRETCH
    stops = np.array(PALETTES[palette].stops, float)
    channels = [np.interp(stretched, np.linspace(-1.0, 1.0, len(stops)), channel) for channel in stops.T]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)


def unit_rgb(colour: Sequence[int]) -> tuple[float, ...]:
    """A colour of 0..255 as matplotlib takes it."""
    return tuple(channel / 255 for channel in colour)
