"""The gallery of a run: the animals of its archive on a map, in Rerun, and as genome files with their audits."""
