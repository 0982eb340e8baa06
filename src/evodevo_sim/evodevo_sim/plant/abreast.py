"""Copies of a swimming body that move abreast: see `physics.abreast`."""

from __future__ import annotations

import numpy as np

from ..kernels.jit import lean
from ..physics.abreast import COPIES, advance_abreast
from ..physics.control_step import advance
from ..physics.soundness import SOUND
from ..physics.step_size import substeps_at_rate
from .muscles import Muscles
from .simulated import BodyState


@lean
def copy_of(state, abreast, held, copy):
    """One of the copies of a body, to be looked at and changed.  Args: held (4, 2 + D, N) or (4, 0, 0): see `Muscles`."""
    muscles = state.muscles
    return BodyState(
        state.body, state.law, abreast.rest[copy], abreast.position[copy], abreast.velocity[copy], state.scratch, state.substeps,
        state.finer, state.halt, Muscles(held[copy], muscles.share, muscles.most, muscles.resolution),
    )


@lean
def move_abreast(state, abreast, seconds, outcomes):
    """Carry the copies of a swimming body over a control step, each as `simulated.move` does.

    Args: outcomes (4,) int64: filled with SOUND, or with what was wrong, where a lane moves its own copy.
    """
    scratch, of, substeps, moving = state.scratch, abreast.of, abreast.substeps, 0
    for copy in range(COPIES):
        scratch.rate[0] = abreast.rate[of[copy]]
        substeps[copy] = int(np.ceil(state.finer * substeps_at_rate(seconds, state.substeps, scratch)))
        moving += of[copy] == copy
    if moving > 1:
        advance_abreast(state.body, state.law, abreast, seconds)
    else:
        abreast.sound[:] = 0.0
    for copy in range(COPIES):
        outcomes[copy] = SOUND
        if of[copy] == copy and not abreast.sound[copy] > 0.0:
            outcomes[copy] = advance(
                state.body, state.law, abreast.rest[copy], abreast.position[copy], abreast.velocity[copy], seconds, substeps[copy], scratch
            )
            abreast.rate[copy] = scratch.rate[0]
