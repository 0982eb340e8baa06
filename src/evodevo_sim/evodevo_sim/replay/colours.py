"""Colours of the paper (Figs. 3 to 5): blue contracting, green at rest, red expanding."""

from __future__ import annotations

import numpy as np

CONTRACTING, AT_REST, EXPANDING = np.array([[36, 92, 220], [92, 184, 92], [224, 48, 44]], float)  # sRGB, 0..255
INK, QUIET, ACCENT, SECOND = (38, 43, 54), (138, 145, 158), (214, 120, 20), (112, 76, 170)  # text, trails and curves


def activation_colours(activation) -> np.ndarray:
    """The colour of e - c, in full at -1 and 1 and stretched about 0, so that weak muscles show, too.

    Args: activation: any shape (...); outside [-1, 1] it is clipped, NaN is at rest.
    Returns: (..., 3) uint8, sRGB.
    """
    a = np.nan_to_num(np.clip(np.asarray(activation, float), -1.0, 1.0))[..., None]
    share = np.sqrt(np.abs(a))
    end = np.where(a < 0, CONTRACTING, EXPANDING)
    # Mixed as light, not as sRGB numbers: halfway between green and red is no mud.
    return np.rint(np.sqrt((1 - share) * AT_REST**2 + share * end**2)).astype(np.uint8)


def unit_rgb(colour) -> tuple[float, ...]:
    """A colour of 0..255 as matplotlib takes it."""
    return tuple(channel / 255 for channel in colour)
