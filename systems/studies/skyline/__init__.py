"""Studies of a skyline: load path, payload, pretension, support layout, inhaul."""
