"""Floor 3: what solves and integrates a model, and knows no kind of component."""
