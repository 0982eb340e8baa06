"""Bodies as messages that public tools draw by themselves: Foxglove, Lichtblick, RViz, Rerun's importer of MCAP.

Everything is in m in the plane z = 0, seen from above; cells are spheres of 1 m, so lines and targets stand above them.  It is for
the eye: numbers to reckon with are in `evodevo_msgs`, in double precision.
"""

from __future__ import annotations

import itertools
from array import array
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, PoseStamped, Vector3
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from evodevo_msgs import msg

from ..palettes import activation_colours
from ..parameters import Scene
from ..physics.terrain import profile
from .messages import time_message

MARKERS_PER_SECOND = 10.0  # of simulated time, at the most
_NAMES = ("x", "y", "z", "activation", "rgb")
_CELL = np.dtype([(name, "<u4" if name == "rgb" else "<f4") for name in _NAMES])
# A packed colour is a float32 by the convention of PCL, which all readers know; its bits are 0x00rrggbb.
FIELDS = tuple(PointField(name=name, offset=4 * k, datatype=PointField.FLOAT32, count=1) for k, name in enumerate(_NAMES))
# Parts of a metre and of an activation of 1 to which what is drawn is rounded: it makes recordings smaller and is not seen.
_FINE, _SHADES = 1024.0, 256.0
_ABOVE = 0.52  # m, of lines: above the cells
_AHEAD, _STEP = 60.0, 20.0  # m of ground that are drawn to either side of the body, and between the places where these ends move on
_ROUND = Vector3(x=0.8, y=0.8, z=0.1)  # m, of the disc that is the target
# Red, green, blue and how opaque, of 256: float32 holds them exactly.
_INK, _QUIET, _TARGET, _CHAMBER = (38, 43, 54, 256), (138, 145, 158, 256), (132, 92, 196, 256), (158, 180, 200, 154)


class Drawing:
    """What is drawn of one body.

    Args: springs (E, 2), outline (M, 2): cell indices; chambers: arrays of cell indices; scene: its solid world, or None; frame: of
        positions; anew: whether the first markers take away all that were drawn before.
    """

    def __init__(
        self, springs: np.ndarray, outline: np.ndarray, chambers: Sequence[np.ndarray] = (), scene: Scene | None = None,
        frame: str = "world", anew: bool = True,
    ):
        self.springs, self.outline, self.chambers, self.scene, self.frame = springs, outline, chambers, scene, frame
        # How many cells the parts need at the least.
        self.cells = 1 + max((int(part.max()) for part in (springs, outline, *chambers) if part.size), default=-1)
        self._anew = anew
        self._triangles: list[int] | None = None
        self._at_birth: np.ndarray | None = None
        self._next = -np.inf  # s, when markers are due

    def due(self, seconds: float) -> bool:
        """Whether it is time for markers again, which are drawn more seldom than cells; also where time has run back."""
        if self._next - 1.0 / MARKERS_PER_SECOND <= seconds < self._next - 1e-9:
            return False
        self._next = seconds + 1.0 / MARKERS_PER_SECOND
        return True

    def cloud(self, position: np.ndarray, activation: np.ndarray, seconds: float) -> PointCloud2:
        """The cells, a point each.  Args: position (N, 2) m; activation (N,) of e - c; seconds: simulated."""
        points = np.zeros(len(position), _CELL)
        points["x"], points["y"] = _rounded(position).T
        shade = np.rint(np.asarray(activation) * _SHADES)
        points["activation"] = shade / _SHADES
        points["rgb"] = _packed_colours()[(np.clip(shade, -_SHADES, _SHADES) + _SHADES).astype(int)]
        return PointCloud2(
            header=self._header(seconds), height=1, width=len(points), fields=list(FIELDS), is_bigendian=False,
            point_step=_CELL.itemsize, row_step=points.nbytes, data=array("B", points.tobytes()), is_dense=True,
        )

    def pose(self, position: np.ndarray, seconds: float) -> PoseStamped:
        """The centre of mass, turned as the body has turned since its first pose, in the mean."""
        centre = position.mean(axis=0)
        about = position - centre
        if self._at_birth is None or len(self._at_birth) != len(about):
            self._at_birth = about
        first = self._at_birth
        turn = np.arctan2((first[:, 0] * about[:, 1] - first[:, 1] * about[:, 0]).sum(), (first * about).sum())
        message = PoseStamped(header=self._header(seconds))
        message.pose.position.x, message.pose.position.y = map(float, centre)
        message.pose.orientation.z, message.pose.orientation.w = float(np.sin(turn / 2)), float(np.cos(turn / 2))
        return message

    def markers(self, position: np.ndarray, seconds: float, target: Any = None) -> MarkerArray:
        """Springs, outline, chambers, ground and target.  Args: target: (x, y) m, or None."""
        rounded = _rounded(position)
        above = [Point(x=x, y=y, z=_ABOVE) for x, y in rounded.tolist()]
        drawn = [Marker(action=Marker.DELETEALL, header=self._header(seconds))] if self._anew else []
        self._anew = False
        if self.chambers:
            level = [Point(x=x, y=y) for x, y in rounded.tolist()]
            if self._triangles is None:
                self._triangles = np.concatenate([fan(position, chamber) for chamber in self.chambers]).ravel().tolist()
            drawn.append(self._marker("chambers", Marker.TRIANGLE_LIST, seconds, _CHAMBER, [level[i] for i in self._triangles]))
        for name, pairs, width in (("springs", self.springs, 0.04), ("outline", self.outline, 0.09)):
            if pairs.size:
                ends = [above[i] for i in pairs.ravel().tolist()]
                drawn.append(self._marker(name, Marker.LINE_LIST, seconds, _INK, ends, width))
        drawn += self._ground(float(position[:, 0].mean()), seconds)
        gone = target is None or not np.isfinite(target).all()
        place = self._marker("target", Marker.CYLINDER, seconds, _TARGET, [])
        place.action, place.scale = Marker.DELETE if gone else Marker.ADD, _ROUND
        if not gone:
            place.pose.position.x, place.pose.position.y, place.pose.position.z = float(target[0]), float(target[1]), _ABOVE
        return MarkerArray(markers=[*drawn, place])

    def _ground(self, x: float, seconds: float) -> list[Marker]:
        if self.scene is None:
            return []
        middle = _STEP * round(x / _STEP)
        lines = surfaces(self.scene, middle - _AHEAD, middle + _AHEAD)
        return [
            self._marker(name, Marker.LINE_STRIP, seconds, _QUIET, [Point(x=x, y=y) for x, y in line.tolist()], 0.12)
            for name, line in zip(("ground", "ceiling"), lines)
        ]

    def _marker(self, name: str, kind: int, seconds: float, colour: Sequence[int], points: list[Point], width: float = 1.0) -> Marker:
        scale = Vector3(x=width, y=1.0, z=1.0) if kind == Marker.TRIANGLE_LIST else Vector3(x=width)
        red, green, blue, opaque = (part / 256 for part in colour)
        marker = Marker(
            header=self._header(seconds), ns=name, type=kind, action=Marker.ADD, points=points, scale=scale,
            color=ColorRGBA(r=red, g=green, b=blue, a=opaque),
        )
        marker.pose.orientation.w = 1.0
        return marker

    def _header(self, seconds: float) -> Header:
        return Header(stamp=time_message(seconds), frame_id=self.frame)


def drawing_of(body: msg.Body, scene: Scene | None = None) -> Drawing:
    """The drawing of a Body message."""
    parts = (_pairs(body.spring_a, body.spring_b), _pairs(body.outline_a, body.outline_b))
    return Drawing(*parts, chambers_of(body.chamber_start, body.chamber_cell), scene, body.header.frame_id)


def _pairs(a: Any, b: Any) -> np.ndarray:
    return np.column_stack((np.asarray(a, int), np.asarray(b, int)))


def surfaces(scene: Scene, low: float, high: float) -> list[np.ndarray]:
    """The lines (K, 2) of the ground, and of the ceiling where there is one, from x = low to high, m."""
    lines = []
    for xs, ys, there in ((scene.ground_x, scene.ground_y, True), (scene.ceiling_x, scene.ceiling_y, bool(scene.ceiling_x))):
        if there:
            x = np.array([low, *(x for x in xs if low < x < high), high])
            lines.append(np.column_stack((x, profile(xs, ys, x))))
    return lines


def fan(position: np.ndarray, chamber: np.ndarray) -> np.ndarray:
    """Triangles (K, 3) of a chamber: of the fans from its corners, the one whose least triangle is the largest."""
    corners = [np.roll(chamber, -k) for k in range(len(chamber))]
    fans = [np.column_stack((np.full(len(c) - 2, c[0]), c[1:-1], c[2:])) for c in corners]
    return max(fans, key=lambda one: _twice_area(*position[one].swapaxes(0, 1)).min())


def chambers_of(start: Any, cell: Any) -> list[np.ndarray]:
    """The cells of each chamber, as a Body message tells them."""
    starts, cells = np.array(start, int), np.array(cell, int)
    return [cells[first:last] for first, last in itertools.pairwise(starts)]


def _twice_area(a, b, c) -> np.ndarray:
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


@cache
def _packed_colours() -> np.ndarray:
    """Of activation from -1 to 1 in steps to which it is rounded."""
    red, green, blue = activation_colours(np.arange(-_SHADES, _SHADES + 1) / _SHADES).T.astype(np.uint32)
    return red << 16 | green << 8 | blue


def _rounded(values: np.ndarray) -> np.ndarray:
    return np.rint(np.asarray(values) * _FINE) / _FINE
