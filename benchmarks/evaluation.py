"""What one evaluation costs, for several limits of cells.

    python benchmarks/evaluation.py [--quick]

Genomes are the first random ones that fill their limit of cells, evaluate as OK and move their muscles a little, so that no
run ends early.  Times are of the processor, not of the clock on the wall, on one core: other work on the machine disturbs
them less.  Shares come from timing each part alone on the same genome; what they do not explain is "rest".
"""

import argparse
import itertools
import time

import numba
import numpy as np
from evodevo_sim import Development, Status, Task, evaluate, random_genome
from evodevo_sim.life import birth, develop
from evodevo_sim.physics import accelerations, check
from evodevo_sim.regulation import exchange, regulate
from evodevo_sim.swim_task import kernel_arguments

NOBODY = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
CALLS = 1000
bare = numba.njit(error_model="numpy", _nrt=False)  # as `_jit.lean`, without its cache


@bare
def many_accelerations(life, calls):
    for _ in range(calls):
        accelerations(life.body, life.law, life.rest, life.position, life.velocity, life.scratch, life.scratch.k1)


@bare
def many_checks(life, calls):
    outcome = 0
    for _ in range(calls):
        outcome += check(life.body, life.position, life.velocity, 1e-3)
    return outcome


@bare
def many_regulations(life, calls):
    for _ in range(calls):
        exchange(life.network, life.table, life.start, life.neighbour, life.muscle.size, life.share)
        regulate(life.network, life.table, life.drive, life.muscle.size, 0.1)


def seconds(action, repeats):
    """CPU seconds of every repeat, after one to compile and warm up."""
    action()
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        action()
        times.append(time.thread_time() - start)
    return np.array(times)


def lively(task, count):
    """Genomes that fill the limit of cells and never rest."""
    found = []
    for seed in itertools.count():
        genome = random_genome(np.random.default_rng(seed))
        evaluation = evaluate(genome, task)
        full = evaluation.metrics.cells == task.development.max_cells
        if full and evaluation.status == Status.OK and evaluation.metrics.activation_amplitude > 1e-9:
            found.append(genome)
            if len(found) == count:
                return found


def measure(genome, task, repeats):
    """Seconds: (all repeats of an evaluation, growth, settling, regulation, force evaluations, checks, one force evaluation)."""
    arguments = kernel_arguments(genome, task)
    genes, _, development, continual, material, scene, given = arguments
    whole = seconds(lambda: evaluate(genome, task), repeats)
    grow = seconds(lambda: develop(genes, development, continual, given, *NOBODY), repeats).min()

    def be_born():
        return birth(genes, development, continual, material, scene, given, task.control_step, 1)[1]

    born = seconds(be_born, repeats).min()
    life = be_born()
    life.velocity[:] = 0.1 * np.random.default_rng(0).standard_normal(life.velocity.shape)
    regulation, force, look = (
        seconds(lambda: action(life, CALLS), repeats).min() / CALLS for action in (many_regulations, many_accelerations, many_checks)
    )
    steps = task.control_steps
    return whole, grow, max(born - grow, 0.0), regulation * steps, 4 * life.substeps * force * steps, look * steps, force


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="two sizes, two genomes each, few repeats")
    quick = parser.parse_args().quick
    sizes, count, repeats = ((32, 64), 2, 8) if quick else ((8, 16, 32, 48, 64), 6, 30)
    print(f"CPU time on one core; {count} genomes each, best of {repeats} repeats; growth of 400 and life of 2000 steps")
    print("cells   ms: min  median   ns per force   % growth settling regulation physics checks   rest")
    for cells in sizes:
        task = Task(development=Development(max_cells=cells))
        rows = [measure(genome, task, repeats) for genome in lively(task, count)]
        best = np.array([row[0].min() for row in rows])
        share = np.array([row[1:6] for row in rows]) / best[:, None]
        parts = 100 * share.mean(axis=0)
        force = 1e9 * np.mean([row[6] for row in rows])
        print(
            f"{cells:5d}   {1e3 * best.min():7.2f} {1e3 * np.median(best):7.2f}   {force:12.0f}   "
            f"{parts[0]:8.0f} {parts[1]:8.0f} {parts[2]:10.0f} {parts[3]:7.0f} {parts[4]:6.0f} {100 - parts.sum():6.0f}"
        )


if __name__ == "__main__":
    main()
