"""A report of runs as one page: `runs` reads them, `differences` says what was set and how to repeat it, `sections` and `page` write it."""
