"""How an evaluation can end: the numbers of `evodevo_msgs/Evaluation`, as kernels use them.  `outcome.Status` names them for users."""

from ..kernels.jit import lean
from ..physics.soundness import INVERTED as TURNED_INSIDE_OUT

OK, NO_GROWTH, NO_CHAMBER, RESTING, UNSTABLE, INVERTED, INVALID_GENOME, UNSETTLED, NO_ROOM, STOPPED = range(10)

_ROUNDING = 1e-9  # of a bound, more than all roundings of a fitness and of its bound: sums of up to 1,000 terms, roots, products


@lean
def surely(bound):
    """What a fitness whose terms are at most those of `bound` cannot exceed, however both are rounded.  Args: bound: 0 or more."""
    return bound * (1.0 + _ROUNDING)


@lean
def end_of(outcome):
    """How an evaluation ends by what physics found unsound."""
    return INVERTED if outcome == TURNED_INSIDE_OUT else UNSTABLE
