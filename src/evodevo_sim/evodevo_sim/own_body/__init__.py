"""Bodies of your own, from files (docs/simulate.md)."""
