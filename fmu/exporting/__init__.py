"""Export of a system as an FMU: its model, its description, and the FMI wrappers of the C core."""
