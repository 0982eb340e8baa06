"""Niches of body shapes: slender bodies start slowly and swim farthest, so they need a while without compact ones as rivals.

A niche is a range of the chambers that a body has, as a share of those of the most compact one: 2 n - 5 for n cells, whose
outline is a triangle.  A ribbon two cells wide has a half of them, grown swarms three quarters.
"""

from __future__ import annotations

import math

from evodevo_sim import Metrics

_SLENDER, _COMPACT = 0.5, 0.78  # shares of chambers between which the niches but the first are spread evenly


def niche_of(metrics: Metrics, niches: int) -> int:
    """The niche of a body: 0 for the most slender, with branches and holes, and for what has no chamber; niches - 1 for compact."""
    if niches == 1 or metrics.chambers == 0:
        return 0
    share = metrics.chambers / max(1, 2 * metrics.cells - 5)
    return min(max(math.floor(1 + (share - _SLENDER) / ((_COMPACT - _SLENDER) / (niches - 1))), 0), niches - 1)
