"""Figures for papers, from recordings alone: `KINDS` is the table of them; each is drawn by the module of its name.

Their widths are those of columns, in mm; text is 7 points; colours are told apart by the colour-blind and in grey, where lines are
dashed and signs stand in cells, too.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """A kind of figure.  what: it shows; module: of this package, with `draw(sources, sheet)`; champions: whether it is of
    champions, which live anew, or else of what was recorded; width: mm."""

    what: str
    module: str
    champions: bool = False
    width: float = 178.0


KINDS = {
    "growth": Kind("embryos from one cell to the last division (Fig. 2)", "growth"),
    "gait": Kind("bodies over one period of their muscles (Figs. 3, 4)", "gaits"),
    "traces": Kind("two cells' muscles over time, below their body (Fig. 5)", "traces"),
    "turning": Kind("change of mean activation in turns towards a target (Fig. 6)", "turns", champions=True),
    "fitness": Kind("best and median fitness by generation, of one run or many", "fitness", width=86.0),
    "work-precision": Kind("error of a champion's swim by steps and method", "work_precision", champions=True, width=86.0),
}
