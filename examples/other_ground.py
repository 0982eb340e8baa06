"""The same walker on flat and on rough ground, and in a body twice as stiff.  No ROS.

    python examples/other_ground.py
"""

from pathlib import Path

from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.worlds import with_world

from evodevo_sim import evaluate, load_genome

champions = Path(__file__).resolve().parents[1] / "src" / "evodevo_sim" / "champions"
walker = load_genome(champions / "walker.yaml")
flat = with_settings(default_task("walk"), {"starts": 1, "control_steps": 600})

for name, task in (
    ("flat", flat), ("rough", with_world(flat, "rough")), ("stiffer", with_settings(flat, {"material.stiffness": 800.0})),
):
    evaluation = evaluate(walker, task)
    print(f"{name:8} {evaluation.status.name:8} {evaluation.metrics.distance:6.2f} m")
