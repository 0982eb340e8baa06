"""What cannot be kept, or gone on from."""

from __future__ import annotations

from pathlib import Path

from evodevo_sim.inputs import InputError


class ResumeError(InputError, RuntimeError):
    """A run that cannot be resumed; the message says which, why, and what to do."""


class KeepingError(InputError, RuntimeError):
    """Something of a run that cannot be written; the message says what, why, and what to do."""

    @classmethod
    def of(cls, what: object, error: OSError, directory: object) -> KeepingError:
        """The error of a file that the operating system does not write."""
        mend = f"what came before is kept: make room, then `ros2 run evodevo_ga evolve --resume {directory}`"
        return cls(f"{Path(str(what)).name} cannot be written ({error.strerror or error}): {mend}")
