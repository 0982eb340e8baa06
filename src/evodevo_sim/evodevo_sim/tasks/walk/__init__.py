"""The walking task (paper section 4.1)."""
