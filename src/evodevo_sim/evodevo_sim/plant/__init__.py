"""What a brain drives: the contract, and the simulated bodies that meet it."""

from .contract import Outcome, Plant

__all__ = ["Outcome", "Plant"]
