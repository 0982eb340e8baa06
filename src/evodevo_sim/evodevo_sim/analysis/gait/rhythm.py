"""The common rhythm of many signals: its frequency, and the amplitude and phase of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

_PADDING = 8  # times as many samples, so that a parabola finds the peak between two
_LEAST_CYCLES = 1.5  # in the time looked at
_FASTEST = 0.4  # cycles a sample: at 0.5 a sine cannot be told from a cosine
_HARMONICS = 4  # of the common frequency that count as coherent


@dataclass(frozen=True, eq=False)
class Rhythm:
    """frequency, Hz, NaN for none; wave (K,) complex: signal k beats as Re(wave[k] exp(2 pi i frequency t)), t from the first
    sample on; coherence: share of the signals' variance at the frequency and its first harmonics."""

    frequency: float
    wave: np.ndarray
    coherence: float

    @property
    def period(self) -> float:
        return 1.0 / self.frequency


def common_rhythm(time: np.ndarray, signals: np.ndarray) -> Rhythm:
    """The rhythm at the peak of the power spectra's sum.  Args: time (T,) s, evenly spaced; signals (T, K)."""
    frequency = _dominant(time, signals)
    if not np.isfinite(frequency):
        return Rhythm(np.nan, np.zeros(signals.shape[1], complex), 0.0)
    wave, explained = beats(time, signals, frequency)
    total = signals.var(axis=0).sum()
    return Rhythm(frequency, wave, min(1.0, float(explained / total)) if total > 0 else 0.0)


def beats(time: np.ndarray, signals: np.ndarray, frequency: float) -> Any:
    """Least squares of signals (T, K) at a frequency and its harmonics, beside a mean and a trend.

    Returns: (complex amplitude (K,) at the frequency itself, variance explained by all of them).
    """
    t = time - time[0]
    orders = np.arange(1, _HARMONICS + 1)
    orders = orders[orders * frequency < 0.5 / (t[1] - t[0])]
    turns = np.exp(2j * np.pi * frequency * np.outer(t, orders if len(orders) else [1]))
    columns = np.column_stack((np.ones_like(t), t / t[-1] - 0.5, turns.real, turns.imag))
    found = np.linalg.solve(columns.T @ columns, columns.T @ signals)  # few columns, nearly orthogonal
    count = turns.shape[1]
    wave = found[2] - 1j * found[2 + count]
    return wave, float((columns[:, 2:] @ found[2:]).var(axis=0).sum())


def _dominant(time, signals) -> float:
    step = (time[-1] - time[0]) / (len(time) - 1)
    trend = np.polynomial.polynomial.polyfit(time - time.mean(), signals, 1)
    free = signals - np.polynomial.polynomial.polyval(time - time.mean(), trend).T.reshape(signals.shape)
    window = np.hanning(len(time))[:, None]
    power = (np.abs(np.fft.rfft(free * window, _PADDING * len(time), axis=0)) ** 2).sum(axis=1)
    least = int(np.ceil(_LEAST_CYCLES * _PADDING))
    power = power[: int(_FASTEST * _PADDING * len(time))]
    if least + 1 >= len(power) - 1 or not power[least:].max() > 1e-18 * len(time) ** 2:
        return np.nan
    k = least + int(power[least:-1].argmax())
    a, b, c = np.log(power[k - 1 : k + 2] + 1e-300)
    shift = 0.5 * (a - c) / (a - 2 * b + c) if a + c < 2 * b else 0.0
    return float((k + np.clip(shift, -1, 1)) / (_PADDING * len(time) * step))
