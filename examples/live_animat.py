"""Let an animat live step by step, and give it a target to follow.  No ROS.

    python examples/live_animat.py [STEPS]
"""

import sys

from evodevo_sim.live import Animat
from evodevo_sim.parameters import default_task

from evodevo_sim import load_champion

animat = Animat(load_champion("seeker"), default_task("chemotaxis"))
animat.target = (6.0, 6.0)  # m
for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 600):
    animat.step()
x, y = animat.position.mean(axis=0)
print(f"after {animat.time:.1f} s its {len(animat.position)} cells are at ({x:.2f}, {y:.2f}) m")
