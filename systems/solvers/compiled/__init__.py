"""Floor 3: what the compiled core reads of drives, responses, records and lines with inertia."""
