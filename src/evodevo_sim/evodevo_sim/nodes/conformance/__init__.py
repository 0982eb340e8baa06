"""Whether a node is a plant as the contract has it: checks that ask a simulator, a driver of ours, or one of yours the same things."""
