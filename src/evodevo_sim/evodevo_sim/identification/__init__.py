"""Across the reality gap: how far a simulation is from a body, and which numbers bring it near."""

from .fitting import FITTED, Fit, fit
from .observation import Observation, ObservationError
from .prediction import predicted
from .tracking import Tracking, tracking

__all__ = ["FITTED", "Fit", "Observation", "ObservationError", "Tracking", "fit", "predicted", "tracking"]
