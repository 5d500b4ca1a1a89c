"""The largest payload along a corridor: study, limits that govern, remarks, picture, command."""
