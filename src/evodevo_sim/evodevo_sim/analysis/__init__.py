"""What motions are like: gaits, turning."""
