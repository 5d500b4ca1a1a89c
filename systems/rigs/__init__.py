"""Floor 7: whole systems out of public parts, without physics of their own."""
