"""Example scripts and their data. `main(folder)` of each prints results and writes pictures into the folder."""
