"""How an evaluation can end: the numbers of `evodevo_msgs/Evaluation`, as kernels use them.  `outcome.Status` names them for users."""

from ..kernels.jit import lean
from ..physics.soundness import INVERTED as TURNED_INSIDE_OUT

OK, NO_GROWTH, NO_CHAMBER, RESTING, UNSTABLE, INVERTED, INVALID_GENOME, UNSETTLED, NO_ROOM = range(9)


@lean
def end_of(outcome):
    """How an evaluation ends by what physics found unsound."""
    return INVERTED if outcome == TURNED_INSIDE_OUT else UNSTABLE
