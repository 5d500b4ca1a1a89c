"""An FMU as a file, as an instance, as a participant of a co-simulation, as a component."""
