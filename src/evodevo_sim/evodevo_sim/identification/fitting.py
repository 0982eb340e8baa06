"""Numbers of a body from recordings of it: the simulation is fitted to them by least squares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..extras import lacking

try:
    from scipy.optimize import least_squares
except ModuleNotFoundError as error:
    raise lacking(error) from None

from .observation import Observation, ObservationError
from .prediction import LISTEN, PLAIN, Model, predicted
from .tracking import laid_on

# name: (least, most, what a difference is taken over), all but lag and delay by their logarithms
FITTED: dict[str, tuple[float, float, float]] = {
    "stiffness": (1.0, 1e5, 1e-2), "damping": (1e-2, 1e4, 1e-2), "pressure": (1.0, 1e5, 1e-2), "drag_normal": (1e-2, 1e5, 1e-2),
    "drag_tangential": (1e-3, 1e4, 1e-2), "lag": (0.0, 2.0, 1e-3), "delay": (0.0, 0.25, 1e-3),
}
USUAL = ("stiffness", "damping", "drag_normal", "drag_tangential", "lag")
_SECONDS = {"lag", "delay"}
_LATEST = 0.25  # s: no residual is taken within so long after a simulation was drawn to what was seen, the longest delay
_FIRST = 3.0  # s to which the first fit goes, before motions drift apart
_FAILED = 1e3  # m, where the physics cannot be carried on


@dataclass(frozen=True, eq=False)
class Fit:
    """What was found.

    Attributes: model; numbers: by name; spread: standard deviation of each, relative, of seconds absolute, as the residuals tell it; rms:
    m, of all cells seen; simulations: that it took.
    """

    model: Model
    numbers: dict[str, float]
    spread: dict[str, float]
    rms: float
    simulations: int


def fit(
    observations: Sequence[Observation], model: Model = PLAIN, names: Sequence[str] = USUAL,
    say: Callable[[str], None] = lambda line: None,
) -> Fit:
    """Fit numbers of a model to observations of one or several bodies of one stuff.

    Args: model: what is not fitted, and where the fit begins; names: of FITTED; say: told a line of each step of the fit.
    Raises ObservationError where a number leaves no trace in the motions, or the physics cannot be carried on from the beginning.
    """
    for name in names:
        if name not in FITTED:
            raise ObservationError(f"{name[:40]!r} cannot be fitted: choose of {', '.join(FITTED)}")
    problem = _Problem(observations, model, tuple(names))
    x = problem.begin()
    for seconds in (_FIRST, np.inf):
        problem.seconds = seconds
        solution = least_squares(
            problem.residuals, x, jac=problem.slopes, bounds=problem.bounds(), x_scale=problem.scales(), ftol=1e-6, xtol=1e-6, gtol=1e-10,
            max_nfev=40,
        )
        x = solution.x
        say(f"first {seconds:g} s: {problem.words(x)}" if np.isfinite(seconds) else problem.words(x))
    left = solution.fun
    if np.abs(left).max() >= _FAILED:
        raise ObservationError("the physics cannot be carried on: give other numbers to begin with, by --set")
    freedom = max(len(left) - len(x), 1)
    information = solution.jac.T @ solution.jac
    weak = [name for name, value in zip(names, np.diag(information)) if value <= 1e-12]
    if weak:
        raise ObservationError(f"the motions say nothing of {' and '.join(weak)}: leave it out by --fit, or record more")
    spread = np.sqrt(np.diag(np.linalg.pinv(information)) * float(left @ left) / freedom)
    numbers, rms = problem.numbers(x), float(np.sqrt(2.0 * np.mean(left**2)))
    return Fit(model.with_numbers(numbers), numbers, dict(zip(names, spread.tolist())), rms, problem.simulations)


class _Problem:
    """Residuals of all observations by the logarithms of numbers, of lag and delay by their seconds."""

    def __init__(self, observations: Sequence[Observation], model: Model, names: tuple[str, ...]):
        self._observations, self._model, self._names = observations, model, names
        self.seconds, self.simulations = np.inf, 0
        self._last: tuple[bytes, float, np.ndarray] | None = None

    def begin(self) -> np.ndarray:
        low, high = self.bounds()
        begin = [self._model.number(name) if name in _SECONDS else np.log(max(self._model.number(name), 1e-9)) for name in self._names]
        at = np.array([max(value, 0.05) if name == "lag" else value for name, value in zip(self._names, begin)])
        return np.clip(at, low + 1e-3, high - 1e-3)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        ends = [FITTED[name][:2] if name in _SECONDS else np.log(FITTED[name][:2]) for name in self._names]
        low, high = np.array(ends, float).T
        return low, high

    def scales(self) -> np.ndarray:
        return np.array([0.05 if name in _SECONDS else 0.3 for name in self._names])

    def numbers(self, x: np.ndarray) -> dict[str, float]:
        return {name: float(value if name in _SECONDS else np.exp(value)) for name, value in zip(self._names, x)}

    def words(self, x: np.ndarray) -> str:
        return ", ".join(f"{name} {value:.4g}" for name, value in self.numbers(x).items())

    def residuals(self, x: np.ndarray) -> np.ndarray:
        if self._last is None or self._last[:2] != (x.tobytes(), self.seconds):
            model = self._model.with_numbers(self.numbers(x))
            self._last = x.tobytes(), self.seconds, np.concatenate([self._of(one, model) for one in self._observations])
        return self._last[2]

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """By differences that are wide beside the grain of the steps that physics takes."""
        there, (low, high) = self.residuals(x), self.bounds()
        columns = []
        for k, name in enumerate(self._names):
            width = FITTED[name][2]
            ahead, behind = x.copy(), x.copy()
            ahead[k], behind[k] = min(x[k] + width, high[k]), max(x[k] - width, low[k])
            columns.append((self.residuals(ahead) - self.residuals(behind)) / (ahead[k] - behind[k]))
        self._last = x.tobytes(), self.seconds, there
        return np.stack(columns, axis=1)

    def _of(self, one: Observation, model: Model) -> np.ndarray:
        until = one.time - one.time[0] <= self.seconds
        part = Observation(one.name, one.body, one.time[until], one.position[until], one.activation[until])
        late = part.time - part.time[0] > min(LISTEN, 0.25 * (part.time[-1] - part.time[0])) + _LATEST
        seen = np.isfinite(part.position).all(axis=2) & late[:, None]
        self.simulations += 1
        track = predicted(part, model)
        if track is None:
            return np.full(2 * int(seen.sum()), _FAILED)
        return (laid_on(part.position, track, seen)(track) - part.position)[seen].ravel()
