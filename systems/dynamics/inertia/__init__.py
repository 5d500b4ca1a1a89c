"""Lines with inertia: their components, state and events, and their integration."""
