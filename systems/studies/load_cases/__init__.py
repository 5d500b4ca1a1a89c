"""Load cases: environments and loadings of a line or a rig, and the tables that its supports are built from."""
