"""Evaluate a champion: fitness, status, metrics.  No ROS.

    python examples/evaluate_champion.py [NAME|GENOME.yaml]
"""

import sys

from evodevo_sim import Task, champions, evaluate, load_champion, load_genome

name = sys.argv[1] if len(sys.argv) > 1 else "ribbon"
genome = load_champion(name) if name in champions() else load_genome(name)

task = Task()
evaluation = evaluate(genome, task)
metrics = evaluation.metrics
print(f"{evaluation.status.name}: fitness {evaluation.fitness:.3f} m, {metrics.cells} cells, {metrics.chambers} chambers")
print(f"it swims {metrics.distance:.2f} m in {task.control_steps * task.control_step:.1f} s")
