"""Curves as SVG within a page: text stays text, and a screen reader hears what they show."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from evodevo_sim.view.colours import SERIES

_WIDE, _HIGH = 400, 240  # units of the drawing, about pixels on a phone
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 12, 30, 38
_POINTS = 300  # of a curve, at the most
_DASHES = ("", "7 4", "2 3", "10 3 2 3")


@dataclass(frozen=True)
class Curve:
    """name; x and y: numbers, NaN where there is a gap."""

    name: str
    x: Sequence[float]
    y: Sequence[float]


def chart(title: str, x_label: str, curves: Sequence[Curve], floor: float | None = None) -> str:
    """A chart as SVG.  Args: title: with the unit of y; floor: lowest y that is shown, below which curves are cut."""
    curves = [_thinned(curve) for curve in curves]
    points = [(x, y) for curve in curves for x, y in zip(curve.x, curve.y) if math.isfinite(x) and math.isfinite(y)]
    if not points:
        return ""
    low, high = min(y for _, y in points), max(y for _, y in points)
    low = low if floor is None else max(low, floor)
    low = 0.0 if 0 < low < 0.5 * high else low
    ticks = _ticks(low, max(high, low + 1e-9))
    low, high = min(low, ticks[0]), max(high, ticks[-1])
    first, last = min(x for x, _ in points), max(x for x, _ in points)
    last = last if last > first else first + 1

    def place(x, y):
        across = _LEFT + (x - first) / (last - first) * (_WIDE - _LEFT - _RIGHT)
        return across, _HIGH - _BOTTOM - (max(y, low) - low) / (high - low or 1) * (_HIGH - _TOP - _BOTTOM)

    said = "; ".join(_said(curve) for curve in curves)
    parts = [
        f'<svg class="chart" viewBox="0 0 {_WIDE} {_HIGH}" role="img" aria-label="{html.escape(f"{title}, by {x_label}: {said}")}">',
        f'<text class="title" x="0" y="14">{html.escape(title)}</text>',
    ]
    for tick in ticks:
        y = place(first, tick)[1]
        parts.append(f'<path class="grid" d="M{_LEFT} {y:.1f}H{_WIDE - _RIGHT}"/>')
        parts.append(f'<text x="{_LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
    for tick in _ticks(first, last, 5):
        x = place(tick, low)[0]
        parts.append(f'<text x="{x:.1f}" y="{_HIGH - _BOTTOM + 16}" text-anchor="middle">{tick:g}</text>')
    parts.append(f'<text x="{_WIDE - _RIGHT}" y="{_HIGH - 4}" text-anchor="end">{html.escape(x_label)}</text>')
    for k, curve in enumerate(curves):
        red, green, blue = SERIES[k % len(SERIES)]
        style = f'stroke="rgb({red},{green},{blue})"' + (f' stroke-dasharray="{_DASHES[k % 4]}"' if _DASHES[k % 4] else "")
        parts.append(f'<path class="curve" {style} d="{_path(curve, place)}"/>')
    parts.append("</svg>")
    key = legend([curve.name for curve in curves]) if len(curves) > 1 else ""
    return f'<div class="chartbox">{"".join(parts)}{key}</div>'


def legend(names: Sequence[str]) -> str:
    """Names of curves with their strokes, as a line below a chart."""
    keys = []
    for k, name in enumerate(names):
        red, green, blue = SERIES[k % len(SERIES)]
        dash = f' stroke-dasharray="{_DASHES[k % 4]}"' if _DASHES[k % 4] else ""
        path = f'<path d="M0 3H30" stroke="rgb({red},{green},{blue})"{dash}/>'
        stroke = f'<svg viewBox="0 0 30 6" width="30" height="6" aria-hidden="true">{path}</svg>'
        keys.append(f"<span>{stroke} {html.escape(name)}</span>")
    return f'<p class="key">{"".join(keys)}</p>'


def _path(curve: Curve, place) -> str:
    parts, pen = [], "M"
    for x, y in zip(curve.x, curve.y):
        if not (math.isfinite(x) and math.isfinite(y)):
            pen = "M"
            continue
        across, up = place(x, y)
        parts.append(f"{pen}{across:.1f} {up:.1f}")
        pen = "L"
    return "".join(parts)


def _said(curve: Curve) -> str:
    values = [y for y in curve.y if math.isfinite(y)]
    if not values:
        return f"{curve.name} has none"
    return f"{curve.name} from {values[0]:.3g} to {values[-1]:.3g}, at most {max(values):.3g}"


def _thinned(curve: Curve) -> Curve:
    """A curve of at most `_POINTS` points: of each stretch the lowest and the highest."""
    count = len(curve.x)
    if count <= _POINTS:
        return curve
    size = math.ceil(2 * count / _POINTS)
    kept = [0]
    for begin in range(0, count, size):
        stretch = [k for k in range(begin, min(begin + size, count)) if math.isfinite(curve.y[k])]
        if stretch:
            kept += sorted({min(stretch, key=lambda k: curve.y[k]), max(stretch, key=lambda k: curve.y[k])})
    kept = sorted({*kept, count - 1})
    return Curve(curve.name, [curve.x[k] for k in kept], [curve.y[k] for k in kept])


def _ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers from the last one not above low to the first one not below high."""
    span = high - low
    power = 10.0 ** math.floor(math.log10(span / most)) if span > 0 else 1.0
    step = next(one * power for one in (1, 2, 5, 10, 20) if span / (one * power) <= most)
    ticks = [round(k * step, 12) for k in range(math.floor(low / step), math.ceil(high / step) + 1)]
    return [tick for tick in ticks if low - step * 1e-9 <= tick <= high + step * 1e-9] or [low]
