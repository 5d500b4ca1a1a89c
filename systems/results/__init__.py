"""Floor 5: results of a run as data, tables and figures."""
