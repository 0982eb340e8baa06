"""Bodies of rubber and air: the line to their firmware, their calibration and limits, and one that is emulated."""
