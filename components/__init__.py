"""Components: the physics of one part of a system in each file."""
