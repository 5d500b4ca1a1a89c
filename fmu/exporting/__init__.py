"""A system as an FMU: its model, its description, and the wrappers of the C core."""
