"""The same walker on flat and on rough ground, and in a body a tenth softer.  No ROS.

    python examples/other_ground.py
"""

from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.worlds import with_world

from evodevo_sim import evaluate, load_champion

walker = load_champion("walker")
flat = with_settings(default_task("walk"), {"starts": 1, "control_steps": 600})
tasks = {
    "flat": flat,
    "rough": with_world(flat, "rough"),
    "softer": with_settings(flat, {"material.stiffness": 0.9 * flat.material.stiffness}),
}
for name, task in tasks.items():
    evaluation = evaluate(walker, task)
    print(f"{name:8} {evaluation.status.name:8} {evaluation.metrics.distance:6.2f} m")
