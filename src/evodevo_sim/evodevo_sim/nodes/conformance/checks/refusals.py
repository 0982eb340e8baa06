"""Checks of what is refused, which changes nothing."""

from __future__ import annotations

import math

from evodevo_msgs.msg import Genome

from ..session import Session, check, must
from .asking import load, states


@check("a malformed genome", "load refuses a genome that is none, in one line of at most 300 characters")
def _malformed(s: Session) -> None:
    answer = load(s, genome=Genome(kind=[9], sign=[1], x=[0.0], y=[0.0]))
    must(not answer.success, "a genome of unknown kinds was loaded")
    line = answer.message
    must(0 < len(line) <= 300 and "\n" not in line, f"its message has {len(line)} characters: {line[:80]!r}")


@check("an odd pace", "load refuses a real_time_factor that is negative or no number")
def _odd_pace(s: Session) -> None:
    for pace in (-1.0, math.nan, math.inf):
        must(not load(s, real_time_factor=pace).success, f"an animat was loaded at a pace of {pace}")


@check("refusals are harmless", "what is refused does not disturb the animat that lives")
def _harmless(s: Session) -> None:
    heard = states(s, 20)
    last = heard.messages[-1].step
    load(s, genome=Genome(kind=[9], sign=[1], x=[0.0], y=[0.0]))
    seen = len(heard)
    must(s.until(lambda: len(heard) > seen + 20), "after a refused load no state came")
    must(heard.messages[-1].step > last, f"after a refused load the step went from {last} to {heard.messages[-1].step}")
