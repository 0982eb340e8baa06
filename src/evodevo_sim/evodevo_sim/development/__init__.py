"""Growth of the embryo, its graph and the body that it becomes (paper sections 2.2, 2.3)."""
