"""One control step of the network in a standing body, and its senses (paper sections 2.1, 4)."""
