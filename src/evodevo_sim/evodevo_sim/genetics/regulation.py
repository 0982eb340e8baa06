"""Gene regulatory network: from a linear genome to sparse weights, and one step of all cells (paper section 2.1).

Concentrations live in one table, a row per quantity and a column per cell:

    [0, units)                 concentration of each unit's products, which share one rate and so one value
    [units, units + 4)         output factors: division, axis, expansion, contraction
    then `units` rows          morphogens as perceived by each cell
    then `INPUTS` rows         input signals, clamped from outside
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.jit import inlined, kernel, lean
from ..kernels.lanes import LANES, WAYS, add_rows, aligned, fma, padded, sum_rows, sum_rows_twice
from ..kernels.vectors import load4, padded4, store, transpose
from .elements import HEADER, INPUTS, MORPHOGEN, OUTPUTS, REGULATORY

DIVISION, AXIS, EXPANSION, CONTRACTION = range(4)
REACH = 5.0  # affinity is 0 beyond this distance
_TRACE = 1e-30  # a concentration below this is none; decay would end in denormal numbers, which cost ten times as much


class Network(NamedTuple):
    """Sparse rows of weights, each filled up with weights of 0 to a multiple of WAYS."""

    units: int  # regulatory units of the genome
    nodes: np.ndarray  # (R,) int64: table rows to integrate
    start: np.ndarray  # (R + 1,) int64: node n sums over [start[n], start[n + 1])
    source: np.ndarray  # (K,) int64: where the row begins that is summed, in a table that is flat
    weight: np.ndarray  # (K,)
    twin: np.ndarray  # (R,) bool: whether the next node sums the same rows
    morphogens: np.ndarray  # (M,) int64: units whose morphogens are perceived


class Spread(NamedTuple):
    """Scratch of `exchange`, rows by cell and columns by morphogen, both filled up."""

    part: np.ndarray  # (rows,): share of what a cell has that each neighbour gets, left by `share_out`
    given: np.ndarray  # (rows, columns): what that is
    received: np.ndarray  # (rows, columns): what came from all of them


@lean
def affinity(distance):
    """Affinity of a trans point for a cis point at `distance`: 10 at 0, 0 from 5 on."""
    if distance > REACH:
        return 0.0
    return 2.0 * (REACH - distance) / (10.0 * distance + 1.0)


@lean
def activation(a):
    """tanh(max(a, 0) / 2), defined as Lambert's continued fraction so that every machine gives the same bits.

    Within 7e-6 of tanh everywhere (at a = 12.6; within 4e-7 up to 9), and never above 1.
    """
    x = 0.5 * a
    x = x if x > 0.0 else 0.0
    x = x if x < 7.5 else 7.5
    s = x * x
    top = x * fma(fma(fma(990.0 + s, s, 135135.0), s, 4729725.0), s, 34459425.0)
    bottom = fma(fma(fma(fma(s, 45.0, 13860.0), s, 945945.0), s, 16216200.0), s, 34459425.0)
    ratio = top / bottom
    return ratio if ratio < 1.0 else 1.0


@kernel
def assign_units(kind):
    """Unit of every element, -1 for none: a run of regulatory elements followed by a run of genes.

    Args: kind (E,) uint8.  Returns: ((E,) int64, number of units).
    """
    unit = np.full(kind.size, -1, np.int64)
    units = 0
    i = HEADER
    while i < kind.size:
        first = i
        while i < kind.size and kind[i] == REGULATORY:
            i += 1
        genes = i
        while i < kind.size and kind[i] != REGULATORY:
            i += 1
        if genes > first and i > genes:
            for k in range(first, i):
                unit[k] = units
            units += 1
    return unit, units


@kernel
def express(kind, sign, x, y):
    """All weights of the network that a genome encodes.

    Args: parallel arrays (E,).  Returns: (weights (units + 4, 2 units + INPUTS), units); columns are own products, perceived
    morphogens, input signals.
    """
    unit, units = assign_units(kind)
    weights = np.zeros((units + OUTPUTS, 2 * units + INPUTS))
    for cis in range(kind.size):
        if INPUTS <= cis < HEADER:
            node = units + cis - INPUTS
        elif cis >= HEADER and kind[cis] == REGULATORY and unit[cis] >= 0:
            node = unit[cis]
        else:
            continue
        for trans in range(kind.size):
            if trans < INPUTS:
                source = 2 * units + trans
            elif trans >= HEADER and kind[trans] != REGULATORY and unit[trans] >= 0:
                source = unit[trans]
                if kind[trans] == MORPHOGEN:
                    source += units
            else:
                continue
            distance = np.sqrt((x[cis] - x[trans]) ** 2 + (y[cis] - y[trans]) ** 2)
            if distance < REACH:
                weights[node, source] += sign[cis] * sign[trans] * affinity(distance)
    return weights, units


@kernel
def _numbers(chosen):
    """Where (N,) bool holds, ascending."""
    found, count = np.empty(chosen.size, np.int64), 0
    for k in range(chosen.size):
        if chosen[k]:
            found[count] = k
            count += 1
    return found[:count].copy()


@kernel
def prune(weights, units, read_outputs, given_inputs, cells):
    """The part of a network that what is read depends on, as sparse rows.

    Args: weights and units of `express`; read_outputs (4,) and given_inputs (INPUTS,) bool: outputs that something reads, and
    inputs that this scene has; cells: for how many a table is made.  Dropping the rest changes no output by one bit.
    """
    targets = units + OUTPUTS
    needed, open_, count = np.zeros(targets, np.bool_), np.empty(targets, np.int64), 0
    for k in range(OUTPUTS):
        if read_outputs[k]:
            needed[units + k], open_[count] = True, units + k
            count += 1
    while count:  # each node once, so that a chain of units takes no longer than any other network of its size
        count -= 1
        node = open_[count]
        for v in range(units):
            if not needed[v] and (weights[node, v] != 0.0 or weights[node, units + v] != 0.0):
                needed[v], open_[count] = True, v
                count += 1
    nodes = _numbers(needed)
    start = np.zeros(nodes.size + 1, np.int64)
    source = np.zeros(nodes.size * (weights.shape[1] + WAYS), np.int64)
    weight = np.zeros(source.size)
    carried = np.zeros(units, np.bool_)
    count = 0
    for row, node in enumerate(nodes):
        for s in range(weights.shape[1]):
            w = weights[node, s]
            if w == 0.0 or (s >= 2 * units and not given_inputs[s - 2 * units]):
                continue
            source[count] = (s if s < units else s + OUTPUTS) * padded(cells)
            weight[count] = w
            count += 1
            if units <= s < 2 * units:
                carried[s - units] = True
        count += -count % WAYS
        start[row + 1] = count
    twin = np.zeros(nodes.size, np.bool_)
    for row in range(nodes.size - 1):
        first, last = start[row], start[row + 1]
        twin[row] = start[row + 2] - last == last - first
        for k in range(first, last):
            twin[row] = twin[row] and source[k] == source[k + last - first]
    return Network(
        units=units, nodes=nodes, start=start, source=source[:count].copy(), weight=weight[:count].copy(), twin=twin,
        morphogens=_numbers(carried),
    )


@lean
def regulate(network, table, drive, cells, rate):
    """One synchronous regulation step of every cell, c <- c + h (activation(A) - c).

    Args: table (rows, W), `lanes.aligned`, with perceived morphogens and inputs filled in, 0 beyond the cells; drive: scratch of
    the same width with a row per node, left holding activation(A); rate: h.
    """
    nodes, start, source, weight = network.nodes, network.start, network.source, network.weight
    width, room, row = padded(cells), drive.shape[1], 0
    while row < nodes.size:
        for at in range(0, width, LANES):
            if network.twin[row]:
                places = row * room + at, (row + 1) * room + at
                sum_rows_twice(table, source, weight, start[row], start[row + 1], at, drive, places)
            else:
                sum_rows(table, source, weight, start[row], start[row + 1], at, drive, row * room + at)
        row += 2 if network.twin[row] else 1
    for row in range(nodes.size):
        a = drive[row]
        c = table[nodes[row]]
        for i in range(width):
            target = activation(a[i])
            after = fma(rate, target - c[i], c[i])
            a[i] = target
            c[i] = after if after > _TRACE else 0.0


@lean
def unrest(network, table, drive, cells):
    """How far concentrations are from where the last `regulate` drove them, at the most: 0 at a fixed point."""
    most = 0.0
    for row in range(network.nodes.size):
        for i in range(cells):
            most = max(most, abs(drive[row, i] - table[network.nodes[row], i]))
    return most


@lean
def share_out(start, cells, spread):
    """Learn from the adjacency lists of a graph what part of each morphogen a cell's neighbours get: none where it is alone."""
    for i in range(cells):
        degree = start[i + 1] - start[i]
        spread.part[i] = 1.0 / degree if degree else 0.0


@lean
def exchange(network, table, start, neighbour, cells, spread):
    """Variant B: every cell shares each morphogen equally among its graph neighbours, so the total is conserved.

    A cell without neighbours gives nothing: what it makes is perceived by nobody.

    Args: start (cells + 1,), neighbour: adjacency lists of the graph; spread: scratch, which `share_out` has seen this graph.
    """
    morphogens, given, received, part = network.morphogens, spread.given, spread.received, spread.part
    last, width, columns = morphogens.size - 1, table.shape[1], given.shape[1]
    for m in range(0, morphogens.size, 4):  # beyond the last, the last once more
        a, b, c, d = _rows(morphogens, 0, m, last, width)
        for i in range(0, cells, 4):
            p, at = load4(part, i), i * columns + m
            one, two, three, four = transpose(
                p * load4(table, a + i), p * load4(table, b + i), p * load4(table, c + i), p * load4(table, d + i)
            )
            store(given, at, one)
            store(given, at + columns, two)
            store(given, at + 2 * columns, three)
            store(given, at + 3 * columns, four)
    for i in range(cells if morphogens.size else 0):
        for column in range(0, columns, LANES):
            add_rows(given, neighbour, start[i], start[i + 1], column, received, i * columns + column)
    for m in range(0, morphogens.size, 4):
        a, b, c, d = _rows(morphogens, network.units + OUTPUTS, m, last, width)
        for i in range(0, cells, 4):
            at = i * columns + m
            one, two, three, four = transpose(
                load4(received, at), load4(received, at + columns), load4(received, at + 2 * columns), load4(received, at + 3 * columns)
            )
            store(table, a + i, one)
            store(table, b + i, two)
            store(table, c + i, three)
            store(table, d + i, four)


@inlined
def _rows(morphogens, first, m, last, width):
    """Where the rows of four morphogens begin."""
    return (
        (first + morphogens[m]) * width, (first + morphogens[min(m + 1, last)]) * width,
        (first + morphogens[min(m + 2, last)]) * width, (first + morphogens[min(m + 3, last)]) * width,
    )


@kernel
def make_spread(network, cells):
    rows = padded4(cells)
    return Spread(np.zeros(rows), aligned(rows, network.morphogens.size), aligned(rows, network.morphogens.size))
