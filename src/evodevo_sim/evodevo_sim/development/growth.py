"""Growth from one cell (paper section 2.2): regulation, division, collision and adhesion, both variants of the model."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..genetics.elements import INPUTS, OUTPUTS
from ..genetics.regulation import AXIS, CONTRACTION, DIVISION, EXPANSION, exchange, make_spread, regulate, share_out, unrest
from ..kernels.jit import inlined, kernel, lean
from ..kernels.lanes import aligned
from ..kernels.vectors import (
    chosen,
    even_pairs,
    evens,
    four,
    high,
    index,
    join,
    lane,
    load2,
    load4,
    low,
    magnitude,
    odd_pairs,
    odds,
    padded4,
    root,
    store,
)
from .gabriel import adjacency, follow

REST = 1e-8  # concentrations this close to where they are driven, and steps that move no cell farther, are at rest
_CLEAR = 0.05  # m, least distance of a new daughter from any cell
_ROUNDING = 1e-11  # m, above that of a cell's move within bodies of up to 10 km
_GOLDEN_ANGLE = 2.399963229728653


class Embryo(NamedTuple):
    """What grew."""

    position: np.ndarray  # (N, 2) m
    table: np.ndarray  # (rows, padded N) of concentrations, see `regulation`; 0 beyond N
    edges: np.ndarray  # (E, 2) of the graph, i < j, ascending
    start: np.ndarray  # (N + 1,): where each cell's neighbours begin
    neighbour: np.ndarray  # (2 E,) uint32
    steps: int  # regulation steps until all was at rest
    past: np.ndarray  # (delays, morphogens, cells): variant A's history, see `remember`
    delay: np.ndarray  # (cells, cells, 2): variant A's delays, see `diffuse`


class Ends(NamedTuple):
    """The ends of edges, see `_list_ends`; filled up to fours."""

    first: np.ndarray  # (>= E,) uint32
    second: np.ndarray  # (>= E,) uint32


class Pushes(NamedTuple):
    """Scratch of `_relax`."""

    shift: np.ndarray  # (> cells, 2) m
    held: np.ndarray  # (> cells,): neighbours that hold each cell
    push: np.ndarray  # (3, >= E): of each edge


@lean
def maternal(table, first_input, position, cells, length):
    """Fill the clamped inputs: two maternal gradients of the position in the egg, and the constant."""
    for i in range(cells):
        for axis in range(2):
            p = position[i, axis]
            table[first_input + axis, i] = 0.5 + 0.5 * p / (length + abs(p))
        table[first_input + 2, i] = 1.0


@lean
def _divide(position, axis, table, units, cells, development, degree):
    """Let every cell whose division factor is high enough divide, in order of age.  Returns the new number of cells.

    A cell of `division_neighbours` waits.  So does one whose daughter would come nearer than `division_room` to another cell, and
    turns its axis.  Where no room is asked for, a daughter that would lie upon another cell goes elsewhere around her mother.

    Args: degree (>= cells,) int64: neighbours of each cell.
    """
    now, room, most = cells, development.division_room, development.division_neighbours
    least = max(room, _CLEAR)
    for i in range(cells):
        if now >= development.max_cells:
            break
        if table[units + DIVISION, i] <= development.division_threshold or 0 < most <= degree[i]:
            continue
        ax, ay, clear = axis[i, 0], axis[i, 1], False
        for _ in range(1 if room > 0.0 else 8):
            x, y = position[i, 0] + 0.5 * ax, position[i, 1] + 0.5 * ay
            clear = True
            for j in range(now):
                clear = clear and (j == i or (x - position[j, 0]) ** 2 + (y - position[j, 1]) ** 2 > least**2)
            if clear:
                break
            turn = development.waiting_turn if room > 0.0 else _GOLDEN_ANGLE
            c, s = np.cos(turn), np.sin(turn)
            ax, ay = c * ax - s * ay, s * ax + c * ay
        if room > 0.0 and not clear:
            axis[i, 0], axis[i, 1] = ax, ay
            continue
        position[now, 0], position[now, 1] = x, y
        turn = development.division_turn + development.axis_turn * table[units + AXIS, i]
        c, s = np.cos(turn), np.sin(turn)
        axis[i, 0], axis[i, 1] = c * ax - s * ay, s * ax + c * ay
        axis[now, 0], axis[now, 1] = axis[i, 0], axis[i, 1]
        table[units + DIVISION, i] = 0.0
        for row in range(table.shape[0]):
            table[row, now] = table[row, i]
        now += 1
    return now


@lean
def _turns(table, units, cells, development):
    """Whether a cell that waits turns its axis, and so may find room yet."""
    turns = False
    if development.division_room > 0.0 and development.waiting_turn != 0.0 and cells < development.max_cells:
        for i in range(cells):
            turns = turns or table[units + DIVISION, i] > development.division_threshold
    return turns


@lean
def _crowded(edges, count, cells, degree):
    """Whether any cell has more than six edges.  degree (>= cells,) int64 is scratch."""
    most = 0
    for i in range(cells):
        degree[i] = 0
    for e in range(count):
        for end in range(2):
            i = edges[e, end]
            degree[i] += 1
            most = max(most, degree[i])
    return most > 6


@lean
def _list_ends(edges, count, spare, ends):
    """Where the ends of edges begin in their positions, filled up to fours with a cell that is none, at `spare`."""
    first, second = ends.first, ends.second
    for e in range(padded4(count)):
        first[e], second[e] = 2 * (edges[e, 0] if e < count else spare), 2 * (edges[e, 1] if e < count else spare)


@inlined
def _apart(position, first, second, e):
    return load2(position, index(second, e)) - load2(position, index(first, e))


@inlined
def _move_apart(shift, first, second, e, move):
    i, j = index(first, e), index(second, e)
    store(shift, i, load2(shift, i) + move)
    store(shift, j, load2(shift, j) - move)


@lean
def _relax(position, cells, ends, count, crowded, development, scratch):
    """Push overlapping neighbours apart, pull separated ones together, once.  Returns the largest move of a coordinate.

    A cell in a crowd of more than six takes the mean of their pushes six times, not their sum, which would overshoot.
    Args: position (> cells, 2); crowded: whether any cell has more than six edges.
    """
    first, second, shift, held, push = ends.first, ends.second, scratch.shift, scratch.held, scratch.push
    repulsion, adhesion, reach = four(0.5 * development.repulsion), four(0.5 * development.adhesion), four(development.adhesion_range)
    zero, one = four(0.0), four(1.0)
    px, py, holds = push[0], push[1], push[2]
    for i in range(0, 2 * cells, 4):
        store(shift, i, zero)
    for e in range(0, count, 4):
        a, b = _apart(position, first, second, e), _apart(position, first, second, e + 1)
        c, d = _apart(position, first, second, e + 2), _apart(position, first, second, e + 3)
        dx, dy = evens(join(a, b), join(c, d)), odds(join(a, b), join(c, d))
        distance = root(dx * dx + dy * dy)
        factor = chosen(reach, distance, chosen(one, distance, repulsion, adhesion), zero)
        share = factor * (distance - one) / chosen(distance, zero, distance, one)
        store(px, e, share * dx)
        store(py, e, share * dy)
        store(holds, e, chosen(distance, zero, chosen(reach, distance, one, zero), zero))
    for e in range(0, count, 4):
        x, y = load4(px, e), load4(py, e)
        even, odd = even_pairs(x, y), odd_pairs(x, y)
        _move_apart(shift, first, second, e, low(even))
        _move_apart(shift, first, second, e + 1, low(odd))
        _move_apart(shift, first, second, e + 2, high(even))
        _move_apart(shift, first, second, e + 3, high(odd))
    if crowded:
        for i in range(cells):
            held[i] = 0.0
        for e in range(count):
            held[first[e] // 2] += holds[e]
            held[second[e] // 2] += holds[e]
        for i in range(cells):
            scale = min(1.0, 6.0 / max(held[i], 1.0))
            shift[i, 0] *= scale
            shift[i, 1] *= scale
    most = zero
    for i in range(0, 2 * cells, 4):
        move = load4(shift, i)
        store(position, i, load4(position, i) + move)
        size = magnitude(move)
        most = chosen(size, most, size, most)
    return max(max(lane(most, 0), lane(most, 1)), max(lane(most, 2), lane(most, 3)))


@lean
def _metric_edges(position, cells, reach, edges):
    """Variant A: all pairs within `reach`.  Returns their number, at most the length of `edges`."""
    count = 0
    for i in range(cells):
        for j in range(i + 1, cells):
            dx, dy = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
            if dx * dx + dy * dy < reach * reach and count < edges.shape[0]:
                edges[count, 0] = i
                edges[count, 1] = j
                count += 1
    return count


@lean
def remember(network, table, past, step, cells):
    """Variant A: keep the morphogens of this step.

    past (delays, morphogens, cells) is a ring over steps.  It holds 0 of every step before a cell's birth: what a newborn makes is a
    source of its own, which reaches others after its delay, while its mother's goes on.
    """
    now = past[step % past.shape[0]]
    for row, morphogen in enumerate(network.morphogens):
        for i in range(cells):
            now[row, i] = table[morphogen, i]


@lean
def diffuse(network, table, past, step, delay, cells, morphogen_range):
    """Variant A: a cell perceives c(t - d/v) / (1 + d/range) of every producer at distance d, itself included.

    Args: delay (>= cells, >= cells, 2): steps, and the factor by distance.
    """
    length, first = past.shape[0], network.units + OUTPUTS
    now = step % length
    for i in range(cells):
        for morphogen in network.morphogens:
            table[first + morphogen, i] = 0.0
        for j in range(cells):
            then = now - int(delay[i, j, 0])
            emitted, factor = past[then if then >= 0 else then + length], delay[i, j, 1]
            for row, morphogen in enumerate(network.morphogens):
                table[first + morphogen, i] += emitted[row, j] * factor


@lean
def _measure_delays(position, cells, development, longest, delay):
    for i in range(cells):
        for j in range(cells):
            d = np.sqrt((position[i, 0] - position[j, 0]) ** 2 + (position[i, 1] - position[j, 1]) ** 2)
            delay[i, j, 0] = min(np.floor(d / development.morphogen_speed), longest)
            delay[i, j, 1] = 1.0 / (1.0 + d / development.morphogen_range)


@lean
def _keep(position, table, units, cells, edges, kept):
    """Keep a moment of growth.  Args: kept: rows of history, activations and graphs, see `grow`."""
    kept_position, kept_activation, kept_edges = kept
    for i in range(cells):
        kept_position[i, 0], kept_position[i, 1] = position[i, 0], position[i, 1]
        kept_activation[i] = table[units + EXPANSION, i] - table[units + CONTRACTION, i]
    for e in range(edges.shape[0]):
        kept_edges[e, 0], kept_edges[e, 1] = edges[e, 0], edges[e, 1]


@kernel
def grow(network, development, continual, history, activations, graphs, halt):
    """Grow an embryo from one cell.

    Args:
        network: of all four outputs.
        development: DevelopmentArguments.
        continual: whether the graph is kept up to date (variant B) or made at the end (variant A).
        history, activations: (steps + 1, max_cells, 2) and (steps + 1, max_cells), NaN where there is no cell; empty
            when nobody looks.
        graphs: (steps + 1, E, 2) int64 edges of each step, filled up with -1, E enough for both the planar graph and, in
            variant A, all pairs of cells; empty when nobody looks.
        halt: (1,) int64: where not 0, growth ends at once.

    Returns: Embryo.
    """
    limit = development.max_cells
    units = network.units
    first_input = 2 * units + OUTPUTS
    table, drive = aligned(first_input + INPUTS, limit), aligned(network.nodes.size, limit)
    position = np.zeros((limit + 1, 2))
    axis = np.zeros((limit, 2))
    axis[0, 0] = 1.0
    spread, degree, crowded = make_spread(network, limit), np.zeros(limit, np.int64), False
    witness = np.zeros((limit, limit) if continual else (0, 0), np.int32)
    edges = np.empty((3 * limit + 1 if continual else limit * (limit - 1) // 2 + 1, 2), np.int64)
    room = padded4(edges.shape[0])
    ends = Ends(np.empty(room, np.uint32), np.empty(room, np.uint32))
    pushes = Pushes(shift=np.zeros((limit + 1, 2)), held=np.empty(limit), push=np.empty((3, room)))
    spare, holds, travelled = np.empty_like(edges), np.full(limit, -1.0), 0.0
    start = np.zeros(limit + 1, np.int64)
    neighbour = np.empty(2 * edges.shape[0], np.uint32)
    longest = 1 if continual else min(int(2.0 * limit / development.morphogen_speed) + 1, 255)
    past = np.zeros((longest + 1, network.morphogens.size, 1 if continual else limit))
    delay = np.zeros((1 if continual else limit, 1 if continual else limit, 2))

    cells, count, moved, steps = 1, 0, True, development.steps
    maternal(table, first_input, position, 1, development.maternal_length)
    for step in range(development.steps):
        if halt[0]:
            break
        if history.size:
            _keep(position, table, units, cells, edges[:count], (history[step], activations[step], graphs[step]))
        if not continual:
            remember(network, table, past, step, cells)
            if moved:
                _measure_delays(position, cells, development, longest, delay)
            diffuse(network, table, past, step, delay, cells, development.morphogen_range)
        else:
            exchange(network, table, start, neighbour, cells, spread)
        regulate(network, table, drive, cells, development.regulation_rate)
        grown = _divide(position, axis, table, units, cells, development, degree)
        moved = moved or grown > cells
        if moved:
            if continual:
                if grown > cells:
                    holds[:grown] = -1.0
                count, changed = follow(position, grown, travelled, holds, witness, edges, count, spare)
                if changed:
                    adjacency(edges, count, grown, start, neighbour)
                    share_out(start, grown, spread)
                    _list_ends(edges, count, limit, ends)
                    crowded = _crowded(edges, count, grown, degree)
            else:
                count = _metric_edges(position, grown, development.neighbour_radius, edges)
                _list_ends(edges, count, limit, ends)
                crowded = _crowded(edges, count, grown, degree)
            most = 0.0
            for _ in range(development.relaxations):
                move = _relax(position, grown, ends, count, crowded, development, pushes)
                most = max(most, move)
                travelled += 1.5 * move + _ROUNDING
            maternal(table, first_input, position, grown, development.maternal_length)
            moved = most > REST
        # Delays of variant A can hold a change back for `longest` steps, so it runs to the end.
        still = continual and not moved and grown == cells and unrest(network, table, drive, cells) < REST
        if still and not _turns(table, units, cells, development):
            steps = step + 1
            break
        cells = grown

    final = aligned(table.shape[0], cells)
    for row in range(final.shape[0]):
        for i in range(final.shape[1]):
            final[row, i] = table[row, i]
    if not continual:
        witness, count = np.zeros((cells, cells), np.int32), 0
    count, _ = follow(position, cells, travelled, holds, witness, edges, count, spare)
    adjacency(edges, count, cells, start, neighbour)
    if not continual:
        _measure_delays(position, cells, development, longest, delay)
    if history.size:
        for step in range(steps, development.steps + 1):
            _keep(position, table, units, cells, edges[:count], (history[step], activations[step], graphs[step]))
    return Embryo(
        position=position[:cells].copy(), table=final, edges=edges[:count].copy(), start=start[: cells + 1].copy(),
        neighbour=neighbour[: 2 * count].copy(), steps=steps, past=past, delay=delay,
    )
