"""Who came from whom: the ancestors of a run's champion, and a picture of its line."""
