"""Evolve swimmers in this process: ask for genomes, tell their evaluations, keep the champion.  No ROS.

    python examples/evolve_here.py [GENERATIONS] [CHAMPION.yaml]
"""

import sys

from evodevo_ga.in_process import evaluate_all

from evodevo_ga import Evolution, Settings
from evodevo_sim import save_genome

generations = int(sys.argv[1]) if len(sys.argv) > 1 else 5
evolution = Evolution(Settings(population=20, generations=generations), seed=1)
while not evolution.finished:
    statistics = evolution.tell(evaluate_all(evolution.ask(), workers=2))
    print(f"generation {statistics.generation}: best {statistics.best:.3f}, median {statistics.median:.3f}")
champion = evolution.champion
print(f"champion: {len(champion.genome)} elements, fitness {champion.evaluation.fitness:.3f} m")
if len(sys.argv) > 2:
    save_genome(sys.argv[2], champion.genome, {"task": "swim"})
