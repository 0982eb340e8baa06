"""Frames of a life as pixels, by Pillow alone: some milliseconds each, where matplotlib takes a hundred."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...extras import lacking
from ...recording.life import RINGS, Life
from ..colours import ACCENT, INK, QUIET, SECOND, activation_colours

try:
    from PIL import Image, ImageDraw, ImageFont
except ModuleNotFoundError as error:
    raise lacking(error) from None

ASPECT = 16 / 10
_FINER = 2  # pixels, along each side, of which one of the frame is the mean
_MARGIN = 1.3  # m around what must be seen
_LARGEST = 90 / 960  # of the width, that a cell takes at the most
_GRID, _FIFTH, _EARTH = (243, 244, 246), (228, 231, 236), (232, 230, 225)
_THIN = 0.6  # pixels of a frame, that lines have at the least in small ones
_TRAIL = 500  # points at the most
_SMOOTH = 30  # control steps to each side, over which the camera's way is a mean


class Painter:
    """Draws the steps of a life, growth first.  Args: width: pixels; palette: of cells."""

    def __init__(self, life: Life, width: int, palette: str):
        self._life, self.steps = life, len(life.growth) + len(life.time)
        self.size = width - width % 2, round(width / ASPECT) // 2 * 2
        self._wide, self._high = (side * _FINER for side in self.size)
        self._unit = max(self._wide / 960, _THIN * _FINER)  # pixels of the finer picture, of a line one pixel wide in a frame of 960
        self._letters = max(9.0, 15 / 960 * width) * _FINER
        self._font = ImageFont.load_default(self._letters)
        self._colours = activation_colours(life.activation, palette) if len(life.time) else np.zeros((0, 0, 3), np.uint8)
        self._growth_colours = [activation_colours(pose.activation, palette) for pose in life.growth]
        self._contact = life.contact if life.scene is not None and len(life.time) else None
        self._surfaces: list[np.ndarray] = []
        if len(life.time):
            self._measure()
        if life.growth:
            last = life.growth[-1].position
            self._embryo = max(2.5, *(np.ptp(last, axis=0) / 2 + 1.0)) if len(last) else 2.5

    def _measure(self) -> None:
        life = self._life
        self._centre = life.centre
        about = np.abs(life.position - self._centre[:, None]).max(axis=(0, 1))
        seen = life.target[np.isfinite(life.target).all(axis=1)]
        self._whole = len(seen) > 0
        points = np.concatenate((life.position.reshape(-1, 2), seen))
        low, high = points.min(axis=0), points.max(axis=0)
        self._box, self._about = (low, high), about
        self._camera = smooth(smooth(self._centre, _SMOOTH), _SMOOTH)
        self._surfaces = life.surfaces(low[0] - 60.0, high[0] + 60.0)

    def _frame(self, step: int) -> tuple[np.ndarray, np.ndarray]:
        """Middle and half size, m, of what must be seen of a step of life."""
        low, high = self._box
        if self._whole:
            return (low + high) / 2, (high - low) / 2 + 1.0
        middle, half = self._camera[step].copy(), self._about.copy()
        if self._surfaces and high[1] - low[1] < 4 * half[1]:
            middle[1], half[1] = (low[1] + high[1]) / 2 - 0.3, (high[1] - low[1]) / 2
        return middle, half + _MARGIN

    def draw(self, step: int) -> Image.Image:
        """A frame, RGB.  Args: step: of growth, and beyond that of life."""
        image = Image.new("RGB", (self._wide, self._high), "white")
        pen = ImageDraw.Draw(image)
        grown = len(self._life.growth)
        words = f"growth, step {step}" if step < grown else f"{self._life.time[step - grown] - self._life.time[0]:.2f} s"
        self._embryo_frame(pen, step) if step < grown else self._life_frame(pen, step - grown)
        self._label(pen, words, 12 * self._unit, 10 * self._unit)
        return image.reduce(_FINER)

    def _look(self, middle: np.ndarray, half: np.ndarray) -> None:
        self._middle = middle
        self._scale = min(self._wide / (2 * half[0]), self._high / (2 * half[1]), _LARGEST * self._wide)

    def _to_pixels(self, points: Any) -> np.ndarray:
        """Points (..., 2) m as pixels of the finer picture."""
        return np.array((self._wide, self._high)) / 2 + (np.asarray(points, float) - self._middle) * (self._scale, -self._scale)

    def _embryo_frame(self, pen, step: int) -> None:
        pose = self._life.growth[step]
        centre = pose.position.mean(axis=0) if len(pose.position) else np.zeros(2)
        self._look(centre, np.full(2, self._embryo))
        self._grid(pen)
        at = self._to_pixels(pose.position)
        self._cells(pen, at, self._growth_colours[step])
        self._lines(pen, at, self._life.growth_springs[step], 1.0)
        self._bar(pen)

    def _life_frame(self, pen, step: int) -> None:
        life = self._life
        self._look(*self._frame(step))
        self._grid(pen)
        self._world(pen)
        at, colours = self._to_pixels(life.position[step]), self._colours[step]
        target = life.target[step] if len(life.target) else np.full(2, np.nan)
        if np.isfinite(target).all():
            self._rings(pen, target)
        for chamber in life.chambers:
            tint = 0.6 * 255 + 0.4 * colours[chamber].mean(axis=0)
            pen.polygon(at[chamber].ravel().tolist(), fill=tuple(tint.astype(int)))
        self._cells(pen, at, colours)
        self._lines(pen, at, life.springs, 1.0)
        self._lines(pen, at, life.outline, 2.0)
        if np.isfinite(target).all():
            self._star(pen, self._to_pixels(target))
        every = max(1, step // _TRAIL)
        trail = self._to_pixels(np.concatenate((self._centre[:step:every], self._centre[step : step + 1])))
        if len(trail) > 1:
            pen.line(trail.ravel().tolist(), fill=ACCENT, width=max(1, round(2 * self._unit)), joint="curve")
        if self._contact is not None:
            for x, y in at[self._contact[step]]:
                w = 6 * self._unit
                pen.polygon((x, y - w, x - w, y + w, x + w, y + w), fill=ACCENT, outline="white")
        for size, colour in ((4.5, "white"), (3.3, "black")):
            self._disc(pen, trail[-1], size * self._unit, fill=colour)
        self._bar(pen)

    def _grid(self, pen) -> None:
        every = 5 if self._scale < 14 * self._unit else 1
        for axis, size in enumerate((self._wide, self._high)):
            half = size / 2 / self._scale
            low, high = self._middle[axis] - half, self._middle[axis] + half
            for metre in np.arange(np.ceil(low / every) * every, high + 1e-9, every):
                place = self._to_pixels(np.full(2, metre))[axis]
                ends = (place, 0, place, self._high) if axis == 0 else (0, place, self._wide, place)
                pen.line(ends, fill=_FIFTH if metre % 5 == 0 else _GRID, width=max(1, round(self._unit)))

    def _world(self, pen) -> None:
        for line, edge in zip(self._surfaces, (self._high + 9, -9)):
            at = self._to_pixels(line)
            pen.polygon([at[0, 0], edge, *at.ravel().tolist(), at[-1, 0], edge], fill=_EARTH)
            pen.line(at.ravel().tolist(), fill=QUIET, width=max(1, round(1.5 * self._unit)))
            low, high = (self._middle[0] + side * self._wide / 2 / self._scale for side in (-1, 1))
            for metre in range(int(np.ceil(low)), int(high) + 1):
                x, y = self._to_pixels((metre, np.interp(metre, *line.T)))
                long = (10 if metre % 5 == 0 else 5) * self._unit * np.sign(edge - y)
                pen.line((x, y, x, y + long), fill=QUIET, width=max(1, round(self._unit)))
                if metre % 5 == 0 and edge > 0:
                    pen.text((x, y + 1.6 * long), str(metre), fill=INK, font=self._font, anchor="ma")

    def _rings(self, pen, target) -> None:
        for ring in range(1, RINGS + 1) if self._life.reach else ():
            radius = ring / RINGS * self._life.reach * self._scale
            self._disc(pen, self._to_pixels(target), radius, outline=(214, 203, 237), width=max(1, round(self._unit)))

    def _star(self, pen, at) -> None:
        angles = np.pi * (np.arange(10) / 5 - 0.5)
        sizes = np.where(np.arange(10) % 2, 5.0, 12.0) * self._unit
        points = at + sizes[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
        pen.polygon(points.ravel().tolist(), fill=SECOND, outline="white")

    def _cells(self, pen, at, colours) -> None:
        radius, edge = 0.5 * self._scale, max(1, round(min(0.6 * self._unit, 0.02 * self._scale)))
        for place, colour in zip(at, colours.tolist()):
            self._disc(pen, place, radius, fill=tuple(colour), outline="white", width=edge)

    def _disc(self, pen, at, radius, **style) -> None:
        x, y = at
        pen.ellipse((x - radius, y - radius, x + radius, y + radius), **style)

    def _lines(self, pen, at, pairs, width) -> None:
        thick = max(1, round(width * min(1.6 * self._unit, 0.045 * self._scale)))
        for ends in at[np.asarray(pairs, int).reshape(-1, 2)].reshape(-1, 4).tolist():
            pen.line(ends, fill=INK, width=thick)

    def _bar(self, pen) -> None:
        metres = _round(self._wide / 4 / self._scale)
        right, top, long = self._wide - 15 * self._unit, 8 * self._unit + 1.4 * self._letters, metres * self._scale
        pen.rectangle((right - long, top, right, top + 3 * self._unit), fill=INK)
        pen.text((right - long / 2, top - 4 * self._unit), f"{metres:g} m", fill=INK, font=self._font, anchor="md")

    def _label(self, pen, words, x, y) -> None:
        box = pen.textbbox((x, y), words, font=self._font)
        pen.rectangle((box[0] - 5, box[1] - 4, box[2] + 5, box[3] + 4), fill="white")
        pen.text((x, y), words, fill=INK, font=self._font)


def _round(metres: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is not above `metres`."""
    power = 10.0 ** np.floor(np.log10(metres))
    return float(max(step * power for step in (1, 2, 5) if step * power <= metres * (1 + 1e-9)))


def smooth(way: np.ndarray, window: int) -> np.ndarray:
    """A way (T, 2) as means over up to `window` points to each side, as many on both."""
    total = np.concatenate((np.zeros((1, way.shape[1])), way.cumsum(axis=0)))
    here = np.arange(len(way))
    near = np.minimum(np.minimum(here, len(way) - 1 - here), min(window, len(way) // 8))
    return (total[here + near + 1] - total[here - near]) / (2 * near + 1)[:, None]
