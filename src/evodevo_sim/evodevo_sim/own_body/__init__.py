"""Bodies of your own, from files (docs/guide/body.md)."""
