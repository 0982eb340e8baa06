"""What genomes are evaluated for: swim, walk, chemotaxis (paper section 4)."""
