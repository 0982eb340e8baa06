"""Height profiles of ground and ceiling as numbers: what is wrong with them, and their height at a place.

`parameters` imports this and `--help` imports that, so NumPy comes with the first profile that has points.
"""

from __future__ import annotations

CELL = 1.0  # m, diameter
_LEAST_RUN = 1e-3  # m, from one point to the next
MOST_POINTS = 100_000


def fault(ground_x, ground_y, ceiling_x, ceiling_y) -> str:
    """What is wrong with profiles, and the mend; nothing where they are sound."""
    if not (len(ground_x) or len(ground_y) or len(ceiling_x) or len(ceiling_y)):
        return ""
    import numpy as np

    for name, x, y in (("ground", ground_x, ground_y), ("ceiling", ceiling_x, ceiling_y)):
        if len(x) != len(y):
            return f"{name} has {len(x)} x and {len(y)} y: give as many of both"
        if len(x) == 1 or len(x) > MOST_POINTS:
            return f"{name} has {len(x)} points: give none, or 2 to {MOST_POINTS}"
        wrong = np.flatnonzero(~(np.abs(np.array([x, y], float)) <= 1e6).all(0)) if len(x) else ()
        if len(wrong):
            return f"{name}[{wrong[0]}] is ({x[wrong[0]]!r}, {y[wrong[0]]!r}): give metres from -1e6 to 1e6"
        back = np.flatnonzero(~(np.diff(x) >= _LEAST_RUN)) if len(x) else ()
        if len(back):
            k = int(back[0])
            return (
                f"{name} is not single-valued: point {k + 1} at x = {x[k + 1]:g} follows x = {x[k]:g}: let x ascend by "
                f"{_LEAST_RUN:g} m or more (a wall is a steep step)"
            )
    if len(ceiling_x):
        at = np.union1d(ceiling_x, ground_x)
        room = profile(ceiling_x, ceiling_y, at) - profile(ground_x, ground_y, at)
        k = int(room.argmin())
        if room[k] < CELL:
            return f"the opening at x = {at[k]:g} is {room[k]:g} m high, less than a cell: make it {CELL:g} m or more"
    return ""


def profile(xs, ys, x):
    """Height of a profile at x, m, of any shape; 0 where it has no points."""
    import numpy as np

    return np.interp(x, xs, ys) if len(xs) else np.zeros(np.shape(x))
