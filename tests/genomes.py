"""Genomes for tests: random ones as hypothesis strategies, and small hand-made ones whose lives are known."""

import numpy as np
from evodevo_sim.genetics.elements import HEADER, HEADER_NAMES, REGULATORY, SPECIAL, TRANSCRIPTION_FACTOR
from hypothesis import strategies as st

from evodevo_sim import Genome, random_genome

FAR = 1000.0  # farther than any affinity reaches


def random_genomes(max_units=8):
    """A strategy of random genomes."""
    return st.builds(
        lambda seed, units, extent: random_genome(np.random.default_rng(seed), units, extent),
        st.integers(0, 2**32), st.integers(0, max_units), st.sampled_from([0.5, 2.0, 5.0]),
    )


def hand_made(special=None, units=()):
    """A genome of known wiring: specials are all far apart but for those given as name: (sign, x, y).

    Args: units: lists of (kind, sign, x, y), regulatory elements first.
    """
    rows = [(SPECIAL, 1, FAR * (i + 1), 0.0) for i in range(HEADER)]
    for name, (sign, x, y) in (special or {}).items():
        rows[HEADER_NAMES.index(name)] = (SPECIAL, sign, x, y)
    rows += [row for unit in units for row in unit]
    return Genome(*(np.array(column) for column in zip(*rows)))


def dividing():
    """A genome whose division factor is driven to its full by the constant input: it fills its limit of cells."""
    return hand_made({"constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0)})


def beating():
    """One of the few random genomes that oscillate; it grows to its limit of cells."""
    return random_genome(np.random.default_rng(663))


def unit(cis, products):
    """A unit of cis points [(sign, x, y)] and products [(kind, sign, x, y)]."""
    return [(REGULATORY, *point) for point in cis] + list(products)


def pulsing():
    """A genome that fills its limit of cells and whose muscles beat for ever: a ring of five repressors, with a maternal gradient
    so that not all cells do alike."""
    place = [(0.0, FAR * (i + 1)) for i in range(5)]
    units = [
        unit([(1, 0.02 * i, 0.0), (-1, *place[i - 1])], [(TRANSCRIPTION_FACTOR, 1, *place[i])]) for i in range(5)
    ]
    special = {
        "constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0), "contraction": (1, 0.5, FAR), "expansion": (1, 0.5, 3 * FAR),
        "maternal_x": (-1, 1.5, FAR),
    }
    return hand_made(special, units)


def ring():
    """A ring of three units, each held down by the one before; the first drives expansion, in all cells alike."""
    at = [(-FAR, FAR * k) for k in range(3)]
    units = [
        unit([(1, offset, 0.0), (-1, *at[k - 1])], [(TRANSCRIPTION_FACTOR, 1, *at[k])]) for k, offset in enumerate((0.05, 0.1, 0.15))
    ]
    return hand_made({"constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0), "expansion": (1, *at[0])}, units)


def first_viable(count, start=0):
    """The first random genomes that grow a body with chambers."""
    from evodevo_sim import evaluate

    found = []
    for seed in range(start, start + 1000):
        genome = random_genome(np.random.default_rng(seed))
        if evaluate(genome).metrics.chambers:
            found.append(genome)
            if len(found) == count:
                return found
    raise AssertionError("no viable random genomes")
