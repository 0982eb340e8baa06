"""Phases over the body: the plane wave that fits them, and the shift between the left and the right side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...extras import lacking
from .frame import BodyFrame, stations

try:
    from scipy.optimize import minimize
except ModuleNotFoundError as error:
    raise lacking(error) from None

_MOST = np.pi  # rad/m: half a period between two cells
_GRID = 121  # gradients tried along each axis, an odd number


@dataclass(frozen=True)
class PlaneWave:
    """along, across: gradient of the phase, rad/m; fit: 0 (none) .. 1 (exactly this wave).  A wave runs towards lower phase."""

    along: float
    across: float
    fit: float


@dataclass(frozen=True)
class Sides:
    """shift: rad, 0 .. pi, between left and right cells at the same station; agreement: 0 .. 1, of their shifts."""

    shift: float
    agreement: float


def plane_wave(shape: np.ndarray, wave: np.ndarray) -> PlaneWave:
    """The phase gradient under which cells agree best, weighted by amplitude.  Args: shape (N, 2) m; wave (N,) complex."""
    total = np.abs(wave).sum()
    if not total > 0:
        return PlaneWave(0.0, 0.0, 0.0)
    tried = np.linspace(-_MOST, _MOST, _GRID)
    turned = [np.exp(-1j * np.outer(tried, x)) for x in shape.T]
    fits = np.abs((turned[0] * wave) @ turned[1].T) / total
    # Of equals (two rows in antiphase fit either way) the slightest, so that noise alone does not make a gradient.
    fits = fits - 1e-6 * np.hypot(*np.meshgrid(tried, tried, indexing="ij"))
    first = [tried[k] for k in np.unravel_index(fits.argmax(), fits.shape)]

    def misfit(gradient):
        return -abs((wave * np.exp(-1j * shape @ gradient)).sum()) / total

    found = minimize(misfit, first, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9})
    return PlaneWave(float(found.x[0]), float(found.x[1]), float(-found.fun))


def sides(frame: BodyFrame, wave: np.ndarray, along: float) -> Sides:
    """Compare the two sides, cells farther from the midline counting more.

    Args: wave (N,) complex; along: its phase gradient, rad/m, that cells beside each other do not share exactly.
    """
    wave = wave * np.exp(-1j * along * frame.shape[:, 0])
    product = _pairs(frame) * np.outer(wave, wave.conj())
    most = np.abs(product).sum()
    if not most > 0:
        return Sides(0.0, 0.0)
    return Sides(float(abs(np.angle(product.sum()))), float(abs(product.sum()) / most))


def bending(frame: BodyFrame, sway: np.ndarray, along: float) -> float:
    """1: both sides sway across the body together, it bends; -1: against each other, it swells and narrows.

    Args: sway (N, 2) complex, see `frame.swaying`; along: as for `sides`.
    """
    wave = sway[:, 1] * np.exp(-1j * along * frame.shape[:, 0])
    product = _pairs(frame) * np.outer(wave, wave.conj())
    most = np.abs(product).sum()
    return float(product.sum().real / most) if most > 0 else 0.0


def _pairs(frame: BodyFrame):
    """(N, N) weight of each pair of a left and a right cell."""
    across = frame.shape[:, 1] - frame.midline
    left, right = np.maximum(across, 0.0), np.maximum(-across, 0.0)
    return stations(frame.shape[:, 0]) * np.outer(left, right)
