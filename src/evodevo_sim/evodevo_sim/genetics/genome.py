"""Linear genomes (paper section 2.1): genetic elements with a kind, a sign and a point in the plane of affinities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..inputs import InputError
from .elements import HEADER, KINDS, MORPHOGEN, REGULATORY, SPECIAL, TRANSCRIPTION_FACTOR
from .limits import MAX_ELEMENTS

MAX_COORDINATE = 1e6


class GenomeError(InputError, ValueError):
    """A malformed genome; the message says which element and how to mend it."""


@dataclass(frozen=True, eq=False)
class Genome:
    """Parallel read-only arrays, one entry per genetic element, the fixed header of special elements first.

    Attributes: kind (E,) uint8, sign (E,) int8 of +1 and -1, x and y (E,) float64, dimensionless.
    Raises GenomeError when made of anything else.
    """

    kind: np.ndarray
    sign: np.ndarray
    x: np.ndarray
    y: np.ndarray

    def __post_init__(self):
        if _whole(self.kind, self.sign, self.x, self.y):
            self._keep(kind=self.kind.copy(), sign=self.sign.copy(), x=self.x.copy(), y=self.y.copy())
            return
        _check_size(self.kind, self.sign, self.x, self.y)  # before anything of that size is made
        arrays = {}
        for name, dtype in (("kind", np.uint8), ("sign", np.int8), ("x", np.float64), ("y", np.float64)):
            try:
                given = np.asarray(getattr(self, name))
                with np.errstate(invalid="ignore"):  # of what is no number of that kind, which is told below
                    arrays[name] = given.astype(dtype)
            except (TypeError, ValueError):
                raise GenomeError(f"genome: {name} holds something that is not a number") from None
            whole = dtype == np.float64 or given.dtype == dtype or np.array_equal(arrays[name], given)
            if given.ndim != 1 or not whole:
                raise GenomeError(f"genome: {name} must be a flat list of {'numbers' if dtype == np.float64 else 'small whole numbers'}")
        _check(**arrays)
        self._keep(**arrays)

    def _keep(self, **arrays: np.ndarray) -> None:
        for name, array in arrays.items():
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return self.kind.size

    def __eq__(self, other) -> bool:
        return isinstance(other, Genome) and self.key() == other.key()

    def __hash__(self) -> int:
        return hash(self.key())

    def key(self) -> bytes:
        """The genome as bytes: equal genomes, and only they, have equal keys."""
        return self.kind.tobytes() + self.sign.tobytes() + self.x.tobytes() + self.y.tobytes()

    def take(self, index: np.ndarray) -> Genome:
        """The genome of the elements at `index`, in that order."""
        return Genome(self.kind[index], self.sign[index], self.x[index], self.y[index])

    def arrays(self) -> tuple[np.ndarray, ...]:
        """kind, sign, x, y: the first arguments of the kernels."""
        return self.kind, self.sign, self.x, self.y


_TYPES = tuple(map(np.dtype, (np.uint8, np.int8, np.float64, np.float64)))
_HEADER, _BEHIND = bytes([SPECIAL]) * HEADER, bytes(k for k in range(len(KINDS)) if k != SPECIAL)
_SIGNS = np.array([1, -1], np.int8).tobytes()


def _whole(*given: Any) -> bool:
    """Whether these are the arrays of a genome for certain, as those are that come of other genomes: a look of a few microseconds."""
    if not all(type(array) is np.ndarray and array.dtype is dtype and array.ndim == 1 for array, dtype in zip(given, _TYPES)):
        return False
    kind, sign, x, y = given
    kinds, near = kind.tobytes(), 0.5 * MAX_COORDINATE**2
    return (
        HEADER <= kind.size <= MAX_ELEMENTS and kind.size == sign.size == x.size == y.size
        and kinds.startswith(_HEADER) and not kinds[HEADER:].translate(None, _BEHIND) and not sign.tobytes().translate(None, _SIGNS)
        and bool(x.dot(x) <= near and y.dot(y) <= near)
    )


def _wrong_size(elements: int) -> GenomeError:
    return GenomeError(f"genome: {elements} elements: give the {HEADER} special elements of the header, then up to {MAX_ELEMENTS} in all")


def _check_size(*given: Any) -> None:
    """Raises GenomeError where any of what stands for kind, sign, x and y is too long."""
    most = max(map(_length, given))
    if most > MAX_ELEMENTS:
        raise _wrong_size(most)


def _length(given: Any) -> int:
    """Of a flat list or array; 0 where it is none, which is told later."""
    shape = getattr(given, "shape", None)
    if shape is not None:
        return int(shape[0]) if len(shape) == 1 else 0
    return len(given) if hasattr(given, "__len__") and np.ndim(given[:0]) == 1 else 0


def _check(kind, sign, x, y):
    if not kind.size == sign.size == x.size == y.size:
        raise GenomeError(f"genome: kind, sign, x and y have {kind.size}, {sign.size}, {x.size} and {y.size} entries: give equal numbers")
    if kind.size < HEADER:
        raise _wrong_size(kind.size)
    for bad, what in (
        (kind >= len(KINDS), f"kind is unknown: use 0 to {len(KINDS) - 1}"),
        (np.abs(sign) != 1, "sign is neither +1 nor -1"),
        (~(np.maximum(np.abs(x), np.abs(y)) <= MAX_COORDINATE), f"point is not finite or beyond {MAX_COORDINATE:g}"),
        ((kind == SPECIAL) != (np.arange(kind.size) < HEADER), f"special elements are the first {HEADER}, and only they"),
    ):
        if bad.any():
            raise GenomeError(f"genome: element {np.flatnonzero(bad)[0]}: {what}")


def random_genome(rng: np.random.Generator, units: int = 20, extent: float = 1.0) -> Genome:
    """A random genome: `units` regulatory units of 1-2 regulatory elements and 1-2 genes, points uniform in [-extent, extent]^2."""
    kind = [SPECIAL] * HEADER
    for _ in range(units):
        kind += [REGULATORY] * int(rng.integers(1, 3))
        kind += [int(k) for k in rng.integers(TRANSCRIPTION_FACTOR, MORPHOGEN + 1, rng.integers(1, 3))]
    points = rng.uniform(-extent, extent, (len(kind), 2))
    return Genome(np.array(kind), rng.choice((-1, 1), len(kind)), points[:, 0], points[:, 1])
