"""Floor 6: a line in time, from event to event."""
