"""Reports of skyline rigs: payload, load path, inhaul."""
