"""The report of a schedule plan."""
