"""The swimming task (paper section 4.2)."""
