"""Floor 5: what a run leaves: data, tables and pictures."""
