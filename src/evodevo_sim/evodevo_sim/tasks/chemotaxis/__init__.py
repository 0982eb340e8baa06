"""Chemotaxis (paper section 4.3)."""
