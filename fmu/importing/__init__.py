"""Import of an FMU: as a file, an instance, a slave of a co-simulation, a component."""
