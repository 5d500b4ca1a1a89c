"""Exchange with people and other tools: project files, reports, tables, maps."""
