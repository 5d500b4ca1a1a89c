"""Floor 8: questions about a system, a folder for each subject."""
