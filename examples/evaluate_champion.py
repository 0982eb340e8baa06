"""Evaluate a shipped champion: fitness, status, metrics.  No ROS.

    python examples/evaluate_champion.py [GENOME]
"""

import sys
from pathlib import Path

from evodevo_sim import Task, evaluate, load_genome

champions = Path(__file__).resolve().parents[1] / "src" / "evodevo_sim" / "champions"
genome = load_genome(sys.argv[1] if len(sys.argv) > 1 else champions / "ribbon.yaml")

evaluation = evaluate(genome, Task())
metrics = evaluation.metrics
print(f"{evaluation.status.name}: fitness {evaluation.fitness:.3f} m, {metrics.cells} cells, {metrics.chambers} chambers")
print(f"it swims {metrics.distance:.2f} m in {Task().control_steps * Task().control_step:.1f} s")
