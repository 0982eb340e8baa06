"""How large a genome may be."""

# Up to 2,000 units; weights take 48 bytes for each pair of them, so that an evaluation takes less than 0.5 GB.
MAX_ELEMENTS = 4_000
