"""Genome and gene regulatory network (paper section 2.1)."""
