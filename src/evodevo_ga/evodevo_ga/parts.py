"""Genomes in two parts: the elements that growth depends on, and the gait, all others.

Affinities end at a distance (`REACH`), so one plane has room for networks that do not know of each other.  In a genome of two parts the
products of either stay out of the reach of the other's receptors, and only inputs are shared: children of which one part alone has
changed have the other one whole.  In genomes that were not made so the gait may be as little as the points of expansion and contraction.
"""

from __future__ import annotations

import numpy as np
from evodevo_sim.genetics.elements import HEADER, INPUT_NAMES, INPUTS, MORPHOGEN, OUTPUTS, REGULATORY, SPECIAL, TRANSCRIPTION_FACTOR
from evodevo_sim.genetics.genome import Genome
from evodevo_sim.genetics.limits import MAX_ELEMENTS
from evodevo_sim.genetics.regulation import AXIS, CONTRACTION, DIVISION, EXPANSION, assign_units, express

GAIT_SHARE = 0.545  # of the units of a random genome in two parts
_RECEIVES_INPUT = 0.2  # share of its receptors that are where the inputs are
_DENSE = 0.5  # extent of a random gait, of that of the body: one network in thirty oscillates then, at 1 one in two hundred
_SCENT = INPUT_NAMES.index("scent")
FINE, COARSE = (-2.5, 0.3), (-1.5, 0.3)  # powers of ten between which moves of gaits and of bodies are drawn
_RUN, _SIGN, _KIND, _REWIRE = 0.05, 0.05, 0.025, 0.025  # shares of the children
_BESIDE = 0.3  # standard deviation of the place of a receptor beside the product that it goes to


def parts_of(genome: Genome) -> tuple[np.ndarray, np.ndarray]:
    """((E,) bool: the elements that division and axis depend on, the inputs but for the scent among them; (E,) bool: those of the gait,
    that expansion and contraction depend on and growth does not, the scent among them).  What is in neither is silent."""
    unit, units = assign_units(genome.kind)
    weights, _ = express(*genome.arrays())
    reads = (weights[:, :units] != 0.0) | (weights[:, units : 2 * units] != 0.0)
    found = []
    for outputs in ((DIVISION, AXIS), (EXPANSION, CONTRACTION)):
        needed = reads[[units + k for k in outputs]].any(axis=0)
        while not np.array_equal(more := needed | reads[:units][needed].any(axis=0), needed):
            needed = more
        part = np.zeros(len(genome), bool)
        part[HEADER:] = np.append(needed, False)[unit[HEADER:]]
        part[[INPUTS + k for k in outputs]] = True
        found.append(part)
    growth, gait = found
    growth[:INPUTS] = True
    growth[_SCENT], gait[_SCENT] = False, True
    return growth, gait & ~growth


def growth_part(genome: Genome) -> np.ndarray:
    """(E,) bool: the elements that growth depends on."""
    return parts_of(genome)[0]


def entangled(child: Genome, growth: np.ndarray) -> bool:
    """Whether growth depends on more of a child than of its parent, whose part `growth` is, but for what was copied in it.

    A product of the gait that a receptor of growth can just reach may change no body yet, and binds the whole gait to it for good.
    """
    return bool(np.count_nonzero(growth_part(child)) > np.count_nonzero(growth))


def random_parted(rng: np.random.Generator, units: int, extent: float, apart: float, scent_extent: float = 0.0) -> Genome:
    """A random genome in two parts: inputs around the origin, what growth reads `apart` on one side, the gait as far on the other.

    Args: units: of both; extent: half side of the squares of points; scent_extent: of the scent's points, around the gait; 0 is extent.
    """
    gait = max(1, round(GAIT_SHARE * units))
    kinds, sides = [SPECIAL] * HEADER, [0.0] * INPUTS + [0.0] * OUTPUTS
    for k in range(OUTPUTS):
        sides[INPUTS + k] = apart if k in (DIVISION, AXIS) else -apart
    sides[_SCENT] = -apart
    every = max(units, gait + 1)
    for number in range(every):
        kind = [REGULATORY] * int(rng.integers(1, 3))
        kind += [int(k) for k in rng.integers(TRANSCRIPTION_FACTOR, MORPHOGEN + 1, rng.integers(1, 3))]
        side = -apart if number >= every - gait else apart
        sides += [0.0 if k == REGULATORY and rng.random() < _RECEIVES_INPUT else side for k in kind]
        kinds += kind
    shift = np.array(sides)
    points = rng.uniform(-extent, extent, (len(kinds), 2)) * np.where(shift < 0.0, _DENSE, 1.0)[:, None]
    if scent_extent:
        points[_SCENT] = rng.uniform(-scent_extent, scent_extent, 2)
    return Genome(np.array(kinds), rng.choice((-1, 1), len(kinds)), points[:, 0] + shift, points[:, 1])


def graft(body: Genome, gait: Genome) -> Genome:
    """A genome with what growth depends on of one and the gait of the other; silent elements are left out."""
    columns = []
    of_body, of_gait = parts_of(body)[0], parts_of(gait)[1]
    first, second = HEADER + np.flatnonzero(of_body[HEADER:]), HEADER + np.flatnonzero(of_gait[HEADER:])
    for b, g in zip(body.arrays(), gait.arrays()):
        columns.append(np.concatenate([np.where(of_body[:HEADER], b[:HEADER], g[:HEADER]), b[first], g[second]])[:MAX_ELEMENTS])
    return Genome(*columns)


def varied(genome: Genome, part: np.ndarray, rng: np.random.Generator, decades: tuple[float, float]) -> tuple[Genome, tuple[str, ...]]:
    """A child of which only elements of a part have changed: one to six points moved, sometimes a run copied or lost, a sign, a gene's
    kind, or a receptor that goes beside another product.

    Args: part (E,) bool; decades: powers of ten between which the standard deviation of a move's length is drawn.
    Returns: the child; names of what changed it.
    """
    made: list[str] = []
    drawn = rng.random()
    own = np.flatnonzero(part)
    behind = own[own >= HEADER]
    if drawn < 2 * _RUN and behind.size:
        genome, part, name = _run_changed(genome, part, behind, rng, drawn < _RUN)
        made += [name] if name else []
        own = np.flatnonzero(part)
        behind = own[own >= HEADER]
    kind, sign, x, y = (values.copy() for values in genome.arrays())
    drawn -= 2 * _RUN
    if 0.0 <= drawn < _SIGN:
        k = rng.choice(own)
        sign[k] = -sign[k]
        made.append("flip")
    elif 0.0 <= drawn - _SIGN < _KIND and (genes := behind[kind[behind] != REGULATORY]).size:
        k = rng.choice(genes)
        kind[k] = TRANSCRIPTION_FACTOR + MORPHOGEN - kind[k]
        made.append("flip")
    elif 0.0 <= drawn - _SIGN - _KIND < _REWIRE and (receptors := behind[kind[behind] == REGULATORY]).size:
        products = np.concatenate((np.arange(INPUTS), behind[kind[behind] != REGULATORY]))
        k, beside = rng.choice(receptors), rng.choice(products)
        x[k], y[k] = np.array((x[beside], y[beside])) + rng.normal(0.0, _BESIDE, 2)
        made.append("rewire")
    count = min(int(rng.geometric(0.6)), 6, own.size)
    chosen, direction = rng.choice(own, count, replace=False), rng.uniform(0.0, 2.0 * np.pi, count)
    length = 10.0 ** rng.uniform(*decades) * np.abs(rng.normal(size=count))
    x[chosen] += length * np.cos(direction)
    y[chosen] += length * np.sin(direction)
    return Genome(kind, sign, x, y), (*made, "points")


def _run_changed(genome, part, behind, rng, copied):
    """The genome with a run of a part's elements copied into that part or lost.  Returns: it, its part, the name of the operator."""
    first, length = int(rng.integers(behind.size)), int(rng.geometric(1.0 / 2.6))
    run = behind[first : first + length]
    index = np.arange(len(genome))
    if copied and len(genome) + run.size <= MAX_ELEMENTS:
        at = int(rng.choice(behind)) + 1
        index = np.concatenate((index[:at], run, index[at:]))
        return genome.take(index), np.concatenate((part[:at], np.ones(run.size, bool), part[at:])), "duplicate"
    if not copied and behind.size > run.size + 4:
        index = np.delete(index, run)
        return genome.take(index), part[index], "delete"
    return genome, part, ""
