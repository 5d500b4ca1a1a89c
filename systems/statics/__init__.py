"""Floor 4: a line at rest, its equilibrium, and the certificate of a state."""
