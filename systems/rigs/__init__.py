"""Floor 7: whole systems built from public components. A rig adds no physics."""
