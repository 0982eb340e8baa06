"""One evaluator above all backends: it shares genomes among workers that may come, go, lie, hang and lose what they were told."""
