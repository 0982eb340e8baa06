"""Colours of cells by their activation e - c.

    paper   blue contracting, green at rest, red expanding, as in the paper's Figs. 3 to 5
    safe    blue contracting, grey at rest, yellow expanding: lighter all the way, so that the colour-blind and a grey print show it
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

_STRETCH = 0.7  # power of |e - c|: weak muscles show, too


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


def activation_colours(activation: Any, palette: str = DEFAULT) -> np.ndarray:
    """The colour of e - c, in full at -1 and 1, and stretched about 0.

    Args: activation: any shape (...); outside [-1, 1] it is clipped, NaN is at rest.
    Returns: (..., 3) uint8, sRGB.
    """
    import numpy as np  # it takes longer than all that help texts need

    a = np.nan_to_num(np.clip(np.asarray(activation, float), -1.0, 1.0))
    stretched = np.sign(a) * np.abs(a) ** _STRETCH
    stops = np.array(PALETTES[palette].stops, float)
    channels = [np.interp(stretched, np.linspace(-1.0, 1.0, len(stops)), channel) for channel in stops.T]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)
