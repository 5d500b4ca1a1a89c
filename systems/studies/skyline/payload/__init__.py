"""The largest payload along a corridor: study, governing limits, remarks, figure, command."""
