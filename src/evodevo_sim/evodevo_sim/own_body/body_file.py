"""Bodies of your own: a YAML or JSON file (docs/guide/body.md), laws as for every other body.

    position: [[0, 0], [1, 0], [0.5, 0.9]]      # (N, 2) m
    springs: [[0, 1], [1, 2], [0, 2]]           # or gabriel
    activation: {amplitude: 0.3, frequency: 1.0, phase: [0, 1, 2]}
    scene: {drag_normal: 100, drag_tangential: 0.5}

All keys but `position` may be left out.
"""

from __future__ import annotations

import os
from collections import namedtuple
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..development.body import Body, build_body
from ..development.gabriel import adjacency, gabriel_graph
from ..inputs import InputError, shown
from ..parameters import Material
from ..text_file import check_keys, parsed, read_text
from .planar import coincident, collinear, crossing, faces_of, rounding, shared_side, too_far, unreachable

KEYS = (
    "position", "velocity", "mass", "springs", "rest_length", "stiffness", "damping", "pressure", "chambers", "activation",
    "scene",
)
ACTIVATION = ("amplitude", "frequency", "phase")
SURROUNDINGS = ("drag_normal", "drag_tangential", "gravity", "friction")
MOST_CELLS = 4096
# key: (least, most, default, unit)
_RANGE = {
    "position": (-1e6, 1e6, None, "m"), "velocity": (-1e6, 1e6, 0.0, "m/s"), "mass": (1e-6, 1e6, 1.0, "kg"),
    "rest_length": (1e-6, 1e6, None, "m"), "stiffness": (0.0, 1e9, Material.stiffness, "N/m"),
    "damping": (0.0, 1e6, Material.damping, "N s/m"), "pressure": (0.0, 1e9, Material.pressure, "N/m"),
    "activation.amplitude": (-1.0, 1.0, 0.0, ""), "activation.frequency": (0.0, 1e3, 0.0, "Hz"),
    "activation.phase": (-1e6, 1e6, 0.0, "rad"),
    "scene.drag_normal": (0.0, 1e6, None, "kg/m^2"), "scene.drag_tangential": (0.0, 1e6, None, "kg/m^2"),
    "scene.gravity": (0.0, 1e4, None, "m/s^2, downward"), "scene.friction": (0.0, 1e3, None, ""),
}


class BodyError(InputError, ValueError):
    """A body that cannot be; the message names the key, the index and the mend."""


_check_keys = partial(check_keys, BodyError)


# stiffness N/m, damping N s/m, pressure N/m
Stuff = namedtuple("Stuff", "stiffness damping pressure")


@dataclass(frozen=True, eq=False)
class OwnBody:
    """What a body file says.

    Attributes:
        body: see `body.Body`, its rest lengths and masses those of the file.
        velocity: (N, 2) m/s at time 0.
        stuff: Stuff.
        amplitude, frequency, phase: (N,) of e - c = amplitude sin(2 pi frequency t + phase); Hz, rad.
        scene: the constants of the world that the file names.
    """

    body: Body
    velocity: np.ndarray
    stuff: Stuff
    amplitude: np.ndarray
    frequency: np.ndarray
    phase: np.ndarray
    scene: dict[str, float]


def load_body(path: str | os.PathLike) -> OwnBody:
    """Read a body file.  Raises BodyError that names file, key, index and mend."""
    text = read_text(path, BodyError, "the path of a body file, YAML or JSON")
    try:
        return make_own_body(parsed(text, BodyError))
    except BodyError as error:
        raise BodyError(f"{path}: {error}") from None


def make_own_body(document: dict) -> OwnBody:
    """The body of a file's contents, e.g. `{"position": [[0, 0], [1, 0]], "chambers": []}`.  Raises BodyError."""
    _check_keys(document, KEYS, "")
    if "position" not in document:
        raise BodyError("position is missing: give the x and y of every cell")
    position = _pairs(document, "position", None)
    cells = len(position)
    if not cells or cells > MOST_CELLS:
        raise BodyError(f"position has {cells} cells: give 1 to {MOST_CELLS}")
    pair = coincident(position)
    if pair is not None:
        raise BodyError(f"position[{pair[0]}] and position[{pair[1]}] are the same point: move one of the cells")
    far = too_far(position)
    if far is not None:
        raise BodyError(
            f"position: coordinates of up to {far[1]:.3g} m are too coarse for cells that are {far[0]:.3g} m apart: "
            "move the body to the origin"
        )
    velocity = _pairs(document, "velocity", cells) if document.get("velocity") is not None else np.zeros((cells, 2))
    mass = _numbers(document, "mass", cells, "cell")
    edges, order = _springs(document.get("springs", "gabriel"), position)
    stuff = Stuff(*(_scalar(document, key) for key in Stuff._fields))
    activation = _section(document, "activation", ACTIVATION)
    amplitude, frequency, phase = (_numbers(activation, f"activation.{key}", cells, "cell") for key in ACTIVATION)
    surroundings = _section(document, "scene", SURROUNDINGS)
    scene = {key: _scalar(surroundings, f"scene.{key}") for key in SURROUNDINGS if surroundings.get(key) is not None}

    start, neighbour = np.zeros(cells + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), cells, start, neighbour)
    lost = unreachable(edges, cells)
    if lost is not None:
        raise BodyError(f"springs do not reach cell {lost} from cell 0, the body is in pieces: join them by a spring")
    body = build_body(position, edges, start, neighbour, 1.0)._replace(inverse_mass=1.0 / mass)
    body = _with_chambers(body, document.get("chambers", "faces"), edges)
    if document.get("rest_length") is not None:
        rest_length = np.empty(len(edges))
        rest_length[np.lexsort((body.spring_b, body.spring_a))] = _numbers(document, "rest_length", len(edges), "spring")[order]
        body = body._replace(rest_length=rest_length, shortest=float(rest_length.min(initial=np.inf)))
    return OwnBody(body, velocity, stuff, amplitude, frequency, phase, scene)


def _section(document, name, known):
    section = document.get(name)
    section = {} if section is None else section
    _check_keys(section, known, name)
    return section


def _number(value, key, where):
    low, high, _, unit = _RANGE[key]
    number = None
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        number = float(value) if abs(value) < 1e300 or value != value else np.inf
    if number is None or not low <= number <= high:
        raise BodyError(f"{where} is {shown(value)}: give a number from {low:g} to {high:g} {unit}".rstrip())
    return number


def _scalar(document, key):
    value = document.get(key.rpartition(".")[2])
    return _RANGE[key][2] if value is None else _number(value, key, key)


def _numbers(document, key, count, each):
    """One number for all, or a list with one for each: (count,)."""
    value = document.get(key.rpartition(".")[2])
    if value is None:
        value = _RANGE[key][2]
    if not isinstance(value, (list, tuple, np.ndarray)):
        return np.full(count, _number(value, key, key))
    if len(value) != count:
        raise BodyError(f"{key} has {len(value)} entries, but there are {count} {each}s: give one number, or one for each {each}")
    return np.array([_number(_plain(item), key, f"{key}[{i}]") for i, item in enumerate(value)], np.float64)


def _plain(value):
    return value.item() if isinstance(value, np.generic) else value


def _list(value, key, what):
    if not isinstance(value, (list, tuple, np.ndarray)):
        raise BodyError(f"{key} is {shown(value)}: give a list of {what}")
    return value


def _pairs(document, key, count):
    rows = _list(document[key], key, "[x, y], one for every cell")
    if count is not None and len(rows) != count:
        raise BodyError(f"{key} has {len(rows)} entries, but there are {count} cells: give [x, y] for every cell")
    for i, row in enumerate(rows):
        if len(_list(row, f"{key}[{i}]", "two numbers, [x, y]")) != 2:
            raise BodyError(f"{key}[{i}] is {shown(row)}: give two numbers, [x, y]")
    numbers = [_number(_plain(value), key, f"{key}[{i}][{k}]") for i, row in enumerate(rows) for k, value in enumerate(row)]
    return np.array(numbers, np.float64).reshape(-1, 2)


def _indices(row, where, cells, what):
    for k, index in enumerate(_list(row, where, what)):
        index = _plain(index)
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < cells:
            raise BodyError(f"{where}[{k}] is {shown(index)}: give the number of a cell, 0 to {cells - 1}")
    return [int(index) for index in row]


def _springs(given, position):
    """(edges (E, 2), i < j, ascending; order (E,): which spring of the file each is)."""
    cells = len(position)
    if isinstance(given, str):
        if given != "gabriel":
            raise BodyError(f"springs is {shown(given)}: give a list of pairs of cells, or gabriel")
        edges = gabriel_graph(position, 2.0 * rounding(position))
        return edges, np.arange(len(edges))
    seen: dict[tuple[int, int], int] = {}
    if len(_list(given, "springs", "pairs of cells, or gabriel")) > 3 * cells:
        raise BodyError(
            f"springs has {len(given)} entries: a planar graph of {cells} cells has fewer than {3 * cells}, leave out those that cross"
        )
    for s, row in enumerate(given):
        pair = tuple(sorted(_indices(row, f"springs[{s}]", cells, "two cells, [i, j]")))
        if len(pair) != 2 or pair[0] == pair[1]:
            raise BodyError(f"springs[{s}] is {shown(row)}: give two different cells, [i, j]")
        if pair in seen:
            raise BodyError(f"springs[{s}] joins cells {pair[0]} and {pair[1]} as springs[{seen[pair]}] does: remove one of them")
        seen[pair] = s
    unsorted = np.array(list(seen), np.int64).reshape(-1, 2)
    fault = crossing(position, unsorted)
    if fault is not None:
        s, other, cell = fault
        if cell is None:
            raise BodyError(f"springs[{s}] and springs[{other}] cross: a body is a planar graph, remove one of them")
        raise BodyError(f"springs[{s}] runs through cell {cell}: move the cell, or join it to both ends instead")
    order = np.lexsort((unsorted[:, 1], unsorted[:, 0]))
    return np.ascontiguousarray(unsorted[order]), order


def _with_chambers(body, given, edges):
    if isinstance(given, str):
        if given != "faces":
            raise BodyError(f"chambers is {shown(given)}: give faces, a list of faces as lists of cells, or an empty list")
        if collinear(body.position):
            raise BodyError("position: all cells lie on one line and make no faces: move a cell, or give 'chambers: []'")
    else:
        rows = _cycles(given, len(body.position), edges)
        shared = shared_side(body.position, rows)
        if shared is not None:
            c, other, a, b = shared
            raise BodyError(
                f"chambers[{c}] and chambers[{other}] lie on the same side of the spring from cell {a} to cell {b}: remove one of them"
            )
        body = faces_of(body, rows)
    least = 1e-6 * np.ptp(body.position, axis=0).max() ** 2 / len(body.position)
    for number, area in enumerate((*body.triangle_area, *body.polygon_area)):
        if not area > least:
            raise BodyError(f"chambers: the face {_face(body, number)} has an area of {area:.3g} m^2: move a cell off its side")
    return body


def _cycles(given, cells, edges):
    joined = {tuple(edge) for edge in edges.tolist()}
    if len(_list(given, "chambers", "lists of cells")) > 2 * cells:
        raise BodyError(
            f"chambers has {len(given)} entries: a planar graph of {cells} cells has fewer than {2 * cells} faces: give each once"
        )
    rows = [_indices(row, f"chambers[{c}]", cells, "cells") for c, row in enumerate(given)]
    for c, row in enumerate(rows):
        if len(row) < 3 or len(set(row)) < len(row):
            raise BodyError(f"chambers[{c}] is {shown(row)}: give three or more different cells, in order around the face")
        for a, b in zip(row, row[1:] + row[:1]):
            if (min(a, b), max(a, b)) not in joined:
                raise BodyError(f"chambers[{c}] has a side from cell {a} to cell {b} where there is no spring: add it to springs")
    return rows


def _face(body, number):
    triangles = len(body.triangle_area)
    if number < triangles:
        return body.triangle[number].tolist()
    number -= triangles
    return body.polygon_cell[body.polygon_start[number] : body.polygon_start[number + 1]].tolist()
