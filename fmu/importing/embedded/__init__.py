"""An FMU for Model Exchange as a component of a system."""
