"""Genetic elements (paper section 2.1): their kinds, and the header of special ones, as kernels and files number them."""

from __future__ import annotations

SPECIAL, REGULATORY, TRANSCRIPTION_FACTOR, MORPHOGEN = range(4)
KINDS = ("special", "regulatory", "transcription_factor", "morphogen")

INPUT_NAMES = ("maternal_x", "maternal_y", "constant", "scent")
OUTPUT_NAMES = ("division", "axis", "expansion", "contraction")
HEADER_NAMES = INPUT_NAMES + OUTPUT_NAMES
INPUTS, OUTPUTS = len(INPUT_NAMES), len(OUTPUT_NAMES)
HEADER = INPUTS + OUTPUTS
