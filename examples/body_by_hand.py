"""A body of one's own, without a genome: a ring of cells whose muscles beat in a wave.  No ROS.

    python examples/body_by_hand.py
"""

import numpy as np

from evodevo_sim import make_own_body, simulate_body

CELLS = 8
angle = 2 * np.pi * np.arange(CELLS) / CELLS
body = make_own_body({
    "position": (1.3 * np.column_stack((np.cos(angle), np.sin(angle)))).tolist(),  # m
    "springs": [[i, (i + 1) % CELLS] for i in range(CELLS)],
    "chambers": [list(range(CELLS))],
    "activation": {"amplitude": [0.8] * CELLS, "frequency": [2.0] * CELLS, "phase": angle.tolist()},  # -, Hz, rad
})
motion = simulate_body(body, "swim", duration=5.0)
x, y = (motion.position[-1] - motion.position[0]).mean(axis=0)
print(f"{motion.cause or 'sound'}: after {motion.time[-1]:.1f} s it is ({x:+.2f}, {y:+.2f}) m from where it began")
