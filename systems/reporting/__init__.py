"""Reports for people: a document of sections, with labels, units, interactive charts and a player."""
