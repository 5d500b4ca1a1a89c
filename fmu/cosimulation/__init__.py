"""Co-simulation of FMUs and systems."""
