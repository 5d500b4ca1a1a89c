"""Example scripts and their data. Each has `main(folder)`: it prints a little and writes its pictures there."""
