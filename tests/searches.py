"""A stand-in for evaluation, pure and fast, and what whole runs of a search come to with it."""

import hashlib
import math
import struct

from evodevo_sim import Evaluation, Metrics, Status

STATISTICS = (
    "generation", "best", "median", "worst", "diversity", "median_elements", "evaluations", "stagnation", "status_count", "improved",
)


def stand_in(genome) -> Evaluation:
    """Points near the origin are good, rounded so that there are equals; body shapes, and failures, are drawn from the genome's bytes."""
    drawn = hashlib.sha256(genome.key()).digest()
    cells = 3 + drawn[0] % 30
    chambers = drawn[1] % (2 * cells - 4)
    if drawn[2] % 8 == 0:
        return Evaluation(-1.0, Status.NO_CHAMBER, "the body has no closed chamber", Metrics(cells=cells))
    size = math.fsum(abs(value) for value in (*genome.x.tolist(), *genome.y.tolist())) / len(genome)
    return Evaluation(round(2.0 - size, 2), Status.OK, "", Metrics(cells=cells, chambers=chambers, distance=size))


def run_on(evolution, generations=None):
    """Run until it is finished, or so many generations.  Returns: a digest of all that was asked, who was settled, and the statistics."""
    digest = hashlib.sha256()
    while not evolution.finished and generations != 0:
        asked = evolution.ask()
        for genome in asked:
            digest.update(genome.key())
        found = evolution.tell([stand_in(genome) for genome in asked])
        for one in evolution.population:
            digest.update(one.genome.key() + struct.pack("<dii", one.evaluation.fitness, one.born, one.layer))
        counted = found.status_count[: Status.STOPPED]  # nobody who was stopped is settled
        digest.update(repr([counted if name == "status_count" else getattr(found, name) for name in STATISTICS]).encode())
        generations = None if generations is None else generations - 1
    return digest.hexdigest()[:16]
