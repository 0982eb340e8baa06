"""What ends a run beside its settings, and what may be raised when it is resumed."""

from __future__ import annotations

from dataclasses import dataclass

RAISED = ("generations", "patience")  # settings


@dataclass(frozen=True)
class Limits:
    """Budgets of a run, at the end of the generation that reaches them; None: no limit.  hours: of wall time, of all its sessions."""

    evaluations: int | None = None
    hours: float | None = None

    def reached(self, evaluations: int, seconds: float) -> str:
        """Which of them ended a run, in words; empty where none did."""
        if self.evaluations is not None and evaluations >= self.evaluations:
            return f"--evaluations {self.evaluations}"
        if self.hours is not None and seconds >= 3600.0 * self.hours:
            return f"--hours {self.hours:g}"
        return ""


NONE = Limits()
