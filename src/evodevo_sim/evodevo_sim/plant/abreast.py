"""Copies of a swimming body that move abreast: see `physics.abreast`."""

from __future__ import annotations

import numpy as np

from ..kernels.jit import lean
from ..physics.abreast import COPIES, advance_abreast, keep_start, put_copy, take_copy, take_rest
from ..physics.control_step import advance
from ..physics.forces import Ramp
from ..physics.soundness import SOUND
from ..physics.step_size import substeps_at_rate


@lean
def move_abreast(state, abreast, seconds, outcomes):
    """Carry the copies of a swimming body over a control step, each as `simulated.move` does.

    Args: state: of the body, all of which is scratch; outcomes (4,) int64: filled with SOUND, or with what was wrong, where a lane moves
    its own copy.
    """
    scratch, of, substeps, moving = state.scratch, abreast.of, abreast.substeps, 0
    for lane in range(COPIES):
        scratch.rate[0] = abreast.rate[of[lane]]
        substeps[lane] = int(np.ceil(state.finer * substeps_at_rate(seconds, state.substeps, scratch)))
        moving += of[lane] == lane
    if moving > 1:
        advance_abreast(state.body, state.law, abreast, seconds)
    else:
        keep_start(abreast)
    for lane in range(COPIES):
        outcomes[lane] = SOUND
        if of[lane] == lane and not abreast.sound[lane] > 0.0:
            take_copy(abreast.start, lane, state.position, state.velocity)
            take_rest(abreast.before, lane, state.before)
            take_rest(abreast.rest, lane, state.rest)
            ramp = Ramp(state.before, state.rest, 0.0)
            outcomes[lane] = advance(state.body, state.law, ramp, state.position, state.velocity, seconds, substeps[lane], scratch)
            abreast.rate[lane] = scratch.rate[0]
            put_copy(abreast, lane, state.position, state.velocity)
