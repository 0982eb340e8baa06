"""The ladder of doubled steps: an interval that came out unsound is tried again from its start, in twice as many.

    remember(position, velocity, ledger, scratch)
    while True:
        outcome = ...                                # one try
        if not again(outcome, doubling, steps, ladder, position, velocity, ledger, scratch):
            return outcome
        doubling, steps = doubling + 1, 2 * steps
"""

from __future__ import annotations

from typing import NamedTuple

from ..kernels.jit import inlined, lean
from .soundness import SOUND, UNSTABLE

MOST_DOUBLINGS = 3  # of the steps of a control step or frame that came out unsound; of an unstable one more: see `again`


class Ladder(NamedTuple):
    """How far an interval is tried again.

    Chambers turn inside out in fine steps, too: three doublings settle that.  Where a body blew up, its steps may be far too long:
    they follow from the drag that it begins with, which is 0 at rest.
    """

    doublings: int  # in any case
    most: int  # steps up to which what is unstable is tried


@lean
def copy_state(position, velocity, to_position, to_velocity):
    for a in range(2):
        for i in range(position.shape[1]):
            to_position[a, i] = position[a, i]
            to_velocity[a, i] = velocity[a, i]


@inlined
def remember(position, velocity, ledger, scratch):
    """Keep the start of an interval in scratch, its ledger of energy (4,) or () with it."""
    copy_state(position, velocity, scratch.start_position, scratch.start_velocity)
    for k in range(ledger.size):
        scratch.start_ledger[k] = ledger[k]


@inlined
def again(outcome, doubling, steps, ladder, position, velocity, ledger, scratch):
    """Whether a try that came out so is to be followed by one of twice as many steps; if so, all is back at the start.

    Args: doubling, steps: of that try; ladder: see `Ladder`; the others: as `remember` took them.
    """
    if outcome == SOUND or not (doubling < ladder.doublings or (outcome == UNSTABLE and 2 * steps <= ladder.most)):
        return False
    copy_state(scratch.start_position, scratch.start_velocity, position, velocity)
    for k in range(ledger.size):
        ledger[k] = scratch.start_ledger[k]
    return True
