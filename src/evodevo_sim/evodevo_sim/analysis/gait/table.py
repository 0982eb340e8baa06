"""A gait as a table, and its cells as lines of a CSV file."""

from __future__ import annotations

import csv
import math
import os

import numpy as np
from rich.table import Table

from .analysis import Analysis, Gait

_CELLS = ("cell", "along_m", "across_m", "amplitude", "phase_rad", "limb")


def headline(gait: Gait) -> str:
    """The gait in a line, e.g. `jellyfish at 1.65 Hz, 0.52 m/s, 0.31 m per period`."""
    if not math.isfinite(gait.frequency) or gait.name == "still":
        return f"{gait.name}: {gait.why}"
    return f"{gait.name} at {gait.frequency:.2f} Hz, {gait.speed:.3g} m/s, {gait.stroke:.3g} m per period"


def gait_table(gait: Gait) -> Table:
    """The numbers of a gait for a terminal; those that are not known are left out."""
    table = Table("", "", "unit", box=None, show_header=False)
    table.columns[1].justify = "right"
    for name, value, unit in _rows(gait):
        if not (isinstance(value, float) and math.isnan(value)):
            table.add_row(name, value if isinstance(value, str) else f"{value:.4g}", unit)
    return table


def _rows(g: Gait):
    yield "frequency of the muscles", g.frequency, "Hz"
    yield "amplitude of e - c, mean over cells", g.amplitude, ""
    yield "coherence: variance at that rhythm", g.coherence, ""
    yield "speed along its heading", g.speed, "m/s"
    yield "way, from begin to end of the second half", g.travel, "m"
    yield "turning", g.turning, "rad/s"
    yield "stroke", g.stroke, "m per period"
    yield "length along the way, width", f"{g.length:.2f}, {g.width:.2f}", "m"
    yield "long axis off the way", math.degrees(g.long_axis), "degrees"
    yield "phase gradient along", g.gradient_along, "rad/m"
    yield "phase gradient across", g.gradient_across, "rad/m"
    yield "fit of that plane wave", g.gradient_fit, ""
    if g.gradient_along:
        pace = 2 * math.pi * g.frequency / abs(g.gradient_along)
        yield f"wave of contraction, to the {'rear' if g.gradient_along > 0 else 'front'}", pace, "m/s"
    yield "phase shift between the sides", math.degrees(g.lateral_shift), "degrees"
    yield "agreement of the cells on it", g.lateral_agreement, ""
    yield "synchrony of muscles", g.synchrony, ""
    yield "synchrony of chambers", g.area_synchrony, ""
    yield "pulsation of the area", g.pulsation, ""
    yield "bending (1) or swelling (-1)", g.bending, ""
    yield "share of cells that move", g.moving_share, ""
    yield "share of limbs in the sway", g.limb_power, ""
    yield "work of muscles", g.muscle_work, "J"
    yield "work of drag", g.drag_work, "J"
    yield "work of damping", g.damping_work, "J"
    yield "work of the ground", g.ground_work, "J"
    yield "cost of transport", g.cost_of_transport, "J/(kg m)"
    if not math.isnan(g.flight):
        yield "time in the air", g.flight, ""
        yield "flights", g.flights, "1/s"
        yield "feet", float(g.feet), ""
        yield "duty factor of a foot, mean", g.duty, ""
        yield "association of the end feet", g.support, ""
        yield "mass over its support, amplitude", g.mass_shift, "m"


def write_cells(path: str | os.PathLike, analysis: Analysis) -> None:
    """Write a CSV file: a line per cell with its place in the body, amplitude and phase (from the mean of all), limb or not and,
    of walkers, the share of the time for which it touches the ground."""
    wave, contact = analysis.rhythm.wave, analysis.contact
    phase = np.angle(wave * np.conj(wave.sum())) if wave.any() else np.zeros(len(wave))
    columns = [range(len(wave)), *analysis.frame.shape.T, np.abs(wave), phase, analysis.limb.astype(int)]
    names: tuple[str, ...] = _CELLS
    if contact is not None:
        columns.append(contact.duty)
        names += ("duty",)
    with open(path, "w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(names)
        lines.writerows([f"{value:.9g}" for value in row] for row in zip(*columns))
