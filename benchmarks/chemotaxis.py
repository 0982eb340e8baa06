"""Whether champions find targets where they were never tested, and what an evaluation costs.

    python benchmarks/chemotaxis.py CHAMPION.yaml|RUN ... [--placements 50] [--seed 1] [--cost]

Each champion swims towards every placement from its birth: angles from 20 to 120 degrees, on either side in turn, distances drawn
from 0.5 to 1.5 of `chemotaxis.distance`, but within a tenth of it of none that it was tested with in evolution.  Said is the
distribution of the last distance of the centre of mass over the first.  A champion passes where, in the median of the placements
on each side, it at least halves the distance.  --cost prints CPU times of an evaluation on one core.
"""

import argparse
import time

import numpy as np
from evodevo_sim.recording.champion import champion_of
from evodevo_sim.ros.command_line import pairs
from evodevo_sim.tasks.chemotaxis.fitness import attempt, placements

from evodevo_sim import Status, evaluate

SHARES = (0.5, 1.5)
APART = 0.1  # of the distance, from those of evolution
ANGLES = np.radians((20.0, 120.0))


def held_out(count, task, seed):
    """(count, 2): rad, to the left positive, and m; sides in turn."""
    rng = np.random.default_rng(seed)
    side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    angle = side * rng.uniform(*ANGLES, count)
    trained, unit = placements(task)[:, 1], task.chemotaxis.distance
    distances = []
    while len(distances) < count:
        distance = unit * rng.uniform(*SHARES)
        if np.abs(distance - trained).min() >= APART * unit:
            distances.append(distance)
    return np.column_stack((angle, distances))


def ratios(champion, places):
    """(count,): last over first distance, inf where that swim fails; also of a straight swim; None where there is nothing to test."""
    found, blind = np.full(len(places), np.inf), np.empty(len(places))
    for k in range(len(places)):
        result = attempt(champion.genome, champion.task, champion.seed, places[k : k + 1])
        if not result.tested:
            return None, None
        blind[k] = np.hypot(*(result.path[-1] - result.targets[0])) / places[k, 1]
        if Status(result.status) == Status.OK:
            found[k] = np.hypot(*(result.paths[0, -1] - result.targets[0])) / places[k, 1]
    return found, blind


def row(name, values):
    quarters = np.quantile(values, (0.0, 0.25, 0.5, 0.75, 1.0), method="nearest")  # some may be infinite
    shares = f"halved {100 * np.mean(values <= 0.5):3.0f} %, nearer {100 * np.mean(values < 1):3.0f} %"
    return f"    {name:22s} " + " ".join(f"{q:5.2f}" for q in quarters) + f"   {shares}"


def cost(champion, repeats=20):
    evaluate(champion.genome, champion.task, champion.seed)
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        evaluate(champion.genome, champion.task, champion.seed)
        times.append(time.thread_time() - start)
    return 1e3 * np.min(times), 1e3 * np.median(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("champions", nargs="+", metavar="CHAMPION.yaml|RUN")
    parser.add_argument("--placements", type=int, default=50, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the placements")
    parser.add_argument("--cost", action="store_true", help="CPU time of an evaluation")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for genome files: a number of the task")
    given = parser.parse_args()
    passed = 0
    for source in given.champions:
        champion = champion_of(source, pairs(given.set), "chemotaxis")
        places = held_out(given.placements, champion.task, given.seed)
        found, blind = ratios(champion, places)
        if found is None:
            print(f"{champion.name}: it does not swim far enough to be tested")
            continue
        left = places[:, 0] > 0
        good = max(np.median(found[left]), np.median(found[~left])) <= 0.5
        passed += good
        print(f"{champion.name}: {'passes' if good else 'does not pass'}; last over first distance, {len(places)} placements")
        print("                           least   1/4  half   3/4  most")
        print(row("left", found[left]) + "\n" + row("right", found[~left]) + "\n" + row("blind, straight ahead", blind))
        if given.cost:
            least, median = cost(champion)
            print(
                f"    an evaluation of {champion.task.development.max_cells} cells: {least:.1f} ms CPU at best, {median:.1f} in the median"
            )
    print(f"{passed} of {len(given.champions)} champions pass")


if __name__ == "__main__":
    main()
