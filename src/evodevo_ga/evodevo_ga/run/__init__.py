"""What `evolve` does with an `Evolution`: finds who evaluates, evaluates, records, and tells the outcome."""
