"""What ROS costs: generations through simulator nodes against the same evaluations in this process, in turns in one run.

    python benchmarks/services.py [--rounds N] [--population N] [--cells N] [--workers N] [--nodes]

A round is a generation as a search in one population asks for it, the next one after the last.  Prints seconds for a
generation, the service's overhead as the median of the rounds' ratios, what share of it the messages take on our side, whether both gave
the same bits, and the memory of the simulator nodes together.
"""

from __future__ import annotations

import argparse
import statistics
import time

import psutil
import rclpy
from evodevo_ga.backends.ros import RosBackend
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.pool.driver import Pool
from evodevo_ga.times import EVALUATION, MESSAGES, Times
from evodevo_sim.parameters import with_settings
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.own_simulators import OwnSimulators
from evodevo_sim.ros.process import stay_on_this_host
from rclpy.experimental import EventsExecutor
from tqdm import tqdm

from evodevo_ga import Evolution, Settings
from evodevo_sim import Task

SEED = 1


def evolved(task, population, generations, workers):
    """An evolution that has gone on for a while: most genomes grow, some rest."""
    evolution = Evolution(Settings(population=population), SEED)
    for _ in tqdm(range(generations), desc="evolving the genomes", unit="gen", leave=False):
        evolution.tell(evaluate_all(evolution.ask(), task, SEED, workers))
    return evolution


def timed(evaluate, genomes):
    before, began = processor_time(), time.perf_counter()
    result = evaluate(genomes)
    return time.perf_counter() - began, processor_time() - before, result


def processor_time():
    """s that this process and its simulators have had of processors."""
    processes = [psutil.Process(), *psutil.Process().children()]
    return sum(process.cpu_times().user + process.cpu_times().system for process in processes)


def watched(times, evaluate, *given):
    with times(EVALUATION):
        return evaluate(*given)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--population", type=int, default=100)
    parser.add_argument("--cells", type=int, default=32)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--nodes", action="store_true", help="a node for each worker, not one node with a thread for each")
    parser.add_argument("--generations", type=int, default=12, help="evolved before measuring")
    given = parser.parse_args()
    task = with_settings(Task(), {"development.max_cells": given.cells})
    evolution = evolved(task, given.population, given.generations, given.workers)

    stay_on_this_host()
    with loopback_alone():
        rclpy.init()
    node, executor = rclpy.create_node("benchmark"), EventsExecutor()
    executor.add_node(node)
    count, threads = (given.workers, 1) if given.nodes else (1, given.workers)
    with OwnSimulators(count, threads=threads) as own:
        times = Times()
        pool = Pool(RosBackend(node, executor, own=own, times=times))
        while len(pool) < count:
            pool.wait(60.0)
        ways = {
            "in this process": lambda genomes: evaluate_all(genomes, task, SEED, given.workers),
            "through simulators": lambda genomes: watched(
                times, pool.evaluate, genomes, task, SEED, lambda: False, evolution.champion.evaluation.fitness
            ),
        }
        seconds, work = {name: [] for name in ways}, dict.fromkeys(ways, 0.0)
        results = {name: evaluate(evolution.ask()) for name, evaluate in ways.items()}  # warm
        equal, evaluated = True, 0
        for k in tqdm(range(given.rounds), desc="rounds", leave=False):
            genomes = evolution.ask()
            for name in list(ways)[:: 1 if k % 2 else -1]:
                took, worked, results[name] = timed(ways[name], genomes)
                seconds[name].append(took)
                work[name] += worked
            here, there = results.values()
            equal &= here == there
            evaluated += len(here)
            evolution.tell(here)
        memory = [process.memory_info().rss / 2**20 for process in psutil.Process().children()]
    rclpy.try_shutdown()

    here, there = seconds.values()
    print(
        f"generations {given.generations + 1} to {given.generations + given.rounds} of {given.population}, "
        f"{evaluated / given.rounds:.0f} evaluations each, {given.cells} cells, {given.workers} workers"
    )
    for name, values in seconds.items():
        print(f"  {name:20s} {min(values):.3f} s at the least, {statistics.median(values):.3f} s in the median")
    ratio = statistics.median(b / a for a, b in zip(here, there))
    print(
        f"  overhead of the services: {100 * (ratio - 1):+.1f} % (median of the rounds' ratios), "
        f"{100 * (min(there) / min(here) - 1):+.1f} % (of the least)"
    )
    alone, served = work.values()
    print(f"  processors' time: {alone / given.rounds:.3f} and {served / given.rounds:.3f} s, {100 * (served / alone - 1):+.1f} %")
    parts = times.seconds()
    share = parts[MESSAGES] / (parts[MESSAGES] + parts[EVALUATION])
    print(f"  making, sending and reading messages: {100 * share:.1f} % of a generation; the rest is waiting for simulators")
    print(f"  equal bits: {equal}")
    print(f"  memory of {len(memory)} simulators: {sum(memory):.0f} MB")


if __name__ == "__main__":
    main()
