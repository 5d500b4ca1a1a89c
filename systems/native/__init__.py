"""Floor 3: the C core, its tables, and the compiler."""
