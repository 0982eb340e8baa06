"""Evolve swimmers in this process, without ROS: ask for genomes, tell their evaluations.

    python examples/evolve_here.py [GENERATIONS]
"""

import sys

from evodevo_ga.in_process import evaluate_all

from evodevo_ga import Evolution, Settings

generations = int(sys.argv[1]) if len(sys.argv) > 1 else 5
evolution = Evolution(Settings(population=20, generations=generations), seed=1)
while not evolution.finished:
    statistics = evolution.tell(evaluate_all(evolution.ask(), workers=2))
    print(f"generation {statistics.generation}: best {statistics.best:.3f}, median {statistics.median:.3f}")
print(f"champion: {len(evolution.champion.genome)} elements, fitness {evolution.champion.evaluation.fitness:.3f} m")
