"""How bodies move (paper sections 2.3, 4)."""
