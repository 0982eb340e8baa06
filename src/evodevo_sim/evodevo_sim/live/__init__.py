"""Animats that live step by step, at a pace, towards targets."""

from .animat import Animat, NotViable, Stage

__all__ = ["Animat", "NotViable", "Stage"]
