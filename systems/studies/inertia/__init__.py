"""Studies of inertia: natural frequencies and shapes, emergency stops."""
