"""The checks of the contract (docs/reference/plant.md); they are asked in the order in which they stand here."""

from . import interfaces, refusals, life, control, evaluation, hardware  # noqa: I001  (the order is that of the report)

__all__ = ["control", "evaluation", "hardware", "interfaces", "life", "refusals"]
