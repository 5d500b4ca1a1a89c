"""How a schedule is found: the line's equations as an optimisation, its rounds, and what comes out."""
