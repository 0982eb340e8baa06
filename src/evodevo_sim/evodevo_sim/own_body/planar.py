"""What makes a set of cells and springs a planar body, checked where somebody else made it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

_CLOSE = 1e-9  # of the extent of a body, that counts as no distance
_COARSE = 1e-6  # of the least distance of two cells, to which coordinates must hold a shape
_ROWS = 256  # springs compared with all others at a time


def _extent(position) -> float:
    return float(np.ptp(position, axis=0).max()) or 1.0


def rounding(position: np.ndarray) -> float:
    """How far from what was meant a difference of two coordinates can be, m: far from the origin they hold less of a shape."""
    return float(2.0 * np.finfo(float).eps * np.abs(position).max())


def _close(position, coordinates=1) -> float:
    """m, that counts as no distance.  Args: coordinates: of how many the distance is made."""
    return max(_CLOSE * _extent(position), 2.0 * rounding(position) * coordinates**0.5)


def _along(position: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells in the order of a coordinate along a slanted line: (their numbers (N,), that coordinate (N,) m, positions (N, 2) m).

    The coordinates of two cells differ by no more than the cells are apart.
    """
    centred = position - position.mean(0)
    along = centred @ (0.8, 0.6)
    order = np.argsort(along, kind="stable")
    return order, along[order], centred[order]


def _least_distance(position: np.ndarray) -> float:
    """m, of any two cells."""
    _, along, centred = _along(position)
    least = np.inf
    for k in range(1, len(along)):  # each cell with the k-th after it
        if (along[k:] - along[:-k]).min() > least:  # and so for any larger k
            break
        least = min(least, float(np.hypot(*(centred[k:] - centred[:-k]).T).min()))
    return least


def too_far(position: np.ndarray) -> tuple[float, float] | None:
    """Where coordinates are too large to hold the shape: (least distance of two cells, largest coordinate), m; or None."""
    if len(position) < 2:
        return None
    least = _least_distance(position)
    return (least, float(np.abs(position).max())) if rounding(position) > _COARSE * least else None


def coincident(position: np.ndarray) -> tuple[int, int] | None:
    """Two cells at one point, the first such pair."""
    order, along, _ = _along(position)
    near, crowded = _CLOSE * _extent(position), np.zeros(len(position), bool)
    for k in range(1, len(order)):
        candidates = np.flatnonzero(along[k:] - along[:-k] <= 1.001 * near)  # rounding adds less than that
        if not len(candidates):
            break
        first, second = order[candidates], order[candidates + k]
        close = np.hypot(*(position[first] - position[second]).T) <= near
        crowded[first[close]] = crowded[second[close]] = True
    if not crowded.any():
        return None
    one = int(crowded.argmax())
    others = np.hypot(*(position - position[one]).T) <= near
    others[one] = False
    return one, int(others.argmax())


def collinear(position: np.ndarray) -> bool:
    """Whether all cells lie on one line."""
    centred = position - position.mean(0)
    return len(position) < 3 or float(np.linalg.svd(centred, compute_uv=False)[1]) < _close(position, len(position))


def unreachable(edges: Any, cells: int) -> int | None:
    """The first cell that no path of springs joins to cell 0."""
    root = list(range(cells))

    def find(i):
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    for a, b in edges.tolist():
        a, b = find(a), find(b)
        root[max(a, b)] = min(a, b)
    return next((i for i in range(cells) if find(i) != 0), None)


def crossing(position: np.ndarray, edges: Any) -> tuple[int, int | None, int | None] | None:
    """The first fault of springs (E, 2): (s, other, None) where two cross, (s, None, cell) where one runs through a cell."""
    a, b = position[edges[:, 0]], position[edges[:, 1]]
    near = _close(position)
    low, high = np.minimum(a, b), np.maximum(a, b)
    for first in range(0, len(edges), _ROWS):
        rows = slice(first, first + _ROWS)
        s, cell = _overlaps(low[rows] - near, high[rows] + near, position, position)
        s += first
        d, inner = b[s] - a[s], position[cell] - a[s]
        length = np.hypot(d[:, 0], d[:, 1])
        share = (inner * d).sum(-1) / length**2
        through = (np.abs(d[:, 0] * inner[:, 1] - d[:, 1] * inner[:, 0]) / length < near) & (share > 0) & (share < 1)
        through &= (cell != edges[s, 0]) & (cell != edges[s, 1])
        if through.any():
            k = int(through.argmax())
            return int(s[k]), None, int(cell[k])
        s, other = _overlaps(low[rows], high[rows], low, high)
        s += first
        crosses = _side(a[s], b[s], a[other]) * _side(a[s], b[s], b[other]) < 0
        crosses &= _side(a[other], b[other], a[s]) * _side(a[other], b[other], b[s]) < 0
        crosses &= ~(edges[s][:, :, None] == edges[other][:, None, :]).any((-1, -2))
        if crosses.any():
            k = int(crosses.argmax())
            return int(min(s[k], other[k])), int(max(s[k], other[k])), None
    return None


def _overlaps(low, high, others_low, others_high):
    """The pairs of boxes, given by their corners (B, 2), that have a point in common with others: (number, number of the other)."""
    common = (low[:, :1] <= others_high[:, 0]) & (high[:, :1] >= others_low[:, 0])
    common &= (low[:, 1:] <= others_high[:, 1]) & (high[:, 1:] >= others_low[:, 1])
    return np.nonzero(common)


def _side(p, q, r):
    """Twice the area of the triangles p, q, r, positive where r lies to the left."""
    return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])


def _area(position, row):
    """Signed, positive where the walk goes counter-clockwise."""
    x, y = (position[row] - position[row[0]]).T  # far from the origin, products of coordinates would hold no area
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _counter_clockwise(position, row):
    return row if _area(position, row) > 0 else row[::-1]


def shared_side(position: np.ndarray, rows: Sequence[list[int]]) -> tuple[int, int, int, int] | None:
    """The first two cycles of cells that lie on the same side of a spring: (cycle, earlier one, both cells of the spring)."""
    seen: dict[tuple[int, int], int] = {}
    for c, row in enumerate(rows):
        row = _counter_clockwise(position, row)
        for side in zip(row, row[1:] + row[:1]):
            if side in seen:
                return c, seen[side], *side
            seen[side] = c
    return None


def faces_of(body: Any, rows: Sequence[list[int]]) -> Any:
    """A body whose chambers are these cycles of cells alone, turned counter-clockwise, no two on the same side of a spring."""
    rows = sorted((_counter_clockwise(body.position, row) for row in rows), key=lambda row: len(row) > 3)  # triangles first
    polygons = [row for row in rows if len(row) > 3]
    areas = np.array([_area(body.position, row) for row in rows], np.float64)
    triangles = len(rows) - len(polygons)
    spring = {pair: e for e, pair in enumerate(zip(body.spring_a.tolist(), body.spring_b.tolist()))}
    left, right = (np.full(len(spring), len(rows), np.uint32) for _ in range(2))
    for chamber, row in enumerate(rows):
        for a, b in zip(row, row[1:] + row[:1]):
            if a < b:
                left[spring[a, b]] = chamber
            else:
                right[spring[b, a]] = chamber
    return body._replace(
        spring_left=left,
        spring_right=right,
        triangle=np.array(rows[:triangles], np.uint32).reshape(-1, 3),
        triangle_area=areas[:triangles].copy(),
        polygon_start=np.cumsum([0, *map(len, polygons)]).astype(np.uint32),
        polygon_cell=np.array([cell for row in polygons for cell in row], np.uint32),
        polygon_area=areas[triangles:].copy(),
    )
